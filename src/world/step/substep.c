/* world/step/substep.c - one pass through the twelve stages, over as much of the time step as is
 * safe.
 *
 * Takes the state at the start of the substep; gives the state at its end, `passed` seconds later,
 * proven free of intersection. Positions and velocities change in accept_paths alone.
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005 (the stages and their order); docs/method/index.md tells where we depart from it. */
#include "base/error.h"
#include "base/timer.h"
#include "contact/pairs/body_paths.h"
#include "contact/solve/end_velocities.h"
#include "contact/solve/solve_bodies.h"
#include "world/bodies/bodies.h"
#include "world/bodies/bodies_sleep.h"
#include "world/bodies/bodies_turn.h"
#include "world/pinch/holds.h"
#include "world/step/detection.h"

#include <math.h>
#include <string.h>

/* An edge may grow by this share of its rest length in one substep. More means that the solve has
 * not carried a hard landing into the cloth: vertices stop while their neighbours fly on. */
static const double STRETCH_GROWTH_MAX = 0.25;

/* Contact keeps this share of the minimum gap more than the world promises: a pair that is pressed
 * against it loses a little with every step. Half of it with each retry of a step that is stuck. */
static const double MINIMUM_GAP_RESERVE = 0.01;

/* The message of a stage that failed. */
static tulle_status fail_step(step_context *context, tulle_status status) {
    unsigned long long const step = context->world->step_count;
    switch (status) {
    case TULLE_ERROR_OUT_OF_MEMORY:
        return error_set(context->error, status, "no memory left for step %llu", step);
    case TULLE_ERROR_LIMIT:
        return error_set(context->error, status,
                         "step %llu has more than 2^32 candidate pairs; use a smaller contact "
                         "distance, a smaller time step or coarser meshes",
                         step);
    default:
        return error_set(context->error, TULLE_ERROR_STEP_FAILED,
                         "step %llu leads to positions that are not finite or too far away; use a "
                         "smaller time step, softer materials or weaker wind",
                         step);
    }
}

/* By the paper's response no other vertex gains what one loses, so contact can give energy on and
 * on. */
static tulle_status fail_torn(step_context *context) {
    return error_set(context->error, TULLE_ERROR_STEP_FAILED,
                     "contact by the paper's response tears cloth to over %g times its rest length "
                     "in step %llu; use the coupled response, a smaller time step or less "
                     "restitution",
                     WORLD_TORN_STRETCH, (unsigned long long)context->world->step_count);
}

void world_end_stage(step_context *context, stage number, double *start) {
    double *const seconds = context->report->stage_seconds;
    contact_times *const nested = &context->nested;
    double const now = timer_now();
    seconds[number] +=
        now - *start - context->search_seconds - nested->test_pairs - nested->select_admissible;
    seconds[STAGE_TEST_PAIRS] += nested->test_pairs;
    seconds[STAGE_SELECT_ADMISSIBLE] += nested->select_admissible;
    *nested = (contact_times){0};
    context->search_seconds = 0.0;
    *start = now;
}

static tulle_status allocate_arrays(step_context *context) {
    tulle_world *const world = context->world;
    size_t const n = 3 * world->vertex_count;
    context->mean_velocity = ARENA_NEW(&world->scratch, double, n);
    context->guess = ARENA_NEW(&world->scratch, double, n);
    context->predicted = ARENA_NEW(&world->scratch, double, n);
    context->end = ARENA_NEW(&world->scratch, double, n);
    context->bounds = ARENA_NEW(&world->scratch, double, n);
    context->certified_end = ARENA_NEW(&world->scratch, double, n);
    context->carrier_maps = ARENA_NEW(&world->scratch, affine_map, world->set.surface_count);
    context->paper =
        (paper_rules){world->def.motion_space, context->state->particles,
                      ARENA_NEW_ZEROED(&world->scratch, uint8_t, world_particle_count(world))};
    context->carriers = ARENA_NEW(&world->scratch, const affine_map *, world->set.surface_count);
    bool const is_complete = context->mean_velocity && context->guess && context->predicted &&
                             context->end && context->bounds && context->certified_end &&
                             context->carrier_maps && context->carriers && context->paper.after;
    return is_complete ? TULLE_OK : fail_step(context, TULLE_ERROR_OUT_OF_MEMORY);
}

