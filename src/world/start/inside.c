/* world/start/inside.c - see inside.h.
 *
 * A connected piece of a surface that crosses nothing is inside an obstacle with all its vertices
 * or with none, so one vertex of it tells.
 *
 * Based on: Van Oosterom, Strackee, The solid angle of a plane triangle, 1983. */
#include "world/start/inside.h"

#include "base/error.h"
#include "geom/distance.h"

#include <math.h>
#include <stdio.h>

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

/* [m] of a surface's vertices. */
typedef struct surface_box {
    double low[3], high[3];
} surface_box;

static surface_box find_box(const surface_range *range, const double *positions) {
    double const most = (double)INFINITY;
    surface_box box = {{most, most, most}, {-most, -most, -most}};
    for (size_t v = range->vertex_begin; v < range->vertex_end; v++) {
        for (size_t c = 0; c < 3; c++) {
            box.low[c] = fmin(box.low[c], positions[3 * v + c]);
            box.high[c] = fmax(box.high[c], positions[3 * v + c]);
        }
    }
    return box;
}

static bool is_in_box(const surface_box *box, const double *point) {
    for (size_t c = 0; c < 3; c++)
        if (point[c] < box->low[c] || point[c] > box->high[c]) return false;
    return true;
}

/* What the search for holders reads. */
typedef struct holder_search {
    const tulle_world *world;
    const double *positions;
    inside_question question;
    surface_box *boxes; /* of all surfaces */
} holder_search;

/* Whether surface `held` may not lie inside obstacle `holder`. */
static bool is_forbidden(const holder_search *search, size_t held, size_t holder) {
    tulle_world const *const world = search->world;
    surface_range const *const a = &world->surfaces[held], *const b = &world->surfaces[holder];
    if (held == holder || !a->is_present || !b->is_present) return false;
    if (a->is_obstacle) return a->is_body || b->is_body;
    return !search->question.is_late || !world->now.is_present[holder - world->cloths.count];
}

/* The obstacle that has a vertex inside, where that may not be, or null. */
static const surface_range *find_holder(const holder_search *search, uint32_t vertex) {
    tulle_world const *const world = search->world;
    double const *const point = search->positions + 3 * (size_t)vertex;
    for (size_t s = world->cloths.count; s < world_surface_count(world); s++) {
        surface_range const *const range = &world->surfaces[s];
        if (!is_forbidden(search, world->vertex_surface[vertex], s) ||
            !is_in_box(&search->boxes[s], point))
            continue;
        if (!surface_is_closed(&world->topo, range)) continue;
        if (find_winding_number(world->topo.triangles + 3 * (size_t)range->triangle_begin,
                                range->triangle_end - range->triangle_begin, search->positions,
                                vec3_load(point, 0)) > INSIDE_WINDING)
            return range;
    }
    return NULL;
}

static tulle_status refuse(const holder_search *search, uint32_t vertex,
                           const surface_range *holder, tulle_error *error) {
    tulle_world const *const world = search->world;
    uint32_t const held = world->vertex_surface[vertex];
    double const *const x = search->positions + 3 * (size_t)vertex;
    const char *const name = world_surface_name(world, (size_t)(holder - world->surfaces));
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
            points[k + 1] = vec3_load(search->positions, world->topo.triangles[3 * t + k]);
        nearest2 = fmin(nearest2, closest_vertex_triangle(points).distance2);
    }
    return error_set(error, TULLE_ERROR_INTERSECTING_START,
                     "'%s' lies inside '%s' %s (vertex %u at %.9g, %.9g, %.9g is %.3g m deep), "
                     "which is closed and faces outward; move it out, %s, or set "
                     "start_intersections to ignore",
                     world_surface_name(world, held), name, search->question.when,
                     vertex - world->surfaces[held].vertex_begin, x[0], x[1], x[2], sqrt(nearest2),
                     advice);
}

/* Whether some surface may not lie inside another, besides cloth: bodies take part. */
static bool has_bodies(const tulle_world *world) {
    bool has_any = false;
    for (size_t s = world->cloths.count; s < world_surface_count(world); s++)
        has_any |= world->surfaces[s].is_body && world->surfaces[s].is_present;
    return has_any;
}

static bool has_edges(const topology *topo, uint32_t vertex) {
    return topo->vertex_edges.begin[vertex] < topo->vertex_edges.begin[vertex + 1];
}

static tulle_status refuse_pieces(tulle_world *world, holder_search *search, tulle_error *error) {
    size_t const count = world->vertex_count, surface_count = world_surface_count(world);
    bool *const is_seen = ARENA_NEW_ZEROED(&world->scratch, bool, count);
    uint32_t *const queue = ARENA_NEW(&world->scratch, uint32_t, count);
    search->boxes = ARENA_NEW(&world->scratch, surface_box, surface_count);
    if (!is_seen || !queue || !search->boxes)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to judge the start");
    for (size_t s = 0; s < surface_count; s++)
        search->boxes[s] = find_box(&world->surfaces[s], search->positions);
    size_t const end = has_bodies(world) ? count : world->cloth_vertex_count;
    for (size_t v = 0; v < end; v++) {
        uint32_t const vertex = (uint32_t)v;
        bool const is_cloth = v < world->cloth_vertex_count;
        if (is_seen[v] || !(is_cloth || has_edges(&world->topo, vertex))) continue;
        mark_piece(&world->topo, vertex, is_seen, queue);
        surface_range const *const holder = find_holder(search, vertex);
        if (holder) return refuse(search, vertex, holder, error);
    }
    return TULLE_OK;
}

tulle_status world_refuse_inside(tulle_world *world, const double *positions,
                                 inside_question question, tulle_error *error) {
    arena_mark const mark = arena_get_mark(&world->scratch);
    holder_search search = {.world = world, .positions = positions, .question = question};
    tulle_status const status = refuse_pieces(world, &search, error);
    arena_release(&world->scratch, mark);
    return status;
}
