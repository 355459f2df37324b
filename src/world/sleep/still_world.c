/* world/sleep/still_world.c - a step in which nothing moves: see cloth_sleep.h.
 *
 * Where all that may move sleeps, and nothing on a script moves, the ten stages would find nothing
 * to do; what they would read and copy costs in proportion to the world all the same. So such a
 * step is not made: the state stays but for its time, and the contacts of the last step that was
 * made go on to be told. Whether a step is one of these follows from the state, the defs and what
 * was given alone. */
#include "world/sleep/cloth_sleep.h"

#include "base/error.h"
#include "world/bodies/bodies.h"

#include <string.h>

/* Whether a script of keyframes holds still from one time to another. */
static bool keys_are_still(const world_motion *motion, double from, double to) {
    size_t const count = motion->key_count;
    return count == 0 || to <= motion->keys[0].time || from >= motion->keys[count - 1].time;
}

/* Whether an obstacle, or a body, comes, goes or moves in no way. */
static bool obstacle_is_still(const tulle_world *world, size_t index, double end) {
    const motion_state *const now = &world->now;
    const world_obstacle *const obstacle = &world->model.obstacles.data[index];
    const surface_range *const range = &world->model.surfaces[world->model.cloths.count + index];
    bool const is_due = now->time >= obstacle->appear_time && now->time < obstacle->disappear_time;
    if (is_due != (now->is_present[index] != 0)) return false;
    if (range->is_static) return true;
    if (obstacle->given != GIVEN_NOTHING || now->largest_lags[index] > 0.0) return false;
    if (obstacle->body.is_dynamic) {
        uint32_t const body = world->model.surface_bodies[world->model.cloths.count + index];
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
static bool cloth_is_still(const tulle_world *world, size_t index, double end) {
    const world_cloth *const cloth = &world->model.cloths.data[index];
    const cloth_rest *const rest = &world->now.cloth_rests[index];
    if (!rest->is_asleep) return false;
    for (size_t p = 0; p < cloth->pin_count; p++) {
        const world_pin *const pin = &cloth->pins[p];
        double const time = world->now.time, release = pin->release_time;
        bool const lets_go = release > rest->slept_from && release <= time;
        bool const moves = release > time && !keys_are_still(&pin->motion, time, end);
        if (lets_go || moves || pin->has_targets) return false;
    }
    return true;
}

bool world_stands_still(const tulle_world *world, double time_step) {
    const motion_state *const now = &world->now;
    double const end = now->time + time_step;
    if (world->model.cloth_rest_count == 0 || now->hold_count > 0) return false;
    for (size_t c = 0; c < world->model.cloth_rest_count; c++)
        if (!cloth_is_still(world, c, end)) return false;
    for (size_t i = 0; i < world->model.obstacles.count; i++)
        if (!obstacle_is_still(world, i, end)) return false;
    for (size_t i = 0; i < now->ties.count; i++) {
        uint32_t const corner = now->ties.data[i].corners[0];
        bool const is_on_body =
            corner != TULLE_NONE && world->model.surface_bodies &&
            world->model.surface_bodies[world->model.vertex_surface[corner]] != TULLE_NONE;
        if (now->time >= now->ties.data[i].release_time || is_on_body) return false;
    }
    return true;
}

tulle_status world_pass_still(step_context *context) {
    tulle_world *const world = context->world;
    motion_state *const now = &world->now;
    tulle_step_report *const report = context->report;
    contact_store *const store = &now->contacts;
    cloth_energies energies;
    context->state = now;
    tulle_status const status =
        world_measure_cloths(context, now->positions, &now->elastic, &energies);
    if (status != TULLE_OK)
        return error_set(context->error, status, "no memory left for the energies");
    body_energies const bodies = world_measure_bodies(world, now->positions, now->velocities);
    report->gravity_energy = energies.gravity + bodies.gravity;
    report->elastic_energy = energies.elastic.stretch + energies.elastic.bend;
    report->max_stretch = energies.elastic.max_stretch;
    report->overstretched = energies.elastic.overstretched;
    report->contacts = world->accepted_rows.rows.count;
    report->substeps = 1;

    /* contacts press on as they did, for the length of this step */
    double const share = store->contacts.count > 0 ? context->whole_step / store->time_step : 1.0;
    for (size_t i = 0; share != 1.0 && i < store->contacts.count; i++)
        for (int k = 0; k < 3; k++) store->contacts.data[i].impulse[k] *= share;
    if (store->contacts.count > 0) store->time_step = context->whole_step;
    now->time = world->work.step_end;
    world->step_count++;
    return TULLE_OK;
}
