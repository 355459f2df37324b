/* step/pinch/pinch_sides.c - see pinch_sides.h; and the search for squeezed cloth that a step
 * tears. */
#include "step/pinch/pinch_sides.h"

#include "step/pinch/holds.h"
#include "step/pinch/pinch.h"

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

blocked_place step_find_blocked_place(const step_model *model, motion_state *state,
                                      step_work *work) {
    const commit_report *const commit = &work->pinch.blocked;
    blocked_place place = {0};
    if (!commit->has_blocking) return place;
    place.is_pair = true;
    place.kind = commit->blocking_kind;
    feature_pair_vertices(&model->topo, commit->blocking_kind, commit->blocking_pair,
                          place.vertices);
    uint32_t chosen = place.vertices[0];
    for (int k = 3; k >= 0; k--)
        if (work->surfaces[model->vertex_surface[place.vertices[k]]].is_body)
            chosen = place.vertices[k];
    for (int k = 3; k >= 0; k--)
        if (place.vertices[k] < model->cloth_vertex_count) chosen = place.vertices[k];
    place.surface = model->vertex_surface[chosen];
    place.position = vec3_load(state->positions, chosen);
    return place;
}

/* The obstacle of a row between cloth and an obstacle that touches a vertex of the place or one of
 * its neighbours. SIZE_MAX for other rows. */
