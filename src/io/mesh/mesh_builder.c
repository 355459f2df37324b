/* io/mesh/mesh_builder.c - see mesh_builder.h. */
#include "io/mesh/mesh_builder.h"

#include "base/error.h"

#include <string.h>

mesh_builder mesh_builder_make(memory *heap) { return (mesh_builder){.heap = heap}; }

void mesh_builder_destroy(mesh_builder *builder) {
    ARRAY_FREE(builder->heap, &builder->positions);
    ARRAY_FREE(builder->heap, &builder->triangles);
    ARRAY_FREE(builder->heap, &builder->vertex_lines);
    ARRAY_FREE(builder->heap, &builder->triangle_lines);
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

bool mesh_builder_add_corner(mesh_builder *builder, uint32_t vertex) {
    if (builder->fan_count == 0) builder->fan_first = vertex;
    if (builder->fan_count >= 2) {
        if (!ARRAY_RESERVE(builder->heap, &builder->triangles, 3)) return false;
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
    builder->fan_count++;
    return true;
}

tulle_status mesh_builder_finish(const mesh_builder *builder, const char *path, tulle_mesh *mesh,
                                 tulle_error *error) {
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
    tulle_status const status = tulle_mesh_create(vertex_count, index_count / 3, &made, error);
    if (status) return status;
    memcpy(made.positions, builder->positions.data, 3 * vertex_count * sizeof(double));
    if (index_count > 0)
        memcpy(made.triangles, builder->triangles.data, index_count * sizeof(uint32_t));
    *mesh = made;
    return TULLE_OK;
}

tulle_status mesh_builder_take_lines(const mesh_builder *builder, tulle_mesh_source *source) {
    size_t const vertex_count = builder->vertex_lines.count;
    size_t const triangle_count = builder->triangle_lines.count;
    memory heap = memory_default();
    uint32_t *const vertices = memory_allocate(&heap, vertex_count * sizeof *vertices);
    uint32_t *const triangles = memory_allocate(&heap, triangle_count * sizeof *triangles);
    if (!vertices || !triangles) {
        memory_release(&heap, vertices, vertex_count * sizeof *vertices);
        memory_release(&heap, triangles, triangle_count * sizeof *triangles);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    memcpy(vertices, builder->vertex_lines.data, vertex_count * sizeof *vertices);
    if (triangle_count > 0)
        memcpy(triangles, builder->triangle_lines.data, triangle_count * sizeof *triangles);
    source->vertex_count = vertex_count;
    source->triangle_count = triangle_count;
    source->vertex_lines = vertices;
    source->triangle_lines = triangles;
    return TULLE_OK;
}
