/* step/pinch/pinch.c - what happens when a step can move on no further, or tears cloth that is
 * squeezed.
 *
 * Cloth alone can always stand still. So only scripted vertices (obstacles, pins) that go where
 * cloth has no room can block a step. Obstacles that close on cloth tear it before they block the
 * step: the rows of each side push the cloth into the other side. Either way the step is undone,
 * and the message names the cloth and the obstacles around the place. Then on_pinch decides:
 * - stop: the step is an error.
 * - slow: those obstacles are held back (see holds.h), and the step is made anew. */
#include "step/pinch/pinch.h"
#include "step/bodies/bodies_sleep.h"
#include "step/lag/lag.h"
#include "step/pinch/holds.h"
#include "step/pinch/pinch_sides.h"
#include "step/script.h"

#include <math.h>
#include <string.h>

/* Obstacles that come nearer by at most this share of the minimum gap in a step count as still. */
static const double APPROACH_SHARE = 1e-6;

/* The way of an obstacle may differ by at most acos of this from the direction across the cloth.
 * Then the obstacle is held back along its way, and motion at right angles to that way does not
 * change the gap. */
static const double STRAIGHT_COSINE = 0.99;

/* Obstacles that pinch one layer of cloth may come to this many contact distances from each other.
 * Nearer ones part to there. The cloth rests between them, a little pressed. */
static const double CLOSED_DISTANCES = 1.5;

/* Two sides of cloth face each other when the cosine between their directions is under this. */
static const double OPPOSED_COSINE = -0.5;

/* What a step that is pinched again and again holds back. */
enum {
    LEVEL_CLOSED = 1, /* obstacles apart, but closed on one layer of cloth */
    LEVEL_APART,      /* as far apart as they were */
    LEVEL_STILL       /* wholly; after it, all that follows a script */
};

bool step_is_script_moving(const step_model *model, motion_state *state, step_work *work) {
    if (work->pinch.is_script_frozen) return false;
    for (size_t v = 0; v < model->vertex_count; v++) {
        if (work->active_inverse_masses[v] != 0.0) continue;
        if (memcmp(work->targets + 3 * v, state->positions + 3 * v, 3 * sizeof(double)) != 0) {
            return true;
        }
    }
    return false;
}

void step_stand_still(const step_model *model, motion_state *state) {
    size_t const vertices = model->cloth_vertex_count + 2 * model->body_count;
    size_t const bytes = 3 * vertices * sizeof(double);
    memset(state->velocities, 0, bytes);
    state->previous_time_step = 0.0;
}

/* ---- findings ---- */

/* Marks the obstacles, other than the body itself, whose vertices are beside one of the body. */
static void mark_touched(const step_model *model, uint32_t body, const uint32_t vertices[4],
                         uint8_t *is_near) {
    bool has_body = false;
    for (int k = 0; k < 4; k++) has_body |= model->vertex_surface[vertices[k]] == body;
    for (int k = 0; k < 4 && has_body; k++) {
        uint32_t const surface = model->vertex_surface[vertices[k]];
        if (surface != body && surface >= model->cloths.count)
            is_near[surface - model->cloths.count] = 1;
    }
}

/* Notes where the step is pinched, between what, and which pins move there. */
static void note_pinch(const step_model *model, const motion_state *state, step_work *work,
                       const blocked_place *place, finding_kind kind) {
    step_finding *const finding = &work->pinch.finding;
    *finding = (step_finding){.kind = kind,
                              .surface = place->surface,
                              .time = state->time,
                              .position = place->position,
                              .marks = work->pinch.is_near};
    /* A body: all obstacles that it touches, by rows and by the pair of the place. */
    bool const is_body = place->surface >= model->cloths.count;
    for (size_t i = 0; is_body && i < work->rows.rows.count; i++)
        mark_touched(model, place->surface, work->rows.rows.data[i].frame.vertices,
                     work->pinch.is_near);
    if (is_body && place->is_pair)
        mark_touched(model, place->surface, place->vertices, work->pinch.is_near);
    /* cloth: the pin that moves nearest to the place, and how many move */
    double nearest = (double)INFINITY;
    const world_cloth *const cloth = is_body ? NULL : &model->cloths.data[place->surface];
    for (size_t p = 0; cloth && p < cloth->pin_count; p++) {
        bool moves = false;
        for (size_t k = 0; k < cloth->pins[p].vertex_count; k++) {
            size_t const v = cloth->vertex_begin + cloth->pins[p].vertices[k];
            vec3 const target = vec3_load(work->targets, v);
            if (!work->is_fixed[v] ||
                vec3_norm(vec3_sub(target, vec3_load(work->start->positions, v))) == 0.0)
                continue;
            double const distance = vec3_norm(vec3_sub(target, place->position));
            moves = true;
            if (distance < nearest) finding->vertices[0] = (uint32_t)p;
            nearest = fmin(nearest, distance);
        }
        finding->count += moves;
    }
}

