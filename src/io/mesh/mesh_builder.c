/* io/mesh/mesh_builder.c - see mesh_builder.h. */
#include "io/mesh/mesh_builder.h"

#include "base/error.h"
#include "base/hash.h"

#include <math.h>
#include <string.h>

mesh_builder mesh_builder_make(memory *heap) { return (mesh_builder){.heap = heap}; }

void mesh_builder_destroy(mesh_builder *builder) {
    ARRAY_FREE(builder->heap, &builder->positions);
    ARRAY_FREE(builder->heap, &builder->triangles);
    ARRAY_FREE(builder->heap, &builder->fans);
    ARRAY_FREE(builder->heap, &builder->uvs);
    ARRAY_FREE(builder->heap, &builder->corner_uvs);
    ARRAY_FREE(builder->heap, &builder->parts);
    for (int k = 0; k < PART_KIND_COUNT; k++) ARRAY_FREE(builder->heap, &builder->open_parts[k]);
    ARRAY_FREE(builder->heap, &builder->part_names);
    ARRAY_FREE(builder->heap, &builder->vertex_lines);
    ARRAY_FREE(builder->heap, &builder->triangle_lines);
    if (builder->cutter.heap) polygon_cutter_destroy(&builder->cutter);
}

bool mesh_builder_add_vertex(mesh_builder *builder, const double position[3]) {
    if (!ARRAY_RESERVE(builder->heap, &builder->positions, 3)) return false;
    if (builder->keeps_lines) {
        if (!ARRAY_RESERVE(builder->heap, &builder->vertex_lines, 1)) return false;
        builder->vertex_lines.data[builder->vertex_lines.count++] = builder->line;
    }
    memcpy(builder->positions.data + builder->positions.count, position, 3 * sizeof *position);
    builder->positions.count += 3;
    return true;
}

size_t mesh_builder_get_vertex_count(const mesh_builder *builder) {
    return builder->positions.count / 3;
}

void mesh_builder_begin_polygon(mesh_builder *builder) { builder->fan_count = 0; }

bool mesh_builder_add_uv(mesh_builder *builder, double u, double v) {
    if (!ARRAY_RESERVE(builder->heap, &builder->uvs, 2)) return false;
    builder->uvs.data[builder->uvs.count++] = u;
    builder->uvs.data[builder->uvs.count++] = v;
    return true;
}

bool mesh_builder_add_corner(mesh_builder *builder, uint32_t vertex, uint32_t uv) {
    if (builder->fan_count == 0) builder->fan_first = vertex, builder->fan_first_uv = uv;
    if (builder->fan_count == 3) {
        if (!ARRAY_RESERVE(builder->heap, &builder->fans, 1)) return false;
        builder->fans.data[builder->fans.count++] =
            (polygon_fan){builder->triangles.count / 3 - 1, 1, builder->line, false};
    }
    if (builder->fan_count >= 3) builder->fans.data[builder->fans.count - 1].count++;
    if (builder->fan_count >= 2) {
        if (!ARRAY_RESERVE(builder->heap, &builder->triangles, 3)) return false;
        if (builder->keeps_uvs) {
            if (!ARRAY_RESERVE(builder->heap, &builder->corner_uvs, 3)) return false;
            uint32_t *const uvs = builder->corner_uvs.data + builder->corner_uvs.count;
            uvs[0] = builder->fan_first_uv;
            uvs[1] = builder->fan_last_uv;
            uvs[2] = uv;
            builder->corner_uvs.count += 3;
        }
        if (builder->keeps_lines) {
            if (!ARRAY_RESERVE(builder->heap, &builder->triangle_lines, 1)) return false;
            builder->triangle_lines.data[builder->triangle_lines.count++] = builder->line;
        }
        uint32_t *const triangle = builder->triangles.data + builder->triangles.count;
        triangle[0] = builder->fan_first;
        triangle[1] = builder->fan_last;
        triangle[2] = vertex;
        builder->triangles.count += 3;
    }
    builder->fan_last = vertex;
    builder->fan_last_uv = uv;
    builder->fan_count++;
    return true;
}

bool mesh_builder_end_parts(mesh_builder *builder, part_kind kind) {
    size_t const triangle_count = builder->triangles.count / 3;
    size_t const count = builder->open_parts[kind].count;
    if (!ARRAY_RESERVE(builder->heap, &builder->parts, count)) return false;
    for (size_t i = 0; i < count; i++) {
        named_part part = builder->open_parts[kind].data[i];
        part.count = triangle_count - part.first;
        if (part.count > 0) builder->parts.data[builder->parts.count++] = part;
    }
    builder->open_parts[kind].count = 0;
    return true;
}

bool mesh_builder_begin_part(mesh_builder *builder, part_kind kind, const char *name,
                             size_t length) {
    if (!ARRAY_RESERVE(builder->heap, &builder->open_parts[kind], 1) ||
        !ARRAY_RESERVE(builder->heap, &builder->part_names, length + 1))
        return false;
    builder->open_parts[kind].data[builder->open_parts[kind].count++] =
        (named_part){kind, builder->part_names.count, builder->triangles.count / 3, 0};
    char *const kept = builder->part_names.data + builder->part_names.count;
    memcpy(kept, name, length);
    kept[length] = '\0';
    builder->part_names.count += length + 1;
    return true;
}

bool mesh_builder_extend_name(mesh_builder *builder, const char *word, size_t length) {
    if (!ARRAY_RESERVE(builder->heap, &builder->part_names, length + 1)) return false;
    char *const end = builder->part_names.data + builder->part_names.count;
    end[-1] = ' ';
    memcpy(end, word, length);
    end[length] = '\0';
    builder->part_names.count += length + 1;
    return true;
}

