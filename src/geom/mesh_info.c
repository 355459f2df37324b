/* geom/mesh_info.c - counts and quality of any triangle soup with valid indices.
 *
 * Triangles that name a vertex twice count as triangles and as degenerate, and for nothing else:
 * edges, pieces, loops, Euler characteristic and angles are those of the others. A boundary loop
 * follows the fans: where two fans meet in one vertex, their boundaries stay two loops. */
#include "geom/mesh.h"

#include "base/error.h"
#include "geom/union_find.h"
#include "math/vec3.h"

#include <string.h>

typedef struct survey {
    memory *heap;
    tulle_mesh_view mesh;
    tulle_mesh_info *info;
    topology topo; /* of the triangles with three different corners */
    size_t edge_count;
    uint32_t *edge_use_counts; /* edge_count */
    uint32_t *sets;            /* union-find over triangles, corners or edges: 3 * triangle_count */
    uint32_t *fan_edges;       /* 3 * triangle_count: the first boundary edge of each fan */
} survey;

static void measure_bounds(survey *s) {
    tulle_mesh_info *const info = s->info;
    if (s->mesh.vertex_count == 0) return;
    for (int k = 0; k < 3; k++) {
        info->bounds_min[k] = INFINITY;
        info->bounds_max[k] = -INFINITY;
    }
    for (size_t v = 0; v < s->mesh.vertex_count; v++) {
        for (int k = 0; k < 3; k++) {
            double const x = s->mesh.positions[3 * v + (size_t)k];
            info->bounds_min[k] = fmin(info->bounds_min[k], x);
            info->bounds_max[k] = fmax(info->bounds_max[k], x);
        }
    }
}

static double measure_smallest_angle(vec3 a, vec3 b, vec3 c) {
    vec3 const corners[3] = {a, b, c};
    double smallest = INFINITY;
    for (int k = 0; k < 3; k++) {
        vec3 const u = vec3_sub(corners[(k + 1) % 3], corners[k]);
        vec3 const v = vec3_sub(corners[(k + 2) % 3], corners[k]);
        smallest = fmin(smallest, atan2(vec3_norm(vec3_cross(u, v)), vec3_dot(u, v)));
    }
    return smallest;
}

static void measure_triangles(survey *s) {
    double angle_min = INFINITY;
    for (size_t t = 0; t < s->topo.triangle_count; t++) {
        const uint32_t *const corner = s->topo.triangles + 3 * t;
        vec3 const a = vec3_load(s->mesh.positions, corner[0]);
        vec3 const b = vec3_load(s->mesh.positions, corner[1]);
        vec3 const c = vec3_load(s->mesh.positions, corner[2]);
        s->info->area += 0.5 * vec3_norm(vec3_cross(vec3_sub(b, a), vec3_sub(c, a)));
        if (triangle_get_height_ratio(s->mesh.positions, corner) > 0.0)
            angle_min = fmin(angle_min, measure_smallest_angle(a, b, c));
        else
            s->info->degenerate_triangle_count++;
    }
    s->info->angle_min = isfinite(angle_min) ? angle_min : 0.0;
}

static void measure_edges(survey *s) {
    tulle_mesh_info *const info = s->info;
    info->edge_count = s->edge_count;
    if (s->edge_count == 0) return;
    info->edge_length_min = INFINITY;
    double sum = 0.0;
    for (size_t e = 0; e < s->edge_count; e++) {
        vec3 const a = vec3_load(s->mesh.positions, s->topo.edges[2 * e]);
        vec3 const b = vec3_load(s->mesh.positions, s->topo.edges[2 * e + 1]);
        double const length = vec3_norm(vec3_sub(b, a));
        info->edge_length_min = fmin(info->edge_length_min, length);
        info->edge_length_max = fmax(info->edge_length_max, length);
        sum += length;
        if (s->edge_use_counts[e] == 1) info->boundary_edge_count++;
        if (s->edge_use_counts[e] > 2) info->nonmanifold_edge_count++;
    }
    info->edge_length_mean = sum / (double)s->edge_count;
}

/* Unreferenced vertices are those that no triangle at all names. */
static void count_vertices(survey *s) {
    const uint32_t *const begin = s->topo.vertex_triangles.begin;
    size_t used_count = 0;
    for (size_t v = 0; v < s->mesh.vertex_count; v++) used_count += begin[v] != begin[v + 1];
    s->info->euler_characteristic =
        (long)used_count - (long)s->edge_count + (long)s->topo.triangle_count;
    size_t named_count = used_count;
    for (size_t t = 0; t < s->mesh.triangle_count; t++) {
        const uint32_t *const corner = s->mesh.triangles + 3 * t;
        if (corner[0] != corner[1] && corner[1] != corner[2] && corner[2] != corner[0]) continue;
        for (int k = 0; k < 3; k++) {
            uint32_t *const mark = &s->topo.vertex_neighbours.begin[corner[k]];
            bool const is_new = begin[corner[k]] == begin[corner[k] + 1] && *mark != TULLE_NONE;
            if (is_new) {
                named_count++;
                *mark = TULLE_NONE; /* the neighbour lists are not used here */
            }
        }
    }
    s->info->unreferenced_vertex_count = s->mesh.vertex_count - named_count;
}

