/* step/lag/lag.c - see lag.h.
 *
 * At the start of a step the lags shrink, and the lagging surface is to end where the drawn one
 * does, plus what is left of its lag. Where cloth would not have its room (room.h), the ends give
 * way, and what is around goes along, so that the lagging surface has no steps. */
#include "step/lag/lag.h"

#include "step/lag/room.h"
#include "step/pinch/pinch_sides.h"
#include "step/script.h"

#include <math.h>
#include <string.h>

/* A lag shrinks at this rate [1/s], and by this speed [m/s] at least. */
static const double RETURN_RATE = 8.0, RETURN_SPEED = 0.02;
/* [contact distances] Places are sought so far beyond what comes nearer in the step. */
static const double REACH = 8.0;
/* [contact distances] A place that lacks less room has it. */
static const double ROOM_TOLERANCE = 1e-3;
/* [contact distances] What gives way with a point. */
static const double GIVING_RADIUS = 40.0;
/* [contact distances] A step that is pinched again stands still so far around the place, the first
 * time; then twice as far each time. */
static const double STILL_RADIUS = 10.0;

/* A part of the step under this share of it is rounding, as for retry.c. */
static const double REST_SHARE = 1e-9;

bool step_may_lag(const step_model *model, size_t obstacle) {
    const world_obstacle *const at = &model->obstacles.data[obstacle];
    bool const deforms = at->read_frame || at->drive == TULLE_DRIVE_DEFORMING;
    return deforms && (model->def.on_pinch == TULLE_ON_PINCH_LAG ||
                       model->def.on_pinch == TULLE_ON_PINCH_SLOW);
}

/* The vertices of an obstacle that may lag; a loop over all such obstacles begins with zeros. */
typedef struct lag_run {
    size_t begin, end; /* in the world's numbering */
    size_t lag;        /* the first's number among those that may lag */
    size_t obstacle;
} lag_run;

static bool next_run(const step_model *model, const step_work *work, lag_run *run) {
    size_t const passed = run->end - run->begin;
    for (size_t i = run->end == 0 ? 0 : run->obstacle + 1; i < model->obstacles.count; i++) {
        const surface_range *const range = &work->surfaces[model->cloths.count + i];
        if (!step_may_lag(model, i)) continue;
        *run = (lag_run){range->vertex_begin, range->vertex_end, run->lag + passed, i};
        return true;
    }
    return false;
}

vec3 step_get_lag(const step_model *model, const step_work *work, size_t vertex) {
    lag_run run = {0};
    while (next_run(model, work, &run))
        if (vertex >= run.begin && vertex < run.end)
            return vec3_load(work->start->lags, run.lag + vertex - run.begin);
    return vec3_make(0.0, 0.0, 0.0);
}

/* ---- the plan of a step ---- */

static void shrink_lags(const step_model *model, const step_work *work, double *ends) {
    lag_run run = {0};
    while (next_run(model, work, &run)) {
        const world_obstacle *const obstacle = &model->obstacles.data[run.obstacle];
        if (work->start->largest_lags[run.obstacle] == 0.0 || obstacle->has_jumped) continue;
        for (size_t v = run.begin; v < run.end; v++) {
            vec3 const lag = vec3_load(work->start->lags, run.lag + v - run.begin);
            double const size = vec3_norm(lag);
            double const shrinks = work->whole_step * fmax(RETURN_SPEED, RETURN_RATE * size);
            if (!(size > shrinks)) continue;
            vec3_store(ends, v, vec3_add_scaled(vec3_load(ends, v), lag, 1.0 - shrinks / size));
        }
    }
}

/* What is around a place where the step was pinched stands still. */
static void stand_still(const step_model *model, const step_work *work, double *ends) {
    lag_run run = {0};
    while (work->lag.still_count > 0 && next_run(model, work, &run)) {
        for (size_t v = run.begin; v < run.end; v++) {
            vec3 const x = vec3_load(work->start->positions, v);
            double part = 1.0;
            for (size_t k = 0; k < work->lag.still_count; k++) {
                const still_place *const still = &work->lag.still[k];
                double const away = vec3_norm(vec3_sub(x, still->position)) / still->radius - 1.0;
                part = fmin(part, fmax(away, 0.0));
            }
            if (part < 1.0) vec3_store(ends, v, vec3_lerp(x, vec3_load(ends, v), part));
        }
    }
}

