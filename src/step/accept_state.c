/* step/accept_state.c - stage 10: the state moves on to the end of the substep.
 *
 * Takes u, the paths that commit_safely has proven and the rows with their impulses. Gives the
 * state its positions, velocities, contacts and time. No other stage changes the state. */
#include "contact/rows/carry_over.h"
#include "contact/solve/body_drives.h"
#include "contact/solve/end_velocities.h"
#include "dynamics/hysteresis.h"
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"
#include "step/script.h"
#include "step/step_context.h"
#include "step/ties/ties.h"

#include <string.h>

void step_scale_impulses(step_context *context, double factor) {
    row_list *const list = &context->work->rows;
    for (size_t i = 0; i < list->rows.count; i++)
        list->rows.data[i].solve.impulse = vec3_scale(list->rows.data[i].solve.impulse, factor);
}

/* Velocities at the end: those of the integrator, changed as the laws of impact say where contacts
 * carry load. */
static tulle_status accept_velocities(step_context *context) {
    motion_state *const state = context->state;
    row_list *const rows = &context->work->rows;
    const linear_system *const system = &context->work->system;
    const contact_response *const response = context->sub->scene.response;
    const double *const u = context->sub->mean_velocity;
    bool const is_whole = context->outcome == SUBSTEP_WHOLE;
    size_t const bytes = 3 * context->model->vertex_count * sizeof(double);

    /* the integrator, but for vertices that end with u itself */
    double *const end = context->sub->predicted; /* free again: takes the new velocities */
    for (size_t v = 0; v < context->model->cloth_vertex_count; v++)
        context->work->is_fixed[v] = !(context->work->active_inverse_masses[v] > 0.0);
    response->mark_plain_ends(&context->sub->scene, rows, context->work->is_fixed);
    /* to what they gave to end velocities */
    step_scale_impulses(context, 1.0 / system->share);
    memcpy(end, u, bytes);
    size_t const solved_count = get_solved_count(&context->sub->scene);
    finish_velocities(system, &context->sub->dynamics, solved_count, u, end);
    for (size_t v = 0; v < solved_count; v++) {
        if (context->work->is_fixed[v]) memcpy(end + 3 * v, u + 3 * v, 3 * sizeof(double));
        /* the part of the change of velocity that fits the passed time */
        bool const is_moved = v >= context->model->cloth_vertex_count ||
                              context->work->active_inverse_masses[v] > 0.0;
        if (is_whole || !is_moved) continue;
        vec3 const start = vec3_load(state->velocities, v);
        vec3 const change = vec3_sub(vec3_load(end, v), start);
        vec3_store(end, v, vec3_add_scaled(start, change, context->commit.fraction));
    }

    /* the laws of impact, as far as energy allows */
    end_velocities ends = {.is_inelastic = system->integrator != TULLE_INTEGRATOR_IMPLICIT_EULER};
    rest_bodies(&context->sub->scene, rows->rows.data, rows->rows.count);
    if (is_whole) {
        bool may_rebound = false;
        for (size_t i = 0; i < rows->rows.count; i++)
            may_rebound |= rows->rows.data[i].law.restitution > 0.0;
        kinetic_limit limit = {0};
        tulle_status status =
            may_rebound && response->balances_energy
                ? step_compute_kinetic_limit(context->model, context->state, context->work, &limit)
                : TULLE_OK;
        ends.kinetic_limit = limit.energy;
        if (status == TULLE_OK)
            status = response->end_contacts(&context->sub->scene, rows, u, end, &ends);
        if (status != TULLE_OK) return status;
    }
    step_scale_impulses(context, system->share * context->sub->time_step / system->force_time);
    if (state->previous_mean) {
        memcpy(state->previous_velocities, state->velocities, bytes);
        memcpy(state->previous_mean, u, bytes);
    }
    step_finish_bodies(context->model, context->state, context->work, end);
    memcpy(state->velocities, end, bytes);
    /* velocities that jump are no history */
    bool const is_smooth = is_whole && ends.rebound_count == 0 && context->sub->damping < 1.0;
    state->previous_time_step = is_smooth ? context->sub->time_step : 0.0;
    return TULLE_OK;
}

tulle_status step_accept_state(step_context *context) {
    motion_state *const state = context->state;
    tulle_status status = step_break_ties(context->model, context->state, context->work);
    if (status == TULLE_OK) status = accept_velocities(context);
    if (status == TULLE_OK)
        context->sub->scene.response->keep_contacts(&context->sub->scene, context->sub->end,
                                                    &context->work->rows);
    /* impulses belong to the whole substep that was solved for, even if less of it passed */
    if (status == TULLE_OK)
        status = step_keep_resting(context->model, context->state, context->work);
    if (status == TULLE_OK)
        status = store_contacts(&state->contacts, context->work->heap, &context->work->rows,
                                context->sub->resting, context->sub->resting_count,
                                context->sub->time_step);
    if (status == TULLE_OK && context->model->plastic_count > 0)
        status = hysteresis_follow(
            context->model->cloth_model,
            (slider_state){context->sub->end, context->work->threads, &context->work->scratch},
            state->plastic);
    if (status != TULLE_OK) return step_end_stage(context, STAGE_ACCEPT_STATE, status);
    memcpy(state->positions, context->sub->end, 3 * context->model->vertex_count * sizeof(double));
    state->elastic = context->sub->end_elastic;
    /* that holds what sliders have lost by now */
    if (context->model->plastic_count > 0) state->elastic.is_known = false;
    state->time += context->sub->passed;
    step_follow_carriers(context->model, context->work);
    return step_end_stage(context, STAGE_ACCEPT_STATE, TULLE_OK);
}
