/* world/inside.c - see inside.h.
 *
 * A connected piece of cloth that crosses nothing is inside an obstacle with all its vertices or
 * with none, so one vertex of it tells.
 *
 * Based on: Van Oosterom, Strackee, The solid angle of a plane triangle, 1983. */
#include "world/inside.h"

#include "base/error.h"

#include <math.h>

/* Over this the winding number says inside. Surfaces that face inward (rooms) have no inside. */
static const double INSIDE_WINDING = 0.5;

double find_winding_number(const uint32_t *triangles, size_t triangle_count,
                           const double *positions, vec3 point) {
    double sum = 0.0;
    for (size_t t = 0; t < triangle_count; t++) {
        vec3 corner[3];
        double length[3];
        for (size_t k = 0; k < 3; k++) {
            corner[k] = vec3_sub(vec3_load(positions, triangles[3 * t + k]), point);
            length[k] = vec3_norm(corner[k]);
        }
        double const volume = vec3_dot(corner[0], vec3_cross(corner[1], corner[2]));
        double const scale =
            length[0] * length[1] * length[2] + vec3_dot(corner[0], corner[1]) * length[2] +
            vec3_dot(corner[1], corner[2]) * length[0] + vec3_dot(corner[2], corner[0]) * length[1];
        sum += 2.0 * atan2(volume, scale);
    }
    return sum / (4.0 * acos(-1.0));
}

bool surface_is_closed(const topology *topo, const surface_range *range) {
    for (uint32_t e = range->edge_begin; e < range->edge_end; e++)
        if (topo->edge_triangles[2 * (size_t)e + 1] == TULLE_NONE) return false;
    return true;
}

/* Marks all that hangs together with `seed`. */
static void mark_piece(const topology *topo, uint32_t seed, bool *is_seen, uint32_t *queue) {
    adjacency const *const around = &topo->vertex_edges;
    size_t head = 0, tail = 0;
    is_seen[seed] = true;
    queue[tail++] = seed;
    while (head < tail) {
        uint32_t const vertex = queue[head++];
        for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++) {
            uint32_t const *const ends = topo->edges + 2 * (size_t)around->items[i];
            uint32_t const next = ends[0] == vertex ? ends[1] : ends[0];
            if (is_seen[next]) continue;
            is_seen[next] = true;
            queue[tail++] = next;
        }
    }
}

static bool is_in_box(const surface_range *range, const double *positions, const double *point) {
    for (size_t c = 0; c < 3; c++) {
        double low = (double)INFINITY, high = -(double)INFINITY;
        for (size_t v = range->vertex_begin; v < range->vertex_end; v++) {
            low = fmin(low, positions[3 * v + c]);
            high = fmax(high, positions[3 * v + c]);
        }
        if (point[c] < low || point[c] > high) return false;
    }
    return true;
}

/* The obstacle that has a point inside, or null. */
static const surface_range *find_holder(const tulle_world *world, const double *positions,
                                        uint32_t vertex) {
    double const *const point = positions + 3 * (size_t)vertex;
    for (size_t s = world->cloths.count; s < world_surface_count(world); s++) {
        surface_range const *const range = &world->surfaces[s];
        if (!range->is_present || !is_in_box(range, positions, point)) continue;
        if (!surface_is_closed(&world->topo, range)) continue;
        if (find_winding_number(world->topo.triangles + 3 * (size_t)range->triangle_begin,
                                range->triangle_end - range->triangle_begin, positions,
                                vec3_load(point, 0)) > INSIDE_WINDING)
            return range;
    }
    return NULL;
}

static tulle_status refuse(const tulle_world *world, const double *positions, uint32_t vertex,
                           const surface_range *holder, tulle_error *error) {
    uint32_t const cloth = world->vertex_surface[vertex];
    double const *const x = positions + 3 * (size_t)vertex;
    const char *const obstacle = world_surface_name(world, (size_t)(holder - world->surfaces));
    return error_set(
        error, TULLE_ERROR_INTERSECTING_START,
        "'%s' lies inside '%s' at the start (vertex %u at %.9g, %.9g, %.9g), which is "
        "closed and faces outward; move it out, turn the triangles of '%s' round if it "
        "is a container, or set start_intersections to ignore",
        world_surface_name(world, cloth), obstacle, vertex - world->surfaces[cloth].vertex_begin,
        x[0], x[1], x[2], obstacle);
}

tulle_status world_refuse_cloth_inside(tulle_world *world, const double *positions,
                                       tulle_error *error) {
    arena_mark const mark = arena_get_mark(&world->scratch);
    bool *const is_seen = ARENA_NEW_ZEROED(&world->scratch, bool, world->cloth_vertex_count);
    uint32_t *const queue = ARENA_NEW(&world->scratch, uint32_t, world->cloth_vertex_count);
    tulle_status status = TULLE_OK;
    if (!is_seen || !queue)
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to judge the start");
    for (uint32_t v = 0; v < world->cloth_vertex_count && status == TULLE_OK; v++) {
        if (is_seen[v]) continue;
        mark_piece(&world->topo, v, is_seen, queue);
        surface_range const *const holder = find_holder(world, positions, v);
        if (holder) status = refuse(world, positions, v, holder, error);
    }
    arena_release(&world->scratch, mark);
    return status;
}
