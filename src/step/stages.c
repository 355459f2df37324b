/* step/stages.c - stage 1, and stages 5 to 9: hands their input from the world to each and takes
 * its output.
 *
 * The stages themselves are in contact/ and dynamics/, where they know neither a world nor a step.
 * Each takes its input from the context, writes its output there and counts into the report. */
#include "base/timer.h"
#include "contact/pairs/body_paths.h"
#include "contact/rows/row_motion.h"
#include "contact/solve/solve_bodies.h"
#include "step/bodies/bodies.h"
#include "step/bodies/bodies_sleep.h"
#include "step/energy_balance.h"
#include "step/lag/lag.h"
#include "step/script.h"
#include "step/sleep/cloth_sleep.h"
#include "step/step_context.h"
#include "step/stretch.h"
#include "step/ties/ties.h"

#include <math.h>
#include <string.h>

/* ---- 1: where the vertices go if nothing stops them ----
 *
 * Takes the state at the start of the substep and the script; fills what the stages read
 * (context->scene, targets, arrays of the scratch arena). Gives the paths to expect: x0 + h v0 +
 * h^2 g for cloth, without contact and inner forces, and the path to the target for everything on a
 * script. Stages 2 to 5 search along them. */

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

/* ---- 5 to 9: contact and dynamics ---- */

/* Springs may take more energy than the linear system predicts. The solve is misled if the
 * difference exceeds this share of the energy that the step takes anyway. */
static const double EXCESS_SHARE = 0.5;
/* Near rest a step takes next to no energy. So springs that were linearised again may also take
 * this share of m (g h)^2 of the lightest cloth. Without that first time pinched cloth creeps.
 * Beside bodies they may not: a stack on cloth would creep. */
static const double FALL_SHARE = 0.01;
/* The first new linearisation usually leaves less than a twentieth of the excess. Where that will
 * do, the solve that follows is a full one, but for an excess over m (g h)^2: stiff sheets that
 * land would be thrown about more, and cloth would creep in a drum that spins fast. */
static const double NEWTON_FALL = 20.0;

/* If the first, rough solution of a substep stretches cloth by so many times the limit, the substep
 * is refused at once. Later solves seldom mend it. */
static const double HOPELESS_GROWTH = 80.0;

/* Paths of a rough solve that are so many times longer than the longest expected path are not used
 * to foresee impacts: they may hit everything. */
static const double LEAP = 4.0;

/* [bytes] of scratch for each vertex of cloth that other stages may need while terms are kept, and
 * that terms may take in any case. */
enum { SCRATCH_BESIDE_TERMS = 640, SMALL_TERMS = 1 << 22 };

tulle_status step_end_stage(step_context *context, stage number, tulle_status status) {
    double const now = timer_now();
    context->work->report->stage_seconds[number] += now - context->lap - context->search_seconds;
    context->search_seconds = 0.0;
    context->lap = now;
    return step_narrow(status);
}

/* ---- 5 ---- */

tulle_status step_gather_rows(step_context *context) {
    tulle_status const status =
        gather_rows(&context->sub->scene, &context->state->contacts, context->sub->predicted,
                    &context->source, &context->work->rows);
    context->gathered_count = context->work->rows.rows.count;
    return step_end_stage(context, STAGE_GATHER_ROWS, status);
}

/* ---- 6 ---- */

tulle_status step_compute_forces(step_context *context) {
    cloth_start *const dynamics = &context->sub->dynamics;
    if (!dynamics->guess) {
        context->sub->damping = step_choose_damping(context->model, context->work);
        /* Terms are kept for later linearisations where they are small, or where a step takes that
         * much memory anyway: where the search for contacts has taken more than what comes after
         * it. */
        size_t const size =
            measure_force_terms(context->model->cloth_model, &context->model->def.wind);
        size_t const needed = SCRATCH_BESIDE_TERMS * context->model->cloth_vertex_count + size;
        bool const are_kept =
            size <= SMALL_TERMS || arena_get_room(&context->work->scratch) > needed;
        context->sub->terms = (force_terms){0};
        dynamics->terms = are_kept ? &context->sub->terms : NULL;
    }
    environment const surroundings = {vec3_load(context->model->def.gravity, 0),
                                      context->model->def.wind};
    force_options const options = {context->model->def.integrator, context->work->threads,
                                   context->sub->damping,
                                   context->sub->scene.response->needs_forces};
    tulle_status const status =
        compute_forces(context->model->cloth_model, dynamics, &surroundings, options,
                       &context->work->scratch, &context->work->system);
    return step_end_stage(context, STAGE_COMPUTE_FORCES, status);
}

/* ---- 7 ---- */

/* Whether the solution stretches the cloth by more energy than the linear system knows of; then the
 * result says how much more. */
