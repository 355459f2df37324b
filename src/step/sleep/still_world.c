/* step/sleep/still_world.c - a step in which nothing moves: see cloth_sleep.h.
 *
 * Where all that may move sleeps, and nothing on a script moves, the ten stages would find nothing
 * to do; but reading and copying would cost in proportion to the world. So they are left out: only
 * the time of the state changes, and the contacts of the last computed step are still reported.
 * Whether a step is one of these follows from the state, the defs and the host's input alone. */
#include "step/sleep/cloth_sleep.h"

#include "step/bodies/bodies.h"
#include "step/energy_balance.h"

#include <string.h>

/* Whether a script of keyframes holds still from one time to another. */
static bool keys_are_still(const world_motion *motion, double from, double to) {
    size_t const count = motion->key_count;
    return count == 0 || to <= motion->keys[0].time || from >= motion->keys[count - 1].time;
}

/* Whether an obstacle, or a body, neither comes nor goes nor moves. */
static bool obstacle_is_still(const step_model *model, const step_work *work, size_t index,
                              double end) {
    const motion_state *const now = work->start;
    const world_obstacle *const obstacle = &model->obstacles.data[index];
    const surface_range *const range = &work->surfaces[model->cloths.count + index];
    bool const is_due = now->time >= obstacle->appear_time && now->time < obstacle->disappear_time;
    if (is_due != (now->is_present[index] != 0)) return false;
    if (range->is_static) return true;
    if (obstacle->given != GIVEN_NOTHING || now->largest_lags[index] > 0.0) return false;
    if (obstacle->body.is_dynamic) {
        uint32_t const body = model->surface_bodies[model->cloths.count + index];
        uint32_t const state = now->rests[body].state;
        if (state != BODY_SCRIPTED) return state == BODY_SLEEPS;
        if (now->time >= obstacle->body.start_time) return false;
    }
    if (obstacle->read_frame) {
        double const last = obstacle->frame_start_time +
                            (double)(obstacle->frame_count - 1) * obstacle->frame_interval;
        if (end > obstacle->frame_start_time && now->time < last) return false;
    }
    bool const is_on_keys = obstacle->drive != TULLE_DRIVE_RIGID;
    if (is_on_keys && !keys_are_still(&obstacle->motion, now->time, end)) return false;
    for (size_t i = 3 * (size_t)range->vertex_begin; i < 3 * (size_t)range->vertex_end; i++)
        if (now->velocities[i] != 0.0) return false;
    return true;
}

/* Whether a cloth sleeps on, held as it is. */
static bool cloth_is_still(const step_model *model, const step_work *work, size_t index,
                           double end) {
    const world_cloth *const cloth = &model->cloths.data[index];
    const cloth_rest *const rest = &work->start->cloth_rests[index];
    if (!rest->is_asleep) return false;
    for (size_t p = 0; p < cloth->pin_count; p++) {
        const world_pin *const pin = &cloth->pins[p];
        double const time = work->start->time, release = pin->release_time;
        bool const lets_go = release > rest->slept_from && release <= time;
        bool const moves = release > time && !keys_are_still(&pin->motion, time, end);
        if (lets_go || moves || pin->has_targets) return false;
    }
    return true;
}

bool step_stands_still(const step_model *model, const step_work *work) {
    const motion_state *const now = work->start;
    double const end = now->time + work->whole_step;
    if (model->cloth_rest_count == 0 || now->still_count > 0) return false;
    for (size_t c = 0; c < model->cloth_rest_count; c++)
        if (!cloth_is_still(model, work, c, end)) return false;
    for (size_t i = 0; i < model->obstacles.count; i++)
        if (!obstacle_is_still(model, work, i, end)) return false;
    for (size_t i = 0; i < now->ties.count; i++) {
        uint32_t const corner = now->ties.data[i].corners[0];
        bool const is_on_body = corner != TULLE_NONE && model->surface_bodies &&
                                model->surface_bodies[model->vertex_surface[corner]] != TULLE_NONE;
        if (now->time >= now->ties.data[i].release_time || is_on_body) return false;
    }
    return true;
}

tulle_status step_pass_still(const step_model *model, motion_state *state, step_work *work) {
    tulle_step_report *const report = work->report;
    contact_store *const store = &state->contacts;
    cloth_energies energies;
    tulle_status const status =
        step_measure_cloths(model, state, work, state->positions, &state->elastic, &energies);
    if (status != TULLE_OK) return status;
    body_energies const bodies =
        step_measure_bodies(model, work, state->positions, state->velocities);
    report->gravity_energy = energies.gravity + bodies.gravity;
    report->elastic_energy = energies.elastic.stretch + energies.elastic.bend;
    report->max_stretch = energies.elastic.max_stretch;
    report->overstretched = energies.elastic.overstretched;
    report->substeps = 1;

    /* contacts press on as they did, for the length of this step */
    double const share = store->contacts.count > 0 ? work->whole_step / store->time_step : 1.0;
    for (size_t i = 0; share != 1.0 && i < store->contacts.count; i++)
        for (int k = 0; k < 3; k++) store->contacts.data[i].impulse[k] *= share;
    if (store->contacts.count > 0) store->time_step = work->whole_step;
    state->time = work->step_end;
    state->step_count++;
    return TULLE_OK;
}
