/* dynamics/compute_forces.c - the stage compute_forces: forces and the system matrix.
 *
 * The forces of cloth, one a file:
 *     gravity, drag of the air    begin_row below
 *     membrane.c, or spring.c     the membrane, with its damping
 *     bending.c                   bending; its constant matrix is made in bending_matrix.c
 *     bending_damping.c           damping of bending
 *     hysteresis_forces.c         sliders of hysteresis
 *     wind.c                      wind and gusts on triangles
 * fill_system and gather_forces list them in the order in which they act. A new force gets a file
 * with fill_... and gather_... (assembly.h), a line in each of these two, and its part of the
 * matrix in begin_row.
 *
 *     A = M - alpha D - beta K,    b = M a + gamma (f0 - D w)
 *
 *                      c          alpha   beta       gamma   a                          w
 *     implicit Euler   1          h       h^2        h       v0                         v0
 *     Crank-Nicolson   1/2 .. 1   c h     c^2 h^2    c h     v0                         v0
 *     BDF2             2/3 .. 1   c h     c^2 h^2    c^2 h   below                      below
 *
 * f0, K = df/dx and D = df/dv are taken at (x0, v0); u' and v' are the mean velocity and the start
 * velocity of the last step. `damping` moves c from its value at full order to 1, which is implicit
 * Euler.
 *
 * Crank-Nicolson: u = c v1 + (1 - c) v0, and the same mean of forces.
 *
 * BDF2, with d = 1 - c: x1 - x0 - d (x0 - x') = c h v1, the same for v, and v1 = (u - d u') / c.
 * All is multiplied by c, so that M has the factor one:
 *
 *     a = d u' + c (2 - c) v0 - c d v',    w = v0 + d/c u'.
 *
 * With a guess of u, springs are linearised about x0 + h guess instead. That is a step of Newton's
 * method for the same equations.
 *
 * A must be symmetric positive definite in every state, so K and D are not always the exact
 * derivatives:
 *   - a spring under compression has no stiffness across itself;
 *   - drag keeps its part along the normal;
 *   - the rest-curvature term of bending is taken as constant;
 *   - bending damping uses the constant matrix, which with M / h is at least half the true one
 *     (bending_damping.c);
 *   - derivatives of damping with respect to positions are dropped.
 * Every integrator stays consistent with f0, but steps in which one of these acts are of first
 * order.
 *
 * A pass of elements is followed by a pass of vertices: elements fill their own slots, then each
 * vertex adds the slots around it to its row in a fixed order. No two threads write the same
 * number. The slots of springs are released before those of bending are made: slots are most of the
 * memory of a step. Terms that do not depend on the guess may be kept from the first linearisation
 * of a step; later ones then add the same numbers in the same order, in one pass.
 *
 * Based on: Baraff, Witkin, Large steps in cloth simulation, 1998; Choi, Ko, Stable but responsive
 * cloth, 2002; Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 5.1. */
#include "dynamics/assembly.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

/* Two steps are the same if they differ by less than the rounding of a sum of times. */
static const double SAME_STEP = 1e-9;

/* w of the table, and the positions at the guess. */
static void fill_starts(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    double const c = work->share, part = work->is_bdf2 ? (1.0 - c) / c : 0.0;
    for (size_t i = 3 * begin; i < 3 * end; i++)
        work->start_velocities[i] = work->state->velocities[i] +
                                    (work->is_bdf2 ? part * work->state->previous_mean[i] : 0.0);
    for (size_t i = 3 * begin; work->guessed_positions && i < 3 * end; i++)
        work->guessed_positions[i] =
            work->state->positions[i] + work->state->time_step * work->state->guess[i];
}

/* Adds the drag of a triangle to a block. */
static inline void add_drag(const assembly *work, uint32_t triangle, symmetric3 *block) {
    if (triangle == TULLE_NONE) return;
    symmetric3 const drag = symmetric3_make(0.0, work->alpha, work->terms.triangle_drags[triangle]);
    for (int i = 0; i < 6; i++) block->m[i] += drag.m[i];
}

/* Fills the row of the matrix, for all forces, and starts the sums with the vertex's own forces and
 * those of its springs. */
