/* world/step/energy_balance.c - the energy that a substep may end with.
 *
 * At the end of a substep, kinetic energy and the true potentials of springs, bending and gravity
 * may not be more than at its start and what was put in from outside: the work of wind, of pins and
 * of obstacles on their own way. Takes the substep as solved; gives what is left for the kinetic
 * energy. */
#include "contact/solve/end_velocities.h"
#include "world/bodies/bodies.h"
#include "world/bodies/body_control.h"
#include "world/ties/ties.h"

#include <math.h>
#include <string.h>

/* A gain is worth another solve if it is over the sum of two slacks. This is the first one, as a
 * share of the kinetic energy that gravity gives in a step from rest. */
static const double GRAVITY_SHARE = 1e-6;
/* The second slack: a share of the kinetic energy at the start. */
static const double KINETIC_SHARE = 1e-12;

/* A substep that gains more than this share of the energy at work in it is tried again at half its
 * length. Where all is well, a substep gains under a hundred thousandth of that energy. Very stiff
 * cloth that the solve has lost gains a hundred times that energy. */
static const double GAIN_MAX = 0.1;

/* The solve is lost when springs take so many times as much as is at work in the substep. What
 * moves slowly and pulls stiff cloth may well give more than that, so the springs' excess over what
 * is linear counts. Sheets that land well stay below. */
static const double LOST_SHARE = 1000.0;
/* A solution that no other follows may have so many times as much: a script that moves slowly and
 * pulls stiff cloth gives more than its own speed tells. */
static const double LAST_SHARE = 10.0;
/* A solution goes back on its way by so many halvings at most. */
enum { HALVINGS_MAX = 30 };

bool world_keeps_balance(const step_context *context) {
    const tulle_world *const world = context->world;
    return context->scene.response->balances_energy && world->work.rows.rows.count > 0 &&
           !world->model.cloth_model->shape && /* targets give what they like */
           world->work.system.integrator == TULLE_INTEGRATOR_IMPLICIT_EULER;
}

bool world_gains_too_much(const step_context *context) {
    return context->retry.is_tempered || context->gain > GAIN_MAX * context->energy_scale;
}

tulle_status world_measure_cloths(const step_context *context, const double *positions,
                                  known_elastic *elastic, cloth_energies *energies) {
    tulle_world *const world = context->world;
    energy_options const options = {.gravity = vec3_load(world->model.def.gravity, 0),
                                    .threads = world->work.threads,
                                    .plastic = context->state->plastic,
                                    .is_elastic_known = elastic->is_known};
    if (elastic->is_known) energies->elastic = elastic->energies;
    tulle_status const status =
        compute_energies(world->model.cloth_model, positions, context->state->velocities, options,
                         &world->work.scratch, energies);
    if (status != TULLE_OK) return status;
    *elastic = (known_elastic){energies->elastic, true};
    return TULLE_OK;
}

/* Work [J] of what holds cloth vertices, but for what their contacts ask: u . (A u - b). */
static tulle_status measure_pins(const step_context *context, double *work) {
    tulle_world *const world = context->world;
    const double *const u = context->mean_velocity;
    bool moves = false;
    *work = 0.0;
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++)
        moves |= world->work.is_fixed[v] && vec3_norm2(vec3_load(u, v)) > 0.0;
    if (!moves) return TULLE_OK;
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    double *const product =
        ARENA_NEW(&world->work.scratch, double, 3 * world->model.cloth_vertex_count);
    if (!product) return TULLE_ERROR_OUT_OF_MEMORY;
    block_matrix_operator matrix = {&world->work.system.matrix, world->work.threads};
    block_matrix_apply(&matrix, u, product);
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++) {
        if (!world->work.is_fixed[v]) continue;
        vec3 const pull =
            vec3_sub(vec3_load(product, v), vec3_load(world->work.system.right_hand_side, v));
        *work += vec3_dot(pull, vec3_load(u, v));
    }
    arena_release(&world->work.scratch, mark);
    return TULLE_OK;
}

/* Kinetic energy [J] of the vertices that are held or of those that are not, with velocities u. */
static double measure_kinetic(const step_context *context, bool is_held) {
    const tulle_world *const world = context->world;
    double sum = 0.0;
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++)
        if ((world->work.is_fixed[v] != 0) == is_held)
            sum += 0.5 * world->model.cloth_model->masses[v] *
                   vec3_norm2(vec3_load(context->mean_velocity, v));
    return sum;
}

tulle_status world_compute_kinetic_limit(step_context *context, kinetic_limit *limit) {
    tulle_world *const world = context->world;
    motion_state *const state = context->state;
    double wind, pins;
    cloth_energies start, end;
    tulle_status status = world_measure_cloths(context, state->positions, &state->elastic, &start);
    if (status == TULLE_OK)
        status = world_measure_cloths(context, context->end, &context->end_elastic, &end);
    if (status == TULLE_OK)
        status =
            measure_wind_work(world->model.cloth_model, &context->dynamics, context->mean_velocity,
                              (wind_work_options){&world->model.def.wind, world->work.threads},
                              &world->work.scratch, &wind);
    if (status == TULLE_OK) status = measure_pins(context, &pins);
    if (status != TULLE_OK) return status;
    body_energies const before = world_measure_bodies(world, state->positions, state->velocities);
    body_energies const after = world_measure_bodies(world, context->end, state->velocities);
    limit->start = start.kinetic + before.kinetic;
    double const potential_start = start.gravity + start.elastic.stretch + start.elastic.bend;
    double const potential_end = end.gravity + end.elastic.stretch + end.elastic.bend;
    limit->energy = limit->start + before.gravity - after.gravity + potential_start -
                    potential_end + wind + pins + world_measure_tie_work(context) +
                    world_measure_control_work(context) - measure_kinetic(context, true);
    return TULLE_OK;
}