void step_end_pinch(const step_model *model, motion_state *state, step_work *work) {
    pinch_work *const pinch = &work->pinch;
    size_t const count = model->obstacles.count;
    step_end_holds(state, work);
    bool has_begun = false;
    for (size_t i = 0; i <= count; i++) {
        bool const was = step_is_held(model, work->start, i);
        bool const is = step_is_held(model, state, i);
        if (was || is) work->report->pinched = 1;
        has_begun |= is && !was;
        pinch->is_freed[i] = was && !is;
        if (pinch->is_freed[i])
            pinch->freed = (step_finding){
                .kind = FINDING_FOLLOWS, .time = state->time, .marks = pinch->is_freed};
    }
    if (!has_begun) pinch->finding.kind = FINDING_NONE;
}

/* ---- slow ---- */

/* [m] How far the script moves the point of an obstacle in this step. Zero for static obstacles and
 * bodies, which are not held. */
static vec3 get_way(const step_model *model, const step_work *work, size_t obstacle,
                    const pinch_side *side) {
    vec3 way = {0, 0, 0};
    if (work->surfaces[model->cloths.count + obstacle].is_static || step_may_lag(model, obstacle) ||
        model->obstacles.data[obstacle].body.is_dynamic)
        return way;
    for (int k = 0; k < 4; k++) {
        uint32_t const v = side->points[k];
        vec3 const step =
            vec3_sub(vec3_load(work->targets, v), vec3_load(work->start->positions, v));
        way = vec3_add(way, vec3_scale(step, side->weights[k]));
    }
    return way;
}

/* Holds two obstacles apart, or one from what is fixed (pair[1]: SIZE_MAX). False when neither
 * moves towards the other, or when there are too many holds. */
static bool hold_apart(const step_model *model, motion_state *state, const step_work *work,
                       const blocked_place *place, const pinch_side *sides, const size_t pair[2]) {
    bool const has_second = pair[1] != SIZE_MAX;
    const pinch_side *const a = &sides[pair[0]];
    vec3 normal = a->direction, second_way = {0, 0, 0};
    vec3 const first_way = get_way(model, work, pair[0], a);
    if (has_second) {
        normal = vec3_normalize(vec3_sub(a->direction, sides[pair[1]].direction));
        second_way = get_way(model, work, pair[1], &sides[pair[1]]);
    }
    vec3 const way = vec3_sub(first_way, second_way);
    if (vec3_dot(way, normal) > STRAIGHT_COSINE * vec3_norm(way)) normal = vec3_normalize(way);
    world_hold hold = {
        .kind = HOLD_APART, .cloth = place->surface, .obstacles = {TULLE_NONE, TULLE_NONE}};
    double const first = fmax(0.0, vec3_dot(first_way, normal));
    double const second = fmax(0.0, -vec3_dot(second_way, normal));
    if (!(first + second > APPROACH_SHARE * model->minimum_gap)) return false;
    hold.share = first / (first + second);
    for (int k = 0; k < (has_second ? 2 : 1); k++) {
        const pinch_side *const side = &sides[pair[k]];
        hold.obstacles[k] = (uint32_t)pair[k];
        memcpy(hold.points[k], side->points, sizeof side->points);
        memcpy(hold.weights[k], side->weights, sizeof side->weights);
    }
    vec3_store(hold.normal, 0, normal);
    hold.gap = vec3_dot(normal, vec3_sub(step_get_hold_point(&hold, 1, work->start->positions),
                                         step_get_hold_point(&hold, 0, work->start->positions)));
    double const closed = CLOSED_DISTANCES * model->contact_distance;
    hold.wanted_gap = has_second ? fmax(hold.gap, closed) : hold.gap;
    if (has_second && work->pinch.level == LEVEL_CLOSED && hold.gap > closed)
        hold.gap = hold.wanted_gap = fmax(closed, hold.gap - first - second);
    return step_add_hold(state, &hold);
}

