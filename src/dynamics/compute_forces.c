/* dynamics/compute_forces.c - stage 1, compute_forces: forces and the system matrix.
 *
 *     A = M - alpha D - beta K,    b = M a + gamma (f0 - D w)
 *
 *                      c          alpha   beta       gamma   a                          w
 *     implicit Euler   1          h       h^2        h       v0                         v0
 *     Crank-Nicolson   1/2 .. 1   c h     c^2 h^2    c h     v0                         v0
 *     BDF2             2/3 .. 1   c h     c^2 h^2    c^2 h   below                      below
 *
 * f0, K = df/dx and D = df/dv at (x0, v0); u' and v' are the mean velocity and the start velocity
 * of the last step. c goes with the damping from the integrator itself to implicit Euler.
 * Crank-Nicolson: u = c v1 + (1 - c) v0, the same mean of forces. BDF2: with d = 1 - c,
 * x1 - x0 - d (x0 - x') = c h v1, the same for v, and v1 = (u - d u') / c, times c so that M has
 * the factor one: a = d u' + c (2 - c) v0 - c d v', w = v0 + d/c u'.
 *
 * With a guess of u, springs are linearised about x0 + h guess instead, a step of Newton's method
 * for the same equations.
 *
 * Where K and D are not the exact derivatives, so that A is symmetric positive definite in every
 * state: a spring under compression has no stiffness across itself; drag keeps its part along the
 * normal; the rest-curvature term of bending is taken as constant; bending damping uses the
 * constant matrix, which is at least the true one; derivatives of damping by positions are dropped.
 * Every integrator stays consistent with f0; steps in which one of these acts are of first order.
 *
 * Passes: springs, hinges and triangles each fill their own slots; then each vertex gathers its row
 * in a fixed order. No two threads write the same number.
 *
 * Based on: Baraff, Witkin, Large steps in cloth simulation, 1998; Choi, Ko, Stable but responsive
 * cloth, 2002; Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 5.1. */
#include "dynamics/compute_forces.h"

#include "base/parallel.h"
#include "dynamics/bend.h"
#include "dynamics/spring.h"
#include "dynamics/wind.h"

#include <math.h>

/* Items a chunk, about 50 microseconds of work each. */
enum { SPRINGS_PER_CHUNK = 1024, VERTICES_PER_CHUNK = 256, HINGES_PER_CHUNK = 512 };

/* Six edges at a vertex and six across from it, and some more for uneven meshes. */
static const double HINGES_AT_A_VERTEX = 16.0;

/* Two steps are the same if they differ by less than the rounding of a sum of times. */
static const double SAME_STEP = 1e-9;

typedef struct coefficients {
    double alpha, beta, gamma, share; /* share: c of the table */
} coefficients;

/* All of the stage: inputs, and slots of springs, hinges and triangles. */
typedef struct assembly {
    const cloth_model *model;
    const motion_state *state;
    const environment *surroundings;
    coefficients factor;
    linear_system *system;
    double *start_velocities;  /* w, 3 a vertex */
    double *guessed_positions; /* x0 + h guess, 3 a vertex; null without a guess */
    symmetric3 *spring_blocks; /* alpha D + beta K, negated, of the first end by the first end */
    vec3 *spring_forces, *spring_sources; /* f and f - D w at the first end */
    hinge_state *hinge_states;
    vec3 *hinge_forces; /* 4 a hinge */
    vec3 *air_velocities;
    vec3 *triangle_forces, *triangle_sources, *triangle_drags; /* per corner; D of a corner by a
                                                                  corner is -g g^T, g the drag */
    bool has_wind, is_bdf2;
} assembly;

/* What a spring does about the guess. The elastic force is the one that the linear system takes as
 * its start: the force at the guess, drawn back along its derivative to x0. Crank-Nicolson takes
 * 1 - c of the true force at x0. */
