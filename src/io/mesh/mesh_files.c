/* io/mesh/mesh_files.c - tulle_mesh_read and tulle_mesh_write: which format a file has, and the
 * writers.
 */
#include "base/error.h"
#include "io/bytes.h"
#include "io/mesh/mesh_builder.h"
#include "io/output_file.h"
#include "io/text/text_cursor.h"
#include "io/unflushed.h"

#include "tulle_io/mesh_files.h"

#include <math.h>
#include <string.h>

typedef enum mesh_format { FORMAT_NONE, FORMAT_OBJ, FORMAT_PLY, FORMAT_STL } mesh_format;

static bool ends_with(const char *path, const char *extension) {
    size_t const length = strlen(path);
    size_t const tail = strlen(extension);
    if (length < tail) return false;
    for (size_t i = 0; i < tail; i++) {
        char const c = path[length - tail + i];
        if ((c >= 'A' && c <= 'Z' ? (char)(c + 32) : c) != extension[i]) return false;
    }
    return true;
}

static mesh_format find_format(const char *path) {
    if (ends_with(path, ".obj")) return FORMAT_OBJ;
    if (ends_with(path, ".ply")) return FORMAT_PLY;
    if (ends_with(path, ".stl")) return FORMAT_STL;
    return FORMAT_NONE;
}

static bool begins_with(const file_data *data, const char *text) {
    size_t const length = strlen(text);
    return data->byte_count >= length && memcmp(data->bytes, text, length) == 0;
}

static tulle_status read_format(memory *heap, const char *path, const file_data *data,
                                tulle_mesh *mesh, tulle_mesh_source *source, tulle_error *error) {
    mesh_format const format = find_format(path);
    if (data->byte_count == 0)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0, "is empty, not a mesh");
    if (!stl_has_binary_size(data) && text_is_utf16(data->bytes, data->byte_count))
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0, TEXT_UTF16_MESSAGE);
    if (begins_with(data, "ply\n") || begins_with(data, "ply\r") || format == FORMAT_PLY)
        return ply_read(heap, path, data, mesh, source, error);
    if (format == FORMAT_OBJ) return obj_read(heap, path, data, mesh, source, error);
    bool const is_solid = begins_with(data, "solid") || begins_with(data, "SOLID");
    if (format == FORMAT_STL || is_solid || stl_has_binary_size(data))
        return is_solid && !stl_has_binary_size(data)
                   ? stl_read_text(heap, path, data, mesh, error)
                   : stl_read_binary(heap, path, data, mesh, error);
    if (ends_with(path, ".yaml") || ends_with(path, ".yml"))
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0, FILE_SCENE_MESSAGE, path);
    static const char *const animations[] = {".glb",  ".gltf", ".usda", ".usd",
                                             ".usdc", ".npz",  ".abc"};
    for (size_t i = 0; i < sizeof animations / sizeof animations[0]; i++)
        if (ends_with(path, animations[i]))
            return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
                                "is an animation, and a mesh is wanted here; 'tulle convert' makes "
                                "one of a frame of it, as OUT.ply by --frame 0");
    static const struct {
        const char *extension, *name;
    } others[] = {{".usdz", "a packed USD file"}, {".fbx", "an FBX file"},
                  {".dae", "a COLLADA file"},     {".blend", "a Blender file"},
                  {".3ds", "a 3DS file"},         {".x3d", "an X3D file"},
                  {".off", "an OFF file"},        {".step", "a STEP file"},
                  {".stp", "a STEP file"},        {".3mf", "a 3MF file"}};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        if (ends_with(path, others[i].extension))
            return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
                                "is %s, which is not read; export a mesh as .ply or .obj, an "
                                "animation as .glb, .abc or .usda (USD's text form)",
                                others[i].name);
    return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
                        "its format is not known here; meshes end in .obj, .ply or .stl, "
                        "animations in .glb, .gltf, .usda, .usd, .npz or .abc, point caches in "
                        ".pc2 or .mdd ('tulle convert' makes meshes of .vtp files)");
}

tulle_status tulle_mesh_read_source(const char *path, tulle_mesh *mesh, tulle_mesh_source *source,
                                    tulle_error *error) {
    if (source) *source = (tulle_mesh_source){0};
    if (!path || !mesh)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "path and mesh may not be null");
    memory heap = memory_default();
    file_data data;
    tulle_status status = file_load(&heap, path, 0, &data, error);
    if (status) return status;
    status = read_format(&heap, path, &data, mesh, source, error);
    file_release(&heap, &data);
    return status;
}

tulle_status tulle_mesh_read(const char *path, tulle_mesh *mesh, tulle_error *error) {
    return tulle_mesh_read_source(path, mesh, NULL, error);
}

void tulle_mesh_source_destroy(tulle_mesh_source *source) {
    if (!source) return;
    memory heap = memory_default();
    memory_release(&heap, source->vertex_lines, source->vertex_count * sizeof(uint32_t));
    memory_release(&heap, source->triangle_lines, source->triangle_count * sizeof(uint32_t));
    memory_release(&heap, source->corner_uvs, 6 * source->triangle_count * sizeof(double));
    memory_release(&heap, source->parts, source->part_count * sizeof *source->parts);
    memory_release(&heap, source->part_names, source->part_bytes);
    *source = (tulle_mesh_source){0};
}

