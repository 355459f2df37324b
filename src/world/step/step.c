/* world/step/step.c - tulle_world_step: one step of the world, all or nothing.
 *
 * A step takes the state and gives a state that is proven free of intersection, or an error and the
 * state as it was. It works on a copy (undo.c) in one or more substeps; a healthy scene needs one.
 * A substep runs the ten stages below, top down. A stage that cannot go on says how the substep
 * ended (substep_outcome); what is tried then stands in retry.c.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005 (detection, contact, response in this order). Departures: docs/method/index.md. */
#include "world/step/step.h"

#include "base/error.h"
#include "base/parallel.h"
#include "base/timer.h"
#include "world/bodies/bodies.h"
#include "world/bodies/bodies_room.h"
#include "world/bodies/bodies_sleep.h"
#include "world/bodies/bodies_turn.h"
#include "world/lag/lag.h"
#include "world/pinch/holds.h"
#include "world/record/record.h"
#include "world/sleep/cloth_sleep.h"

#include <math.h>

/* [s] The integrators say nothing sensible beyond it. */
static const double TIME_STEP_MAX = 1.0;

/* Looks at the motion of stages 7 and 8 before it is committed; may end the substep. No stage of
 * its own: its time counts as that of stage 7. */
static tulle_status judge_motion(step_context *context) {
    world_note_loss(context);
    tulle_status status = world_wake_pressed(context);
    if (status == TULLE_OK && context->outcome == SUBSTEP_RUNS) {
        if (world_turns_too_far(context))
            context->outcome = SUBSTEP_TURNS;
        else if (world_may_refuse_gain(context) && world_gains_too_much(context))
            context->outcome = SUBSTEP_GAINS;
        else if (world_may_halve(context))
            status = world_judge_stretch(context, 1.0);
        if (status == TULLE_OK && context->outcome == SUBSTEP_RUNS &&
            context->scene.response->may_tear_cloth && world_check_torn(context) != TULLE_OK)
            return TULLE_ERROR_STEP_FAILED;
    }
    return world_end_stage(context, STAGE_SOLVE_MOTION, status);
}

/* The ten stages, over as much of context->time_step as is safe. */
static tulle_status run_substep(step_context *context) {
    arena_mark const mark = arena_get_mark(&context->world->work.scratch);
    context->outcome = SUBSTEP_RUNS;
    context->lap = timer_now();

    tulle_status status = world_predict_paths(context);                                 /* 1 */
    if (status == TULLE_OK) status = world_update_patches(context, context->predicted); /* 2 */
    if (status == TULLE_OK) status = world_build_trees(context, context->predicted);    /* 3 */
    if (status == TULLE_OK) status = world_find_pairs(context, context->predicted);     /* 4 */
    if (status == TULLE_OK) status = world_gather_rows(context);                        /* 5 */
    if (status == TULLE_OK) status = world_compute_forces(context);                     /* 6 */
    if (status == TULLE_OK) world_begin_solves(context);
    bool runs = false; /* after the solves: none has ended the substep */
    do {
        do {
            if (status == TULLE_OK) status = world_solve_motion(context); /* 7 */
            runs = status == TULLE_OK && context->outcome == SUBSTEP_RUNS;
            if (runs && context->retry.is_rough && context->retry.history.is_costly)
                status = world_resolve_impacts(context); /* 8, for the solves that follow */
        } while (world_retry_solve(context, &status));
        if (runs && status == TULLE_OK) status = world_resolve_impacts(context); /* 8 */
    } while (world_retry_balance(context, &status));
    if (runs && status == TULLE_OK) status = judge_motion(context);
    if (status == TULLE_OK && context->outcome == SUBSTEP_RUNS)
        status = world_commit_safely(context); /* 9 */
    bool const is_accepted =
        context->outcome == SUBSTEP_WHOLE || context->outcome == SUBSTEP_SHORTENED;
    if (status == TULLE_OK && is_accepted) status = world_accept_state(context); /* 10 */

    arena_release(&context->world->work.scratch, mark);
    context->report->substeps += context->outcome != SUBSTEP_WAKES;
    return status;
}

/* Substeps until the step has passed or is pinched. */
static tulle_status run_substeps(step_context *context) {
    tulle_world *const world = context->world;
    double const end_time = context->state->time + context->whole_step;
    world_begin_retries(context);
    while (!world_is_step_over(context)) {
        world->work.progress =
            (tulle_step_progress){.is_under_way = 1,
                                  .step = context->report->step,
                                  .substep = context->report->substeps + 1,
                                  .share = 1.0 - context->retry.remaining / context->whole_step,
                                  .solve_count = context->report->solve_count};
        if (stop_is_wanted(&world->work.stop, 0)) return TULLE_ERROR_INTERRUPTED;
        tulle_status status = world_choose_substep(context);
        if (status == TULLE_OK) status = run_substep(context);
        world_retry_substep(context, &status);
        if (status != TULLE_OK) return status;
    }
    if (context->outcome != SUBSTEP_PINCHED) context->state->time = end_time;
    return TULLE_OK;
}

/* Energies and stretch at the end of the step, into the report. */
static tulle_status report_energies(step_context *context) {
    tulle_world *const world = context->world;
    motion_state *const state = context->state;
    tulle_step_report *const report = context->report;
    cloth_energies energies;
    tulle_status const status =
        world_measure_cloths(context, state->positions, &state->elastic, &energies);
    if (status != TULLE_OK)
        return error_set(context->error, status, "no memory left for the energies");
    body_energies const bodies = world_measure_bodies(world, state->positions, state->velocities);
    report->kinetic_energy = energies.kinetic + bodies.kinetic;
    report->gravity_energy = energies.gravity + bodies.gravity;
    report->elastic_energy = energies.elastic.stretch + energies.elastic.bend;
    report->max_stretch = energies.elastic.max_stretch;
    report->overstretched = energies.elastic.overstretched;
    return TULLE_OK;
}

