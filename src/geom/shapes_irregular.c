/* geom/shapes_irregular.c - jitter of cloth: inner vertices move within the surface, the outline
 * stays.
 *
 * In: a regular mesh. Out: the same triangles over moved vertices. A vertex moves by less than a
 * fifth of its shortest edge, so no triangle of a sound grid turns over; where a triangle would
 * still become too slender, its vertices go back to their places, until no such triangle is left.
 */
#include "base/error.h"
#include "base/hash.h"
#include "geom/shapes.h"
#include "geom/topology.h"

static const double FULL_TURN = 6.283185307179586; /* [rad] */
/* [of the shortest edge at the vertex] */
static const double JITTER = 0.2;
/* [of its old value] The part of the height ratio that a triangle keeps at least. */
static const double KEPT_QUALITY = 0.4;

/* [m] The shortest edge at each vertex, 0 on the boundary, which does not move. */
static void measure_room(const topology *topo, const tulle_mesh *mesh, double *room) {
    for (size_t v = 0; v < mesh->vertex_count; v++) room[v] = INFINITY;
    for (size_t e = 0; e < topo->edge_count; e++) {
        const uint32_t *const ends = topo->edges + 2 * e;
        vec3 const a = vec3_load(mesh->positions, ends[0]), b = vec3_load(mesh->positions, ends[1]);
        bool const is_boundary = topo->edge_triangles[2 * e + 1] == TULLE_NONE;
        double const length = is_boundary ? 0.0 : vec3_norm(vec3_sub(b, a));
        room[ends[0]] = fmin(room[ends[0]], length);
        room[ends[1]] = fmin(room[ends[1]], length);
    }
}

/* A tube's vertex moves along its circle and its axis, all others in the plane. */
static vec3 move_vertex(const tulle_shape_def *def, vec3 x, double reach, double direction) {
    double const along = reach * cos(direction), up = reach * sin(direction);
    if (def->shape != TULLE_SHAPE_TUBE) return vec3_make(x.x + along, x.y + up, x.z);
    double const angle = along / def->radius, c = cos(angle), s = sin(angle);
    return vec3_make(c * x.x - s * x.y, s * x.x + c * x.y, x.z + up);
}

static vec3 get_normal(const double *positions, const uint32_t *corner) {
    vec3 const a = vec3_load(positions, corner[0]);
    return vec3_cross(vec3_sub(vec3_load(positions, corner[1]), a),
                      vec3_sub(vec3_load(positions, corner[2]), a));
}

static double get_longest2(const double *positions, const uint32_t *corner) {
    vec3 const a = vec3_load(positions, corner[0]), b = vec3_load(positions, corner[1]),
               c = vec3_load(positions, corner[2]);
    return fmax(vec3_norm2(vec3_sub(b, a)),
                fmax(vec3_norm2(vec3_sub(c, b)), vec3_norm2(vec3_sub(a, c))));
}

/* Height ratio seen along the old normal, against the old one. */
static bool is_sound(const tulle_mesh *mesh, const double *old_positions, const uint32_t *corner) {
    vec3 const old_normal = get_normal(old_positions, corner);
    double const kept = vec3_dot(get_normal(mesh->positions, corner), old_normal) /
                        get_longest2(mesh->positions, corner);
    return kept >= KEPT_QUALITY * vec3_norm2(old_normal) / get_longest2(old_positions, corner);
}

/* Puts the corners of slender triangles back; each round that goes on puts at least one back. */
static void restore_slender(tulle_mesh *mesh, const double *old_positions, double *room) {
    for (bool is_done = false; !is_done;) {
        is_done = true;
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            const uint32_t *const corner = mesh->triangles + 3 * t;
            if (is_sound(mesh, old_positions, corner)) continue;
            for (int k = 0; k < 3; k++) {
                if (room[corner[k]] == 0.0) continue;
                vec3_store(mesh->positions, corner[k], vec3_load(old_positions, corner[k]));
                room[corner[k]] = 0.0;
                is_done = false;
            }
        }
    }
}

tulle_status shape_jitter(memory *heap, const tulle_shape_def *def, tulle_mesh *mesh,
                          tulle_error *error) {
    topology topo;
    tulle_status status =
        topology_build(heap, mesh->triangles, mesh->triangle_count, mesh->vertex_count, &topo);
    size_t const room_bytes = mesh->vertex_count * sizeof(double);
    double *const room = memory_allocate(heap, room_bytes);
    double *const old_positions = memory_allocate(heap, 3 * room_bytes);
    if (status == TULLE_OK && room && old_positions) {
        measure_room(&topo, mesh, room);
        for (size_t v = 0; v < mesh->vertex_count; v++) {
            vec3 const x = vec3_load(mesh->positions, v);
            uint64_t random = shape_hash(def->seed, v, 1);
            double const reach = JITTER * room[v] * sqrt(random_uniform(&random));
            double const direction = FULL_TURN * random_uniform(&random);
            vec3_store(old_positions, v, x);
            if (room[v] > 0.0)
                vec3_store(mesh->positions, v, move_vertex(def, x, reach, direction));
        }
        restore_slender(mesh, old_positions, room);
    } else {
        status =
            error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                      "no memory to make the shape of %zu vertices irregular", mesh->vertex_count);
    }
    memory_release(heap, room, room_bytes);
    memory_release(heap, old_positions, 3 * room_bytes);
    topology_destroy(heap, &topo);
    return status;
}