tulle_status world_measure_gain(step_context *context) {
    tulle_world *const world = context->world;
    context->gain = 0.0;
    if (!world_keeps_balance(context)) return TULLE_OK;
    vec3 const fall = vec3_scale(vec3_load(world->model.def.gravity, 0), context->time_step);
    const double *const u = context->mean_velocity;
    kinetic_limit limit;
    tulle_status const status = world_compute_kinetic_limit(context, &limit);
    if (status != TULLE_OK) return status;
    double mass = 0.0;
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++)
        mass += world->model.cloth_model->masses[v];
    for (size_t b = 0; b < world->model.body_count; b++)
        mass += world->model.obstacles.data[world->model.body_obstacles[b]].rigid.mass;
    double const outside = compute_obstacle_work(&context->scene, world->work.rows.rows.data,
                                                 world->work.rows.rows.count, u);
    double const slack =
        GRAVITY_SHARE * 0.5 * mass * vec3_norm2(fall) + KINETIC_SHARE * limit.start;
    context->energy_scale = fmax(limit.start, limit.energy) + mass * vec3_norm2(fall);
    double const bodies = world_measure_bodies(world, context->state->positions, u).kinetic;
    context->gain = measure_kinetic(context, false) + bodies - limit.energy - outside - slack;
    return TULLE_OK;
}

/* Energy [J] at work in a substep, from above: what cloth and bodies have, what cloth gets by its
 * fall, and as much as if all of it went as fast as the fastest of pins and obstacles. */
static tulle_status measure_work(step_context *context, double *work) {
    const tulle_world *const world = context->world;
    motion_state *const state = context->state;
    double const fall = vec3_norm(vec3_load(world->model.def.gravity, 0)) * context->time_step;
    double mass = 0.0, fastest2 = 0.0;
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++)
        mass += world->model.cloth_model->masses[v];
    for (size_t v = 0; v < world->model.vertex_count; v++) {
        if (context->scene.inverse_mass[v] > 0.0) continue;
        vec3 const x0 = vec3_load(state->positions, v);
        vec3 const way = vec3_sub(vec3_load(context->scene.targets, v), x0);
        fastest2 = fmax(fastest2, vec3_norm2(way) / (context->time_step * context->time_step));
    }
    cloth_energies cloths = {0};
    tulle_status const status =
        world_measure_cloths(context, state->positions, &state->elastic, &cloths);
    body_energies const bodies = world_measure_bodies(world, state->positions, state->velocities);
    *work = cloths.elastic.stretch + 2.0 * (cloths.kinetic + bodies.kinetic) +
            mass * (fall * fall + fastest2);
    return status;
}

/* Newton's method goes astray where a solution stretches stiff cloth in earnest: the tangent there
 * throws it farther off. No motion can have more energy than there is, so none is linearised about
 * that has. The way from the guess before to the solution begins with such as have not, and is
 * halved until one is found. Pins go their part of it in the guess, but not in u. */
tulle_status world_temper_solution(step_context *context) {
    tulle_world *const world = context->world;
    retry_state *const retry = &context->retry;
    double work;
    tulle_status status = measure_work(context, &work);
    if (status != TULLE_OK) return status;
    bool const was_lost = retry->is_lost;
    retry->is_lost |= context->excess.springs > LOST_SHARE * work;
    if (!retry->is_lost) return TULLE_OK;
    bool const is_last = !retry->is_rough && !world_may_linearise(context);
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    size_t const size = 3 * world->model.cloth_vertex_count;
    double *const before = ARENA_NEW_ZEROED(&world->work.scratch, double, size);
    double *const ends = ARENA_NEW(&world->work.scratch, double, size);
    if (!before || !ends) return TULLE_ERROR_OUT_OF_MEMORY;
    if (was_lost) memcpy(before, context->guess, size * sizeof *before);
    double const most = (is_last ? LAST_SHARE : 1.0) * work;
    double part = 1.0;
    for (int halvings = 0; status == TULLE_OK; halvings++, part *= 0.5) {
        double kinetic = 0.0;
        for (size_t i = 0; i < size; i++) {
            double const way = context->mean_velocity[i] - before[i];
            context->guess[i] = halvings == 0 ? context->mean_velocity[i] : before[i] + part * way;
            if (!world->work.is_fixed[i / 3])
                kinetic += 0.5 * world->model.cloth_model->masses[i / 3] * context->guess[i] *
                           context->guess[i];
            ends[i] = context->state->positions[i] + context->time_step * context->guess[i];
        }
        known_elastic elastic = {.is_known = false};
        cloth_energies energies = {0};
        status = world_measure_cloths(context, ends, &elastic, &energies);
        if (energies.elastic.stretch + kinetic <= most || halvings == HALVINGS_MAX) break;
        retry->is_tempered = is_last;
    }
    for (size_t i = 0; i < size && status == TULLE_OK; i++)
        if (!world->work.is_fixed[i / 3]) context->mean_velocity[i] = context->guess[i];
    arena_release(&world->work.scratch, mark);
    return status;
}
