/* geom/mesh.c - meshes that own their arrays: create, destroy, view, transform; and the helpers
 * that validation and counting share. */
#include "geom/mesh.h"

#include "base/error.h"
#include "geom/union_find.h"
#include "math/vec3.h"

tulle_status tulle_mesh_create(size_t vertex_count, size_t triangle_count, tulle_mesh *mesh,
                               tulle_error *error) {
    if (!mesh) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the mesh pointer is null");
    *mesh = (tulle_mesh){0};
    if (vertex_count > MESH_COUNT_MAX || triangle_count > MESH_COUNT_MAX)
        return error_set(error, TULLE_ERROR_LIMIT,
                         "a mesh of %zu vertices and %zu triangles was asked for; the limit is %zu "
                         "of each",
                         vertex_count, triangle_count, MESH_COUNT_MAX);
    memory heap = memory_default();
    tulle_mesh made = {.vertex_count = vertex_count, .triangle_count = triangle_count};
    if (vertex_count > 0)
        made.positions = memory_allocate(&heap, 3 * vertex_count * sizeof *made.positions);
    if (triangle_count > 0)
        made.triangles = memory_allocate(&heap, 3 * triangle_count * sizeof *made.triangles);
    if ((vertex_count > 0 && !made.positions) || (triangle_count > 0 && !made.triangles)) {
        tulle_mesh_destroy(&made);
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                         "no memory for a mesh of %zu vertices and %zu triangles", vertex_count,
                         triangle_count);
    }
    *mesh = made;
    return TULLE_OK;
}

void tulle_mesh_destroy(tulle_mesh *mesh) {
    if (!mesh) return;
    memory heap = memory_default();
    memory_release(&heap, mesh->positions, 3 * mesh->vertex_count * sizeof *mesh->positions);
    memory_release(&heap, mesh->triangles, 3 * mesh->triangle_count * sizeof *mesh->triangles);
    *mesh = (tulle_mesh){0};
}

tulle_mesh_view tulle_mesh_get_view(const tulle_mesh *mesh) {
    if (!mesh) return (tulle_mesh_view){0};
    return (tulle_mesh_view){mesh->positions, mesh->vertex_count, mesh->triangles,
                             mesh->triangle_count};
}

/* R of the quaternion (w, x, y, z); its length is divided out, zero gives the identity. */
static mat3 rotation_of_quaternion(const double q[4]) {
    double const norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    double const f = norm2 > 0.0 ? 2.0 / norm2 : 0.0;
    double const w = q[0], x = q[1], y = q[2], z = q[3];
    return (mat3){{1.0 - f * (y * y + z * z), f * (x * y - w * z), f * (x * z + w * y),
                   f * (x * y + w * z), 1.0 - f * (x * x + z * z), f * (y * z - w * x),
                   f * (x * z - w * y), f * (y * z + w * x), 1.0 - f * (x * x + y * y)}};
}

void tulle_mesh_transform(tulle_mesh *mesh, const double scale[3], const double rotation[4],
                          const double translation[3]) {
    if (!mesh || !mesh->positions || !scale || !rotation || !translation) return;
    mat3 const matrix = rotation_of_quaternion(rotation);
    vec3 const shift = vec3_make(translation[0], translation[1], translation[2]);
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        vec3 const x = vec3_load(mesh->positions, v);
        vec3 const scaled = vec3_make(scale[0] * x.x, scale[1] * x.y, scale[2] * x.z);
        vec3_store(mesh->positions, v, vec3_add(shift, mat3_multiply_vec3(&matrix, scaled)));
    }
    bool const is_mirrored = (scale[0] < 0.0) ^ (scale[1] < 0.0) ^ (scale[2] < 0.0);
    for (size_t t = 0; is_mirrored && mesh->triangles && t < mesh->triangle_count; t++) {
        uint32_t *const corners = mesh->triangles + 3 * t, second = corners[1];
        corners[1] = corners[2];
        corners[2] = second;
    }
}

static double get_largest_component(vec3 a) { return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z))); }

double triangle_get_height_ratio(const double *positions, const uint32_t corners[3]) {
    vec3 const a = vec3_load(positions, corners[0]), b = vec3_load(positions, corners[1]),
               c = vec3_load(positions, corners[2]);
    vec3 u = vec3_sub(b, a), v = vec3_sub(c, a);
    double const size = fmax(get_largest_component(u), get_largest_component(v));
    if (!(size > 0.0)) return 0.0;
    u = vec3_make(u.x / size, u.y / size, u.z / size);
    v = vec3_make(v.x / size, v.y / size, v.z / size);
    double const longest2 = fmax(vec3_norm2(u), fmax(vec3_norm2(v), vec3_norm2(vec3_sub(v, u))));
    return vec3_norm(vec3_cross(u, v)) / longest2;
}

/* The corner of the triangle at the vertex, as 3 * triangle + k. */
static uint32_t find_corner(const topology *topo, uint32_t triangle, uint32_t vertex) {
    uint32_t corner = 3 * triangle;
    while (topo->triangles[corner] != vertex) corner++;
    return corner;
}

void mesh_join_fans(const topology *topo, const uint32_t *edge_use_counts, uint32_t *fans) {
    union_find_reset(fans, 3 * topo->triangle_count);
    for (size_t e = 0; e < topo->edge_count; e++) {
        if (edge_use_counts[e] != 2) continue;
        for (size_t end = 0; end < 2; end++) {
            uint32_t const vertex = topo->edges[2 * e + end];
            union_find_join(fans, find_corner(topo, topo->edge_triangles[2 * e], vertex),
                            find_corner(topo, topo->edge_triangles[2 * e + 1], vertex));
        }
    }
}
