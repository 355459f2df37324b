/* render/corner_normals.c - smooth normals that break at creases.
 *
 * Corners are nodes; two corners of one vertex are joined when their triangles share a smooth edge
 * there. The normal of a corner is the sum over its group of unit triangle normals weighted by the
 * corner's angle, which does not depend on how the surface is cut into triangles.
 *
 * Based on: Grit Thürmer and Charles A. Wüthrich, Computing vertex normals from polygonal facets,
 *           1998. */
#include "render/geometry.h"

#include <string.h>

/* A side of a triangle, kept at one end: two that match join their corners at that end. */
typedef struct side {
    uint32_t vertex, other; /* of the edge: the end it is kept at, the far end */
    uint32_t corner;        /* 3 * triangle + place, at `vertex` */
    uint32_t is_outgoing;   /* the triangle runs from vertex to other */
} side;

typedef struct workspace {
    tulle_mesh_view mesh;
    double crease_angle;
    side *sides, *spare; /* 6 * triangle_count */
    size_t *starts;      /* vertex_count + 1 */
    uint32_t *group;     /* of each corner, a forest */
    double *sums;        /* 3 of each corner */
} workspace;

static vec3 compute_triangle_normal(tulle_mesh_view mesh, size_t triangle) {
    const uint32_t *const t = mesh.triangles + 3 * triangle;
    vec3 const a = vec3_load(mesh.positions, t[0]);
    return vec3_normalize(vec3_cross(vec3_sub(vec3_load(mesh.positions, t[1]), a),
                                     vec3_sub(vec3_load(mesh.positions, t[2]), a)));
}

static double compute_corner_angle(tulle_mesh_view mesh, size_t corner) {
    const uint32_t *const t = mesh.triangles + corner / 3 * 3;
    vec3 const at = vec3_load(mesh.positions, t[corner % 3]);
    vec3 const a = vec3_sub(vec3_load(mesh.positions, t[(corner + 1) % 3]), at);
    vec3 const b = vec3_sub(vec3_load(mesh.positions, t[(corner + 2) % 3]), at);
    return atan2(vec3_norm(vec3_cross(a, b)), vec3_dot(a, b));
}

static uint32_t find_root(uint32_t *group, uint32_t corner) {
    while (group[corner] != corner) corner = group[corner] = group[group[corner]];
    return corner;
}

/* One pass of a stable counting sort of all sides by one of their ends. */
static void sort_sides(workspace *work, bool by_vertex) {
    size_t const count = 6 * work->mesh.triangle_count;
    memset(work->starts, 0, (work->mesh.vertex_count + 1) * sizeof *work->starts);
    for (size_t i = 0; i < count; i++) {
        const side *const s = &work->sides[i];
        work->starts[(by_vertex ? s->vertex : s->other) + 1]++;
    }
    for (size_t v = 0; v < work->mesh.vertex_count; v++) work->starts[v + 1] += work->starts[v];
    for (size_t i = 0; i < count; i++) {
        const side *const s = &work->sides[i];
        work->spare[work->starts[by_vertex ? s->vertex : s->other]++] = *s;
    }
    side *const sorted = work->spare;
    work->spare = work->sides;
    work->sides = sorted;
}

static void list_sides(workspace *work) {
    for (uint32_t corner = 0; corner < 3 * work->mesh.triangle_count; corner++) {
        uint32_t const base = corner / 3 * 3;
        const uint32_t *const t = work->mesh.triangles + base;
        uint32_t const at = t[corner % 3];
        work->sides[2 * (size_t)corner] = (side){at, t[(corner + 1) % 3], corner, 1};
        work->sides[2 * (size_t)corner + 1] = (side){at, t[(corner + 2) % 3], corner, 0};
    }
    sort_sides(work, false);
    sort_sides(work, true);
}

static bool is_smooth(const workspace *work, const side *a, const side *b) {
    if (a->is_outgoing == b->is_outgoing) return false;
    vec3 const m = compute_triangle_normal(work->mesh, a->corner / 3);
    vec3 const n = compute_triangle_normal(work->mesh, b->corner / 3);
    return atan2(vec3_norm(vec3_cross(m, n)), vec3_dot(m, n)) <= work->crease_angle;
}

static void join_corners(workspace *work) {
    size_t const count = 6 * work->mesh.triangle_count;
    for (uint32_t i = 0; i < 3 * work->mesh.triangle_count; i++) work->group[i] = i;
    for (size_t i = 0, end; i < count; i = end) {
        const side *const a = &work->sides[i];
        end = i + 1;
        while (end < count && work->sides[end].vertex == a->vertex &&
               work->sides[end].other == a->other)
            end++;
        if (end - i != 2 || !is_smooth(work, a, a + 1)) continue;
        work->group[find_root(work->group, a->corner)] = find_root(work->group, a[1].corner);
    }
}

static void sum_groups(workspace *work, float *corner_normals) {
    tulle_mesh_view const mesh = work->mesh;
    for (uint32_t corner = 0; corner < 3 * mesh.triangle_count; corner++) {
        uint32_t const root = find_root(work->group, corner);
        vec3_store(work->sums, root,
                   vec3_add_scaled(vec3_load(work->sums, root),
                                   compute_triangle_normal(mesh, corner / 3),
                                   compute_corner_angle(mesh, corner)));
    }
    for (uint32_t corner = 0; corner < 3 * mesh.triangle_count; corner++) {
        vec3 const own = compute_triangle_normal(mesh, corner / 3);
        vec3 normal = vec3_normalize(vec3_load(work->sums, find_root(work->group, corner)));
        if (vec3_dot(normal, own) <= 0.0) normal = own; /* folded over: no mean makes sense */
        float *const out = corner_normals + 3 * (size_t)corner;
        out[0] = (float)normal.x;
        out[1] = (float)normal.y;
        out[2] = (float)normal.z;
    }
}

bool render_compute_corner_normals(memory *heap, tulle_mesh_view mesh, double crease_angle,
                                   float *corner_normals) {
    size_t const corner_count = 3 * mesh.triangle_count,
                 side_bytes = 2 * corner_count * sizeof(side);
    size_t const start_bytes = (mesh.vertex_count + 1) * sizeof(size_t);
    side *const first = memory_allocate(heap, side_bytes), *const second =
                                                               memory_allocate(heap, side_bytes);
    workspace work = {.mesh = mesh,
                      .crease_angle = crease_angle,
                      .sides = first,
                      .spare = second,
                      .starts = memory_allocate(heap, start_bytes),
                      .group = memory_allocate(heap, corner_count * sizeof(uint32_t)),
                      .sums = memory_allocate_zeroed(heap, corner_count, 3 * sizeof(double))};
    bool const is_made = first && second && work.starts && work.group && work.sums;
    if (is_made) {
        list_sides(&work);
        join_corners(&work);
        sum_groups(&work, corner_normals);
    }
    memory_release(heap, first, side_bytes);
    memory_release(heap, second, side_bytes);
    memory_release(heap, work.starts, start_bytes);
    memory_release(heap, work.group, corner_count * sizeof(uint32_t));
    memory_release(heap, work.sums, corner_count * 3 * sizeof(double));
    return is_made;
}
