/* step/step.c - one step, all or nothing.
 *
 * A step takes the state and gives a state that is proven free of intersection, or an error and the
 * state as it was. It works on a copy (undo.c) in one or more substeps; a healthy scene needs one.
 * A substep runs the ten stages below, top down. A stage that cannot go on says how the substep
 * ended (substep_outcome); retry.c decides what is tried then.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005 (detection, contact, response in this order). Departures: docs/method/index.md. */
#include "step/step.h"

#include "base/timer.h"
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_room.h"
#include "step/bodies/bodies_sleep.h"
#include "step/bodies/bodies_turn.h"
#include "step/energy_balance.h"
#include "step/lag/lag.h"
#include "step/lag/pinch.h"
#include "step/sleep/cloth_sleep.h"
#include "step/step_context.h"
#include "step/stretch.h"

#include <math.h>
#include <string.h>

/* Looks at the motion of stages 7 and 8 before it is committed; may end the substep. No stage of
 * its own: its time counts as that of stage 7. */
static tulle_status judge_motion(step_context *context) {
    step_note_loss(context->work);
    bool wakes = false, stretches = false;
    tulle_status status = step_wake_pressed(context->model, context->state, context->work, &wakes);
    if (wakes) context->outcome = SUBSTEP_WAKES;
    if (status == TULLE_OK && context->outcome == SUBSTEP_RUNS) {
        context->retry.turn_time = step_find_turn_time(context->model, context->work);
        if (isfinite(context->retry.turn_time))
            context->outcome = SUBSTEP_TURNS;
        else if (step_may_refuse_gain(context) &&
                 step_gains_too_much(context->work, &context->retry.lost))
            context->outcome = SUBSTEP_GAINS;
        else if (step_may_halve(context))
            status =
                step_judge_stretch(context->model, context->state, context->work, 1.0, &stretches);
        if (stretches) context->outcome = SUBSTEP_STRETCHES;
        if (status == TULLE_OK && context->outcome == SUBSTEP_RUNS &&
            context->sub->scene.response->may_tear_cloth &&
            step_is_torn(context->model, context->state, context->work)) {
            context->work->failure =
                (step_finding){.kind = FINDING_TORN, .numbers = {TORN_STRETCH}};
            return TULLE_ERROR_STEP_FAILED;
        }
    }
    return step_end_stage(context, STAGE_SOLVE_MOTION, status);
}

/* The ten stages, over as much of context->time_step as is safe. */
static tulle_status run_substep(step_context *context) {
    arena_mark const mark = arena_get_mark(&context->work->scratch);
    context->outcome = SUBSTEP_RUNS;
    context->lap = timer_now();

    tulle_status status = step_predict_paths(context);                                      /* 1 */
    if (status == TULLE_OK) status = step_update_patches(context, context->sub->predicted); /* 2 */
    if (status == TULLE_OK) status = step_build_trees(context, context->sub->predicted);    /* 3 */
    if (status == TULLE_OK) status = step_find_pairs(context, context->sub->predicted);     /* 4 */
    if (status == TULLE_OK) status = step_gather_rows(context);                             /* 5 */
    if (status == TULLE_OK) status = step_compute_forces(context);                          /* 6 */
    if (status == TULLE_OK) step_begin_solves(context);
    bool runs = false; /* after the solves: none has ended the substep */
    do {
        do {
            if (status == TULLE_OK) status = step_solve_motion(context); /* 7 */
            runs = status == TULLE_OK && context->outcome == SUBSTEP_RUNS;
            if (runs && context->retry.is_rough && context->retry.history.is_costly)
                status = step_resolve_impacts(context); /* 8, for the solves that follow */
        } while (step_retry_solve(context, &status));
        if (runs && status == TULLE_OK) status = step_resolve_impacts(context); /* 8 */
    } while (step_retry_balance(context, &status));
    if (runs && status == TULLE_OK) status = judge_motion(context);
    if (status == TULLE_OK && context->outcome == SUBSTEP_RUNS)
        status = step_commit_safely(context); /* 9 */
    bool const is_accepted =
        context->outcome == SUBSTEP_WHOLE || context->outcome == SUBSTEP_SHORTENED;
    if (status == TULLE_OK && is_accepted) status = step_accept_state(context); /* 10 */

    arena_release(&context->work->scratch, mark);
    context->work->report->substeps += context->outcome != SUBSTEP_WAKES;
    return status;
}

