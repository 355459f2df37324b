/* dynamics/compute_forces.c - the stage compute_forces: forces and the system matrix.
 *
 * The forces of cloth, one a file:
 *     gravity, drag of the air    kernels/row_kernel.c
 *     membrane.c, or spring.c     the membrane, with its damping
 *     bending.c                   bending; its constant matrix is made in bending_matrix.c
 *     kernels/bending_damping.c   damping of bending
 *     hysteresis_forces.c         sliders of hysteresis
 *     wind.c                      wind and gusts on triangles
 * fill_system and kernels/row_kernel.c list them in the order in which they act. A new force gets a
 * file with fill_... (assembly.h), a line in fill_system, and its part of the rows there.
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
 *     (kernels/bending_damping.c);
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
#include "dynamics/row_kernel.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

/* Two steps are the same if they differ by less than the rounding of a sum of times. */
static const double SAME_STEP = 1e-9;

/* w of the table for BDF2, and the positions at the guess. */
static void fill_starts(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    double const c = work->share, part = (1.0 - c) / c;
    for (size_t i = 3 * begin; work->later_starts && i < 3 * end; i++)
        work->later_starts[i] = work->state->velocities[i] + part * work->state->previous_mean[i];
    for (size_t i = 3 * begin; work->guessed_positions && i < 3 * end; i++)
        work->guessed_positions[i] =
            work->state->positions[i] + work->state->time_step * work->state->guess[i];
}

/* The rows of a range of vertices. */
static void fill_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const assembly *const work = context;
    if (work->begins_rows) TULLE_PICK_KERNEL(begin_rows)(work, begin, end);
    if (work->begins_rows && work->sliders.blocks) add_slider_blocks(work, begin, end);
    if (!work->ends_rows) return;
    if (work->model->has_bending) TULLE_PICK_KERNEL(gather_bending)(work, begin, end);
    if (work->sliders.sources) gather_sliders(work, begin, end);
    TULLE_PICK_KERNEL(end_rows)(work, begin, end);
}

/* Fills the system with all forces, in their order. False: no memory. */
static bool fill_system(assembly *work) {
    const cloth_model *const model = work->model;
    arena *const scratch = work->scratch;
    size_t const triangles = work->has_wind ? model->triangle_count : 0;

    /* Slots that outlive the passes. */
    work->start_velocities = work->state->velocities;
    if (work->is_bdf2) {
        work->later_starts = ARENA_NEW(scratch, double, 3 * model->vertex_count);
        work->start_velocities = work->later_starts;
    }
    if (!work->is_renewed) work->triangle_forces = ARENA_NEW(scratch, vec3, triangles + 1);
    if (!work->start_velocities || (!work->is_renewed && !work->triangle_forces) ||
        !provide_slots(&work->terms.triangle_sources, triangles + 1, scratch) ||
        !provide_slider_slots(work))
        return false;

    arena_mark const mark = arena_get_mark(scratch);
    if (work->state->guess && (model->springs || model->sliders)) {
        work->guessed_positions = ARENA_NEW(scratch, double, 3 * model->vertex_count);
        if (!work->guessed_positions) return false;
    }
    parallel_for(model->vertex_count, VERTICES_PER_CHUNK, work->threads, fill_starts, work);
    if (work->has_wind && !work->is_renewed && !fill_wind(work)) return false;
    if (!(model->elements ? fill_elements(work) : fill_springs(work))) return false;
    if (!fill_sliders(work)) return false;
    work->begins_rows = true;
    work->ends_rows = work->is_renewed;
    parallel_for(model->vertex_count, VERTICES_PER_CHUNK, work->threads, fill_rows, work);
    arena_release(scratch, mark);
    if (work->is_renewed) return true;

    if (model->has_bending && !fill_bending(work)) return false;
    work->begins_rows = false;
    work->ends_rows = true;
    parallel_for(model->vertex_count, VERTICES_PER_CHUNK, work->threads, fill_rows, work);
    return true;
}

size_t measure_force_terms(const cloth_model *model, const tulle_wind *wind) {
    size_t count = 0;
    if (wind->drag_coefficient > 0.0) count += 2 * model->triangle_count + model->vertex_count + 3;
    if (model->has_bending && (model->has_bend_damping || !model->bends_by_matrix))
        count += (model->has_curved_rest ? 4 : 1) * model->hinge_count + 1;
    if (model->has_bend_damping) count += 2 * model->triangle_count + 1;
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
            (!work.has_wind || (provide_slots(&kept->triangle_drags, triangles + 1, scratch) &&
                                provide_slots(&kept->triangle_sources, triangles + 1, scratch) &&
                                provide_slots(&kept->air_velocities, vertices + 1, scratch))) &&
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