/* Fails where a fabric holds no more and the world is to stop there. */
static tulle_status check_overstretch(step_context *context) {
    const tulle_world *const world = context->world;
    if (context->report->overstretched == 0 ||
        world->model.def.on_overstretch != TULLE_ON_OVERSTRETCH_STOP)
        return TULLE_OK;
    yarn_stretch const longest =
        cloth_find_longest_yarn(world->model.cloth_model, context->state->positions, true);
    const uint32_t *const corners = world->model.topo.triangles + 3 * (size_t)longest.triangle;
    size_t const cloth = world->model.vertex_surface[corners[0]];
    uint32_t const begin = world->model.surfaces[cloth].vertex_begin;
    return error_set(context->error, TULLE_ERROR_STEP_FAILED,
                     "'%s' is overstretched in step %llu, which is undone: at vertices %u, %u, %u "
                     "its %s is stretched by %.3g %%, and the material holds %.3g %%; pull less, "
                     "take a stronger material, or let on_overstretch warn",
                     world_surface_name(world, cloth), (unsigned long long)world->step_count,
                     corners[0] - begin, corners[1] - begin, corners[2] - begin,
                     longest.yarn == YARN_WARP ? "warp" : "weft", 100.0 * longest.strain,
                     100.0 * longest.limit);
}

/* The step on its copy of the state, again until nothing pinches or tears it. */
static tulle_status run_step(step_context *context) {
    tulle_world *const world = context->world;
    tulle_status status = world_copy_start(world, context->error);
    bool is_again = false;
    do {
        arena_mark const mark = arena_get_mark(&world->work.scratch);
        context->outcome = SUBSTEP_RUNS;
        if (status == TULLE_OK) world_begin_holds(context);
        if (status == TULLE_OK) status = world_begin_lag(context);
        if (status == TULLE_OK) status = world_begin_carriers(context);
        if (status == TULLE_OK) status = run_substeps(context);
        if (status == TULLE_OK && context->outcome != SUBSTEP_PINCHED) {
            status = world_settle_bodies(context, context->whole_step);
            if (status == TULLE_OK) status = world_settle_cloths(context, context->whole_step);
            world_end_lag(context);
            if (status == TULLE_OK) status = report_energies(context);
            if (status == TULLE_OK) status = check_overstretch(context);
            if (status == TULLE_OK && world_tears_squeezed(context))
                context->outcome = SUBSTEP_TORN;
        }
        is_again = world_retry_step(context, &status);
        arena_release(&world->work.scratch, mark);
    } while (is_again);
    return status;
}

tulle_step_progress tulle_world_get_step_progress(const tulle_world *world) {
    return world ? world->work.progress : (tulle_step_progress){0};
}

/* What a step leaves once it has run: its copy becomes the state, or all is as it was. */
static tulle_status end_step(step_context *context, tulle_status status) {
    tulle_world *const world = context->world;
    tulle_error *const error = context->error;
    world->work.progress = (tulle_step_progress){0};
    if (atomic_load(&world->work.stop.is_stopped))
        status =
            error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted in step %llu, which is undone",
                      (unsigned long long)world->step_count);
    if (status == TULLE_OK) status = world_find_touching(world, context->state, error);
    if (status == TULLE_OK) status = world_swap_states(world, error);
    world_end_given(world, status != TULLE_OK);
    if (status == TULLE_OK)
        world_tell_events(world);
    else
        world_undo_step(world);
    return status;
}

static tulle_status make_step(tulle_world *world, double time_step, tulle_step_report *report,
                              tulle_error *error) {
    double const start = timer_now();
    if (world->is_started) world->message[0] = '\0';
    tulle_status status = world_start(world, true, NULL, error);
    if (status != TULLE_OK) return status;

    tulle_step_report local = {
        .step = world->step_count, .cg_converged = 1, .smallest_gap = (double)INFINITY};
    step_context context = {.world = world,
                            .state = &world->next,
                            .whole_step = time_step,
                            .report = &local,
                            .error = error};
    const tulle_tasks *const before = parallel_use(world->work.tasks);
    atomic_store(&world->work.stop.is_stopped, false);
    world->work.step_end = world->now.time + time_step;
    bool const stands = world_stands_still(world, time_step);
    status = stands ? world_pass_still(&context) : world_keep_start(world, error);
    if (!stands && status != TULLE_OK) {
        world_end_given(world, true);
    } else if (!stands) {
        arena_mark const mark = arena_get_mark(&world->work.scratch);
        status = world_begin_given(world, error);
        if (status == TULLE_OK) status = run_step(&context);
        if (status == TULLE_OK) status = world_end_pinch(&context);
        arena_release(&world->work.scratch, mark);
        status = end_step(&context, status);
    }
    (void)parallel_use(before);

    local.time = world->now.time;
    local.ignored_pairs = world->ignored.count;
    local.total_seconds = timer_now() - start;
    if (report) *report = local;
    return status;
}

tulle_status tulle_world_step(tulle_world *world, double time_step, tulle_step_report *report,
                              tulle_error *error) {
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world is null");
    if (!(time_step > 0.0 && time_step <= TIME_STEP_MAX))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the time step is %g s; it must be greater than 0 and at most %g s",
                         time_step, TIME_STEP_MAX);
    recorded_call const call = {.kind = RECORD_STEP, .arrays = {{&time_step, 1}}};
    tulle_status status = world_begin_call(world, &call, error);
    if (status != TULLE_OK) return status;
    status = make_step(world, time_step, report, error);
    world_end_call(world, status);
    return status;
}
