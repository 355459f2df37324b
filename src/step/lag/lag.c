/* step/lag/lag.c - see lag.h.
 *
 * At the start of a step the lags shrink, and what lags is to end where it is drawn, plus what is
 * left of its lag. Where cloth would not have its room (room.h), the ends give way. Last, what is
 * around places of pinches stands still. */
#include "step/lag/lag.h"

#include "step/lag/room.h"
#include "step/script.h"
#include "step/surface_box.h"

#include <math.h>
#include <string.h>

/* A lag shrinks at this rate [1/s], and by this speed [m/s] at least. */
static const double RETURN_RATE = 8.0, RETURN_SPEED = 0.02;
/* [contact distances] Places are sought so far beyond what comes nearer in the step. */
static const double REACH = 8.0;
/* [contact distances] What is so near to the place of a second pinch stands still, and up to twice
 * as far away it moves less. At each further pinch of the step the radius is four times as large,
 * at the last it is infinite. */
static const double STILL_RADIUS = 10.0, STILL_GROWTH = 4.0;
enum { TRIES_MAX = 10 };
/* Steps for which pins and what is rigid stand still, at first and at most. A place that pinches
 * again is still for twice as many. It is forgotten after as many steps as it was still, less one.
 * What deforms stands still in the step of the pinch alone. */
enum { WAIT_FIRST = 8, WAIT_MOST = 64 };

bool step_deforms(const step_model *model, size_t obstacle) {
    const world_obstacle *const at = &model->obstacles.data[obstacle];
    return at->read_frame || at->drive == TULLE_DRIVE_DEFORMING;
}

static bool may_lag(const step_model *model, size_t obstacle) {
    const world_obstacle *const at = &model->obstacles.data[obstacle];
    return model->lag_vertex_count > 0 && !at->is_static && !at->body.is_dynamic;
}

bool step_lags_now(const step_model *model, const step_work *work, size_t obstacle) {
    if (!may_lag(model, obstacle)) return false;
    bool const is_tried = work->lag.level > 0 || work->lag.still_count > 0;
    bool const is_pinched = is_tried && model->def.on_pinch == TULLE_ON_PINCH_SLOW;
    return is_pinched || step_deforms(model, obstacle) || work->start->largest_lags[obstacle] > 0.0;
}

static size_t get_first_vertex(const step_model *model) {
    return model->cloth_vertex_count + 2 * model->body_count;
}

vec3 step_get_lag(const step_model *model, const motion_state *state, size_t vertex) {
    size_t const first = get_first_vertex(model);
    if (vertex < first || model->lag_vertex_count == 0) return (vec3){0, 0, 0};
    return vec3_load(state->lags, vertex - first);
}

/* Adds what is left of a lag after the step. What is rigid waits where it is for its path to come
 * back to it; what deforms goes along, for cloth that rides on it would be stretched. */
static void add_rest(const step_work *work, vec3 lag, bool is_rigid, double *ends, size_t vertex) {
    double const size = vec3_norm(lag);
    vec3 const end = vec3_load(ends, vertex);
    vec3 const way = vec3_sub(end, vec3_sub(vec3_load(work->start->positions, vertex), lag));
    double const returns = work->whole_step * fmax(RETURN_SPEED, RETURN_RATE * size);
    double const left = size - fmax(returns, is_rigid ? vec3_dot(way, lag) / size : 0.0);
    if (left > 0.0) vec3_store(ends, vertex, vec3_add_scaled(end, lag, left / size));
}

static void shrink_lags(const step_model *model, const step_work *work, double *ends) {
    for (size_t i = 0; i < model->obstacles.count; i++) {
        const surface_range *const range = &work->surfaces[model->cloths.count + i];
        if (work->start->largest_lags[i] == 0.0 || model->obstacles.data[i].has_jumped) continue;
        for (size_t v = range->vertex_begin; v < range->vertex_end; v++)
            add_rest(work, step_get_lag(model, work->start, v), !step_deforms(model, i), ends, v);
    }
}

