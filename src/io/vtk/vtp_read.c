/* io/vtk/vtp_read.c - see vtp_read.h. Puts the pieces of the file together to one mesh: points one
 * after the other, each piece's polygons over its own points. */
#include "io/vtk/vtp_read.h"

#include "base/error.h"
#include "geom/cut_polygon.h"
#include "io/file_data.h"
#include "io/vtk/vtp_document.h"
#include "io/vtk/vtp_values.h"

#include <string.h>

static const uint64_t COUNT_LIMIT = 0x7fffffff; /* points, corners and triangles */

/* The mesh so far. */
typedef struct mesh_parts {
    vtp_document *document;
    ARRAY(double) positions;
    ARRAY(uint32_t) triangles;
    ARRAY(polygon_fan) fans; /* polygons of more than three corners, to be cut */
    uint32_t polygon_count;
    polygon_cutter cutter;
    tulle_error *error;
} mesh_parts;

/* The polygons of a piece, as the file has them. */
typedef struct piece_polygons {
    uint64_t *ends, *corners; /* polygon_count, corner_count */
    uint64_t corner_count;
} piece_polygons;

static tulle_status fail(const mesh_parts *parts, tulle_status status, int line, const char *text) {
    return error_set_at(parts->error, status, parts->document->path, line, 0, "%s", text);
}

static tulle_status check_piece(const mesh_parts *parts, const vtp_piece *piece) {
    if (piece->strip_count > 0)
        return fail(parts, TULLE_ERROR_UNSUPPORTED, piece->line,
                    "holds triangle strips, which cannot be read (in ParaView: the filter "
                    "Triangulate makes triangles of them)");
    if (piece->point_count > COUNT_LIMIT || piece->polygon_count > COUNT_LIMIT)
        return fail(parts, TULLE_ERROR_LIMIT, piece->line,
                    "holds more than 2^31 - 1 points or polygons");
    if (piece->point_count > 0 && !piece->points.is_there)
        return fail(parts, TULLE_ERROR_PARSE, piece->line, "the piece has no array in Points");
    if (piece->point_count > 0 && piece->points.component_count != 3)
        return fail(parts, TULLE_ERROR_PARSE, piece->points.line,
                    "array Points: should have NumberOfComponents=\"3\"");
    if (piece->polygon_count > 0 && (!piece->connectivity.is_there || !piece->offsets.is_there))
        return fail(parts, TULLE_ERROR_PARSE, piece->line,
                    "the piece has polygons, but Polys lacks the array connectivity or offsets");
    return TULLE_OK;
}

static tulle_status add_points(mesh_parts *parts, const vtp_piece *piece) {
    memory *const heap = &parts->document->heap;
    uint64_t const count = 3 * piece->point_count;
    double *values = NULL;
    tulle_status status =
        vtp_decode_doubles(parts->document, &piece->points, "Points", count, &values, parts->error);
    if (status != TULLE_OK) return status;
    if (parts->positions.count / 3 + piece->point_count > COUNT_LIMIT)
        status = fail(parts, TULLE_ERROR_LIMIT, piece->line, "has more than 2^31 - 1 points");
    else if (!ARRAY_RESERVE(heap, &parts->positions, (size_t)count))
        status = fail(parts, TULLE_ERROR_OUT_OF_MEMORY, 0, "out of memory for its points");
    if (status == TULLE_OK) {
        memcpy(parts->positions.data + parts->positions.count, values,
               (size_t)count * sizeof *values);
        parts->positions.count += (size_t)count;
    }
    memory_release(heap, values, (size_t)count * sizeof *values);
    return status;
}

/* Each polygon must end behind its third corner or later, each corner be a point of the piece. */
static tulle_status check_ends(const mesh_parts *parts, const vtp_piece *piece,
                               const piece_polygons *polygons) {
    uint64_t begin = 0;
    for (uint64_t i = 0; i < piece->polygon_count; i++) {
        uint64_t const end = polygons->ends[i];
        if (end > COUNT_LIMIT || end < begin + 3)
            return error_set_at(
                parts->error, TULLE_ERROR_PARSE, parts->document->path, piece->offsets.line, 0,
                "array offsets: polygon %llu goes from corner %llu to %llu; it "
                "should have 3 or more",
                (unsigned long long)i, (unsigned long long)begin, (unsigned long long)end);
        begin = end;
    }
    return TULLE_OK;
}

static tulle_status check_corners(const mesh_parts *parts, const vtp_piece *piece,
                                  const piece_polygons *polygons) {
    for (uint64_t i = 0; i < polygons->corner_count; i++)
        if (polygons->corners[i] >= piece->point_count)
            return error_set_at(parts->error, TULLE_ERROR_PARSE, parts->document->path,
                                piece->connectivity.line, 0,
                                "array connectivity: value %llu is %llu, but the piece has %llu "
                                "points (counted from 0)",
                                (unsigned long long)i, (unsigned long long)polygons->corners[i],
                                (unsigned long long)piece->point_count);
    return TULLE_OK;
}

static tulle_status read_polygons(const mesh_parts *parts, const vtp_piece *piece,
                                  piece_polygons *polygons) {
    vtp_document *const document = parts->document;
    tulle_status status = vtp_decode_indices(document, &piece->offsets, "offsets",
                                             piece->polygon_count, &polygons->ends, parts->error);
    if (status == TULLE_OK) status = check_ends(parts, piece, polygons);
    if (status != TULLE_OK) return status;
    polygons->corner_count = polygons->ends[piece->polygon_count - 1];
    status = vtp_decode_indices(document, &piece->connectivity, "connectivity",
                                polygons->corner_count, &polygons->corners, parts->error);
    return status == TULLE_OK ? check_corners(parts, piece, polygons) : status;
}