tulle_status step_begin_lag(const step_model *model, step_work *work) {
    size_t const n = 3 * model->vertex_count;
    work->lag.lagging = work->lag.drawn = NULL;
    if (model->lag_vertex_count == 0) return TULLE_OK;
    double const start = work->start->time;
    tulle_status status =
        step_script_targets(model, work, start, start + work->whole_step, work->error);
    if (status != TULLE_OK) return status;
    double *const drawn = ARENA_NEW(&work->scratch, double, n);
    double *const ends = ARENA_NEW(&work->scratch, double, n);
    if (!drawn || !ends) return TULLE_ERROR_OUT_OF_MEMORY;
    memcpy(drawn, work->targets, n * sizeof(double));
    lag_run run = {0};
    while (next_run(model, work,
                    &run)) { /* what was given no place stands as drawn, without its lag */
        const world_obstacle *const obstacle = &model->obstacles.data[run.obstacle];
        if (obstacle->read_frame || obstacle->given != GIVEN_NOTHING) continue;
        for (size_t v = run.begin; v < run.end; v++)
            vec3_store(
                drawn, v,
                vec3_sub(vec3_load(work->start->positions, v), step_get_lag(model, work, v)));
    }
    memcpy(ends, drawn, n * sizeof(double));
    shrink_lags(model, work, ends);
    double farthest2 = 0.0; /* [m^2] way of what may lag, or follows a script beside it */
    for (size_t v = model->cloth_vertex_count + 2 * model->body_count; v < model->vertex_count; v++)
        farthest2 =
            fmax(farthest2,
                 vec3_norm2(vec3_sub(vec3_load(ends, v), vec3_load(work->start->positions, v))));
    double const reach = REACH * model->contact_distance + 2.0 * sqrt(farthest2);
    status = step_find_room(model, work, ends, reach, &work->lag.places);
    if (status != TULLE_OK) return status;
    if (!step_make_room(model, work, &work->lag.places, GIVING_RADIUS * model->contact_distance,
                        ROOM_TOLERANCE * model->contact_distance, ends))
        return TULLE_ERROR_OUT_OF_MEMORY;
    bool const lags = memcmp(ends, drawn, n * sizeof(double)) != 0;
    stand_still(model, work, ends);
    work->lag.drawn = drawn;
    /* what lags comes back to where it is drawn, to the bit, also where no script leads it there */
    if (lags || step_has_lags(model, work->start) || work->lag.still_count > 0)
        work->lag.lagging = ends;
    return TULLE_OK;
}

void step_lead_lag(const step_model *model, motion_state *state, step_work *work) {
    if (!work->lag.lagging) return;
    double const passed = state->time + work->sub.time_step - work->start->time;
    double const share = passed / work->whole_step;
    bool const is_end = share > 1.0 - REST_SHARE;
    lag_run run = {0};
    while (next_run(model, work, &run)) {
        for (size_t v = run.begin; v < run.end; v++) {
            vec3 const to = vec3_load(work->lag.lagging, v);
            vec3 const from = vec3_load(work->start->positions, v);
            vec3_store(work->targets, v, is_end ? to : vec3_lerp(from, to, share));
        }
    }
}

bool step_has_lags(const step_model *model, const motion_state *state) {
    for (size_t i = 0; i < model->obstacles.count; i++)
        if (state->largest_lags[i] > 0.0) return true;
    return false;
}

/* The vertex of a run that lags most; its size is in state->largest_lags then. */
static size_t find_largest(const lag_run *run, motion_state *state) {
    double largest2 = 0.0;
    size_t vertex = run->begin;
    for (size_t v = run->begin; v < run->end; v++) {
        double const size2 = vec3_norm2(vec3_load(state->lags, run->lag + v - run->begin));
        if (!(size2 > largest2)) continue;
        largest2 = size2;
        vertex = v;
    }
    state->largest_lags[run->obstacle] = sqrt(largest2);
    return vertex;
}

void step_measure_lags(const step_model *model, motion_state *state, step_work *work) {
    if (model->lag_vertex_count == 0) return;
    lag_run run = {0};
    while (next_run(model, work, &run)) (void)find_largest(&run, state);
}

void step_end_lag(const step_model *model, motion_state *state, step_work *work) {
    bool const is_off = work->lag.lagging || (work->lag.drawn && work->pinch.is_script_frozen);
    lag_run run = {0};
    while (work->lag.drawn && next_run(model, work, &run)) {
        for (size_t v = run.begin; v < run.end; v++) {
            vec3 const lag =
                vec3_sub(vec3_load(state->positions, v), vec3_load(work->lag.drawn, v));
            vec3_store(state->lags, run.lag + v - run.begin, is_off ? lag : (vec3){0, 0, 0});
        }
        size_t const vertex = find_largest(&run, state);
        double const largest = state->largest_lags[run.obstacle];
        work->report->largest_lag = fmax(work->report->largest_lag, largest);
        if (!(largest > 0.0) || work->start->largest_lags[run.obstacle] > 0.0) continue;
        vec3 const x = vec3_load(state->positions, vertex);
        work->pinch.finding =
            (step_finding){.kind = FINDING_LAGS,
                           .surface = (uint32_t)(model->cloths.count + run.obstacle),
                           .time = state->time,
                           .position = x};
    }
}

bool step_may_feel(const step_model *model, motion_state *state, step_work *work) {
    if (!(work->pinch.level + 1 < STILL_TRIES)) return false;
    blocked_place const place = step_find_blocked_place(model, state, work);
    for (int k = 0; k < 4 && place.is_pair; k++) {
        size_t const surface = model->vertex_surface[place.vertices[k]];
        if (surface >= model->cloths.count && step_may_lag(model, surface - model->cloths.count))
            return true;
    }
    return false;
}

bool step_feel_pinch(const step_model *model, step_work *work, const blocked_place *place) {
    if (model->lag_vertex_count == 0) return false;
    work->pinch.level++;
    for (size_t k = 0; k < work->lag.still_count; k++) {
        still_place *const still = &work->lag.still[k];
        if (vec3_norm(vec3_sub(place->position, still->position)) > 2.0 * still->radius) continue;
        still->radius *= 2.0;
        return work->pinch.level < STILL_TRIES;
    }
    if (work->pinch.level > 1 && work->lag.still_count < STILL_PLACES)
        work->lag.still[work->lag.still_count++] =
            (still_place){place->position, STILL_RADIUS * model->contact_distance};
    else
        for (size_t k = 0; k < work->lag.still_count; k++) work->lag.still[k].radius *= 2.0;
    return work->pinch.level < STILL_TRIES;
}
