/* app/run/loop.c - the loop of `tulle run`: step, report, frame, checkpoint, until all frames are
 * there, a step cannot be made, a file cannot be written, or someone asks to stop.
 *
 * Whatever ends the loop, the world is in the state after its last whole step, and a last
 * checkpoint of that state is written where the disk allows. */
#include "app/cli/interrupt.h"
#include "app/run/session.h"
#include "base/error.h"
#include "base/timer.h"

#include <math.h>
#include <stdio.h>

/* Files hold floats. A vertex at distance r along an axis is rounded by up to 2^-24 r there. So two
 * features come nearer by at most 2 sqrt(3) 2^-24 r. That must stay under the minimum gap. */
static tulle_status check_extent(const run_session *session, tulle_error *error) {
    const tulle_scene_world *const built = &session->built;
    double minimum_gap = 0.0;
    tulle_world_get_distances(built->world, NULL, NULL, &minimum_gap);
    double const farthest = minimum_gap * 0x1p24 / (2.0 * sqrt(3.0));
    for (size_t i = 0; i < built->cloth_count; i++) {
        size_t count = 0;
        const double *const x = tulle_cloth_get_positions(built->world, built->cloths[i], &count);
        for (size_t k = 0; k < 3 * count; k++) {
            if (fabs(x[k]) <= farthest) continue;
            return error_set(error, TULLE_ERROR_LIMIT,
                             "vertex %zu of '%s' is at (%.6g, %.6g, %.6g) m; beyond %.4g m the "
                             "floats of the files cannot keep gaps of %.3g m apart. Put ground "
                             "under the cloth, run fewer frames, or use thicker cloth",
                             k / 3, tulle_scene_get_cloth_name(session->scene, i), x[k - k % 3],
                             x[k - k % 3 + 1], x[k - k % 3 + 2], farthest, minimum_gap);
        }
    }
    return TULLE_OK;
}

static tulle_status get_transforms(run_session *session, tulle_error *error) {
    const tulle_scene_world *const built = &session->built;
    size_t count = 0;
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < built->obstacle_count && status == TULLE_OK; i++)
        if (session->bodies[built->cloth_count + i].is_dynamic)
            status = tulle_obstacle_get_transform(built->world, built->obstacles[i],
                                                  &session->transforms[count++], error);
    return status;
}

static tulle_status write_frame(run_session *session, tulle_error *error) {
    tulle_status status = check_extent(session, error);
    if (status == TULLE_OK) status = get_transforms(session, error);
    bool const records = session->options.records_debug || session->options.records_velocities;
    if (status == TULLE_OK && records) status = debug_record_fill(&session->debug, session, error);
    if (status != TULLE_OK) return status;
    const tulle_scene_world *const built = &session->built;
    for (size_t i = 0; i < built->cloth_count; i++) {
        session->positions[i] = tulle_cloth_get_positions(built->world, built->cloths[i], NULL);
        session->velocities[i] = tulle_cloth_get_velocities(built->world, built->cloths[i], NULL);
        session->is_present[i] = 1;
    }
    for (size_t i = 0; i < built->obstacle_count; i++) {
        size_t const body = built->cloth_count + i;
        session->positions[body] =
            tulle_obstacle_get_positions(built->world, built->obstacles[i], NULL);
        session->is_present[body] = tulle_obstacle_is_present(built->world, built->obstacles[i]);
    }
    session->lag_count = 0;
    if (session->may_lag) status = run_measure_lags(session, error);
    if (status != TULLE_OK) return status;
    tulle_run_frame const frame = {.time = tulle_world_get_time(built->world),
                                   .step = tulle_world_get_step_count(built->world),
                                   .state_hash = tulle_world_get_state_hash(built->world),
                                   .positions = session->positions,
                                   .velocities = session->velocities,
                                   .is_present = session->is_present,
                                   .transforms = session->transforms,
                                   .lags = session->lags,
                                   .lag_count = session->lag_count,
                                   .debug = records ? &session->debug.debug : NULL};
    return tulle_run_write_frame(session->writer, &frame, error);
}