/* Adds the polygons as fans; their points begin at `first_point`. */
static tulle_status add_fans(mesh_parts *parts, const vtp_piece *piece,
                             const piece_polygons *polygons, size_t first_point) {
    uint64_t const triangle_count = polygons->corner_count - 2 * piece->polygon_count;
    if (parts->triangles.count / 3 + triangle_count > COUNT_LIMIT)
        return fail(parts, TULLE_ERROR_LIMIT, piece->line, "has more than 2^31 - 1 triangles");
    if (!ARRAY_RESERVE(&parts->document->heap, &parts->triangles, 3 * (size_t)triangle_count))
        return fail(parts, TULLE_ERROR_OUT_OF_MEMORY, 0, "out of memory for its triangles");
    uint64_t begin = 0;
    for (uint64_t i = 0; i < piece->polygon_count; i++) {
        const uint64_t *const corners = polygons->corners + begin;
        uint32_t const fan_count = (uint32_t)(polygons->ends[i] - begin - 2);
        if (fan_count > 1) {
            if (!ARRAY_RESERVE(&parts->document->heap, &parts->fans, 1))
                return fail(parts, TULLE_ERROR_OUT_OF_MEMORY, 0, "out of memory for its polygons");
            parts->fans.data[parts->fans.count++] =
                (polygon_fan){parts->triangles.count / 3, fan_count, parts->polygon_count, false};
        }
        for (uint64_t k = 2; k < polygons->ends[i] - begin; k++) {
            uint32_t *const triangle = parts->triangles.data + parts->triangles.count;
            triangle[0] = (uint32_t)(first_point + corners[0]);
            triangle[1] = (uint32_t)(first_point + corners[k - 1]);
            triangle[2] = (uint32_t)(first_point + corners[k]);
            parts->triangles.count += 3;
        }
        parts->polygon_count++;
        begin = polygons->ends[i];
    }
    return TULLE_OK;
}

static tulle_status add_polygons(mesh_parts *parts, const vtp_piece *piece, size_t first_point) {
    piece_polygons polygons = {0};
    tulle_status status = read_polygons(parts, piece, &polygons);
    if (status == TULLE_OK) status = add_fans(parts, piece, &polygons, first_point);
    memory *const heap = &parts->document->heap;
    memory_release(heap, polygons.ends, (size_t)piece->polygon_count * sizeof(uint64_t));
    memory_release(heap, polygons.corners, (size_t)polygons.corner_count * sizeof(uint64_t));
    return status;
}

static tulle_status add_piece(mesh_parts *parts, const vtp_piece *piece) {
    size_t const first_point = parts->positions.count / 3;
    tulle_status status = check_piece(parts, piece);
    if (status == TULLE_OK && piece->point_count > 0) status = add_points(parts, piece);
    if (status == TULLE_OK && piece->polygon_count > 0)
        status = add_polygons(parts, piece, first_point);
    return status;
}

static tulle_status make_mesh(const mesh_parts *parts, tulle_mesh *mesh) {
    if (parts->positions.count == 0)
        return fail(parts, TULLE_ERROR_PARSE, 0, "holds no points; is it the right file?");
    tulle_mesh made = {0};
    tulle_status const status = tulle_mesh_create(parts->positions.count / 3,
                                                  parts->triangles.count / 3, &made, parts->error);
    if (status != TULLE_OK) return status;
    memcpy(made.positions, parts->positions.data, parts->positions.count * sizeof(double));
    if (parts->triangles.count > 0)
        memcpy(made.triangles, parts->triangles.data, parts->triangles.count * sizeof(uint32_t));
    *mesh = made;
    return TULLE_OK;
}

tulle_status vtp_read_memory(const char *path, const char *bytes, size_t byte_count,
                             tulle_mesh *mesh, tulle_vtp_passed_over *passed_over,
                             tulle_error *error) {
    vtp_document document;
    tulle_status status = vtp_document_read(path, bytes, byte_count, &document, error);
    mesh_parts parts = {.document = &document,
                        .cutter = {.heap = &document.heap, .path = path, .place = "polygon"},
                        .error = error};
    tulle_vtp_passed_over passed = {0};
    for (size_t i = 0; i < document.pieces.count && status == TULLE_OK; i++) {
        status = add_piece(&parts, &document.pieces.data[i]);
        passed.vertex_cells += document.pieces.data[i].vertex_cell_count;
        passed.lines += document.pieces.data[i].line_count;
    }
    polygon_list const list = {parts.positions.data, parts.triangles.data, NULL, parts.fans.data,
                               parts.fans.count};
    if (status == TULLE_OK) status = polygons_cut(&parts.cutter, &list, error);
    if (status == TULLE_OK) status = make_mesh(&parts, mesh);
    polygon_cutter_describe(&parts.cutter, passed.polygons, sizeof passed.polygons);
    if (status == TULLE_OK && passed_over) *passed_over = passed;
    polygon_cutter_destroy(&parts.cutter);
    ARRAY_FREE(&document.heap, &parts.positions);
    ARRAY_FREE(&document.heap, &parts.triangles);
    ARRAY_FREE(&document.heap, &parts.fans);
    vtp_document_destroy(&document);
    return status;
}

tulle_status tulle_vtp_read(const char *path, tulle_mesh *mesh, tulle_vtp_passed_over *passed_over,
                            tulle_error *error) {
    if (!path || !mesh)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "path and mesh may not be null");
    memory heap = memory_default();
    file_data data;
    tulle_status status = file_load(&heap, path, 0, &data, error);
    if (status == TULLE_OK)
        status = vtp_read_memory(path, data.bytes, data.byte_count, mesh, passed_over, error);
    file_release(&heap, &data);
    return status;
}