static void begin_row(const assembly *work, uint32_t vertex, vertex_sum *sum) {
    const cloth_model *const model = work->model;
    block_matrix *const matrix = &work->system->matrix;
    double const alpha = work->alpha, beta = work->beta;
    vec3 const none = {0.0, 0.0, 0.0};

    /* Mass, gravity and the drag of the air at rest. */
    double const mass = model->masses[vertex], damping = mass * model->air_damping[vertex];
    size_t const diagonal = matrix->diagonal_positions[vertex];
    double own = mass + alpha * (damping + model->bend_block_damping[diagonal]) +
                 beta * model->bend_blocks[diagonal];
    const double *const sliders = work->sliders.blocks;
    if (sliders) own += beta * sliders[diagonal];
    symmetric3 own_block = symmetric3_make(own, 0.0, none);
    sum->force = vec3_add_scaled(vec3_scale(work->surroundings->gravity, mass),
                                 vec3_load(work->state->velocities, vertex), -damping);
    sum->source = vec3_add_scaled(sum->force, vec3_load(work->start_velocities, vertex), damping);

    /* The membrane, and the blocks off the diagonal, each of which belongs to an edge. */
    const adjacency *const around = &model->surface->vertex_edges;
    const uint32_t *edges = around->items + around->begin[vertex]; /* as neighbours ascend */
    for (size_t k = model->block_begin[vertex]; k < model->block_begin[vertex + 1]; k++) {
        if (model->block_columns[k] == vertex) continue;
        uint32_t const s = *edges++;
        double const sign = model->surface->edges[2 * (size_t)s] == vertex ? 1.0 : -1.0;
        if (work->spring_forces)
            sum->force = vec3_add_scaled(sum->force, work->spring_forces[s], sign);
        if (work->spring_sources)
            sum->source = vec3_add_scaled(sum->source, work->spring_sources[s], sign);
        double bend = alpha * model->bend_block_damping[k] + beta * model->bend_blocks[k];
        if (sliders) bend += beta * sliders[k];
        symmetric3 block = symmetric3_make(bend, 0.0, none);
        symmetric3 const membrane = gather_edge_block(work, s);
        for (int i = 0; i < 6; i++) {
            own_block.m[i] += membrane.m[i];
            block.m[i] -= membrane.m[i];
        }
        for (size_t side = 0; work->has_wind && side < 2; side++)
            add_drag(work, model->surface->edge_triangles[2 * (size_t)s + side], &block);
        memcpy(matrix->values + BLOCK_NUMBERS * k, block.m, sizeof block.m);
    }

    if (work->membrane_slots) gather_elements(work, vertex, sum);
    const adjacency *const uses = &model->surface->vertex_triangles;
    for (size_t k = uses->begin[vertex]; work->has_wind && k < uses->begin[vertex + 1]; k++)
        add_drag(work, uses->items[k], &own_block);
    memcpy(matrix->values + BLOCK_NUMBERS * diagonal, own_block.m, sizeof own_block.m);
}

/* The rows of a range of vertices. After a pass that does not end them the forces of the system are
 * those so far, and the right-hand side has their sources, f - D w. */
static void gather_forces(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const assembly *const work = context;
    const motion_state *const state = work->state;
    linear_system *const system = work->system;
    double const c = work->share;
    for (size_t v = begin; v < end; v++) {
        uint32_t const vertex = (uint32_t)v;
        vertex_sum sum;
        if (work->begins_rows) {
            begin_row(work, vertex, &sum);
        } else {
            sum.force = vec3_load(system->forces, v);
            sum.source = vec3_load(system->right_hand_side, v);
        }
        if (work->ends_rows) {
            if (work->model->has_bending) gather_bending(work, vertex, &sum);
            if (work->sliders.sources) gather_sliders(work, vertex, &sum);
            if (work->has_wind) gather_wind(work, vertex, &sum);
            vec3 start = vec3_load(state->velocities, v); /* a of the table */
            if (work->is_bdf2) {
                start = vec3_add_scaled(vec3_scale(vec3_load(state->previous_mean, v), 1.0 - c),
                                        start, c * (2.0 - c));
                start = vec3_add_scaled(start, vec3_load(state->previous_velocities, v),
                                        -c * (1.0 - c));
            }
            sum.source =
                vec3_add_scaled(vec3_scale(start, work->model->masses[v]), sum.source, work->gamma);
        }
        if (!work->is_renewed) vec3_store(system->forces, v, sum.force);
        vec3_store(system->right_hand_side, v, sum.source);
    }
}

