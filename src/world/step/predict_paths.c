/* world/step/predict_paths.c - stage 1: where the vertices go if nothing stops them.
 *
 * Takes the state at the start of the substep and the script; fills what the stages read
 * (context->scene, targets, arrays of the scratch arena). Gives the paths to expect: x0 + h v0 +
 * h^2 g for cloth, without contact and inner forces, and the way to the target for what follows a
 * script. Stages 2 to 5 search along them. */
#include "contact/pairs/body_paths.h"
#include "world/bodies/bodies.h"
#include "world/bodies/bodies_sleep.h"
#include "world/lag/lag.h"
#include "world/pinch/holds.h"
#include "world/sleep/cloth_sleep.h"
#include "world/step/search.h"
#include "world/ties/ties.h"

#include <math.h>
#include <string.h>

/* Contact keeps this share of the minimum gap more than the world promises, because a pair that is
 * pressed against the gap loses a little of it with every step. Each time that a stuck step goes on
 * with shorter substeps the share is halved. */
static const double MINIMUM_GAP_RESERVE = 0.01;

contact_scene world_make_scene(step_context *context) {
    tulle_world *const world = context->world;
    motion_state *const state = context->state;
    contact_settings settings = default_contact_settings;
    settings.minimum_gap = (1.0 + ldexp(MINIMUM_GAP_RESERVE, -context->retry.shorter_count)) *
                           world->model.minimum_gap;
    settings.solve_rounds = world->model.def.solve_rounds;
    if (settings.solve_rounds_landing < settings.solve_rounds)
        settings.solve_rounds_landing = settings.solve_rounds;
    settings.impulse_sweeps = world->model.def.impulse_sweeps;
    settings.impact_rounds = world->model.def.impact_rounds;
    settings.effort = &solve_efforts[world->model.def.quality];
    /* The residual counts least where the matrix is stiff, and vertices of short edges would hang
     * in the air as a pair. So solves end later there. */
    settings.cg_tolerance = world->model.height_share * world->model.def.cg_tolerance;
    settings.cg_max_iterations = world->model.def.cg_max_iterations;
    return (contact_scene){.set = &world->model.set,
                           .vertex_count = world->model.vertex_count,
                           .cloth_vertex_count = world->model.cloth_vertex_count,
                           .vertex_surface = world->model.vertex_surface,
                           .x0 = state->positions,
                           .v0 = state->velocities,
                           .rest = world->model.rest,
                           .targets = world->work.targets,
                           .inverse_mass = world->work.active_inverse_masses,
                           .laws = world->model.laws,
                           .largest_contact = world->model.contact_distance,
                           .largest_separation = world->model.separation_distance,
                           .grains = world->model.grains,
                           .rooms = world->model.rooms,
                           .automatic = world->model.automatic,
                           .gravity = vec3_load(world->model.def.gravity, 0),
                           .carriers = context->carriers,
                           .ignored = world->ignored_keys.data,
                           .ignored_count = world->ignored_keys.count,
                           .time_step = context->time_step,
                           .response = world->model.response,
                           .paper = world->model.response->keeps_particles ? &context->paper : NULL,
                           .settings = settings,
                           .heap = &world->heap,
                           .scratch = &world->work.scratch,
                           .stop = &world->work.stop,
                           .threads = world->work.threads};
}

static bool allocate_arrays(step_context *context) {
    tulle_world *const world = context->world;
    arena *const scratch = &world->work.scratch;
    size_t const n = 3 * world->model.vertex_count;
    context->mean_velocity = ARENA_NEW(scratch, double, n);
    context->guess = ARENA_NEW(scratch, double, n);
    context->predicted = ARENA_NEW(scratch, double, n);
    context->end = ARENA_NEW(scratch, double, n);
    context->bounds = ARENA_NEW(scratch, double, n);
    context->certified_end = ARENA_NEW(scratch, double, n);
    context->carrier_maps = ARENA_NEW(scratch, affine_map, world->model.set.surface_count);
    context->paper = (paper_rules){world->model.def.motion_space, context->state->particles,
                                   ARENA_NEW_ZEROED(scratch, uint8_t, world->model.particle_count)};
    context->carriers = ARENA_NEW(scratch, const affine_map *, world->model.set.surface_count);
    return context->mean_velocity && context->guess && context->predicted && context->end &&
           context->bounds && context->certified_end && context->carrier_maps &&
           context->carriers && context->paper.after;
}

tulle_status world_predict_paths(step_context *context) {
    tulle_world *const world = context->world;
    motion_state *const state = context->state;
    if (!allocate_arrays(context))
        return world_end_stage(context, STAGE_PREDICT_PATHS, TULLE_ERROR_OUT_OF_MEMORY);
    /* where the script has its vertices at the end of the substep, as far as holds let them go */
    double const advance = context->is_script_frozen ? 0.0 : context->time_step;
    tulle_status status =
        world_script_targets(world, state->time, state->time + advance, context->error);
    if (status != TULLE_OK) return status;
    world_lead_lag(context);
    world_hold_targets(context);
    world_lead_ties(context);
    if (context->is_script_frozen)
        memcpy(world->work.targets, state->positions,
               3 * world->model.vertex_count * sizeof(double));
    status = world_wake_near_script(context);
    if (status != TULLE_OK) return world_end_stage(context, STAGE_PREDICT_PATHS, status);
    world_hold_sleepers(context);
    world_compute_carriers(context);
    context->scene = world_make_scene(context);
    status = world_prepare_bodies(context);
    if (status == TULLE_OK) status = world_make_ties(context);
    context->dynamics = (cloth_start){.positions = state->positions,
                                      .velocities = state->velocities,
                                      .previous_mean = state->previous_mean,
                                      .previous_velocities = state->previous_velocities,
                                      .time_step = context->time_step,
                                      .previous_time_step = state->previous_time_step,
                                      .time = state->time,
                                      .plastic = state->plastic};
    context->source = world_make_pair_source(context);
    if (status == TULLE_OK) {
        vec3 const fall = vec3_scale(vec3_load(world->model.def.gravity, 0), context->time_step);
        double *const u = context->mean_velocity;
        for (size_t v = 0; v < world->model.cloth_vertex_count; v++)
            vec3_store(u, v, vec3_add(vec3_load(state->velocities, v), fall));
        prescribe_motion(&context->scene, u);
        propose_paths(&context->scene, u, context->predicted);
    }
    return world_end_stage(context, STAGE_PREDICT_PATHS, status);
}