static void linearise_at_guess(const assembly *work, const cloth_spring *spring,
                               spring_response *response) {
    vec3 const at_start = response->elastic_force;
    *response = spring_evaluate(spring, work->guessed_positions, work->state->velocities);
    vec3 const n = response->direction;
    vec3 const drift = vec3_scale(vec3_sub(vec3_load(work->state->guess, spring->vertices[1]),
                                           vec3_load(work->state->guess, spring->vertices[0])),
                                  work->state->time_step);
    double const across = fmax(response->across, 0.0);
    double const along = (response->axial - across) * vec3_dot(n, drift);
    vec3 force = vec3_add_scaled(response->elastic_force, n, -along);
    force = vec3_add_scaled(force, drift, -across);
    bool const is_mean = work->system->integrator == TULLE_INTEGRATOR_CRANK_NICOLSON;
    response->elastic_force = is_mean ? vec3_lerp(at_start, force, work->factor.share) : force;
}

static void assemble_springs(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    coefficients const factor = work->factor;
    for (size_t s = begin; s < end; s++) {
        const cloth_spring *const spring = &work->model->springs[s];
        spring_response response =
            spring_evaluate(spring, work->state->positions, work->state->velocities);
        work->spring_forces[s] = vec3_add(response.elastic_force, response.damping_force);
        if (work->guessed_positions) linearise_at_guess(work, spring, &response);
        double const across = factor.beta * fmax(response.across, 0.0);
        double const axial = factor.beta * response.axial;
        bool const has_length = vec3_norm2(response.direction) > 0.0;
        /* Without a direction the axial stiffness acts in all of them. */
        work->spring_blocks[s] =
            has_length ? symmetric3_make(across, axial - across + factor.alpha * spring->damping,
                                         response.direction)
                       : symmetric3_make(axial, 0.0, response.direction);
        vec3 const n = response.direction;
        double const rate =
            vec3_dot(n, vec3_sub(vec3_load(work->start_velocities, spring->vertices[1]),
                                 vec3_load(work->start_velocities, spring->vertices[0])));
        vec3 const force = vec3_add(response.elastic_force, response.damping_force);
        work->spring_sources[s] = vec3_add_scaled(force, n, -spring->damping * rate);
    }
}

/* The damping force acts along g = w n + e. The matrix holds damping of the rate of c, along w, but
 * not e, which comes from the turning of the normal: explicit, it is stable while h S |e|^2 / m
 * stays under 1 / (hinges at a vertex), S the sum of the hinge's damping couplings. Where folds,
 * fine meshes or strong damping exceed that, g is scaled down: both momenta are kept, and the
 * scaling vanishes with the step. */
static void limit_damping(const assembly *work, size_t hinge) {
    const cloth_model *const model = work->model;
    hinge_state *const state = &work->hinge_states[hinge];
    double strength = 0.0, spread = 0.0;
    for (size_t k = model->coupling_begin[hinge]; k < model->coupling_begin[hinge + 1]; k++)
        strength += fabs(model->damping_couplings[k]);
    for (int k = 0; k < 4; k++) {
        vec3 const turning = vec3_add_scaled(state->rate_directions[k], state->normal,
                                             -model->hinges[hinge].weights[k]);
        spread += vec3_norm2(turning) / model->masses[model->hinges[hinge].vertices[k]];
    }
    double const share = work->state->time_step * strength * spread * HINGES_AT_A_VERTEX;
    if (!(share > 1.0)) return;
    double const kept = 1.0 / sqrt(share);
    state->rate *= kept;
    for (int k = 0; k < 4; k++)
        state->rate_directions[k] = vec3_scale(state->rate_directions[k], kept);
}

static void evaluate_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    for (size_t h = begin; h < end; h++) {
        bend_evaluate(&work->model->hinges[h], work->state->positions, work->state->velocities,
                      work->model->has_bend_damping, &work->hinge_states[h]);
        if (work->model->has_bend_damping) limit_damping(work, h);
    }
}

static void assemble_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    const cloth_model *const model = work->model;
    for (size_t h = begin; h < end; h++) {
        vec3 moment = {0.0, 0.0, 0.0};
        double damping_moment = 0.0;
        for (size_t k = model->coupling_begin[h]; k < model->coupling_begin[h + 1]; k++) {
            const hinge_state *const other = &work->hinge_states[model->coupling_hinges[k]];
            moment = vec3_add_scaled(moment, other->deviation, model->couplings[k]);
            damping_moment += model->damping_couplings[k] * other->rate;
        }
        bend_get_forces(&model->hinges[h], work->state->positions, &work->hinge_states[h], moment,
                        damping_moment, work->hinge_forces + 4 * h);
    }
}