/* Pins on keyframes wait and come back, too: from where these have them at the start. Returns
 * whether any lags; ends null: no more than that. */
static bool shrink_pin_lags(const step_model *model, const step_work *work, double *ends) {
    bool has_any = false;
    if (model->def.on_pinch != TULLE_ON_PINCH_SLOW) return false;
    for (size_t c = 0; c < model->cloths.count; c++) {
        const world_cloth *const cloth = &model->cloths.data[c];
        for (size_t p = 0; p < cloth->pin_count; p++) {
            const world_pin *const pin = &cloth->pins[p];
            bool const is_led = pin->motion.key_count > 0 && work->start->time < pin->release_time;
            for (size_t k = 0; is_led && k < pin->vertex_count; k++) {
                size_t const v = cloth->vertex_begin + pin->vertices[k];
                double at[3];
                motion_apply(&pin->motion, work->start->time,
                             cloth->mesh.positions + 3 * (size_t)pin->vertices[k], 1, at);
                vec3 const lag = vec3_sub(vec3_load(work->start->positions, v), vec3_load(at, 0));
                has_any |= vec3_norm(lag) > work->whole_step * RETURN_SPEED;
                if (ends) add_rest(work, lag, true, ends, v);
            }
        }
    }
    return has_any;
}

/* What is around a place where a step was pinched stands still: what is rigid, as a whole. */
static void stand_still(const step_model *model, const step_work *work, double *ends) {
    const lag_work *const lag = &work->lag;
    const double *const starts = work->start->positions;
    for (size_t s = 0; s < model->surface_count && lag->still_count > 0; s++) {
        const surface_range *const range = &work->surfaces[s];
        bool const is_cloth = s < model->cloths.count;
        if (is_cloth ? model->def.on_pinch != TULLE_ON_PINCH_SLOW
                     : !step_lags_now(model, work, s - model->cloths.count))
            continue;
        bool const is_rigid = !is_cloth && !step_deforms(model, s - model->cloths.count);
        surface_box const box = measure_surface_box(range, starts, starts);
        for (size_t v = range->vertex_begin; v < range->vertex_end; v++) {
            if (is_cloth && !work->is_fixed[v]) continue;
            vec3 const x = vec3_load(starts, v);
            double part = 1.0;
            for (size_t k = 0; k < lag->still_count; k++) {
                const still_place *const place = &lag->still[k];
                double const away = is_rigid
                                        ? surface_box_distance(&box, place->position)
                                        : vec3_norm(vec3_sub(x, vec3_load(place->position, 0)));
                if (place->waiting > (is_cloth || is_rigid ? 0 : place->wait - 1))
                    part = fmin(part, fmax(away / place->radius - 1.0, 0.0));
            }
            if (part < 1.0) vec3_store(ends, v, vec3_lerp(x, vec3_load(ends, v), part));
        }
    }
}

/* Marks the surfaces that are led: they lag, or end elsewhere than drawn. They come back to where
 * they are drawn, to the bit, also where no script leads them there. */
static void mark_led(const step_model *model, step_work *work) {
    for (size_t s = 0; s < model->surface_count; s++) {
        size_t const begin = work->surfaces[s].vertex_begin, end = work->surfaces[s].vertex_end;
        bool const lags =
            s >= model->cloths.count && work->start->largest_lags[s - model->cloths.count] > 0.0;
        work->lag.is_led[s] =
            lags || memcmp(work->lag.lagging + 3 * begin, work->lag.drawn + 3 * begin,
                           3 * (end - begin) * sizeof(double)) != 0;
    }
}

