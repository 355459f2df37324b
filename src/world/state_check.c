/* world/state_check.c - whether what was read from a saved state is what a world may hold.
 *
 * The hash of a saved state finds damage. This finds bytes that were made to have the right hash,
 * or that a mistake wrote: numbers that are not finite, flags and states out of their range,
 * objects that are not there. What passes cannot lead a step outside its arrays. */
#include "base/error.h"
#include "step/bodies/bodies.h"
#include "step/lag/lag.h"
#include "world/world_state.h"

#include <math.h>
#include <string.h>

/* Without a branch for each number. A number is finite unless all bits of its exponent are set;
 * then a one at the lowest of them carries over to the sign. */
static bool are_finite(const double *values, size_t count) {
    uint64_t const exponent = UINT64_C(0x7ff0000000000000), lowest = UINT64_C(0x0010000000000000);
    uint64_t signs = 0;
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        signs |= (bits & exponent) + lowest;
    }
    return signs >> 63 == 0;
}

/* [1/m] beyond any curvature of cloth. */
static const double LARGEST_PLASTIC = 1e12;

static bool are_bounded(const double *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!(fabs(values[i]) <= LARGEST_PLASTIC)) return false;
    return true;
}

static bool are_at_most(const uint8_t *values, size_t count, uint8_t most) {
    for (size_t i = 0; i < count; i++)
        if (values[i] > most) return false;
    return true;
}

static bool rests_are_valid(const tulle_world *world, const body_rest *rests) {
    for (size_t i = 0; i < world->model.body_count; i++) {
        const body_rest *const rest = &rests[i];
        if (rest->state > BODY_SLEEPS || rest->group >= world->model.body_count ||
            !isfinite(rest->quiet_time) || rest->quiet_time < 0.0 || !are_finite(rest->force, 3) ||
            !are_finite(rest->torque, 3) || !are_finite(rest->impulse, 3) ||
            !are_finite(rest->moment, 3))
            return false;
    }
    return true;
}

static bool cloth_rests_are_valid(const step_model *model, const motion_state *state) {
    for (size_t c = 0; c < model->cloth_rest_count; c++) {
        const cloth_rest *const rest = &state->cloth_rests[c];
        if (rest->is_asleep > 1 || !isfinite(rest->quiet_time) || !(rest->quiet_time >= 0.0) ||
            !(rest->slept_from >= 0.0) || !(rest->slept_from <= state->time))
            return false;
    }
    return true;
}

static bool poses_are_valid(const tulle_world *world, const motion_pose *poses) {
    for (size_t i = 0; i < world->model.pose_count; i++) {
        const vec3 *const t = &poses[i].translation;
        if (!isfinite(t->x + t->y + t->z) ||
            !(fabs(quaternion_norm(poses[i].rotation) - 1.0) <= QUATERNION_TOLERANCE))
            return false;
    }
    return true;
}

static bool vectors_are_finite(const tulle_world *world, const motion_state *state) {
    double *vectors[STATE_VECTORS_MAX];
    size_t const count = step_list_vectors(state, vectors);
    moving_run run = world_first_moving(world);
    do
        for (size_t i = 0; i < count; i++)
            if (!are_finite(vectors[i] + 3 * run.begin, 3 * (run.end - run.begin))) return false;
    while (world_next_moving(world, &run));
    return true;
}

tulle_status world_check_state(const tulle_world *world, const motion_state *state,
                               tulle_error *error) {
    size_t const obstacle_count = world->model.obstacles.count;
    const char *what = NULL;
    if (!isfinite(state->time) || state->time < 0.0 || !(state->previous_time_step >= 0.0) ||
        !(state->previous_time_step <= 1.0) || !isfinite(state->lost_energy))
        what = "a time, a time step or an energy that no world has";
    else if (!vectors_are_finite(world, state))
        what = "positions or velocities that are not finite";
    else if (!are_bounded(state->plastic, world->model.plastic_count))
        what = "an impossible hysteresis of cloth";
    else if (!are_at_most(state->is_present, obstacle_count, 1) ||
             !are_at_most(state->particles, world->model.particle_count, PARTICLE_STICKS))
        what = "meaningless flags of obstacles or vertices";
    else if (!rests_are_valid(world, state->rests))
        what = "rigid bodies in an impossible state";
    else if (!cloth_rests_are_valid(&world->model, state))
        what = "an impossible sleep of cloth";
    else if (!poses_are_valid(world, state->poses))
        what = "obstacles in an impossible pose";
    else if (!step_lags_are_valid(&world->model, state) ||
             !are_bounded(state->lags, 3 * world->model.lag_vertex_count))
        what = "obstacles that lag too far behind their frames";
    else if (!world_ties_are_valid(world, state))
        what = "attachments of missing objects";
    if (!what) return TULLE_OK;
    return error_set(error, TULLE_ERROR_PARSE, "the saved state has %s: start the run again", what);
}