static void sample_wind(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    gust_cell cell = {0};
    for (size_t v = begin; v < end; v++)
        work->air_velocities[v] =
            wind_get_velocity(&work->surroundings->wind, vec3_load(work->state->positions, v),
                              work->state->time, &cell);
}

static void assemble_triangles(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    double const third = 1.0 / 3.0;
    for (size_t t = begin; t < end; t++) {
        const uint32_t *const vertices = work->model->triangles[t].vertices;
        vec3 corners[3], relative = {0.0, 0.0, 0.0}, start = {0.0, 0.0, 0.0};
        for (int k = 0; k < 3; k++) {
            corners[k] = vec3_load(work->state->positions, vertices[k]);
            relative = vec3_add(relative, vec3_sub(vec3_load(work->state->velocities, vertices[k]),
                                                   work->air_velocities[vertices[k]]));
            start = vec3_add(start, vec3_load(work->start_velocities, vertices[k]));
        }
        wind_response const response = wind_evaluate(work->surroundings->wind.drag_coefficient,
                                                     corners, vec3_scale(relative, third));
        work->triangle_forces[t] = vec3_scale(response.force, third);
        work->triangle_drags[t] = vec3_scale(response.normal, third * sqrt(response.drag));
        vec3 const g = work->triangle_drags[t];
        work->triangle_sources[t] =
            vec3_add_scaled(work->triangle_forces[t], g, vec3_dot(g, start));
    }
}

/* Adds the drag of a triangle to a block. */
static void add_drag(const assembly *work, uint32_t triangle, symmetric3 *block) {
    if (triangle == TULLE_NONE) return;
    vec3 const g = work->triangle_drags[triangle];
    symmetric3 const drag = symmetric3_make(0.0, work->factor.alpha, g);
    symmetric3_add(block, &drag);
}

static void store_block(double *target, const symmetric3 *block) {
    const double *const m = block->m;
    double const full[9] = {m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5]};
    for (int i = 0; i < 9; i++) target[i] = full[i];
}

/* What a vertex gathers. */
typedef struct vertex_sum {
    vec3 force, source; /* f and f - D w */
    symmetric3 diagonal;
} vertex_sum;

/* Blocks of one row off the diagonal, and the springs' part of the sums. */
static void gather_springs(const assembly *work, uint32_t vertex, vertex_sum *sum) {
    const cloth_model *const model = work->model;
    for (size_t k = model->block_begin[vertex]; k < model->block_begin[vertex + 1]; k++) {
        uint32_t const s = model->block_springs[k];
        if (s == TULLE_NONE) continue;
        const cloth_spring *const spring = &model->springs[s];
        double const sign = spring->vertices[0] == vertex ? 1.0 : -1.0;
        sum->force = vec3_add_scaled(sum->force, work->spring_forces[s], sign);
        sum->source = vec3_add_scaled(sum->source, work->spring_sources[s], sign);
        symmetric3_add(&sum->diagonal, &work->spring_blocks[s]);
        double const bend = work->factor.alpha * model->bend_block_damping[k] +
                            work->factor.beta * model->bend_blocks[k];
        symmetric3 block = symmetric3_make(bend, 0.0, (vec3){0.0, 0.0, 0.0});
        for (int i = 0; i < 6; i++) block.m[i] -= work->spring_blocks[s].m[i];
        if (work->has_wind) {
            add_drag(work, spring->triangles[0], &block);
            add_drag(work, spring->triangles[1], &block);
        }
        store_block(work->system->matrix.values + 9 * k, &block);
    }
}

/* Forces of hinges, the bending matrix of the row, and the source -D w of bending damping. */
static void gather_hinges(const assembly *work, uint32_t vertex, vertex_sum *sum) {
    const cloth_model *const model = work->model;
    for (size_t k = model->vertex_hinges.begin[vertex]; k < model->vertex_hinges.begin[vertex + 1];
         k++) {
        vec3 const force = work->hinge_forces[model->vertex_hinges.items[k]];
        sum->force = vec3_add(sum->force, force);
        sum->source = vec3_add(sum->source, force);
    }
    for (size_t k = model->scalar_begin[vertex]; k < model->scalar_begin[vertex + 1]; k++) {
        work->system->matrix.scalar_values[k] = work->factor.alpha * model->bend_scalar_damping[k] +
                                                work->factor.beta * model->bend_scalars[k];
        sum->source = vec3_add_scaled(sum->source,
                                      vec3_load(work->start_velocities, model->scalar_columns[k]),
                                      model->bend_scalar_damping[k]);
    }
    for (size_t k = model->block_begin[vertex]; k < model->block_begin[vertex + 1]; k++)
        sum->source =
            vec3_add_scaled(sum->source, vec3_load(work->start_velocities, model->block_columns[k]),
                            model->bend_block_damping[k]);
}