tulle_status step_begin_lag(const step_model *model, step_work *work) {
    size_t const n = 3 * model->vertex_count, first = get_first_vertex(model);
    const double *const starts = work->start->positions;
    bool is_wanted = work->lag.still_count > 0 || shrink_pin_lags(model, work, NULL);
    work->lag.is_led = NULL;
    for (size_t i = 0; i < model->obstacles.count; i++) is_wanted |= step_lags_now(model, work, i);
    if (!is_wanted) return TULLE_OK;
    double const start = work->start->time;
    tulle_status status =
        step_script_targets(model, work, start, start + work->whole_step, work->error);
    if (status != TULLE_OK) return status;
    double *const drawn = ARENA_NEW(&work->scratch, double, n);
    double *const ends = ARENA_NEW(&work->scratch, double, n);
    uint8_t *const is_led = ARENA_NEW(&work->scratch, uint8_t, model->surface_count);
    if (!drawn || !ends || !is_led) return TULLE_ERROR_OUT_OF_MEMORY;
    memcpy(drawn, work->targets, n * sizeof(double));
    for (size_t i = 0; i < model->obstacles.count; i++) {
        /* what was given no place stands as drawn, without its lag */
        const world_obstacle *const obstacle = &model->obstacles.data[i];
        const surface_range *const range = &work->surfaces[model->cloths.count + i];
        bool const stands =
            obstacle->drive == TULLE_DRIVE_DEFORMING && obstacle->given == GIVEN_NOTHING;
        for (size_t v = range->vertex_begin; stands && v < range->vertex_end; v++)
            vec3_store(drawn, v,
                       vec3_sub(vec3_load(starts, v), step_get_lag(model, work->start, v)));
    }
    memcpy(ends, drawn, n * sizeof(double));
    shrink_lags(model, work, ends);
    (void)shrink_pin_lags(model, work, ends);
    double farthest2 = 0.0; /* [m^2] way of what may lag, or follows a script beside it */
    for (size_t v = first; v < model->vertex_count; v++)
        farthest2 = fmax(farthest2, vec3_norm2(vec3_sub(vec3_load(ends, v), vec3_load(starts, v))));
    double const reach = REACH * model->contact_distance + 2.0 * sqrt(farthest2);
    status = step_find_room(model, work, ends, reach, &work->lag.places);
    if (status == TULLE_OK) status = step_make_room(model, work, &work->lag.places, ends);
    if (status != TULLE_OK) return status;
    stand_still(model, work, ends);
    work->lag.drawn = drawn;
    work->lag.lagging = ends;
    work->lag.is_led = is_led;
    mark_led(model, work);
    return TULLE_OK;
}

void step_lead_lag(const step_model *model, motion_state *state, step_work *work) {
    double const passed = state->time + work->sub.time_step - work->start->time;
    double const share = passed / work->whole_step;
    bool const is_end = share > 1.0 - REMAINDER_SHARE;
    for (size_t s = 0; s < model->surface_count && work->lag.is_led; s++) {
        const surface_range *const range = &work->surfaces[s];
        for (size_t v = range->vertex_begin; work->lag.is_led[s] && v < range->vertex_end; v++) {
            if (s < model->cloths.count && !work->is_fixed[v]) continue;
            vec3 const to = vec3_load(work->lag.lagging, v);
            vec3 const from = vec3_load(work->start->positions, v);
            vec3_store(work->targets, v, is_end ? to : vec3_lerp(from, to, share));
        }
    }
}

/* ---- the end of a step ---- */

/* The vertex of an obstacle that lags most; its size is in state->largest_lags then. */
static size_t find_largest(const step_model *model, motion_state *state, size_t obstacle) {
    const world_obstacle *const at = &model->obstacles.data[obstacle];
    double largest2 = 0.0;
    size_t vertex = at->vertex_begin;
    for (size_t v = at->vertex_begin; v < at->vertex_begin + at->mesh.vertex_count; v++) {
        double const size2 = vec3_norm2(step_get_lag(model, state, v));
        if (!(size2 > largest2)) continue;
        largest2 = size2;
        vertex = v;
    }
    state->largest_lags[obstacle] = sqrt(largest2);
    return vertex;
}

void step_measure_lags(const step_model *model, motion_state *state) {
    for (size_t i = 0; i < model->obstacles.count && model->lag_vertex_count > 0; i++)
        (void)find_largest(model, state, i);
}

