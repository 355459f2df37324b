/* world/step/solve_step.c - stages 3, 4 and 10 of a substep, again until they feed the cloth
 * nothing.
 *
 * Solves for the motion with contact, proposes paths and resolves impacts on them. The springs are
 * linear in the solve, and impulses of the last sweeps, in stage 10 above all, act on the masses
 * alone: both may leave springs with energy that came from nowhere, as where a tip stops a vertex
 * and the cloth around it flies on. Takes the rows and the system of the start; gives u, the paths
 * x0 -> x1, and impulses.
 *
 * Based on: Newton's method for the equations of implicit Euler. */
#include "base/timer.h"
#include "contact/pairs/body_paths.h"
#include "contact/pairs/contact_paths.h"
#include "contact/solve/solve_bodies.h"
#include "world/bodies/bodies.h"
#include "world/bodies/bodies_room.h"

#include <math.h>
#include <string.h>

/* Springs are linearised anew while their energy beyond what the system reckons with is more than
 * this share of what the step takes anyway; so often at most. */
static const double EXCESS_SHARE = 0.5;
enum { LINEARISATIONS_MAX = 3 };
/* Solves that tell whether springs must be linearised anew, and about what, end at this part of
 * their first residual, but not above so many times the tolerance, or a hundredth: the next go on
 * from them. At rest the first residual is small, and they are as exact as others. */
static const double EARLY_SHARE = 0.01, EARLY_TOLERANCES = 30.0, EARLY_MOST = 0.01;

/* A step that ends with more energy than it may is solved anew, with impulses that settle better:
 * the most rounds of others, then twice as many each time, while that makes it less; so often at
 * most. */
enum { BALANCES_MAX = 3, BALANCE_ROUNDS = 6 };
/* Before that bodies make less room for one another, in so many steps. */
enum { ROOM_LEVELS = 2 };

/* A substep that still ends with more than this share of the energy at work in it is not taken: it
 * is tried again at half its length. Where all is well what is gained is under a hundred thousandth
 * of it; very stiff cloth that the solve has lost gains a hundred times it. */
static const double GAIN_MAX = 0.1;

/* [bytes] of scratch for each vertex of cloth that other stages may need while terms are kept. */
enum { SCRATCH_BESIDE_TERMS = 640 };

/* Terms are kept for later linearisations where that takes no more memory than a step takes anyway:
 * with contacts, whose detection has taken more than what comes after it. */
static void choose_terms(step_context *context) {
    tulle_world *const world = context->world;
    size_t const needed = SCRATCH_BESIDE_TERMS * world->cloth_vertex_count +
                          measure_force_terms(world->model, &world->def.wind);
    context->terms = (force_terms){0};
    context->dynamics.terms = arena_get_room(&world->scratch) > needed ? &context->terms : NULL;
}

tulle_status world_compute_forces(step_context *context) {
    tulle_world *const world = context->world;
    if (!context->dynamics.guess) choose_terms(context);
    environment const surroundings = {vec3_load(world->def.gravity, 0), world->def.wind};
    force_options const options = {world->def.integrator, world->threads, context->damping};
    return compute_forces(world->model, &context->dynamics, &surroundings, options, &world->scratch,
                          &world->system);
}

/* With springs linearised about u of now, again; `is_first`: about x0, from the velocities at the
 * start. */
static tulle_status run_solve_motion(step_context *context, bool is_first) {
    tulle_world *const world = context->world;
    linear_system_operator system_operator = {&world->system, world->threads};
    motion_system const system = {.right_hand_side = world->system.right_hand_side,
                                  .matrix = &world->system.matrix,
                                  .apply = linear_system_apply,
                                  .apply_context = &system_operator,
                                  .forces = world->system.forces,
                                  .force_time = world->system.force_time,
                                  .start = is_first ? NULL : context->state->velocities,
                                  .aggregates = world->aggregates};
    if (is_first) {
        memcpy(context->mean_velocity, context->state->velocities,
               3 * world->cloth_vertex_count * sizeof(double));
        start_bodies(&context->scene, context->mean_velocity);
        start_pressed_bodies(&context->scene, &world->rows, context->mean_velocity);
        prescribe_motion(&context->scene, context->mean_velocity);
    }
    solve_report solved = {0};
    world_load_bodies(context, world->system.share);
    tulle_status const status = context->scene.response->solve_motion(
        &context->scene, &system, &world->rows, context->mean_velocity, &solved);
    tulle_step_report *const report = context->report;
    report->solve_count += solved.solve_count;
    report->cg_iterations += solved.cg_iterations;
    if (solved.cg_residual > report->cg_residual) report->cg_residual = solved.cg_residual;
    if (!solved.has_converged) report->cg_converged = 0;
    context->has_settled = solved.has_settled && !solved.is_early &&
                           (int)solved.solve_count >= context->scene.settings.solve_rounds;
    report->stick_contacts = solved.stick_count;
    report->slip_contacts = solved.slip_count;
    report->hard_contacts = solved.hard_count;
    return status;
}

/* Springs linearised about u of now. */
static tulle_status linearise_anew(step_context *context) {
    memcpy(context->guess, context->mean_velocity,
           3 * context->world->cloth_vertex_count * sizeof(double));
    context->dynamics.guess = context->guess;
    return world_compute_forces(context);
}