/* Fills the system with all forces, in their order. False: no memory. */
static bool fill_system(assembly *work) {
    const cloth_model *const model = work->model;
    arena *const scratch = work->scratch;
    size_t const triangles = work->has_wind ? model->triangle_count : 0;

    /* Slots that outlive the passes. */
    work->start_velocities = ARENA_NEW(scratch, double, 3 * model->vertex_count);
    if (!work->is_renewed) work->triangle_forces = ARENA_NEW(scratch, vec3, triangles);
    if (!work->start_velocities || (!work->is_renewed && !work->triangle_forces) ||
        !provide_slots(&work->terms.triangle_sources, triangles, scratch) ||
        !provide_slider_slots(work))
        return false;

    arena_mark const mark = arena_get_mark(scratch);
    if (work->state->guess) {
        work->guessed_positions = ARENA_NEW(scratch, double, 3 * model->vertex_count);
        if (!work->guessed_positions) return false;
    }
    parallel_for(model->vertex_count, VERTICES_PER_CHUNK, work->threads, fill_starts, work);
    if (work->has_wind && !work->is_renewed && !fill_wind(work)) return false;
    if (!(model->elements ? fill_elements(work) : fill_springs(work))) return false;
    if (!fill_sliders(work)) return false;
    work->begins_rows = true;
    work->ends_rows = work->is_renewed;
    parallel_for(model->vertex_count, VERTICES_PER_CHUNK, work->threads, gather_forces, work);
    arena_release(scratch, mark);
    if (work->is_renewed) return true;

    if (model->has_bending && !fill_bending(work)) return false;
    work->begins_rows = false;
    work->ends_rows = true;
    parallel_for(model->vertex_count, VERTICES_PER_CHUNK, work->threads, gather_forces, work);
    return true;
}

size_t measure_force_terms(const cloth_model *model, const tulle_wind *wind) {
    size_t count = 0;
    if (wind->drag_coefficient > 0.0) count += 2 * model->triangle_count + model->vertex_count;
    if (model->has_bending) count += (model->has_curved_rest ? 4 : 1) * model->hinge_count;
    if (model->has_bend_damping) count += 2 * model->triangle_count;
    return count * sizeof(vec3);
}

tulle_status compute_forces(const cloth_model *model, const motion_state *state,
                            const environment *surroundings, force_options options, arena *scratch,
                            linear_system *system) {
    /* BDF2 needs one earlier step of the same length. */
    double const h = state->time_step, damping = options.damping;
    bool const has_history = state->previous_mean && state->previous_velocities &&
                             fabs(state->previous_time_step - h) <= SAME_STEP * h;
    system->integrator = options.integrator;
    if (damping >= 1.0 || (options.integrator == TULLE_INTEGRATOR_BDF2 && !has_history))
        system->integrator = TULLE_INTEGRATOR_IMPLICIT_EULER;

    /* c of the table: from its value at full order (damping 0) to 1 (damping 1). */
    bool const is_bdf2 = system->integrator == TULLE_INTEGRATOR_BDF2;
    double share = 1.0;
    if (system->integrator == TULLE_INTEGRATOR_CRANK_NICOLSON) share = 0.5 + 0.5 * damping;
    if (is_bdf2) share = (2.0 + damping) / 3.0;
    assembly work = {.model = model,
                     .state = state,
                     .surroundings = surroundings,
                     .system = system,
                     .scratch = scratch,
                     .threads = options.threads,
                     .alpha = share * h,
                     .beta = share * share * h * h,
                     .gamma = is_bdf2 ? share * share * h : share * h,
                     .share = share,
                     .has_wind = surroundings->wind.drag_coefficient > 0.0,
                     .is_bdf2 = is_bdf2};
    system->force_time = work.gamma;
    system->share = share;
    system->matrix.scalar_factors[0] = work.alpha;
    system->matrix.scalar_factors[1] = work.beta;

    force_terms *const kept = state->terms;
    work.is_renewed = kept && kept->is_complete;
    if (kept && !work.is_renewed) { /* room for the terms that outlive the stage */
        size_t const triangles = model->triangle_count, vertices = model->vertex_count;
        bool const has_room =
            (!work.has_wind || (provide_slots(&kept->triangle_drags, triangles, scratch) &&
                                provide_slots(&kept->triangle_sources, triangles, scratch) &&
                                provide_slots(&kept->air_velocities, vertices, scratch))) &&
            (!model->has_bending || provide_bending_terms(model, kept, scratch));
        if (!has_room) return TULLE_ERROR_OUT_OF_MEMORY;
    }
    if (kept) work.terms = *kept;
    arena_mark const mark = arena_get_mark(scratch);
    bool const ok = fill_system(&work);
    arena_release(scratch, mark);
    if (kept) kept->is_complete = ok;
    return ok ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