static contact_settings make_settings(const step_context *context) {
    tulle_world const *const world = context->world;
    double const reserve = ldexp(MINIMUM_GAP_RESERVE, -context->retry_count);
    contact_settings settings = contact_settings_default();
    settings.minimum_gap = (1.0 + reserve) * world->minimum_gap;
    settings.solve_rounds = world->def.solve_rounds;
    if (settings.solve_rounds_landing < settings.solve_rounds) {
        settings.solve_rounds_landing = settings.solve_rounds;
    }
    settings.impulse_sweeps = world->def.impulse_sweeps;
    settings.impact_rounds = world->def.impact_rounds;
    settings.cg_tolerance = world->def.cg_tolerance;
    settings.cg_max_iterations = world->def.cg_max_iterations;
    return settings;
}

/* Scripted targets and everything that the stages read. */
static tulle_status prepare(step_context *context) {
    tulle_world *const world = context->world;
    world_motion_state *const state = context->state;
    tulle_status status = allocate_arrays(context);
    if (status != TULLE_OK) return status;
    double const advance = context->is_script_frozen ? 0.0 : context->time_step;
    status = world_script_targets(world, state->time, state->time + advance, context->error);
    if (status != TULLE_OK) return status;
    world_hold_targets(context);
    if (context->is_script_frozen) {
        memcpy(world->targets, state->positions, 3 * world->vertex_count * sizeof(double));
    }
    world_wake_near_script(context);
    world_find_carriers(context);
    context->scene = (contact_scene){
        .set = &world->set,
        .vertex_count = world->vertex_count,
        .cloth_vertex_count = world->cloth_vertex_count,
        .vertex_surface = world->vertex_surface,
        .x0 = state->positions,
        .v0 = state->velocities,
        .rest = world->rest,
        .targets = world->targets,
        .inverse_mass = world->active_inverse_masses,
        .laws = world->laws,
        .largest_contact = world->contact_distance,
        .largest_separation = world->separation_distance,
        .grains = world->grains,
        .gravity = vec3_load(world->def.gravity, 0),
        .carriers = context->carriers,
        .ignored = world->ignored_keys.data,
        .ignored_count = world->ignored_keys.count,
        .time_step = context->time_step,
        .response = get_response(world->def.response),
        .paper = world->def.response == TULLE_RESPONSE_PAPER ? &context->paper : NULL,
        .settings = make_settings(context),
        .heap = &world->heap,
        .scratch = &world->scratch,
        .times = &context->nested,
        .stop = &world->stop,
        .threads = world->threads};
    if (world_prepare_bodies(context) != TULLE_OK)
        return fail_step(context, TULLE_ERROR_OUT_OF_MEMORY);
    context->dynamics = (motion_state){.positions = state->positions,
                                       .velocities = state->velocities,
                                       .previous_mean = state->previous_mean,
                                       .previous_velocities = state->previous_velocities,
                                       .time_step = context->time_step,
                                       .previous_time_step = state->previous_time_step,
                                       .time = state->time};
    context->source = world_make_pair_source(context);
    return TULLE_OK;
}

/* Where the cloth would go without contact and inner forces: x0 + h v0 + h^2 g. */
static void predict_paths(step_context *context) {
    tulle_world *const world = context->world;
    double const h = context->time_step;
    vec3 const fall = vec3_scale(vec3_load(world->def.gravity, 0), h);
    double *const u = context->mean_velocity;
    for (size_t v = 0; v < world->cloth_vertex_count; v++) {
        vec3_store(u, v, vec3_add(vec3_load(context->state->velocities, v), fall));
    }
    start_bodies(&context->scene, u);
    prescribe_motion(&context->scene, u);
    propose_paths(&context->scene, u, context->predicted);
}

static void count_contacts(step_context *context) {
    row_list const *const list = &context->world->rows;
    uint64_t new_count = 0;
    for (size_t i = 0; i < list->rows.count; i++) new_count += !list->rows.data[i].law.is_old;
    context->report->contacts = list->rows.count;
    context->report->new_contacts = new_count;
}

static tulle_status run_commit_safely(step_context *context, bool is_clean) {
    commit_report *const commit = &context->commit;
    tulle_status const status = commit_safely(&context->scene, &context->source, is_clean,
                                              context->mean_velocity, context->end, commit);
    context->has_end_elastic &= is_clean; /* else a rescue may have moved the ends */
    tulle_step_report *const report = context->report;
    report->tested_pairs += commit->tested_pairs;
    report->turning_pairs += commit->turning_pairs;
    if (status == TULLE_OK && commit->has_blocking) context->blocked = *commit;
    context->passed = status == TULLE_OK ? commit->fraction * context->time_step : 0.0;
    return status;
}