/* Whether the solution stretches the cloth by more energy than the linear system knows of. */
static tulle_status check_springs(const step_context *context, bool *is_false) {
    tulle_world *const world = context->world;
    /* of the energy that implicit Euler takes, Crank-Nicolson takes the part of its damping */
    double const c = world->system.share;
    bool const is_mean = world->system.integrator == TULLE_INTEGRATOR_CRANK_NICOLSON;
    double const kept = is_mean ? (2.0 * c - 1.0) / (c * c) : 1.0;
    linear_excess excess;
    tulle_status const status =
        measure_linear_excess(world->model, &context->dynamics, context->mean_velocity,
                              world->threads, &world->scratch, &excess);
    *is_false = status == TULLE_OK && excess.springs > EXCESS_SHARE * kept * excess.inertia;
    return status;
}

static void make_quick(contact_settings *settings) {
    settings->solve_rounds = settings->solve_rounds_landing = 1;
    settings->early_share = EARLY_SHARE;
    settings->early_most = fmin(EARLY_TOLERANCES * settings->cg_tolerance, EARLY_MOST);
}

/* Solves until the springs' energy is what the system takes it for and impulses have settled. Until
 * springs are linearised for the last time a round of impulses at a time does, and less exactly. */
static tulle_status solve_with_true_springs(step_context *context, bool is_first) {
    contact_settings *const settings = &context->scene.settings;
    contact_settings const given = *settings;
    bool is_quick = !context->scene.paper, is_false = false;
    int linearisations = 0;
    tulle_status status = TULLE_OK;
    for (;;) {
        if (is_quick) make_quick(settings);
        status = run_solve_motion(context, is_first);
        *settings = given;
        is_first = false;
        if (status == TULLE_OK && !context->scene.paper) status = check_springs(context, &is_false);
        if (status != TULLE_OK) break;
        if (is_false && linearisations < LINEARISATIONS_MAX) {
            status = linearise_anew(context);
            if (status != TULLE_OK) break;
            linearisations++;
            is_quick = true;
        } else if (context->has_settled || !is_quick) {
            break;
        } else {
            is_quick = false;
        }
    }
    return status;
}

static tulle_status run_resolve_impacts(step_context *context, impact_report *impacts) {
    tulle_status const status =
        resolve_impacts(&context->scene, &context->source, &context->world->rows,
                        context->mean_velocity, context->end, impacts);
    context->report->impact_rounds += impacts->rounds;
    context->report->tested_pairs += impacts->tested_pairs;
    context->report->turning_pairs += impacts->turning_pairs;
    return status;
}

/* Other integrators have steps without friction of their own: energy goes up and down about its
 * value. Their steps with an impact are those of implicit Euler. */
static bool keeps_balance(const step_context *context) {
    tulle_world const *const world = context->world;
    return !context->scene.paper && world->rows.rows.count > 0 &&
           world->system.integrator == TULLE_INTEGRATOR_IMPLICIT_EULER;
}

/* What is held back with cloth between it presses in steps of any length alike. */
static bool is_too_much(const step_context *context, double gain) {
    return gain > GAIN_MAX * context->energy_scale && context->state->hold_count == 0;
}

tulle_status world_check_gain(step_context *context, bool *has_gained) {
    double gain = 0.0;
    tulle_status const status =
        keeps_balance(context) ? world_measure_gain(context, &gain) : TULLE_OK;
    *has_gained = status == TULLE_OK && gain > 0.0 && is_too_much(context, gain);
    return status;
}

tulle_status world_solve_step(step_context *context, impact_report *impacts, double *start) {
    contact_settings *const settings = &context->scene.settings;
    double last_gain = (double)INFINITY, gain = 0.0;
    int asked_less = 0;
    if (keeps_balance(context)) world_share_room(context);
    tulle_status status = solve_with_true_springs(context, true);
    for (int i = 0; status == TULLE_OK; i++) {
        world_end_stage(context, STAGE_SOLVE_MOTION, start);
        set_body_lifts(&context->scene, &context->world->rows);
        propose_paths(&context->scene, context->mean_velocity, context->end);
        context->has_end_elastic = false; /* impacts move on from there, and are measured then */
        world_end_stage(context, STAGE_PROPOSE_PATHS, start);
        status = run_resolve_impacts(context, impacts);
        world_end_stage(context, STAGE_RESOLVE_IMPACTS, start);
        if (status != TULLE_OK || !keeps_balance(context)) break;
        status = world_measure_gain(context, &gain);
        world_end_stage(context, STAGE_SOLVE_MOTION, start);
        if (status == TULLE_OK && gain > 0.0 && asked_less < ROOM_LEVELS &&
            world_ask_less_room(context, asked_less)) {
            asked_less++;
            i--;
            settings->push_out_speed = 0.0; /* of impacts that are found from now on */
            status = solve_with_true_springs(context, false);
            continue;
        }
        if (status != TULLE_OK || i == BALANCES_MAX || !(gain > 0.0 && gain < last_gain)) break;
        last_gain = gain;
        settings->solve_rounds = BALANCE_ROUNDS << i;
        if (settings->solve_rounds_landing < settings->solve_rounds)
            settings->solve_rounds_landing = settings->solve_rounds;
        status = linearise_anew(context);
        world_end_stage(context, STAGE_COMPUTE_FORCES, start);
        if (status == TULLE_OK) status = solve_with_true_springs(context, false);
    }
    context->has_gained =
        status == TULLE_OK && keeps_balance(context) && is_too_much(context, gain);
    world_note_loss(context, gain);
    return status;
}
