/* world/pinch/pinch_sides.c - see pinch_sides.h; and the search for squeezed cloth that a step
 * tears. */
#include "world/pinch/pinch_sides.h"

#include "world/pinch/holds.h"

#include <math.h>
#include <string.h>

/* The contacts of an obstacle have a common direction when the mean of theirs is longer than this.
 */
static const double DIRECTION_MIN = 0.3;

/* A step tears squeezed cloth when it makes an edge longer by over TEARING_GROWTH of its rest
 * length. Stretch up to TEARING_FREE does not count. */
static const double TEARING_GROWTH = 0.1, TEARING_FREE = 1.05;

/* Cosine between the directions of two sides that squeeze cloth, at most. */
static const double SQUEEZE_COSINE = -0.5;

blocked_place world_find_blocked_place(const step_context *context) {
    const tulle_world *const world = context->world;
    const commit_report *const commit = &context->blocked;
    blocked_place place = {0};
    if (!commit->has_blocking) return place;
    place.is_pair = true;
    place.kind = commit->blocking_kind;
    feature_pair_vertices(&world->model.topo, commit->blocking_kind, commit->blocking_pair,
                          place.vertices);
    uint32_t chosen = place.vertices[0];
    for (int k = 3; k >= 0; k--)
        if (world->model.surfaces[world->model.vertex_surface[place.vertices[k]]].is_body)
            chosen = place.vertices[k];
    for (int k = 3; k >= 0; k--)
        if (place.vertices[k] < world->model.cloth_vertex_count) chosen = place.vertices[k];
    place.surface = world->model.vertex_surface[chosen];
    place.position = vec3_load(context->state->positions, chosen);
    return place;
}

/* The obstacle of a row between cloth and an obstacle that touches a vertex of the place or one of
 * its neighbours. SIZE_MAX for other rows. */
static size_t find_row_obstacle(const tulle_world *world, const contact_row *row,
                                const blocked_place *place) {
    const adjacency *const around = &world->model.topo.vertex_neighbours;
    bool has_cloth = false, is_near = false;
    size_t obstacle = SIZE_MAX;
    for (int k = 0; k < 4; k++) {
        size_t const surface = world->model.vertex_surface[row->frame.vertices[k]];
        if (surface < world->model.cloths.count)
            has_cloth = true;
        else
            obstacle = surface - world->model.cloths.count;
    }
    for (int k = 0; k < 4 && has_cloth && obstacle != SIZE_MAX; k++) {
        uint32_t const vertex = place->vertices[k];
        for (int j = 0; j < 4; j++) {
            is_near |= row->frame.vertices[j] == vertex;
            for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++)
                is_near |= around->items[i] == row->frame.vertices[j];
        }
    }
    return is_near ? obstacle : SIZE_MAX;
}

/* Adds a row to its obstacle's side: its direction by its load, or alike where none carries any. */
static void add_row(const tulle_world *world, const contact_row *row, pinch_side *side) {
    bool const is_first = row->frame.vertices[0] < world->model.cloth_vertex_count;
    double const sign = is_first ? 1.0 : -1.0;
    double const weight =
        side->load > 0.0 ? fmax(0.0, vec3_dot(row->frame.normal, row->solve.impulse)) : 1.0;
    side->direction = vec3_add(side->direction, vec3_scale(row->frame.normal, sign * weight));
    if (side->is_near && row->frame.gap >= side->gap) return;
    double sum = 0.0;
    for (int k = 0; k < 4; k++)
        if (row->frame.vertices[k] >= world->model.cloth_vertex_count) sum += row->frame.weights[k];
    if (sum == 0.0) return;
    uint32_t own = 0;
    for (int k = 0; k < 4; k++)
        if (row->frame.vertices[k] >= world->model.cloth_vertex_count) own = row->frame.vertices[k];
    for (int k = 0; k < 4; k++) {
        bool const is_own = row->frame.vertices[k] >= world->model.cloth_vertex_count;
        side->points[k] = is_own ? row->frame.vertices[k] : own;
        side->weights[k] = is_own ? row->frame.weights[k] / sum : 0.0;
    }
    side->gap = row->frame.gap;
    side->is_near = true;
}

/* Adds the pair that blocked. It may have no row, as where pins hold all of the cloth's side. */
static void add_blocked_pair(const tulle_world *world, const blocked_place *place,
                             pinch_side *sides) {
    if (!place->is_pair) return;
    contact_row pair = {0};
    vec3 points[4];
    for (int k = 0; k < 4; k++) {
        pair.frame.vertices[k] = place->vertices[k];
        points[k] = vec3_load(world->now.positions, place->vertices[k]);
    }
    size_t const obstacle = find_row_obstacle(world, &pair, place);
    if (obstacle == SIZE_MAX || sides[obstacle].is_near) return;
    closest_points const closest = closest_of_pair(place->kind, points);
    memcpy(pair.frame.weights, closest.weights, sizeof pair.frame.weights);
    pair.frame.gap = sqrt(closest.distance2);
    if (!(pair.frame.gap > 0.0)) return;
    pair.frame.normal = vec3_scale(closest.difference, 1.0 / pair.frame.gap);
    sides[obstacle].load = 0.0;
    add_row(world, &pair, &sides[obstacle]);
    sides[obstacle].has_direction = sides[obstacle].is_near;
}

