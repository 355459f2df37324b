/* dynamics/compute_forces.c - the stage compute_forces: forces and the system matrix.
 *
 * The forces of cloth, one a file:
 *     kernels/row_kernel.c     gravity, drag of the air on vertices, bending that is flat at rest
 *     kernels/drag_kernel.c   wind and gusts on triangles (wind.c), damping of bending
 *     bending.c                bending from a curved rest shape
 *     membrane.c, or spring.c  the membrane, with its damping
 *     hysteresis_forces.c      sliders of hysteresis
 * fill_terms, fill_system and kernels/row_kernel.c list them in the order in which they act. A new
 * force gets a file with fill_... (assembly.h), a line in one of the former, and its part of the
 * sums and rows there.
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
 * With a guess of u, the membrane is linearised about x0 + h guess instead. That is a step of
 * Newton's method for the same equations.
 *
 * A must be symmetric positive definite in every state, so K and D are not always the exact
 * derivatives:
 *   - a spring under compression has no stiffness across itself;
 *   - drag keeps its part along the normal;
 *   - the rest-curvature term of bending is taken as constant;
 *   - bending damping uses the constant matrix, which with M / h is at least half the true one
 *     (kernels/drag_kernel.c);
 *   - derivatives of damping with respect to positions are dropped.
 * Every integrator stays consistent with f0, but steps in which one of these acts are of first
 * order.
 *
 * A pass of elements is followed by a pass of vertices: elements fill their own slots, then each
 * vertex adds the slots around it in a fixed order. No two threads write the same number. First
 * come the terms that do not depend on the guess, summed by vertex; later linearisations may add
 * the membrane to the same numbers. Their slots, most of the memory of a step, are released before
 * that.
 *
 * Based on: Baraff, Witkin, Large steps in cloth simulation, 1998; Choi, Ko, Stable but responsive
 * cloth, 2002; Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 5.1. */
#include "dynamics/drag_kernel.h"
#include "dynamics/row_kernel.h"

#include "base/parallel.h"

#include <math.h>
#include <string.h>

/* Two steps are the same if they differ by less than the rounding of a sum of times. */
static const double SAME_STEP = 1e-9;

/* w, the positions at the guess, and what is padded. */
static void fill_vertices(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    assembly *const work = context;
    const cloth_start *const state = work->state;
    const padded_vertices *const to = &work->padded;
    double const c = work->share, part = (1.0 - c) / c;
    const double *const shape = work->model->shape;
    for (size_t v = begin; v < end; v++)
        for (size_t i = 0; i < 4; i++) {
            size_t const from = 3 * v + i % 3, place = 4 * v + i;
            to->positions[place] = state->positions[from];
            to->velocities[place] = state->velocities[from];
            if (shape) to->bent[place] = state->positions[from] - shape[from];
            if (to->guess) to->guess[place] = state->guess[from];
            if (work->finds_forces)
                to->starts[place] = 0.0;
            else if (to->starts != to->velocities)
                to->starts[place] = state->velocities[from] + part * state->previous_mean[from];
        }
    for (size_t i = 3 * begin; work->guessed_positions && i < 3 * end; i++)
        work->guessed_positions[i] = state->positions[i] + state->time_step * state->guess[i];
}

static bool provide_vertices(assembly *work) {
    const cloth_model *const model = work->model;
    const cloth_start *const state = work->state;
    size_t const count = 4 * model->vertex_count;
    padded_vertices *const padded = &work->padded;
    padded->positions = ARENA_NEW(work->scratch, double, count);
    padded->velocities = ARENA_NEW(work->scratch, double, count);
    padded->bent = model->shape ? ARENA_NEW(work->scratch, double, count) : padded->positions;
    bool const has_starts = work->finds_forces || work->is_bdf2;
    padded->starts = has_starts ? ARENA_NEW(work->scratch, double, count) : padded->velocities;
    if (state->guess) padded->guess = ARENA_NEW(work->scratch, double, count);
    if (!padded->positions || !padded->velocities || !padded->bent || !padded->starts ||
        (state->guess && !padded->guess))
        return false;
    if (!state->guess || !(model->springs || model->sliders)) return true;
    work->guessed_positions = ARENA_NEW(work->scratch, double, 3 * model->vertex_count);
    return work->guessed_positions != NULL;
}

/* The terms that do not depend on the guess. */
static bool fill_terms(assembly *work) {
    const cloth_model *const model = work->model;
    size_t const places = cloth_count_places(model);
    arena_mark const mark = arena_get_mark(work->scratch);
    if (work->has_wind && !fill_air(work)) return false;
    if (work->has_wind || model->patches) {
        work->corner_sources = ARENA_NEW(work->scratch, vec3, places + 1);
        if (model->patches) work->far_sources = ARENA_NEW(work->scratch, vec3, places + 1);
        if (!work->corner_sources || (model->patches && !work->far_sources)) return false;
        parallel_for_busy(model->idle_triangles, model->triangle_count, PATCHES_PER_CHUNK,
                          work->threads, TULLE_PICK_KERNEL(fill_drag), work);
    }
    if (!fill_bending(work)) return false;
    parallel_for_busy(model->idle_vertices, model->vertex_count, VERTICES_PER_CHUNK, work->threads,
                      TULLE_PICK_KERNEL(sum_terms), work);
    arena_release(work->scratch, mark);
    return true;
}