static tulle_status write_checkpoint(run_session *session, tulle_error *error) {
    tulle_world *const world = session->built.world;
    tulle_run_checkpoint checkpoint = {.step = tulle_world_get_step_count(world),
                                       .time = tulle_world_get_time(world),
                                       .state_hash = tulle_world_get_state_hash(world)};
    tulle_status status =
        tulle_world_save_state(world, &checkpoint.bytes, &checkpoint.byte_count, error);
    if (status != TULLE_OK) return status;
    status = tulle_run_write_checkpoint(session->writer, &checkpoint, error);
    tulle_world_free_state(world, checkpoint.bytes, checkpoint.byte_count);
    if (status != TULLE_OK) return status;
    session->checkpoint_step = checkpoint.step;
    session->checkpoint_time = timer_now();
    progress_show_checkpoint(session);
    return TULLE_OK;
}

tulle_status run_write_start(run_session *session, tulle_error *error) {
    tulle_status const status =
        session->source ? run_source_copy(session, error) : write_frame(session, error);
    return status != TULLE_OK ? status : write_checkpoint(session, error);
}

static bool is_checkpoint_due(const run_session *session) {
    const run_options *const options = &session->options;
    if (options->checkpoint_steps > 0)
        return tulle_world_get_step_count(session->built.world) - session->checkpoint_step >=
               options->checkpoint_steps;
    return timer_now() - session->checkpoint_time >= options->checkpoint_seconds;
}

static void add_to_totals(run_session *session, const tulle_step_report *report) {
    run_totals *const totals = &session->totals;
    totals->steps++;
    totals->seconds += report->total_seconds;
    totals->contacts += report->contacts;
    if (report->contacts > totals->most_contacts) totals->most_contacts = report->contacts;
    totals->ignored_pairs = report->ignored_pairs;
    totals->smallest_gap = fmin(totals->smallest_gap, report->smallest_gap);
    double const stretch_before = session->outcome.largest_stretch;
    tulle_run_outcome_add(&session->outcome, report);
    if (session->outcome.largest_stretch > stretch_before) {
        tulle_stretch const stretch = tulle_world_find_largest_stretch(session->built.world);
        tulle_run_outcome_place(&session->outcome, &stretch, stretch.cloth);
    }
}

static tulle_status make_step(run_session *session, tulle_error *error) {
    tulle_step_report report = {0};
    tulle_world *const world = session->built.world;
    session->progress.step_begin = timer_now();
    tulle_status status =
        tulle_world_step(world, tulle_scene_get_time_step(session->scene), &report, error);
    if (status != TULLE_OK) return status;
    add_to_totals(session, &report);
    session->may_lag = report.largest_lag > 0.0;
    status = tulle_run_write_report(session->writer, &report, error);
    uint64_t const done = tulle_world_get_step_count(world);
    if (status == TULLE_OK && done % tulle_scene_get_steps_per_frame(session->scene) == 0)
        status = write_frame(session, error);
    if (status == TULLE_OK && done < session->wanted_steps && is_checkpoint_due(session))
        status = write_checkpoint(session, error);
    progress_show_step(session, &report);
    const char *const message = tulle_world_last_message(world);
    if (message[0]) progress_show_message(session, &report, message);
    char *const first = session->totals.message;
    if (!first[0]) snprintf(first, sizeof session->totals.message, "%s", message);
    return status;
}

/* A step that could not be made left the world as it was: its state is worth keeping. After a
 * failed write the files lag behind the world, so the checkpoint before stays. */
static bool is_state_consistent(tulle_status status) {
    return status == TULLE_OK || status == TULLE_ERROR_PINCHED ||
           status == TULLE_ERROR_STEP_FAILED || status == TULLE_ERROR_INTERSECTING_START ||
           status == TULLE_ERROR_INTERRUPTED;
}

tulle_status run_step_to_end(run_session *session, tulle_error *error) {
    tulle_status status = TULLE_OK;
    while (status == TULLE_OK &&
           tulle_world_get_step_count(session->built.world) < session->wanted_steps) {
        if (interrupt_is_pending())
            status = TULLE_ERROR_INTERRUPTED;
        else
            status = make_step(session, error);
    }
    if (!is_state_consistent(status) ||
        tulle_world_get_step_count(session->built.world) == session->checkpoint_step)
        return status;
    tulle_error checkpoint_error = {0};
    tulle_status const kept = write_checkpoint(session, &checkpoint_error);
    if (kept == TULLE_OK || (status != TULLE_OK && status != TULLE_ERROR_INTERRUPTED))
        return status;
    *error = checkpoint_error;
    return kept;
}