static void count_components(survey *s) {
    size_t const count = s->topo.triangle_count;
    union_find_reset(s->sets, count);
    for (size_t h = 0; h < 3 * count; h++)
        union_find_join(s->sets, (uint32_t)(h / 3),
                        s->topo.edge_triangles[2 * (size_t)s->topo.triangle_edges[h]]);
    for (uint32_t t = 0; t < count; t++)
        s->info->component_count += union_find_root(s->sets, t) == t;
}

/* Notes the edge on the fan of a corner, and joins it with the fan's other boundary edge. */
static void link_boundary_edge(survey *s, uint32_t *loops, uint32_t corner, uint32_t edge) {
    uint32_t *const fan_edge = &s->fan_edges[union_find_root(s->sets, corner)];
    if (*fan_edge == TULLE_NONE)
        *fan_edge = edge;
    else
        union_find_join(loops, *fan_edge, edge);
}

/* loops: union-find over edges; the boundary edges of one fan belong to one loop. */
static void count_loops(survey *s, uint32_t *loops) {
    size_t const corner_count = 3 * s->topo.triangle_count;
    mesh_join_fans(&s->topo, s->edge_use_counts, s->sets);
    union_find_reset(loops, s->edge_count);
    for (size_t k = 0; k < corner_count; k++) s->fan_edges[k] = TULLE_NONE;
    for (uint32_t h = 0; h < corner_count; h++) {
        uint32_t const edge = s->topo.triangle_edges[h];
        if (s->edge_use_counts[edge] != 1) continue;
        link_boundary_edge(s, loops, h, edge);
        link_boundary_edge(s, loops, h % 3 == 2 ? h - 2 : h + 1, edge);
    }
    for (uint32_t e = 0; e < s->edge_count; e++)
        s->info->boundary_loop_count +=
            s->edge_use_counts[e] == 1 && union_find_root(loops, e) == e;
}

/* Builds the topology of the triangles with three different corners. */
static tulle_status build_proper_topology(survey *s) {
    size_t const index_count = 3 * s->mesh.triangle_count;
    uint32_t *const proper = memory_allocate(s->heap, index_count * sizeof *proper);
    if (!proper) return TULLE_ERROR_OUT_OF_MEMORY;
    size_t count = 0;
    for (size_t t = 0; t < s->mesh.triangle_count; t++) {
        const uint32_t *const corner = s->mesh.triangles + 3 * t;
        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0])
            s->info->degenerate_triangle_count++;
        else
            memcpy(proper + 3 * count++, corner, 3 * sizeof *corner);
    }
    tulle_status const status =
        topology_build(s->heap, proper, count, s->mesh.vertex_count, &s->topo);
    memory_release(s->heap, proper, index_count * sizeof *proper);
    return status;
}

static tulle_status count_topology(survey *s) {
    size_t const corner_count = 3 * s->topo.triangle_count;
    s->edge_count = s->topo.edge_count;
    size_t const edge_bytes = s->edge_count * sizeof(uint32_t);
    size_t const corner_bytes = corner_count * sizeof(uint32_t);
    s->edge_use_counts = memory_allocate(s->heap, edge_bytes);
    s->sets = memory_allocate(s->heap, corner_bytes);
    s->fan_edges = memory_allocate(s->heap, corner_bytes);
    uint32_t *const loops = memory_allocate(s->heap, edge_bytes);
    bool const has_memory = s->edge_use_counts && s->sets && s->fan_edges && loops;
    if (has_memory) {
        topology_count_edge_uses(&s->topo, s->edge_use_counts);
        measure_triangles(s);
        measure_edges(s);
        count_vertices(s);
        count_components(s);
        count_loops(s, loops);
    }
    memory_release(s->heap, s->edge_use_counts, edge_bytes);
    memory_release(s->heap, s->sets, corner_bytes);
    memory_release(s->heap, s->fan_edges, corner_bytes);
    memory_release(s->heap, loops, edge_bytes);
    return has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

tulle_status mesh_get_info(memory *heap, tulle_mesh_view mesh, tulle_mesh_info *info,
                           tulle_error *error) {
    if (!info) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the info pointer is null");
    tulle_status status = mesh_check_indices(mesh, error);
    if (status != TULLE_OK) return status;
    tulle_mesh_info found = {.vertex_count = mesh.vertex_count,
                             .triangle_count = mesh.triangle_count};
    survey s = {.heap = heap, .mesh = mesh, .info = &found};
    measure_bounds(&s);
    status = build_proper_topology(&s);
    if (status == TULLE_OK) {
        status = count_topology(&s);
        topology_destroy(heap, &s.topo);
    }
    if (status != TULLE_OK)
        return error_set(error, status,
                         "no memory to examine a mesh of %zu vertices and %zu triangles",
                         mesh.vertex_count, mesh.triangle_count);
    *info = found;
    return TULLE_OK;
}

tulle_status tulle_mesh_get_info(tulle_mesh_view mesh, tulle_mesh_info *info, tulle_error *error) {
    memory heap = memory_default();
    return mesh_get_info(&heap, mesh, info, error);
}
