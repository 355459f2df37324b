/* world/start/inside.c - see inside.h.
 *
 * A connected piece of a surface that crosses nothing is inside an obstacle with all its vertices
 * or with none, so one vertex of it tells.
 *
 * Based on: Van Oosterom, Strackee, The solid angle of a plane triangle, 1983. */
#include "world/start/inside.h"

#include "base/error.h"
#include "geom/distance.h"
#include "step/surface_box.h"

#include <math.h>
#include <stdio.h>

double compute_winding_number(const uint32_t *triangles, size_t triangle_count,
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
    const adjacency *const around = &topo->vertex_edges;
    size_t head = 0, tail = 0;
    is_seen[seed] = true;
    queue[tail++] = seed;
    while (head < tail) {
        uint32_t const vertex = queue[head++];
        for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++) {
            const uint32_t *const ends = topo->edges + 2 * (size_t)around->items[i];
            uint32_t const next = ends[0] == vertex ? ends[1] : ends[0];
            if (is_seen[next]) continue;
            is_seen[next] = true;
            queue[tail++] = next;
        }
    }
}

/* What the search for holders reads. */
typedef struct holder_search {
    const tulle_world *world;
    const double *positions;
    inside_question question;
    surface_box *boxes; /* of all surfaces */
} holder_search;

/* The obstacle that has a vertex inside, where that may not be, or null. */
static const surface_range *find_holder(const holder_search *search, uint32_t vertex) {
    const tulle_world *const world = search->world;
    const double *const point = search->positions + 3 * (size_t)vertex;
    const surface_range *const held = &world->work.surfaces[world->model.vertex_surface[vertex]];
    for (size_t s = world->model.cloths.count; s < world->model.surface_count; s++) {
        const surface_range *const range = &world->work.surfaces[s];
        if (held == range || !held->is_present || !range->is_present) continue;
        /* Of two obstacles one is a body. In a step, cloth may lie in what was there before. */
        bool const is_forbidden = held->is_obstacle
                                      ? held->is_body || range->is_body
                                      : !search->question.is_late ||
                                            !world->now.is_present[s - world->model.cloths.count];
        bool const is_asked = !search->question.has_added || s == search->question.added ||
                              world->model.vertex_surface[vertex] == search->question.added;
        if (!is_forbidden || !is_asked ||
            !world_pair_collides(&world->model, s, world->model.vertex_surface[vertex]))
            continue;
        if (!surface_box_holds(&search->boxes[s], point)) continue;
        if (!surface_is_closed(&world->model.topo, range)) continue;
        if (compute_winding_number(world->model.topo.triangles + 3 * (size_t)range->triangle_begin,
                                   range->triangle_end - range->triangle_begin, search->positions,
                                   vec3_load(point, 0)) > INSIDE_WINDING)
            return range;
    }
    return NULL;
}

static tulle_status refuse(const holder_search *search, uint32_t vertex,
                           const surface_range *holder, tulle_error *error) {
    const tulle_world *const world = search->world;
    uint32_t const held = world->model.vertex_surface[vertex];
    const double *const x = search->positions + 3 * (size_t)vertex;
    const char *const name =
        world_surface_name(&world->model, (size_t)(holder - world->work.surfaces));
    char advice[WORLD_NAME_BYTES + 64]; /* what else than moving may help */
    if (holder->is_body)
        (void)snprintf(advice, sizeof advice, "give '%s' a hollow with a surface of its own", name);
    else
        (void)snprintf(advice, sizeof advice,
                       "turn the triangles of '%s' round if it is a container", name);
    double nearest2 = (double)INFINITY; /* [m^2] of the vertex to the holder's surface */
    for (size_t t = holder->triangle_begin; t < holder->triangle_end; t++) {
        vec3 points[4] = {vec3_load(x, 0)};
        for (size_t k = 0; k < 3; k++)
            points[k + 1] = vec3_load(search->positions, world->model.topo.triangles[3 * t + k]);
        nearest2 = fmin(nearest2, closest_vertex_triangle(points).distance2);
    }
    return error_set(error, TULLE_ERROR_INTERSECTING_START,
                     "'%s' lies inside '%s' %s (vertex %u at %.9g, %.9g, %.9g is %.3g m deep), "
                     "which is closed and faces outward; move it out, %s, or set "
                     "start_intersections to ignore",
                     world_surface_name(&world->model, held), name, search->question.when,
                     vertex - world->work.surfaces[held].vertex_begin, x[0], x[1], x[2],
                     sqrt(nearest2), advice);
}

tulle_status world_refuse_inside(tulle_world *world, const double *positions,
                                 inside_question question, tulle_error *error) {
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    size_t const count = world->model.vertex_count, surface_count = world->model.surface_count;
    bool *const is_seen = ARENA_NEW_ZEROED(&world->work.scratch, bool, count);
    uint32_t *const queue = ARENA_NEW(&world->work.scratch, uint32_t, count);
    holder_search search = {.world = world,
                            .positions = positions,
                            .question = question,
                            .boxes = ARENA_NEW(&world->work.scratch, surface_box, surface_count)};
    tulle_status status = TULLE_OK;
    if (!is_seen || !queue || !search.boxes)
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to judge the start");
    bool has_bodies = false; /* else only cloth can lie where it may not */
    for (size_t s = 0; status == TULLE_OK && s < surface_count; s++) {
        search.boxes[s] = measure_surface_box(&world->work.surfaces[s], positions, positions);
        has_bodies |= world->work.surfaces[s].is_body && world->work.surfaces[s].is_present;
    }
    const uint32_t *const edge_begin = world->model.topo.vertex_edges.begin;
    size_t const end = has_bodies ? count : world->model.cloth_vertex_count;
    for (size_t v = 0; status == TULLE_OK && v < end; v++) {
        bool const has_edges = edge_begin[v] < edge_begin[v + 1];
        if (is_seen[v] || !(v < world->model.cloth_vertex_count || has_edges)) continue;
        mark_piece(&world->model.topo, (uint32_t)v, is_seen, queue);
        const surface_range *const holder = find_holder(&search, (uint32_t)v);
        if (holder) status = refuse(&search, (uint32_t)v, holder, error);
    }
    arena_release(&world->work.scratch, mark);
    return status;
}