static void count_rescues(step_context *context) {
    commit_report const *const commit = &context->commit;
    tulle_step_report *const report = context->report;
    report->rescue_impact_zones += commit->impact_zones;
    report->rescue_component_scalings += commit->component_scalings;
    report->rescue_global_scalings += commit->global_scalings;
    report->smallest_gap = commit->smallest_gap;
}

/* Whether what was rescued has far more energy than there is: a rescue knows nothing of springs. */
static tulle_status check_rescue(step_context *context) {
    commit_report const *const commit = &context->commit;
    bool const has_rescue = commit->impact_zones + commit->component_scalings > 0;
    bool has_gained = false;
    tulle_status status = TULLE_OK;
    if (has_rescue && commit->outcome == COMMIT_CLEAN &&
        context->time_step > context->shortest_step)
        status = world_check_gain(context, &has_gained);
    context->is_rejected = has_gained;
    return status;
}

/* Impulses of rows are as b counts them while the motion is solved, and those that act in the whole
 * step before and after: the same for implicit Euler. */
static void scale_impulses(row_list *list, double factor) {
    for (size_t i = 0; i < list->rows.count; i++)
        list->rows.data[i].solve.impulse = vec3_scale(list->rows.data[i].solve.impulse, factor);
}

/* Which vertices end with u itself: those that are held; by the paper's response also those in
 * contact. */
static void mark_plain_ends(const step_context *context, uint8_t *is_plain) {
    tulle_world const *const world = context->world;
    for (size_t v = 0; v < world->cloth_vertex_count; v++)
        is_plain[v] = !(world->active_inverse_masses[v] > 0.0);
    if (!context->scene.paper) return;
    for (size_t i = 0; i < world->rows.rows.count; i++) {
        contact_row const *const row = &world->rows.rows.data[i];
        if (vec3_norm2(row->solve.impulse) == 0.0) continue;
        for (int k = 0; k < 4; k++)
            if (row->frame.vertices[k] < world->cloth_vertex_count)
                is_plain[row->frame.vertices[k]] = 1;
    }
}

/* Of a substep that ended early, cloth has the part of its change of velocity that fits the time
 * which passed. */
static void shorten_changes(const step_context *context, double *end) {
    tulle_world const *const world = context->world;
    for (size_t v = 0; v < world->cloth_vertex_count; v++) {
        if (!(world->active_inverse_masses[v] > 0.0)) continue;
        vec3 const start = vec3_load(context->state->velocities, v);
        vec3 const change = vec3_sub(vec3_load(end, v), start);
        vec3_store(end, v, vec3_add_scaled(start, change, context->commit.fraction));
    }
}

static bool may_rebound(const tulle_world *world) {
    bool has_restitution = false;
    for (size_t i = 0; i < world->rows.rows.count; i++)
        has_restitution |= world->rows.rows.data[i].law.restitution > 0.0;
    return has_restitution;
}

/* The laws of impact, as far as energy allows. */
static tulle_status end_contacts(step_context *context, double *end, end_velocities *ends) {
    tulle_world *const world = context->world;
    if (may_rebound(world)) {
        kinetic_limit limit;
        tulle_status const status = world_find_kinetic_limit(context, &limit);
        if (status != TULLE_OK) return status;
        ends->kinetic_limit = limit.energy;
    }
    return find_end_velocities(&context->scene, &world->rows, context->mean_velocity, end, ends);
}

/* Velocities at the end: those of the integrator, and contacts that carry load end as the laws of
 * impact say. */
static tulle_status accept_velocities(step_context *context) {
    tulle_world *const world = context->world;
    world_motion_state *const state = context->state;
    linear_system const *const system = &world->system;
    bool const is_whole = context->commit.outcome == COMMIT_CLEAN;
    size_t const bytes = 3 * world->vertex_count * sizeof(double);
    double *const end = context->predicted; /* free again: takes the new velocities */
    bool const is_euler = system->integrator == TULLE_INTEGRATOR_IMPLICIT_EULER;
    end_velocities ends = {.is_inelastic = !is_euler};
    mark_plain_ends(context, world->is_fixed);
    scale_impulses(&world->rows, 1.0 / system->share); /* to what they gave to end velocities */
    memcpy(end, context->mean_velocity, bytes);
    finish_velocities(system, &context->dynamics, world->is_fixed, context->mean_velocity, end);
    if (!is_whole) shorten_changes(context, end);
    world_end_bodies(context, end);
    if (is_whole && !context->scene.paper) { /* the paper's law of impact is in u already */
        tulle_status const status = end_contacts(context, end, &ends);
        if (status != TULLE_OK) return status;
    }
    scale_impulses(&world->rows, system->share * context->time_step / system->force_time);
    world_finish_bodies(context, end);
    memcpy(state->previous_velocities, state->velocities, bytes);
    memcpy(state->previous_mean, context->mean_velocity, bytes);
    memcpy(state->velocities, end, bytes);
    /* velocities that jump are no history */
    bool const is_smooth = is_whole && ends.rebound_count == 0 && context->damping < 1.0;
    state->previous_time_step = is_smooth ? context->time_step : 0.0;
    return TULLE_OK;
}

