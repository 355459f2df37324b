/* world/lag/lag.c - see lag.h.
 *
 * At the start of a step the lags shrink, and the lagging surface is to end where the drawn one
 * does, plus what is left of its lag. Where cloth would not have its room (room.h), the ends give
 * way, and what is around goes along, so that the lagging surface has no steps. */
#include "world/lag/lag.h"

#include "base/error.h"
#include "world/lag/room.h"
#include "world/pinch/pinch_sides.h"

#include <math.h>
#include <stdio.h>
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

bool world_may_lag(const tulle_world *world, size_t obstacle) {
    const world_obstacle *const at = &world->model.obstacles.data[obstacle];
    bool const deforms = at->read_frame || at->drive == TULLE_DRIVE_DEFORMING;
    return deforms && (world->model.def.on_pinch == TULLE_ON_PINCH_LAG ||
                       world->model.def.on_pinch == TULLE_ON_PINCH_SLOW);
}

/* The vertices of an obstacle that may lag; a loop over all such obstacles begins with zeros. */
typedef struct lag_run {
    size_t begin, end; /* in the world's numbering */
    size_t lag;        /* the first's number among those that may lag */
    size_t obstacle;
} lag_run;

static bool next_run(const tulle_world *world, lag_run *run) {
    size_t const passed = run->end - run->begin;
    for (size_t i = run->end == 0 ? 0 : run->obstacle + 1; i < world->model.obstacles.count; i++) {
        const surface_range *const range = &world->model.surfaces[world->model.cloths.count + i];
        if (!world_may_lag(world, i)) continue;
        *run = (lag_run){range->vertex_begin, range->vertex_end, run->lag + passed, i};
        return true;
    }
    return false;
}

vec3 world_get_lag(const tulle_world *world, size_t vertex) {
    lag_run run = {0};
    while (next_run(world, &run))
        if (vertex >= run.begin && vertex < run.end)
            return vec3_load(world->now.lags, run.lag + vertex - run.begin);
    return vec3_make(0.0, 0.0, 0.0);
}

/* ---- the plan of a step ---- */

static void shrink_lags(const step_context *context, double *ends) {
    const tulle_world *const world = context->world;
    lag_run run = {0};
    while (next_run(world, &run)) {
        const world_obstacle *const obstacle = &world->model.obstacles.data[run.obstacle];
        if (world->now.largest_lags[run.obstacle] == 0.0 || obstacle->has_jumped) continue;
        for (size_t v = run.begin; v < run.end; v++) {
            vec3 const lag = vec3_load(world->now.lags, run.lag + v - run.begin);
            double const size = vec3_norm(lag);
            double const shrinks = context->whole_step * fmax(RETURN_SPEED, RETURN_RATE * size);
            if (!(size > shrinks)) continue;
            vec3_store(ends, v, vec3_add_scaled(vec3_load(ends, v), lag, 1.0 - shrinks / size));
        }
    }
}

/* [m] The farthest way that a vertex that may lag, or what follows a script beside it, goes. */
static double measure_ways(const tulle_world *world, const double *ends) {
    double farthest2 = 0.0;
    for (size_t v = world->model.cloth_vertex_count + 2 * world->model.body_count;
         v < world->model.vertex_count; v++)
        farthest2 =
            fmax(farthest2,
                 vec3_norm2(vec3_sub(vec3_load(ends, v), vec3_load(world->now.positions, v))));
    return sqrt(farthest2);
}

/* What is around a place where the step was pinched stands still. */
static void stand_still(const step_context *context, double *ends) {
    const tulle_world *const world = context->world;
    lag_run run = {0};
    while (context->still_count > 0 && next_run(world, &run)) {
        for (size_t v = run.begin; v < run.end; v++) {
            vec3 const x = vec3_load(world->now.positions, v);
            double part = 1.0;
            for (size_t k = 0; k < context->still_count; k++) {
                const still_place *const still = &context->still[k];
                double const away = vec3_norm(vec3_sub(x, still->position)) / still->radius - 1.0;
                part = fmin(part, fmax(away, 0.0));
            }
            if (part < 1.0) vec3_store(ends, v, vec3_lerp(x, vec3_load(ends, v), part));
        }
    }
}

/* What was given no place stands still as drawn, without its lag. */
static void draw_what_stands(const tulle_world *world, double *drawn) {
    lag_run run = {0};
    while (next_run(world, &run)) {
        const world_obstacle *const obstacle = &world->model.obstacles.data[run.obstacle];
        if (obstacle->read_frame || obstacle->given != GIVEN_NOTHING) continue;
        for (size_t v = run.begin; v < run.end; v++)
            vec3_store(drawn, v,
                       vec3_sub(vec3_load(world->now.positions, v), world_get_lag(world, v)));
    }
}

static bool has_run(const tulle_world *world) {
    lag_run run = {0};
    return next_run(world, &run);
}