/* Energies and stretch at the end of the step, into the report. */
static tulle_status report_energies(step_context *context) {
    motion_state *const state = context->state;
    tulle_step_report *const report = context->work->report;
    cloth_energies energies;
    tulle_status const status = step_measure_cloths(context->model, context->state, context->work,
                                                    state->positions, &state->elastic, &energies);
    if (status != TULLE_OK) return status;
    body_energies const bodies =
        step_measure_bodies(context->model, context->work, state->positions, state->velocities);
    report->kinetic_energy = energies.kinetic + bodies.kinetic;
    report->gravity_energy = energies.gravity + bodies.gravity;
    report->elastic_energy = energies.elastic.stretch + energies.elastic.bend;
    report->max_stretch = energies.elastic.max_stretch;
    report->overstretched = energies.elastic.overstretched;
    return TULLE_OK;
}

/* Fails if a yarn is beyond its limit and the world is to stop there. */
static tulle_status check_overstretch(const step_context *context) {
    if (context->work->report->overstretched == 0 ||
        context->model->def.on_overstretch != TULLE_ON_OVERSTRETCH_STOP)
        return TULLE_OK;
    yarn_stretch const longest =
        cloth_find_longest_yarn(context->model->cloth_model, context->state->positions, true);
    const uint32_t *const corners = context->model->topo.triangles + 3 * (size_t)longest.triangle;
    uint32_t const cloth = context->model->vertex_surface[corners[0]];
    uint32_t const begin = context->work->surfaces[cloth].vertex_begin;
    context->work->failure =
        (step_finding){.kind = FINDING_OVERSTRETCHED,
                       .surface = cloth,
                       .vertices = {corners[0] - begin, corners[1] - begin, corners[2] - begin},
                       .count = longest.yarn == YARN_WARP,
                       .numbers = {longest.strain, longest.limit}};
    return TULLE_ERROR_STEP_FAILED;
}

tulle_status step_run(const step_model *model, motion_state *state, step_work *work) {
    step_context whole = {.model = model, .state = state, .work = work, .sub = &work->sub};
    step_context *const context = &whole;
    tulle_status status = TULLE_OK;
    double const end_time = state->time + work->whole_step;
    bool is_again = false;
    work->failure = work->broken = (step_finding){0};
    work->lag = (lag_work){.places = work->lag.places, .still_count = work->start->still_count};
    memcpy(work->lag.still, work->start->still, sizeof work->lag.still);
    work->sub = (substep){0};
    work->lag.is_near = ARENA_NEW_ZEROED(&work->scratch, uint8_t, model->obstacles.count + 1);
    work->lag.is_freed = ARENA_NEW_ZEROED(&work->scratch, uint8_t, model->obstacles.count + 1);
    if (!work->lag.is_near || !work->lag.is_freed) return TULLE_ERROR_OUT_OF_MEMORY;
    do {
        arena_mark const mark = arena_get_mark(&work->scratch);
        context->outcome = SUBSTEP_RUNS;
        if (status == TULLE_OK) status = step_begin_lag(model, work);
        if (status == TULLE_OK) status = step_begin_carriers(model, work);
        step_begin_retries(context);
        while (status == TULLE_OK && !step_is_over(context)) {
            work->progress =
                (tulle_step_progress){.is_under_way = 1,
                                      .step = work->report->step,
                                      .substep = work->report->substeps + 1,
                                      .share = 1.0 - context->retry.remaining / work->whole_step,
                                      .solve_count = work->report->solve_count};
            if (stop_is_wanted(&work->stop, 0)) return TULLE_ERROR_INTERRUPTED;
            status = step_choose_substep(context);
            if (status == TULLE_OK) status = run_substep(context);
            step_retry_substep(context, &status);
        }
        if (status == TULLE_OK && context->outcome != SUBSTEP_PINCHED) {
            state->time = end_time;
            step_end_lag(model, state, work);
            status = step_settle_bodies(model, state, work);
            if (status == TULLE_OK)
                status = step_settle_cloths(model, state, work, context->outcome == SUBSTEP_WHOLE);
            if (status == TULLE_OK) status = report_energies(context);
            if (status == TULLE_OK) status = check_overstretch(context);
            if (status == TULLE_OK && step_tears_squeezed(model, state, work))
                context->outcome = SUBSTEP_TORN;
        }
        is_again = step_retry_whole(context, &status);
        arena_release(&work->scratch, mark);
    } while (is_again);
    if (status == TULLE_OK) step_end_pinch(model, state, work);
    return status;
}