static tulle_status check_springs(step_context *context) {
    /* of the energy that implicit Euler takes, Crank-Nicolson takes the part of its damping */
    double const c = context->work->system.share;
    bool const is_mean = context->work->system.integrator == TULLE_INTEGRATOR_CRANK_NICOLSON;
    double const kept = is_mean ? (2.0 * c - 1.0) / (c * c) : 1.0;
    linear_excess *const excess = &context->excess;
    tulle_status status = measure_linear_excess(
        context->model->cloth_model, &context->sub->dynamics, context->sub->mean_velocity,
        context->work->threads, &context->work->scratch, excess);
    if (status != TULLE_OK) return status;
    double const of_step = EXCESS_SHARE * kept * excess->inertia;
    if (!(excess->springs > of_step)) return TULLE_OK;
    double lightest = (double)INFINITY;
    for (size_t s = 0; s < context->model->cloths.count; s++) {
        double mass = 0.0;
        for (uint32_t v = context->work->surfaces[s].vertex_begin;
             v < context->work->surfaces[s].vertex_end; v++)
            mass += context->model->cloth_model->masses[v];
        lightest = fmin(lightest, mass);
    }
    double const speed =
        vec3_norm(vec3_load(context->model->def.gravity, 0)) * context->sub->time_step;
    bool const has_bodies = context->sub->scene.body_count > 0;
    double const fall = has_bodies ? 0.0 : kept * (lightest * speed * speed); /* [J] m (g h)^2 */
    double const enough = fmax(of_step, FALL_SHARE * fall);
    if (context->retry.linearisations > 0 && !(excess->springs > enough)) return TULLE_OK;
    bool const is_nearly_linear = excess->springs < fmin(NEWTON_FALL * enough, fall);
    status = step_temper(context);
    if (step_may_linearise(&context->retry, context->retry.lost.is_lost))
        context->result = context->retry.lost.is_lost ? SOLVE_LOST
                          : is_nearly_linear          ? SOLVE_NEARLY_SOLVED
                                                      : SOLVE_STRETCHED;
    return status;
}

tulle_status step_solve_motion(step_context *context) {
    retry_state *const retry = &context->retry;
    retry->lost.is_tempered = false;
    double *const u = context->sub->mean_velocity;
    bool const is_first = retry->solves++ == 0;
    motion_system const system = {.right_hand_side = context->work->system.right_hand_side,
                                  .matrix = &context->work->system.matrix,
                                  .forces = context->work->system.forces,
                                  .force_time = context->work->system.force_time,
                                  .start = is_first ? NULL : context->state->velocities,
                                  .aggregates = context->work->aggregates,
                                  .history = &retry->history,
                                  .springs = context->sub->springs,
                                  .spring_count = context->sub->spring_count};
    if (is_first) { /* velocities and impulses from which the solves of a substep start */
        step_scale_impulses(context, context->work->system.force_time / context->sub->time_step);
        if (step_keeps_balance(context->model, context->work))
            step_share_room(context->state, context->work);
        memcpy(u, context->state->velocities,
               3 * context->model->cloth_vertex_count * sizeof(double));
        start_bodies(&context->sub->scene, &context->work->rows, u);
        prescribe_motion(&context->sub->scene, u);
    }
    solve_plan const plan =
        step_make_solve_plan(context->model, context->work, retry->is_rough, retry->balances);
    solve_report solved = {0};
    step_load_bodies(context->model, context->work, context->work->system.share);
    const contact_response *const response = context->sub->scene.response;
    tulle_status status = response->solve_motion(&context->sub->scene, &system, &plan,
                                                 &context->work->rows, u, &solved);
    bool const goes_on =
        plan.iterations_most < context->model->paper.cg_max_iterations && !solved.has_converged;
    bool const has_settled = solved.has_settled && !goes_on && !solved.is_early &&
                             (int)solved.solve_count >= plan.rounds_settled;
    context->result = has_settled ? SOLVE_SOLVED : SOLVE_ROUGH;
    retry->history.iterations += solved.cg_iterations;
    if (status == TULLE_OK && response->linearises_again) status = check_springs(context);
    if (status == TULLE_OK && is_first && retry->is_rough &&
        context->result >= SOLVE_NEARLY_SOLVED && step_may_halve(context)) {
        propose_paths(&context->sub->scene, u, context->sub->end);
        bool stretches = false;
        status = step_judge_stretch(context->model, context->state, context->work, HOPELESS_GROWTH,
                                    &stretches);
        if (stretches) context->outcome = SUBSTEP_STRETCHES;
    }

    tulle_step_report *const report = context->work->report;
    report->solve_count += solved.solve_count;
    context->work->progress.solve_count = report->solve_count;
    report->cg_iterations += solved.cg_iterations;
    if (!goes_on) report->cg_residual = fmax(report->cg_residual, solved.cg_residual);
    if (!solved.has_converged && !goes_on) report->cg_converged = 0;
    report->stick_contacts = solved.stick_count;
    report->slip_contacts = solved.slip_count;
    report->hard_contacts = solved.hard_count;
    return step_end_stage(context, STAGE_SOLVE_MOTION, status);
}