/* The one place where the state moves on. */
static tulle_status accept_paths(step_context *context) {
    tulle_world *const world = context->world;
    world_motion_state *const state = context->state;
    tulle_status status = accept_velocities(context);
    if (status == TULLE_OK)
        context->scene.response->keep_contacts(&context->scene, context->end, &world->rows);
    /* impulses belong to the whole substep that was solved for, even if less of it passed */
    if (status == TULLE_OK) status = world_keep_resting(context);
    if (status == TULLE_OK)
        status = update_contacts(&state->contacts, &world->heap, &world->rows, context->time_step);
    if (status == TULLE_OK)
        status = add_contacts(&state->contacts, &world->heap, context->resting,
                              context->resting_count, context->time_step);
    if (status != TULLE_OK) return fail_step(context, status);
    memcpy(state->positions, context->end, 3 * world->vertex_count * sizeof(double));
    state->elastic = context->end_elastic;
    state->has_elastic = context->has_end_elastic;
    state->time += context->passed;
    world_follow_carriers(context);
    return TULLE_OK;
}

static tulle_status run_stages(step_context *context) {
    row_list *const rows = &context->world->rows;
    double start = timer_now();

    /* stages 5, 6 and 7 for the predicted paths; stages 10 and 11 come back to them */
    predict_paths(context);
    tulle_status status = context->source.renew(&context->source, context->predicted);
    world_end_stage(context, STAGE_PROPOSE_PATHS, &start);
    if (status != TULLE_OK) return fail_step(context, status);

    status = gather_contacts(&context->scene, &context->state->contacts, context->predicted,
                             &context->source, rows);
    world_end_stage(context, STAGE_GATHER_CONTACTS, &start);
    if (status != TULLE_OK) return fail_step(context, status);

    context->damping = world_choose_damping(context);
    status = world_compute_forces(context);
    world_end_stage(context, STAGE_COMPUTE_FORCES, &start);
    if (status != TULLE_OK) return fail_step(context, status);

    scale_impulses(rows, context->world->system.force_time / context->time_step);
    impact_report impacts = {0};
    status = world_solve_step(context, &impacts, &start);
    if (status == TULLE_OK) status = world_wake_pressed(context);
    if (status != TULLE_OK) return fail_step(context, status);
    if (context->has_woken) return TULLE_OK;

    context->is_rejected = world_turns_too_far(context);
    if (context->is_rejected) return TULLE_OK;
    context->is_rejected =
        context->time_step > context->shortest_step &&
        (context->has_gained || world_measure_stretch_growth(context) > STRETCH_GROWTH_MAX);
    if (context->is_rejected) return TULLE_OK;
    if (context->scene.paper && world_is_torn(context)) return fail_torn(context);
    /* these checks are of the solve, as is the balance of energy */
    world_end_stage(context, STAGE_SOLVE_MOTION, &start);

    status = run_commit_safely(context, impacts.is_clean);
    if (status == TULLE_OK) status = check_rescue(context);
    world_end_stage(context, STAGE_COMMIT_SAFELY, &start);
    if (status != TULLE_OK) return fail_step(context, status);
    if (context->is_rejected) return TULLE_OK;

    count_rescues(context);
    count_contacts(context);
    if (context->commit.outcome == COMMIT_BLOCKED) return TULLE_OK;
    status = accept_paths(context);
    world_end_stage(context, STAGE_UPDATE_CONTACTS, &start);
    return status;
}

tulle_status world_advance(step_context *context) {
    arena_mark const mark = arena_get_mark(&context->world->scratch);
    context->is_rejected = context->has_woken = context->has_end_elastic = false;
    context->passed = 0.0;
    tulle_status status = prepare(context);
    if (status == TULLE_OK) status = run_stages(context);
    arena_release(&context->world->scratch, mark);
    context->report->substeps += !context->has_woken;
    return status;
}