void step_end_lag(const step_model *model, motion_state *state, step_work *work) {
    size_t const first = get_first_vertex(model);
    for (size_t i = 0; i < model->obstacles.count && work->lag.is_led; i++) {
        const surface_range *const range = &work->surfaces[model->cloths.count + i];
        if (!work->lag.is_led[model->cloths.count + i]) continue;
        for (size_t v = range->vertex_begin; v < range->vertex_end; v++)
            vec3_store(state->lags, v - first,
                       vec3_sub(vec3_load(state->positions, v), vec3_load(work->lag.drawn, v)));
        size_t const vertex = find_largest(model, state, i);
        double const largest = state->largest_lags[i];
        work->report->largest_lag = fmax(work->report->largest_lag, largest);
        if (!(largest > 0.0) || work->start->largest_lags[i] > 0.0 || !step_deforms(model, i))
            continue;
        work->lag.finding = (step_finding){.kind = FINDING_LAGS,
                                           .surface = (uint32_t)(model->cloths.count + i),
                                           .time = state->time,
                                           .position = vec3_load(state->positions, vertex)};
    }
    state->still_count = 0;
    for (size_t k = 0; k < work->lag.still_count; k++) {
        still_place place = work->lag.still[k];
        if (--place.waiting > 1 - place.wait) state->still[state->still_count++] = place;
    }
}

bool step_is_held(const step_model *model, const motion_state *state, size_t obstacle) {
    if (obstacle < model->obstacles.count) return state->largest_lags[obstacle] > 0.0;
    return model->def.on_pinch == TULLE_ON_PINCH_SLOW && state->still_count > 0;
}

bool step_has_lags(const step_model *model, const motion_state *state) {
    for (size_t i = 0; i < model->obstacles.count; i++)
        if (state->largest_lags[i] > 0.0) return true;
    return state->still_count > 0;
}

bool step_lag_more(const step_model *model, step_work *work, const blocked_place *place) {
    lag_work *const lag = &work->lag;
    bool const is_cloth = place->surface < model->cloths.count;
    if (lag->level == TRIES_MAX) return false;
    if (lag->level++ == 0 && is_cloth) return true; /* its rows now say where room is needed */
    bool is_known = false;
    for (size_t k = 0; k < lag->still_count; k++) {
        still_place *const still = &lag->still[k];
        vec3 const away = vec3_sub(place->position, vec3_load(still->position, 0));
        bool const is_there = !(vec3_norm(away) > 2.0 * still->radius);
        if (is_there &&
            still->waiting < still->wait) { /* pinched in this step for the first time */
            if (still->waiting <= 0 && still->wait < WAIT_MOST) still->wait *= 2;
            still->waiting = still->wait;
        } else if (still->waiting > 0) {
            still->radius *= STILL_GROWTH;
        }
        is_known |= is_there;
    }
    if (!is_known) {
        size_t const k = lag->still_count < STILL_PLACES ? lag->still_count++ : 0;
        int32_t const wait = model->def.on_pinch == TULLE_ON_PINCH_SLOW ? WAIT_FIRST : 1;
        lag->still[k] = (still_place){
            .radius = STILL_RADIUS * model->contact_distance, .wait = wait, .waiting = wait};
        vec3_store(lag->still[k].position, 0, place->position);
    }
    for (size_t k = 0; k < lag->still_count && lag->level == TRIES_MAX; k++)
        if (lag->still[k].waiting > 0) lag->still[k].radius = (double)INFINITY;
    return true;
}

bool step_lags_are_valid(const step_model *model, const motion_state *state) {
    for (size_t k = 0; k < state->still_count; k++) {
        const still_place *const place = &state->still[k];
        vec3 const at = vec3_load(place->position, 0);
        if (!isfinite(at.x + at.y + at.z) || !(place->radius > 0.0) || place->wait < 1 ||
            place->wait > WAIT_MOST || place->waiting > place->wait ||
            place->waiting <= 1 - place->wait)
            return false;
    }
    for (size_t i = 0; i < model->obstacles.count; i++)
        if (state->largest_lags[i] > 0.0 && !may_lag(model, i)) return false;
    return true;
}