/* ---- 8 ---- */

/* A rough solve of fine cloth: its impacts become rows, which the solves that follow answer to.
 * Where rows of earlier impacts are more than others, those without load go: rough paths may hit
 * much that later ones never come near. */
static tulle_status foresee(step_context *context) {
    row_list *const list = &context->work->rows;
    size_t const gathered = context->gathered_count;
    double expected2 = 0.0, found2 = 0.0; /* [m^2] longest ways */
    for (size_t v = 0; v < context->sub->scene.vertex_count; v++) {
        vec3 const x0 = vec3_load(context->state->positions, v);
        double const expected = vec3_norm2(vec3_sub(vec3_load(context->sub->predicted, v), x0));
        double const found = vec3_norm2(vec3_sub(vec3_load(context->sub->end, v), x0));
        expected2 = expected > expected2 ? expected : expected2;
        found2 = found > found2 ? found : found2;
    }
    context->impacts = (impact_report){0};
    if (found2 > LEAP * LEAP * expected2) return TULLE_OK;
    bool const are_many = list->rows.count > 2 * gathered;
    size_t kept = gathered;
    for (size_t i = gathered; i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        bool const is_loaded = row->solve.is_hard || get_normal_impulse(row) > 0.0;
        if (is_loaded || !are_many) list->rows.data[kept++] = *row;
    }
    list->rows.count = kept;
    tulle_status const status =
        foresee_impacts(&context->sub->scene, &context->source, list, context->sub->predicted,
                        context->sub->end, &context->impacts);
    if (context->impacts.impact_count > 0 && context->result == SOLVE_SOLVED)
        context->result = SOLVE_ROUGH;
    return status;
}

tulle_status step_resolve_impacts(step_context *context) {
    row_list *const list = &context->work->rows;
    tulle_step_report *const report = context->work->report;
    propose_paths(&context->sub->scene, context->sub->mean_velocity, context->sub->end);
    context->sub->end_elastic.is_known = false; /* impacts move the ends on */
    tulle_status const status =
        context->retry.is_rough
            ? foresee(context)
            : resolve_impacts(&context->sub->scene, &context->source, list,
                              context->sub->mean_velocity, context->sub->end, &context->impacts);
    report->impact_rounds += context->impacts.rounds;
    report->tested_pairs += context->impacts.tested_pairs;
    report->turning_pairs += context->impacts.turning_pairs;
    return step_end_stage(context, STAGE_RESOLVE_IMPACTS, status);
}

/* ---- 9 ---- */

tulle_status step_commit_safely(step_context *context) {
    static const substep_outcome outcomes[] = {[COMMIT_CLEAN] = SUBSTEP_WHOLE,
                                               [COMMIT_SHORTENED] = SUBSTEP_SHORTENED,
                                               [COMMIT_BLOCKED] = SUBSTEP_BLOCKED};
    commit_report *const commit = &context->commit;
    tulle_step_report *const report = context->work->report;
    tulle_status status =
        commit_safely(&context->sub->scene, &context->source, context->impacts.is_clean,
                      context->sub->mean_velocity, context->sub->end, commit);
    context->sub->end_elastic.is_known &=
        context->impacts.is_clean; /* else a rescue may move the ends */
    report->tested_pairs += commit->tested_pairs;
    report->turning_pairs += commit->turning_pairs;
    if (status == TULLE_OK) {
        if (commit->has_blocking) context->work->lag.blocked = *commit;
        context->sub->passed = commit->fraction * context->sub->time_step;
        context->outcome = outcomes[commit->outcome];
        /* a rescue knows nothing of springs: cloth that it moved may have far too much energy
         */
        bool const has_rescue = commit->impact_zones + commit->component_scalings > 0;
        if (has_rescue && commit->outcome == COMMIT_CLEAN && step_may_refuse_gain(context)) {
            status = step_measure_gain(context->model, context->state, context->work);
            if (status == TULLE_OK && step_gains_too_much(context->work, &context->retry.lost))
                context->outcome = SUBSTEP_GAINS;
        }
    }
    if (status == TULLE_OK && context->outcome != SUBSTEP_GAINS) {
        const row_list *const list = &context->work->rows;
        report->rescue_impact_zones += commit->impact_zones;
        report->rescue_component_scalings += commit->component_scalings;
        report->rescue_global_scalings += commit->global_scalings;
        report->smallest_gap = commit->smallest_gap;
        report->contacts = list->rows.count;
        report->new_contacts = 0;
        for (size_t i = 0; i < list->rows.count; i++)
            report->new_contacts += !list->rows.data[i].law.is_old;
    }
    return step_end_stage(context, STAGE_COMMIT_SAFELY, status);
}