static size_t find_row_obstacle(const step_model *model, const contact_row *row,
                                const blocked_place *place) {
    const adjacency *const around = &model->topo.vertex_neighbours;
    bool has_cloth = false, is_near = false;
    size_t obstacle = SIZE_MAX;
    for (int k = 0; k < 4; k++) {
        size_t const surface = model->vertex_surface[row->frame.vertices[k]];
        if (surface < model->cloths.count)
            has_cloth = true;
        else
            obstacle = surface - model->cloths.count;
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
static void add_row(const step_model *model, const contact_row *row, pinch_side *side) {
    bool const is_first = row->frame.vertices[0] < model->cloth_vertex_count;
    double const sign = is_first ? 1.0 : -1.0;
    double const weight =
        side->load > 0.0 ? fmax(0.0, vec3_dot(row->frame.normal, row->solve.impulse)) : 1.0;
    side->direction = vec3_add(side->direction, vec3_scale(row->frame.normal, sign * weight));
    if (side->is_near && row->frame.gap >= side->gap) return;
    double sum = 0.0;
    for (int k = 0; k < 4; k++)
        if (row->frame.vertices[k] >= model->cloth_vertex_count) sum += row->frame.weights[k];
    if (sum == 0.0) return;
    uint32_t own = 0;
    for (int k = 0; k < 4; k++)
        if (row->frame.vertices[k] >= model->cloth_vertex_count) own = row->frame.vertices[k];
    for (int k = 0; k < 4; k++) {
        bool const is_own = row->frame.vertices[k] >= model->cloth_vertex_count;
        side->points[k] = is_own ? row->frame.vertices[k] : own;
        side->weights[k] = is_own ? row->frame.weights[k] / sum : 0.0;
    }
    side->gap = row->frame.gap;
    side->is_near = true;
}

/* Adds the pair that blocked. It may have no row, as where pins hold all of the cloth's side. */
static void add_blocked_pair(const step_model *model, const step_work *work,
                             const blocked_place *place, pinch_side *sides) {
    if (!place->is_pair) return;
    contact_row pair = {0};
    vec3 points[4];
    for (int k = 0; k < 4; k++) {
        pair.frame.vertices[k] = place->vertices[k];
        points[k] = vec3_load(work->start->positions, place->vertices[k]);
    }
    size_t const obstacle = find_row_obstacle(model, &pair, place);
    if (obstacle == SIZE_MAX || sides[obstacle].is_near) return;
    closest_points const closest = closest_of_pair(place->kind, points);
    memcpy(pair.frame.weights, closest.weights, sizeof pair.frame.weights);
    pair.frame.gap = sqrt(closest.distance2);
    if (!(pair.frame.gap > 0.0)) return;
    pair.frame.normal = vec3_scale(closest.difference, 1.0 / pair.frame.gap);
    sides[obstacle].load = 0.0;
    add_row(model, &pair, &sides[obstacle]);
    sides[obstacle].has_direction = sides[obstacle].is_near;
}

void step_measure_pinch_sides(const step_model *model, step_work *work, const blocked_place *place,
                              pinch_side *sides) {
    for (size_t r = 0; r < work->rows.rows.count; r++) {
        const contact_row *const row = &work->rows.rows.data[r];
        size_t const obstacle = find_row_obstacle(model, row, place);
        if (obstacle == SIZE_MAX) continue;
        sides[obstacle].load += fmax(0.0, vec3_dot(row->frame.normal, row->solve.impulse));
        sides[obstacle].row_count++;
    }
    for (size_t r = 0; r < work->rows.rows.count; r++) {
        const contact_row *const row = &work->rows.rows.data[r];
        size_t const obstacle = find_row_obstacle(model, row, place);
        if (obstacle != SIZE_MAX) add_row(model, row, &sides[obstacle]);
    }
    for (size_t i = 0; i < model->obstacles.count; i++) {
        pinch_side *const side = &sides[i];
        double const norm = vec3_norm(side->direction);
        double const sum = side->load > 0.0 ? side->load : (double)side->row_count;
        side->has_direction = side->is_near && norm > DIRECTION_MIN * sum;
        if (side->has_direction) side->direction = vec3_scale(side->direction, 1.0 / norm);
    }
    add_blocked_pair(model, work, place, sides);
}

/* ---- squeezed cloth that tears ---- */

/* [m] How far the point of a side goes along `direction` in this step. */
static double get_way(const motion_state *state, const step_work *work, const pinch_side *side,
                      vec3 direction) {
    double way = 0.0;
    for (int k = 0; k < 4; k++) {
        uint32_t const v = side->points[k];
        vec3 const step =
            vec3_sub(vec3_load(state->positions, v), vec3_load(work->start->positions, v));
        way += side->weights[k] * vec3_dot(step, direction);
    }
    return way;
}

/* Whether two obstacles that are nearer to the cloth at a place than the contact distance have come
 * nearer to each other. Free bodies give way. */
static bool is_squeezed(const step_model *model, const motion_state *state, step_work *work,
                        const blocked_place *place) {
    size_t const count = model->obstacles.count;
    arena_mark const mark = arena_get_mark(&work->scratch);
    pinch_side *const sides = ARENA_NEW_ZEROED(&work->scratch, pinch_side, count + 1);
    bool is_so = false;
    if (sides) step_measure_pinch_sides(model, work, place, sides);
    for (size_t i = 0; sides && i < count; i++) {
        const pinch_side *const a = &sides[i];
        bool const is_pressing = a->has_direction && !(a->gap > model->contact_distance) &&
                                 !work->surfaces[model->cloths.count + i].is_body;
        for (size_t j = i + 1; is_pressing && j < count; j++) {
            const pinch_side *const b = &sides[j];
            if (!b->has_direction || b->gap > model->contact_distance ||
                work->surfaces[model->cloths.count + j].is_body ||
                vec3_dot(a->direction, b->direction) > SQUEEZE_COSINE)
                continue;
            vec3 const across = vec3_normalize(vec3_sub(a->direction, b->direction));
            is_so |= get_way(state, work, a, across) - get_way(state, work, b, across) >
                     1e-6 * model->minimum_gap;
        }
    }
    arena_release(&work->scratch, mark);
    return is_so;
}

bool step_tears_squeezed(const step_model *model, motion_state *state, step_work *work) {
    bool const may_tear =
        work->report->max_stretch > TEARING_FREE + TEARING_GROWTH && !model->cloth_model->shape;
    if (!may_tear || model->obstacles.count < 2 || work->rows.rows.count == 0) return false;
    const double *const states[3] = {model->rest, work->start->positions, state->positions};
    for (size_t e = 0; e < model->cloth_edge_count; e++) {
        uint32_t const a = model->topo.edges[2 * e], b = model->topo.edges[2 * e + 1];
        double lengths[3];
        for (int k = 0; k < 3; k++)
            lengths[k] = vec3_norm(vec3_sub(vec3_load(states[k], a), vec3_load(states[k], b)));
        double const before = lengths[1] / lengths[0], after = lengths[2] / lengths[0];
        if (!(after - fmax(before, TEARING_FREE) > TEARING_GROWTH)) continue;
        work->pinch.torn_place = (blocked_place){.vertices = {a, b, a, b},
                                                 .surface = model->vertex_surface[a],
                                                 .position = vec3_load(work->start->positions, a)};
        if (is_squeezed(model, state, work, &work->pinch.torn_place)) return true;
    }
    return false;
}