static tulle_status cut_polygons(mesh_builder *builder, const char *path, const char *place,
                                 tulle_error *error) {
    builder->polygons_hash =
        hash_bytes(HASH_SEED, builder->triangles.data, builder->triangles.count * sizeof(uint32_t));
    builder->cutter = (polygon_cutter){.heap = builder->heap, .path = path, .place = place};
    polygon_list const list = {builder->positions.data, builder->triangles.data,
                               builder->keeps_uvs ? builder->corner_uvs.data : NULL,
                               builder->fans.data, builder->fans.count};
    return polygons_cut(&builder->cutter, &list, error);
}

tulle_status mesh_builder_finish(mesh_builder *builder, const char *path, const char *place,
                                 tulle_mesh *mesh, tulle_error *error) {
    size_t const vertex_count = mesh_builder_get_vertex_count(builder);
    size_t const index_count = builder->triangles.count;
    if (vertex_count == 0)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "holds no vertices; is it the right file?");
    if (vertex_count > MESH_COUNT_LIMIT || index_count / 3 > MESH_COUNT_LIMIT)
        return error_set_at(error, TULLE_ERROR_LIMIT, path, 0, 0,
                            "has %zu vertices and %zu triangles; the most of each is %zu",
                            vertex_count, index_count / 3, MESH_COUNT_LIMIT);
    for (size_t i = 0; i < index_count; i++) {
        if (builder->triangles.data[i] >= vertex_count)
            return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                                "triangle %zu uses vertex %u, but there are only %zu (both "
                                "counted from 0)",
                                i / 3, builder->triangles.data[i], vertex_count);
    }
    tulle_mesh made = {0};
    tulle_status status = cut_polygons(builder, path, place, error);
    if (status == TULLE_OK) status = tulle_mesh_create(vertex_count, index_count / 3, &made, error);
    if (status) return status;
    memcpy(made.positions, builder->positions.data, 3 * vertex_count * sizeof(double));
    if (index_count > 0)
        memcpy(made.triangles, builder->triangles.data, index_count * sizeof(uint32_t));
    *mesh = made;
    return TULLE_OK;
}

static bool has_uvs(const mesh_builder *builder) {
    size_t const known = builder->uvs.count / 2;
    for (size_t i = 0; i < builder->corner_uvs.count; i++)
        if (builder->corner_uvs.data[i] < known) return true;
    return false;
}

/* Of all corners; null without memory. */
static double *list_uvs(memory *heap, const mesh_builder *builder) {
    size_t const known = builder->uvs.count / 2, count = builder->corner_uvs.count;
    double *const uvs = memory_allocate(heap, 2 * count * sizeof *uvs);
    for (size_t i = 0; uvs && i < count; i++) {
        uint32_t const named = builder->corner_uvs.data[i];
        for (size_t k = 0; k < 2; k++)
            uvs[2 * i + k] = named < known ? builder->uvs.data[2 * (size_t)named + k] : (double)NAN;
    }
    return uvs;
}

/* Ends all parts and copies them; where no part has triangles there is nothing to copy. */
static bool take_parts(memory *heap, mesh_builder *builder, tulle_mesh_source *made) {
    for (int kind = 0; kind < PART_KIND_COUNT; kind++)
        if (!mesh_builder_end_parts(builder, (part_kind)kind)) return false;
    if (builder->parts.count == 0) return true;
    made->part_count = builder->parts.count;
    made->part_bytes = builder->part_names.count;
    made->parts = memory_allocate(heap, made->part_count * sizeof *made->parts);
    made->part_names = memory_allocate(heap, made->part_bytes);
    if (!made->parts || !made->part_names) return false;
    memcpy(made->part_names, builder->part_names.data, made->part_bytes);
    for (size_t i = 0; i < made->part_count; i++) {
        const named_part *const part = &builder->parts.data[i];
        made->parts[i] = (tulle_mesh_part){made->part_names + part->name,
                                           part->kind == PART_MATERIAL ? TULLE_MESH_PART_MATERIAL
                                                                       : TULLE_MESH_PART_GROUP,
                                           part->first, part->count};
    }
    return true;
}

tulle_status mesh_builder_take_source(mesh_builder *builder, tulle_mesh_source *source) {
    memory heap = memory_default();
    tulle_mesh_source made = {.vertex_count = builder->positions.count / 3,
                              .triangle_count = builder->triangles.count / 3,
                              .polygons_hash = builder->polygons_hash};
    size_t const vertex_bytes = made.vertex_count * sizeof(uint32_t);
    size_t const triangle_bytes = made.triangle_count * sizeof(uint32_t);
    bool const is_dressed = has_uvs(builder);
    if (is_dressed) made.corner_uvs = list_uvs(&heap, builder);
    if (builder->keeps_lines) {
        made.vertex_lines = memory_allocate(&heap, vertex_bytes);
        made.triangle_lines = memory_allocate(&heap, triangle_bytes);
    }
    bool const has_lines = made.vertex_lines && made.triangle_lines;
    if (!take_parts(&heap, builder, &made) || (is_dressed && !made.corner_uvs) ||
        (builder->keeps_lines && !has_lines)) {
        tulle_mesh_source_destroy(&made);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    if (builder->keeps_lines) {
        memcpy(made.vertex_lines, builder->vertex_lines.data, vertex_bytes);
        if (triangle_bytes > 0)
            memcpy(made.triangle_lines, builder->triangle_lines.data, triangle_bytes);
    }
    *source = made;
    return TULLE_OK;
}
