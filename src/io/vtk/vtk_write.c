/* io/vtk/vtk_write.c - writes VTK XML files for ParaView: one PolyData file (.vtp) a frame, and
 * collections of them over time (.pvd). Arrays stand inline as base64 of an 8-byte length and the
 * values, little endian.
 *
 * Based on: Kitware, VTK file formats, the XML formats; RFC 4648 (base64). */
#include "base/error.h"
#include "io/bytes.h"
#include "io/output_file.h"
#include "io/unflushed.h"

#include "tulle_io/mesh_files.h"

#include <stdbool.h>

/* Three bytes become four letters. */
typedef struct base64 {
    output_file *output;
    unsigned char bytes[3];
    size_t count;
} base64;

static void base64_flush(base64 *coder) {
    static const char letters[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    if (coder->count == 0) return;
    for (size_t i = coder->count; i < 3; i++) coder->bytes[i] = 0;
    unsigned const bits =
        (unsigned)coder->bytes[0] << 16 | (unsigned)coder->bytes[1] << 8 | coder->bytes[2];
    char quad[4];
    for (unsigned i = 0; i < 4; i++)
        quad[i] = i <= coder->count ? letters[bits >> (18 - 6 * i) & 63] : '=';
    output_write(coder->output, quad, sizeof quad);
    coder->count = 0;
}

static void base64_add(base64 *coder, const unsigned char *bytes, size_t byte_count) {
    for (size_t i = 0; i < byte_count; i++) {
        coder->bytes[coder->count++] = bytes[i];
        if (coder->count == 3) base64_flush(coder);
    }
}

static void base64_add_integer(base64 *coder, uint64_t value) {
    unsigned char bytes[8];
    bytes_store(bytes, sizeof bytes, value);
    base64_add(coder, bytes, sizeof bytes);
}

static void write_array_start(output_file *output, const char *type, const char *name,
                              const char *components) {
    output_text(output, "<DataArray type=\"");
    output_text(output, type);
    output_text(output, "\" Name=\"");
    output_text(output, name);
    output_text(output, "\" NumberOfComponents=\"");
    output_text(output, components);
    output_text(output, "\" format=\"binary\">\n");
}

static void write_vectors(output_file *output, const char *name, const double *values,
                          size_t count) {
    write_array_start(output, "Float64", name, "3");
    base64 coder = {.output = output};
    base64_add_integer(&coder, 24 * (uint64_t)count);
    for (size_t i = 0; i < 3 * count; i++) {
        unsigned char bytes[8];
        bytes_store_double(bytes, values[i]);
        base64_add(&coder, bytes, sizeof bytes);
    }
    base64_flush(&coder);
    output_text(output, "\n</DataArray>\n");
}

static void write_triangles(output_file *output, tulle_mesh_view mesh) {
    base64 coder = {.output = output};
    output_text(output, "<Polys>\n");
    write_array_start(output, "Int64", "connectivity", "1");
    base64_add_integer(&coder, 24 * (uint64_t)mesh.triangle_count);
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        base64_add_integer(&coder, mesh.triangles[i]);
    base64_flush(&coder);
    output_text(output, "\n</DataArray>\n");
    write_array_start(output, "Int64", "offsets", "1");
    base64_add_integer(&coder, 8 * (uint64_t)mesh.triangle_count);
    for (size_t i = 0; i < mesh.triangle_count; i++) base64_add_integer(&coder, 3 * (i + 1));
    base64_flush(&coder);
    output_text(output, "\n</DataArray>\n</Polys>\n");
}

static void write_polydata(output_file *output, tulle_mesh_view mesh, const double *velocities) {
    output_text(output, "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
                        "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n"
                        "<Piece NumberOfPoints=\"");
    output_unsigned(output, mesh.vertex_count);
    output_text(output, "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
                        "NumberOfPolys=\"");
    output_unsigned(output, mesh.triangle_count);
    output_text(output, "\">\n");
    if (velocities) {
        output_text(output, "<PointData Vectors=\"velocities\">\n");
        write_vectors(output, "velocities", velocities, mesh.vertex_count);
        output_text(output, "</PointData>\n");
    }
    output_text(output, "<Points>\n");
    write_vectors(output, "Points", mesh.positions, mesh.vertex_count);
    output_text(output, "</Points>\n");
    write_triangles(output, mesh);
    output_text(output, "</Piece>\n</PolyData>\n</VTKFile>\n");
}

/* sum null: the file is flushed to disk. */
static tulle_status write_vtp(const char *path, tulle_mesh_view mesh, const double *velocities,
                              file_sum *sum, tulle_error *error) {
    if (!path || (mesh.vertex_count > 0 && !mesh.positions) ||
        (mesh.triangle_count > 0 && !mesh.triangles))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "path and the arrays of the mesh may not be null");
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        if (mesh.triangles[i] >= mesh.vertex_count)
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "triangle %zu uses vertex %u, but there are only %zu", i / 3,
                             mesh.triangles[i], mesh.vertex_count);
    output_file *output = NULL;
    tulle_status const status =
        sum ? output_open_unflushed(path, &output, error) : output_open(path, &output, error);
    if (status) return status;
    write_polydata(output, mesh, velocities);
    return output_commit_summed(output, sum, error);
}

tulle_status tulle_vtp_write(const char *path, tulle_mesh_view mesh, const double *velocities,
                             tulle_error *error) {
    return write_vtp(path, mesh, velocities, NULL, error);
}

tulle_status vtp_write_unflushed(const char *path, tulle_mesh_view mesh, const double *velocities,
                                 file_sum *sum, tulle_error *error) {
    return write_vtp(path, mesh, velocities, sum, error);
}

/* Text of an attribute: the five reserved characters by their names. */
static void write_escaped(output_file *output, const char *text) {
    for (; *text; text++) {
        switch (*text) {
        case '&': output_text(output, "&amp;"); break;
        case '<': output_text(output, "&lt;"); break;
        case '>': output_text(output, "&gt;"); break;
        case '"': output_text(output, "&quot;"); break;
        case '\'': output_text(output, "&apos;"); break;
        default: output_write(output, text, 1); break;
        }
    }
}

/* The same. */
static tulle_status write_pvd(const char *path, const char *const *files, const double *times,
                              size_t count, file_sum *sum, tulle_error *error) {
    bool has_all = path && (count == 0 || (files && times));
    for (size_t i = 0; has_all && i < count; i++) has_all = files[i] != NULL;
    if (!has_all)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "path, files and times may not be null");
    output_file *output = NULL;
    tulle_status const status =
        sum ? output_open_unflushed(path, &output, error) : output_open(path, &output, error);
    if (status) return status;
    output_text(output, "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
                        "byte_order=\"LittleEndian\">\n<Collection>\n");
    for (size_t i = 0; i < count; i++) {
        output_text(output, "<DataSet timestep=\"");
        output_double(output, times[i]);
        output_text(output, "\" group=\"\" part=\"0\" file=\"");
        write_escaped(output, files[i]);
        output_text(output, "\"/>\n");
    }
    output_text(output, "</Collection>\n</VTKFile>\n");
    return output_commit_summed(output, sum, error);
}

tulle_status tulle_pvd_write(const char *path, const char *const *files, const double *times,
                             size_t count, tulle_error *error) {
    return write_pvd(path, files, times, count, NULL, error);
}

tulle_status pvd_write_unflushed(const char *path, const char *const *files, const double *times,
                                 size_t count, file_sum *sum, tulle_error *error) {
    return write_pvd(path, files, times, count, sum, error);
}