/* ---- writing ---- */

static void write_obj(output_file *output, tulle_mesh_view mesh) {
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        output_text(output, "v");
        for (size_t axis = 0; axis < 3; axis++) {
            output_text(output, " ");
            output_double(output, mesh.positions[3 * i + axis]);
        }
        output_text(output, "\n");
    }
    for (size_t i = 0; i < mesh.triangle_count; i++) {
        output_text(output, "f");
        for (size_t corner = 0; corner < 3; corner++) {
            output_text(output, " ");
            output_unsigned(output, (uint64_t)mesh.triangles[3 * i + corner] + 1);
        }
        output_text(output, "\n");
    }
}

static void write_ply(output_file *output, tulle_mesh_view mesh) {
    output_text(output, "ply\nformat binary_little_endian 1.0\nelement vertex ");
    output_unsigned(output, mesh.vertex_count);
    output_text(output, "\nproperty double x\nproperty double y\nproperty double z\nelement face ");
    output_unsigned(output, mesh.triangle_count);
    output_text(output, "\nproperty list uchar uint vertex_indices\nend_header\n");
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++) {
        unsigned char bytes[8];
        bytes_store_double(bytes, mesh.positions[i]);
        output_write(output, bytes, sizeof bytes);
    }
    for (size_t i = 0; i < mesh.triangle_count; i++) {
        unsigned char bytes[13] = {3};
        for (size_t corner = 0; corner < 3; corner++)
            bytes_store(bytes + 1 + 4 * corner, 4, mesh.triangles[3 * i + corner]);
        output_write(output, bytes, sizeof bytes);
    }
}

/* Unit normal of a triangle; zero for one without area. */
static void compute_normal(const double *const corners[3], double normal[3]) {
    double first[3], second[3];
    for (int axis = 0; axis < 3; axis++) {
        first[axis] = corners[1][axis] - corners[0][axis];
        second[axis] = corners[2][axis] - corners[0][axis];
    }
    for (int axis = 0; axis < 3; axis++) {
        int const next = (axis + 1) % 3;
        int const last = (axis + 2) % 3;
        normal[axis] = first[next] * second[last] - first[last] * second[next];
    }
    double const length =
        sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int axis = 0; axis < 3; axis++)
        normal[axis] = length > 0.0 && isfinite(length) ? normal[axis] / length : 0.0;
}

static void write_stl(output_file *output, tulle_mesh_view mesh) {
    char header[84] = "binary STL, metres";
    bytes_store(header + 80, 4, mesh.triangle_count);
    output_write(output, header, sizeof header);
    for (size_t i = 0; i < mesh.triangle_count; i++) {
        const double *corners[3];
        for (size_t corner = 0; corner < 3; corner++)
            corners[corner] = mesh.positions + 3 * (size_t)mesh.triangles[3 * i + corner];
        double normal[3];
        compute_normal(corners, normal);
        unsigned char bytes[50] = {0};
        for (size_t axis = 0; axis < 3; axis++) {
            bytes_store_float(bytes + 4 * axis, (float)normal[axis]);
            for (size_t corner = 0; corner < 3; corner++)
                bytes_store_float(bytes + 12 + 12 * corner + 4 * axis,
                                  (float)corners[corner][axis]);
        }
        output_write(output, bytes, sizeof bytes);
    }
}

/* Every number must be finite in the file's precision, every index in range. */
static tulle_status check_mesh(tulle_mesh_view mesh, mesh_format format, tulle_error *error) {
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++) {
        double const value = mesh.positions[i];
        if (!isfinite(value) || (format == FORMAT_STL && !isfinite((float)value)))
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "coordinate %c of vertex %zu is not a finite number that the file's "
                             "format can hold",
                             "xyz"[i % 3], i / 3);
    }
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        if (mesh.triangles[i] >= mesh.vertex_count)
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "triangle %zu uses vertex %u, but there are only %zu", i / 3,
                             mesh.triangles[i], mesh.vertex_count);
    return TULLE_OK;
}

/* sum null: the file is flushed to disk. */
static tulle_status write_mesh(const char *path, tulle_mesh_view mesh, file_sum *sum,
                               tulle_error *error) {
    if (!path || (mesh.vertex_count > 0 && !mesh.positions) ||
        (mesh.triangle_count > 0 && !mesh.triangles))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "path and the arrays of the mesh may not be null");
    mesh_format const format = find_format(path);
    if (format == FORMAT_NONE)
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
                            "the name of a mesh file should end in .obj, .ply or .stl");
    tulle_status status = check_mesh(mesh, format, error);
    if (status) return status;
    output_file *output = NULL;
    status = sum ? output_open_unflushed(path, &output, error) : output_open(path, &output, error);
    if (status) return status;
    switch (format) {
    case FORMAT_OBJ: write_obj(output, mesh); break;
    case FORMAT_PLY: write_ply(output, mesh); break;
    default: write_stl(output, mesh); break;
    }
    return output_commit_summed(output, sum, error);
}

tulle_status tulle_mesh_write(const char *path, tulle_mesh_view mesh, tulle_error *error) {
    return write_mesh(path, mesh, NULL, error);
}

tulle_status mesh_write_unflushed(const char *path, tulle_mesh_view mesh, file_sum *sum,
                                  tulle_error *error) {
    return write_mesh(path, mesh, sum, error);
}