tulle_status world_begin_lag(step_context *context) {
    tulle_world *const world = context->world;
    size_t const n = 3 * world->model.vertex_count;
    context->lagging = context->drawn = NULL;
    if (!has_run(world)) return TULLE_OK;
    double const start = world->now.time;
    tulle_status status =
        world_script_targets(world, start, start + context->whole_step, context->error);
    if (status != TULLE_OK) return status;
    double *const drawn = ARENA_NEW(&world->work.scratch, double, n);
    double *const ends = ARENA_NEW(&world->work.scratch, double, n);
    if (!drawn || !ends)
        return error_set(context->error, TULLE_ERROR_OUT_OF_MEMORY,
                         "no memory left for lagging surfaces");
    memcpy(drawn, world->work.targets, n * sizeof(double));
    draw_what_stands(world, drawn);
    memcpy(ends, drawn, n * sizeof(double));
    shrink_lags(context, ends);
    status = world_find_room(
        context, ends, REACH * world->model.contact_distance + 2.0 * measure_ways(world, ends),
        &world->work.places);
    if (status != TULLE_OK)
        return error_set(context->error, status, "no memory left for lagging surfaces");
    if (!world_make_room(world, &world->work.places, GIVING_RADIUS * world->model.contact_distance,
                         ROOM_TOLERANCE * world->model.contact_distance, ends))
        return error_set(context->error, TULLE_ERROR_OUT_OF_MEMORY,
                         "no memory left for lagging surfaces");
    bool const lags = memcmp(ends, drawn, n * sizeof(double)) != 0;
    stand_still(context, ends);
    context->drawn = drawn;
    /* what lags comes back to where it is drawn, to the bit, also where no script leads it there */
    if (lags || world_has_lags(world, &world->now) || context->still_count > 0)
        context->lagging = ends;
    return TULLE_OK;
}

void world_lead_lag(step_context *context) {
    tulle_world *const world = context->world;
    if (!context->lagging) return;
    double const passed = context->state->time + context->time_step - context->step_start;
    double const share = passed / context->whole_step;
    bool const is_end = share > 1.0 - REST_SHARE;
    lag_run run = {0};
    while (next_run(world, &run)) {
        for (size_t v = run.begin; v < run.end; v++) {
            vec3 const to = vec3_load(context->lagging, v);
            vec3 const from = vec3_load(world->now.positions, v);
            vec3_store(world->work.targets, v, is_end ? to : vec3_lerp(from, to, share));
        }
    }
}

bool world_has_lags(const tulle_world *world, const motion_state *state) {
    for (size_t i = 0; i < world->model.obstacles.count; i++)
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

void world_measure_lags(const tulle_world *world, motion_state *state) {
    if (world->model.lag_vertex_count == 0) return;
    lag_run run = {0};
    while (next_run(world, &run)) (void)find_largest(&run, state);
}

void world_end_lag(step_context *context) {
    tulle_world *const world = context->world;
    motion_state *const state = context->state;
    bool const is_off = context->lagging || (context->drawn && context->is_script_frozen);
    lag_run run = {0};
    while (context->drawn && next_run(world, &run)) {
        for (size_t v = run.begin; v < run.end; v++) {
            vec3 const lag = vec3_sub(vec3_load(state->positions, v), vec3_load(context->drawn, v));
            vec3_store(state->lags, run.lag + v - run.begin, is_off ? lag : (vec3){0, 0, 0});
        }
        size_t const vertex = find_largest(&run, state);
        double const largest = state->largest_lags[run.obstacle];
        context->report->largest_lag = fmax(context->report->largest_lag, largest);
        if (!(largest > 0.0) || world->now.largest_lags[run.obstacle] > 0.0) continue;
        vec3 const x = vec3_load(state->positions, vertex);
        snprintf(context->pinch_message, sizeof context->pinch_message,
                 "'%s' leaves cloth no room near (%.6g, %.6g, %.6g) m at %.6g s; there it lags "
                 "behind its frames (on_pinch: %s)",
                 world->model.obstacles.data[run.obstacle].name, x.x, x.y, x.z, state->time,
                 world->model.def.on_pinch == TULLE_ON_PINCH_LAG ? "lag" : "slow");
    }
}

bool world_may_feel(const step_context *context) {
    const tulle_world *const world = context->world;
    if (!(context->pinch_level + 1 < STILL_TRIES)) return false;
    blocked_place const place = world_find_blocked_place(context);
    for (int k = 0; k < 4 && place.is_pair; k++) {
        size_t const surface = world->model.vertex_surface[place.vertices[k]];
        if (surface >= world->model.cloths.count &&
            world_may_lag(world, surface - world->model.cloths.count))
            return true;
    }
    return false;
}

bool world_feel_pinch(step_context *context, const blocked_place *place) {
    const tulle_world *const world = context->world;
    if (!has_run(world)) return false;
    context->pinch_level++;
    for (size_t k = 0; k < context->still_count; k++) {
        still_place *const still = &context->still[k];
        if (vec3_norm(vec3_sub(place->position, still->position)) > 2.0 * still->radius) continue;
        still->radius *= 2.0;
        return context->pinch_level < STILL_TRIES;
    }
    if (context->pinch_level > 1 && context->still_count < STILL_PLACES)
        context->still[context->still_count++] =
            (still_place){place->position, STILL_RADIUS * world->model.contact_distance};
    else
        for (size_t k = 0; k < context->still_count; k++) context->still[k].radius *= 2.0;
    return context->pinch_level < STILL_TRIES;
}
