/* step/step.c - one step, all or nothing.
 *
 * A step takes the state and gives a state that is proven free of intersection, or an error and the
 * state as it was. It works on a copy in one or more substeps; a healthy scene needs one. The copy
 * takes the place of the state when the step has succeeded. What the step changes outside the copy
 * (who is present, patches) is noted before and put back when the step fails or is repeated.
 * A substep runs the ten stages below, top down. A stage that cannot go on says how the substep
 * ended (substep_outcome); retry.c decides what is tried then.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005 (detection, contact, response in this order). Departures: docs/method/index.md. */
#include "step/step.h"

#include "base/timer.h"
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"
#include "step/energy_balance.h"
#include "step/lag/lag.h"
#include "step/lag/pinch.h"
#include "step/script.h"
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
            if (status == TULLE_OK) status = step_report_energies(model, state, work);
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

/* ---- the copy, and what is put back ---- */

tulle_status step_keep_patches(step_work *work) {
    work->kept_patch_bytes.count = 0;
    if (!work->patches) return TULLE_OK;
    size_t const size = kept_patches_save(work->patches, NULL);
    if (!ARRAY_RESERVE(work->heap, &work->kept_patch_bytes, size)) return TULLE_ERROR_OUT_OF_MEMORY;
    work->kept_patch_bytes.count = kept_patches_save(work->patches, work->kept_patch_bytes.data);
    return TULLE_OK;
}

/* Patches that cannot be loaded for want of memory are gone, which is safe. */
void step_restore_patches(step_work *work) {
    if (!work->patches) return;
    (void)kept_patches_load(work->patches, work->kept_patch_bytes.data,
                            work->kept_patch_bytes.count);
}

void step_undo(const step_model *model, step_work *work) {
    for (size_t i = 0; i < model->obstacles.count; i++) {
        frame_cache *const frames = model->obstacles.data[i].frames;
        work->surfaces[model->cloths.count + i].is_present = work->start->is_present[i];
        /* a live reader may give other frames when the step is tried again */
        if (frames) frames->numbers[0] = frames->numbers[1] = TULLE_NONE;
    }
    step_mark_bodies(model, work->start, work);
    step_restore_patches(work);
}

/* Which obstacles are there, and which bodies are free, at the time of the state. */
static bool update_presence(const step_model *model, motion_state *state, step_work *work) {
    bool has_appeared = false, has_changed = false;
    for (size_t i = 0; i < model->obstacles.count; i++) {
        const world_obstacle *const obstacle = &model->obstacles.data[i];
        bool const is_present =
            state->time >= obstacle->appear_time && state->time < obstacle->disappear_time;
        has_appeared = has_appeared || (is_present && !state->is_present[i]);
        has_changed |= is_present != (state->is_present[i] != 0);
        state->is_present[i] = is_present;
        work->surfaces[model->cloths.count + i].is_present = is_present;
    }
    if (has_changed) step_wake_all(model, state);
    has_appeared |= step_free_bodies(model, state);
    step_mark_bodies(model, state, work);
    return has_appeared;
}

tulle_status step_copy_start(const step_model *model, motion_state *target, step_work *work,
                             bool *has_appeared) {
    const motion_state *const source = work->start;
    size_t const bytes = 3 * model->vertex_count * sizeof(double);
    double *from[STATE_VECTORS_MAX], *to[STATE_VECTORS_MAX];
    size_t const vector_count = step_list_vectors(source, from);
    (void)step_list_vectors(target, to);
    for (size_t i = 0; i < vector_count; i++) memcpy(to[i], from[i], bytes);
    if (model->obstacles.count > 0)
        memcpy(target->is_present, source->is_present, model->obstacles.count);
    if (model->particle_count > 0)
        memcpy(target->particles, source->particles, model->particle_count);
    if (model->cloth_rest_count > 0)
        memcpy(target->cloth_rests, source->cloth_rests,
               model->cloth_rest_count * sizeof *target->cloth_rests);
    if (model->body_count > 0) {
        memcpy(target->rests, source->rests, model->body_count * sizeof *target->rests);
        memcpy(target->drive_forces, source->drive_forces,
               BODY_AXES * model->body_count * sizeof(double));
    }
    if (model->pose_count > 0)
        memcpy(target->poses, source->poses, model->pose_count * sizeof *target->poses);
    for (size_t i = 0; i < model->obstacles.count; i++) { /* a jump is no velocity */
        const world_obstacle *const obstacle = &model->obstacles.data[i];
        if (obstacle->given == GIVEN_JUMP)
            memset(target->velocities + 3 * (size_t)obstacle->vertex_begin, 0,
                   3 * obstacle->mesh.vertex_count * sizeof(double));
    }
    double const length = work->step_end - source->time;
    for (size_t i = 0; i < model->cloths.count; i++) { /* it sets out to where it is drawn */
        const world_cloth *const cloth = &model->cloths.data[i];
        double *const x = target->positions + 3 * (size_t)cloth->vertex_begin;
        double *const v = target->velocities + 3 * (size_t)cloth->vertex_begin;
        for (size_t k = 0; cloth->is_drawn && k < 3 * cloth->mesh.vertex_count; k++)
            v[k] = (cloth->targets[3 * cloth->mesh.vertex_count + k] - x[k]) / length;
    }
    if (model->plastic_count > 0)
        memcpy(target->plastic, source->plastic, model->plastic_count * sizeof(double));
    target->previous_time_step = source->previous_time_step;
    target->lost_energy = source->lost_energy;
    target->elastic = source->elastic;
    memcpy(target->still, source->still, sizeof source->still);
    target->still_count = source->still_count;
    if (source->ties.count > 0) /* there is room: tulle_world_attach */
        memcpy(target->ties.data, source->ties.data, source->ties.count * sizeof(world_tie));
    target->ties.count = source->ties.count;
    target->attachment_count = source->attachment_count;
    if (model->lag_vertex_count > 0) {
        memcpy(target->lags, source->lags, 3 * model->lag_vertex_count * sizeof(double));
        memcpy(target->largest_lags, source->largest_lags, model->obstacles.count * sizeof(double));
    }
    target->time = source->time;
    target->step_count = source->step_count;

    size_t const count = source->contacts.contacts.count;
    target->contacts.contacts.count = 0;
    if (reserve_contacts(&target->contacts, work->heap, count) != TULLE_OK)
        return TULLE_ERROR_OUT_OF_MEMORY;
    if (count > 0)
        memcpy(target->contacts.contacts.data, source->contacts.contacts.data,
               count * sizeof *source->contacts.contacts.data);
    target->contacts.contacts.count = count;
    target->contacts.time_step = source->contacts.time_step;
    *has_appeared = update_presence(model, target, work);
    return TULLE_OK;
}