/* Holds apart the obstacles around the place that come nearer to each other, or to what is fixed.
 * False when there are none. */
static bool hold_obstacles_apart(const step_model *model, motion_state *state, step_work *work,
                                 const blocked_place *place, const pinch_side *sides) {
    size_t const count = model->obstacles.count;
    bool has_any = false;
    for (size_t i = 0; i < count; i++) {
        bool has_partner = false;
        for (size_t j = 0; j < count && sides[i].has_direction; j++) {
            if (j == i || !sides[j].has_direction ||
                vec3_dot(sides[i].direction, sides[j].direction) > OPPOSED_COSINE)
                continue;
            has_partner = true;
            if (i < j) has_any |= hold_apart(model, state, work, place, sides, (size_t[2]){i, j});
        }
        if (sides[i].has_direction && !has_partner)
            has_any |= hold_apart(model, state, work, place, sides, (size_t[2]){i, SIZE_MAX});
    }
    return has_any;
}

/* Holds back more each time the step is made anew. */
static void hold_back(const step_model *model, motion_state *state, step_work *work,
                      const blocked_place *place, const pinch_side *sides) {
    if (step_delay_holds(state)) return;
    work->pinch.level++;
    if (work->pinch.level <= LEVEL_APART && hold_obstacles_apart(model, state, work, place, sides))
        return;
    if (work->pinch.level < LEVEL_STILL) work->pinch.level = LEVEL_STILL;
    bool has_still = false;
    for (size_t i = 0; work->pinch.level == LEVEL_STILL && i < model->obstacles.count; i++) {
        const surface_range *const range = &work->surfaces[model->cloths.count + i];
        bool const is_body = model->obstacles.data[i].body.is_dynamic;
        if (!sides[i].is_near || range->is_static || is_body || step_may_lag(model, i)) continue;
        world_hold still = {.kind = HOLD_STILL, .cloth = place->surface};
        still.obstacles[0] = (uint32_t)i;
        still.obstacles[1] = TULLE_NONE;
        for (int k = 0; k < 4; k++) still.points[0][k] = range->vertex_begin;
        has_still |= step_add_hold(state, &still);
    }
    if (has_still) return;
    world_hold const all = {
        .kind = HOLD_ALL, .cloth = place->surface, .obstacles = {TULLE_NONE, TULLE_NONE}};
    if (step_add_hold(state, &all)) return;
    state->hold_count = 0;
    (void)step_add_hold(state, &all);
}

/* ---- the choice ---- */

tulle_status step_handle_pinch(const step_model *model, motion_state *state, step_work *work,
                               bool is_torn) {
    pinch_work *const pinch = &work->pinch;
    arena_mark const mark = arena_get_mark(&work->scratch);
    pinch_side *const sides =
        ARENA_NEW_ZEROED(&work->scratch, pinch_side, model->obstacles.count + 1);
    if (!sides) return TULLE_ERROR_OUT_OF_MEMORY;
    blocked_place const place =
        is_torn ? pinch->torn_place : step_find_blocked_place(model, state, work);
    step_measure_pinch_sides(model, work, &place, sides);
    /* Targets at the end of the whole step, where the script alone has them. */
    double const start = work->start->time;
    tulle_status status =
        step_script_targets(model, work, start, start + work->whole_step, work->error);
    bool helps_lag = false;
    for (size_t i = 0; i < model->obstacles.count; i++) {
        pinch->is_near[i] = sides[i].is_near;
        helps_lag |= sides[i].is_near && step_may_lag(model, i);
    }
    if (status != TULLE_OK) {
        /* the reader of frames has said why */
    } else if (helps_lag && step_feel_pinch(model, work, &place)) {
        note_pinch(model, state, work, &place, FINDING_NO_ROOM);
    } else if (model->def.on_pinch == TULLE_ON_PINCH_SLOW) {
        note_pinch(model, state, work, &place, FINDING_WAITS);
        hold_back(model, state, work, &place, sides);
    } else {
        note_pinch(model, state, work, &place, FINDING_PINCHED);
        work->report->pinched = 1;
        work->failure = pinch->finding;
        status = TULLE_ERROR_PINCHED;
    }
    arena_release(&work->scratch, mark);
    return status;
}