static void gather_triangles(const assembly *work, uint32_t vertex, vertex_sum *sum) {
    const adjacency *const uses = &work->model->vertex_triangles;
    for (size_t k = uses->begin[vertex]; k < uses->begin[vertex + 1]; k++) {
        uint32_t const triangle = uses->items[k] / 3;
        sum->force = vec3_add(sum->force, work->triangle_forces[triangle]);
        sum->source = vec3_add(sum->source, work->triangle_sources[triangle]);
        add_drag(work, triangle, &sum->diagonal);
    }
}

/* M a of the table above, divided by the mass. */
static vec3 get_start(const assembly *work, uint32_t vertex) {
    const motion_state *const state = work->state;
    vec3 const v0 = vec3_load(state->velocities, vertex);
    if (!work->is_bdf2) return v0;
    double const c = work->factor.share;
    vec3 const mean = vec3_load(state->previous_mean, vertex);
    vec3 const previous = vec3_load(state->previous_velocities, vertex);
    vec3 const start = vec3_add_scaled(vec3_scale(mean, 1.0 - c), v0, c * (2.0 - c));
    return vec3_add_scaled(start, previous, -c * (1.0 - c));
}

static void gather_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    const cloth_model *const model = work->model;
    linear_system *const system = work->system;
    for (size_t v = begin; v < end; v++) {
        uint32_t const vertex = (uint32_t)v;
        double const mass = model->masses[v], damping = mass * model->air_damping[v];
        vec3 const w = vec3_load(work->start_velocities, v);
        size_t const position = system->matrix.diagonal_positions[v];
        double const own = mass +
                           work->factor.alpha * (damping + model->bend_block_damping[position]) +
                           work->factor.beta * model->bend_blocks[position];
        vertex_sum sum = {.diagonal = symmetric3_make(own, 0.0, (vec3){0.0, 0.0, 0.0})};
        sum.force = vec3_add_scaled(vec3_scale(work->surroundings->gravity, mass),
                                    vec3_load(work->state->velocities, v), -damping);
        sum.source = vec3_add_scaled(sum.force, w, damping);
        gather_springs(work, vertex, &sum);
        if (model->has_bending) gather_hinges(work, vertex, &sum);
        if (work->has_wind) gather_triangles(work, vertex, &sum);
        store_block(system->matrix.values + 9 * position, &sum.diagonal);
        store_block(system->diagonal + 9 * v, &sum.diagonal);
        vec3_store(system->forces, v, sum.force);
        vec3_store(system->right_hand_side, v,
                   vec3_add_scaled(vec3_scale(get_start(work, vertex), mass), sum.source,
                                   work->factor.gamma));
    }
}

/* w of the table. */
static void fill_start_velocities(void *context, size_t begin, size_t end, size_t chunk,
                                  int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    double const c = work->factor.share, part = work->is_bdf2 ? (1.0 - c) / c : 0.0;
    for (size_t i = 3 * begin; i < 3 * end; i++)
        work->start_velocities[i] = work->state->velocities[i] +
                                    (work->is_bdf2 ? part * work->state->previous_mean[i] : 0.0);
    for (size_t i = 3 * begin; work->guessed_positions && i < 3 * end; i++)
        work->guessed_positions[i] =
            work->state->positions[i] + work->state->time_step * work->state->guess[i];
}