/* Room for the terms that are missing. */
static bool provide_terms(const assembly *work, force_terms *terms) {
    const cloth_model *const model = work->model;
    bool const has_gusts = work->has_wind && work->surroundings->wind.gust_strength > 0.0;
    size_t const drags = cloth_count_places(model) / 3 + 1;
    return provide_slots(&terms->sums, model->vertex_count + 1, work->scratch) &&
           (!has_gusts ||
            provide_slots(&terms->air_velocities, model->vertex_count + 1, work->scratch)) &&
           (!work->has_wind || provide_slots(&terms->triangle_drags, drags, work->scratch));
}

size_t measure_force_terms(const cloth_model *model, const tulle_wind *wind) {
    size_t count = model->vertex_count + 1;
    if (wind->drag_coefficient > 0.0) {
        count += cloth_count_places(model) / 3 + 1;
        if (wind->gust_strength > 0.0) count += model->vertex_count + 1;
    }
    return count * sizeof(vec3);
}

/* Rows of idle vertices. A chunk of them that is not idle has added slots that nobody filled. */
static void fill_idle(assembly *work) {
    const cloth_model *const model = work->model;
    block_matrix *const matrix = &work->system->matrix;
    for (size_t begin = 0; begin < model->vertex_count; begin += VERTICES_PER_CHUNK) {
        size_t const left = model->vertex_count - begin;
        size_t const end = begin + (left < VERTICES_PER_CHUNK ? left : VERTICES_PER_CHUNK);
        bool const is_filled = !are_idle(model->idle_vertices, begin, end);
        for (size_t v = begin; v < end; v++) {
            if (!model->idle_vertices[v]) continue;
            memset(work->sums + 3 * v, 0, 3 * sizeof *work->sums);
            if (!is_filled || work->finds_forces) continue;
            size_t const first = BLOCK_NUMBERS * (size_t)matrix->row_begin[v];
            size_t const last = BLOCK_NUMBERS * (size_t)matrix->row_begin[v + 1];
            memset(matrix->values + first, 0, (last - first) * sizeof *matrix->values);
            double *const own =
                matrix->values + BLOCK_NUMBERS * (size_t)matrix->diagonal_positions[v];
            own[0] = own[3] = own[5] = model->masses[v];
        }
    }
}

/* Fills the matrix and the sums with all forces, in their order. False: no memory. */
static bool fill_system(assembly *work) {
    const cloth_model *const model = work->model;
    if (!provide_terms(work, &work->terms) || !provide_vertices(work)) return false;
    parallel_for(model->vertex_count, VERTICES_PER_CHUNK, work->threads, fill_vertices, work);
    if (!work->is_renewed && !fill_terms(work)) return false;
    if (!provide_slider_slots(work)) return false;
    if (!(model->elements ? fill_elements(work) : fill_springs(work))) return false;
    if (!fill_sliders(work)) return false;
    parallel_for_busy(model->idle_vertices, model->vertex_count, VERTICES_PER_CHUNK, work->threads,
                      TULLE_PICK_KERNEL(fill_rows), work);
    if (work->sliders.blocks)
        parallel_for(model->vertex_count, VERTICES_PER_CHUNK, work->threads, add_sliders, work);
    if (model->idle_vertices) fill_idle(work);
    return true;
}

/* f(x0, v0): the sums of a system whose w is zero. */
static bool find_forces(assembly work, double *forces) {
    cloth_start start = *work.state;
    start.guess = NULL;
    work.state = &start;
    work.finds_forces = true;
    work.sums = forces;
    work.terms = (force_terms){0};
    arena_mark const mark = arena_get_mark(work.scratch);
    bool const ok = fill_system(&work);
    arena_release(work.scratch, mark);
    return ok;
}

tulle_status compute_forces(const cloth_model *model, const cloth_start *state,
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
                     .is_bdf2 = is_bdf2,
                     .sums = system->right_hand_side};
    system->force_time = work.gamma;
    system->share = share;
    system->matrix.scalar_factors[0] = work.alpha;
    system->matrix.scalar_factors[1] = work.beta;

    force_terms *const kept = state->terms;
    work.is_renewed = kept && kept->is_complete;
    /* Terms that are kept outlive the stage. */
    if (kept && !provide_terms(&work, kept)) return TULLE_ERROR_OUT_OF_MEMORY;
    bool ok = !options.finds_forces || work.is_renewed || find_forces(work, system->forces);
    if (kept) work.terms = *kept;
    arena_mark const mark = arena_get_mark(scratch);
    ok = ok && fill_system(&work);
    arena_release(scratch, mark);
    if (kept) kept->is_complete = ok;
    return ok ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
