/* step/predict_paths.c - stage 1: where the vertices go if nothing stops them.
 *
 * Takes the state at the start of the substep and the script; fills what the stages read
 * (context->scene, targets, arrays of the scratch arena). Gives the paths to expect: x0 + h v0 +
 * h^2 g for cloth, without contact and inner forces, and the path to the target for everything on a
 * script. Stages 2 to 5 search along them. */
#include "contact/pairs/body_paths.h"
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"
#include "step/lag/lag.h"
#include "step/script.h"
#include "step/search.h"
#include "step/sleep/cloth_sleep.h"
#include "step/ties/ties.h"

#include <math.h>
#include <string.h>

/* Contact keeps this share of the minimum gap more than the world promises, because a pair that is
 * pressed against the gap loses a little of it with every step. Each time that a stuck step goes on
 * with shorter substeps the share is halved. */
static const double MINIMUM_GAP_RESERVE = 0.01;

contact_scene step_make_scene(step_context *context) {
    motion_state *const state = context->state;
    const contact_response *const response = contact_responses[context->model->paper.response];
    contact_settings settings = default_contact_settings;
    settings.minimum_gap = (1.0 + ldexp(MINIMUM_GAP_RESERVE, -context->retry.shorter_count)) *
                           context->model->minimum_gap;
    settings.impulse_sweeps = context->model->paper.impulse_sweeps;
    settings.impact_rounds = context->model->paper.impact_rounds;
    return (contact_scene){.set = &context->work->set,
                           .vertex_count = context->model->vertex_count,
                           .cloth_vertex_count = context->model->cloth_vertex_count,
                           .vertex_surface = context->model->vertex_surface,
                           .x0 = state->positions,
                           .v0 = state->velocities,
                           .rest = context->model->rest,
                           .targets = context->work->targets,
                           .inverse_mass = context->work->active_inverse_masses,
                           .laws = context->model->laws,
                           .largest_contact = context->model->contact_distance,
                           .largest_separation = context->model->separation_distance,
                           .grains = context->model->grains,
                           .rooms = context->model->rooms,
                           .automatic = context->model->automatic,
                           .gravity = vec3_load(context->model->def.gravity, 0),
                           .carriers = context->work->carriers.used,
                           .ignored = context->work->ignored_keys.data,
                           .ignored_count = context->work->ignored_keys.count,
                           .time_step = context->sub->time_step,
                           .response = response,
                           .paper = response->keeps_particles ? &context->sub->paper : NULL,
                           .settings = settings,
                           .heap = context->work->heap,
                           .scratch = &context->work->scratch,
                           .stop = &context->work->stop,
                           .threads = context->work->threads};
}

static bool allocate_arrays(step_context *context) {
    arena *const scratch = &context->work->scratch;
    size_t const n = 3 * context->model->vertex_count;
    context->sub->mean_velocity = ARENA_NEW(scratch, double, n);
    context->sub->guess = ARENA_NEW(scratch, double, n);
    context->sub->predicted = ARENA_NEW(scratch, double, n);
    context->sub->end = ARENA_NEW(scratch, double, n);
    context->sub->bounds = ARENA_NEW(scratch, double, n);
    context->sub->certified_end = ARENA_NEW(scratch, double, n);
    context->work->carriers.maps = ARENA_NEW(scratch, affine_map, context->model->surface_count);
    context->sub->paper =
        (paper_rules){context->model->paper.motion_space, context->state->particles,
                      ARENA_NEW_ZEROED(scratch, uint8_t, context->model->particle_count)};
    context->work->carriers.used =
        ARENA_NEW(scratch, const affine_map *, context->model->surface_count);
    return context->sub->mean_velocity && context->sub->guess && context->sub->predicted &&
           context->sub->end && context->sub->bounds && context->sub->certified_end &&
           context->work->carriers.maps && context->work->carriers.used &&
           context->sub->paper.after;
}

tulle_status step_predict_paths(step_context *context) {
    motion_state *const state = context->state;
    if (!allocate_arrays(context))
        return step_end_stage(context, STAGE_PREDICT_PATHS, TULLE_ERROR_OUT_OF_MEMORY);
    /* where the script has its vertices at the end of the substep, as far as lags let them go */
    tulle_status status =
        step_script_targets(context->model, context->work, state->time,
                            state->time + context->sub->time_step, context->work->error);
    if (status != TULLE_OK) return status;
    step_lead_lag(context->model, context->state, context->work);
    step_lead_ties(context->model, context->state, context->work);
    status = step_wake_near_script(context->model, context->state, context->work);
    if (status != TULLE_OK) return step_end_stage(context, STAGE_PREDICT_PATHS, status);
    step_hold_sleepers(context->model, context->state, context->work);
    step_compute_carriers(context->model, context->state, context->work);
    context->sub->scene = step_make_scene(context);
    status = step_prepare_bodies(context->model, context->state, context->work);
    if (status == TULLE_OK) status = step_make_ties(context->model, context->state, context->work);
    context->sub->dynamics = (cloth_start){.positions = state->positions,
                                           .velocities = state->velocities,
                                           .previous_mean = state->previous_mean,
                                           .previous_velocities = state->previous_velocities,
                                           .time_step = context->sub->time_step,
                                           .previous_time_step = state->previous_time_step,
                                           .time = state->time,
                                           .plastic = state->plastic};
    context->source = step_make_pair_source(context);
    if (status == TULLE_OK) {
        vec3 const fall =
            vec3_scale(vec3_load(context->model->def.gravity, 0), context->sub->time_step);
        double *const u = context->sub->mean_velocity;
        for (size_t v = 0; v < context->model->cloth_vertex_count; v++)
            vec3_store(u, v, vec3_add(vec3_load(state->velocities, v), fall));
        prescribe_motion(&context->sub->scene, u);
        propose_paths(&context->sub->scene, u, context->sub->predicted);
    }
    return step_end_stage(context, STAGE_PREDICT_PATHS, status);
}