static bool allocate_assembly(assembly *work, arena *scratch) {
    const cloth_model *const model = work->model;
    size_t const vertices = model->vertex_count, springs = model->spring_count;
    size_t const hinges = model->has_bending ? model->hinge_count : 0;
    size_t const triangles = work->has_wind ? model->triangle_count : 0;
    work->start_velocities = ARENA_NEW(scratch, double, 3 * vertices);
    if (work->state->guess) {
        work->guessed_positions = ARENA_NEW(scratch, double, 3 * vertices);
        if (!work->guessed_positions) return false;
    }
    work->spring_blocks = ARENA_NEW(scratch, symmetric3, springs);
    work->spring_forces = ARENA_NEW(scratch, vec3, springs);
    work->spring_sources = ARENA_NEW(scratch, vec3, springs);
    work->hinge_states = ARENA_NEW(scratch, hinge_state, hinges);
    work->hinge_forces = ARENA_NEW(scratch, vec3, 4 * hinges);
    work->air_velocities = ARENA_NEW(scratch, vec3, work->has_wind ? vertices : 0);
    work->triangle_forces = ARENA_NEW(scratch, vec3, triangles);
    work->triangle_sources = ARENA_NEW(scratch, vec3, triangles);
    work->triangle_drags = ARENA_NEW(scratch, vec3, triangles);
    return work->start_velocities && work->spring_blocks && work->spring_forces &&
           work->spring_sources && work->hinge_states && work->hinge_forces &&
           work->air_velocities && work->triangle_forces && work->triangle_sources &&
           work->triangle_drags;
}

/* c of the table: from its value at full order (damping 0) to 1 (damping 1). */
static coefficients get_coefficients(tulle_integrator integrator, double h, double damping) {
    double share = 1.0;
    if (integrator == TULLE_INTEGRATOR_CRANK_NICOLSON) share = 0.5 + 0.5 * damping;
    if (integrator == TULLE_INTEGRATOR_BDF2) share = (2.0 + damping) / 3.0;
    double const gamma = integrator == TULLE_INTEGRATOR_BDF2 ? share * share * h : share * h;
    return (coefficients){share * h, share * share * h * h, gamma, share};
}

/* BDF2 needs one earlier step of the same length. */
static tulle_integrator choose_integrator(tulle_integrator wanted, double damping,
                                          const motion_state *state) {
    if (damping >= 1.0) return TULLE_INTEGRATOR_IMPLICIT_EULER;
    bool const has_history =
        state->previous_mean && state->previous_velocities &&
        fabs(state->previous_time_step - state->time_step) <= SAME_STEP * state->time_step;
    return wanted == TULLE_INTEGRATOR_BDF2 && !has_history ? TULLE_INTEGRATOR_IMPLICIT_EULER
                                                           : wanted;
}

tulle_status compute_forces(const cloth_model *model, const motion_state *state,
                            const environment *surroundings, force_options options, arena *scratch,
                            linear_system *system) {
    system->integrator = choose_integrator(options.integrator, options.damping, state);
    assembly work = {.model = model,
                     .state = state,
                     .surroundings = surroundings,
                     .factor =
                         get_coefficients(system->integrator, state->time_step, options.damping),
                     .system = system,
                     .has_wind = surroundings->wind.drag_coefficient > 0.0,
                     .is_bdf2 = system->integrator == TULLE_INTEGRATOR_BDF2};
    system->force_time = work.factor.gamma;
    system->share = work.factor.share;
    system->bend_damping_factor = work.factor.alpha;
    system->bend_factor = work.factor.beta;
    arena_mark const mark = arena_get_mark(scratch);
    if (!allocate_assembly(&work, scratch)) {
        arena_release(scratch, mark);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    size_t const vertices = model->vertex_count;
    int const threads = options.threads;
    parallel_for(vertices, VERTICES_PER_CHUNK, threads, fill_start_velocities, &work);
    parallel_for(model->spring_count, SPRINGS_PER_CHUNK, threads, assemble_springs, &work);
    if (model->has_bending) {
        parallel_for(model->hinge_count, HINGES_PER_CHUNK, threads, evaluate_hinges, &work);
        parallel_for(model->hinge_count, HINGES_PER_CHUNK, threads, assemble_hinges, &work);
    }
    if (work.has_wind) {
        parallel_for(vertices, VERTICES_PER_CHUNK, threads, sample_wind, &work);
        parallel_for(model->triangle_count, SPRINGS_PER_CHUNK, threads, assemble_triangles, &work);
    }
    parallel_for(vertices, VERTICES_PER_CHUNK, threads, gather_rows, &work);
    arena_release(scratch, mark);
    return TULLE_OK;
}