void world_measure_pinch_sides(const tulle_world *world, const blocked_place *place,
                               pinch_side *sides) {
    for (size_t r = 0; r < world->work.rows.rows.count; r++) {
        const contact_row *const row = &world->work.rows.rows.data[r];
        size_t const obstacle = find_row_obstacle(world, row, place);
        if (obstacle == SIZE_MAX) continue;
        sides[obstacle].load += fmax(0.0, vec3_dot(row->frame.normal, row->solve.impulse));
        sides[obstacle].row_count++;
    }
    for (size_t r = 0; r < world->work.rows.rows.count; r++) {
        const contact_row *const row = &world->work.rows.rows.data[r];
        size_t const obstacle = find_row_obstacle(world, row, place);
        if (obstacle != SIZE_MAX) add_row(world, row, &sides[obstacle]);
    }
    for (size_t i = 0; i < world->model.obstacles.count; i++) {
        pinch_side *const side = &sides[i];
        double const norm = vec3_norm(side->direction);
        double const sum = side->load > 0.0 ? side->load : (double)side->row_count;
        side->has_direction = side->is_near && norm > DIRECTION_MIN * sum;
        if (side->has_direction) side->direction = vec3_scale(side->direction, 1.0 / norm);
    }
    add_blocked_pair(world, place, sides);
}

/* ---- squeezed cloth that tears ---- */

/* [m] How far the point of a side goes along `direction` in this step. */
static double get_way(const step_context *context, const pinch_side *side, vec3 direction) {
    double way = 0.0;
    for (int k = 0; k < 4; k++) {
        uint32_t const v = side->points[k];
        vec3 const step = vec3_sub(vec3_load(context->state->positions, v),
                                   vec3_load(context->world->now.positions, v));
        way += side->weights[k] * vec3_dot(step, direction);
    }
    return way;
}

/* Whether two obstacles that are nearer to the cloth at a place than the contact distance have come
 * nearer to each other. Free bodies give way. */
static bool is_squeezed(const step_context *context, const blocked_place *place) {
    tulle_world *const world = context->world;
    size_t const count = world->model.obstacles.count;
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    pinch_side *const sides = ARENA_NEW_ZEROED(&world->work.scratch, pinch_side, count + 1);
    bool is_so = false;
    if (sides) world_measure_pinch_sides(world, place, sides);
    for (size_t i = 0; sides && i < count; i++) {
        const pinch_side *const a = &sides[i];
        bool const is_pressing = a->has_direction && !(a->gap > world->model.contact_distance) &&
                                 !world->model.surfaces[world->model.cloths.count + i].is_body;
        for (size_t j = i + 1; is_pressing && j < count; j++) {
            const pinch_side *const b = &sides[j];
            if (!b->has_direction || b->gap > world->model.contact_distance ||
                world->model.surfaces[world->model.cloths.count + j].is_body ||
                vec3_dot(a->direction, b->direction) > SQUEEZE_COSINE)
                continue;
            vec3 const across = vec3_normalize(vec3_sub(a->direction, b->direction));
            is_so |= get_way(context, a, across) - get_way(context, b, across) >
                     1e-6 * world->model.minimum_gap;
        }
    }
    arena_release(&world->work.scratch, mark);
    return is_so;
}

bool world_tears_squeezed(step_context *context) {
    tulle_world *const world = context->world;
    bool const may_tear = context->report->max_stretch > TEARING_FREE + TEARING_GROWTH &&
                          !world->model.cloth_model->shape;
    if (!may_tear || world->model.obstacles.count < 2 || world->work.rows.rows.count == 0)
        return false;
    const double *const states[3] = {world->model.rest, world->now.positions,
                                     context->state->positions};
    for (size_t e = 0; e < world->model.cloth_edge_count; e++) {
        uint32_t const a = world->model.topo.edges[2 * e], b = world->model.topo.edges[2 * e + 1];
        double lengths[3];
        for (int k = 0; k < 3; k++)
            lengths[k] = vec3_norm(vec3_sub(vec3_load(states[k], a), vec3_load(states[k], b)));
        double const before = lengths[1] / lengths[0], after = lengths[2] / lengths[0];
        if (!(after - fmax(before, TEARING_FREE) > TEARING_GROWTH)) continue;
        context->torn_place =
            (blocked_place){.vertices = {a, b, a, b},
                            .surface = world->model.vertex_surface[a],
                            .position = vec3_load(context->world->now.positions, a)};
        if (is_squeezed(context, &context->torn_place)) return true;
    }
    return false;
}
