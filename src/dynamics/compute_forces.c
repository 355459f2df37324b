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
 * constant matrix, which with M / h is at least half the true one (bend_damping.c); derivatives of
 * damping by positions are dropped. Every integrator stays consistent with f0; steps in which one
 * of these acts are of first order.
 *
 * Passes, of springs, then of hinges: elements fill their own slots (assembly_elements.c); then
 * each vertex adds them to its row in a fixed order (assembly_rows.c). No two threads write the
 * same number. Slots are released before those of the next kind are made: they are most of the
 * memory of a step. Terms that do not depend on the guess may be kept from the first linearisation
 * of a step; the others then add the same numbers in the same order, in one pass.
 *
 * Based on: Baraff, Witkin, Large steps in cloth simulation, 1998; Choi, Ko, Stable but responsive
 * cloth, 2002; Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 5.1. */
#include "dynamics/assembly.h"

#include "base/parallel.h"

#include <math.h>

/* Items a chunk, about 50 microseconds of work each. */
enum { SPRINGS_PER_CHUNK = 1024, VERTICES_PER_CHUNK = 256, HINGES_PER_CHUNK = 512 };

/* Two steps are the same if they differ by less than the rounding of a sum of times. */
static const double SAME_STEP = 1e-9;

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

/* Slots of this stage, where the state keeps none. */
static bool provide(vec3 **slots, size_t count, arena *scratch) {
    if (!*slots) *slots = ARENA_NEW(scratch, vec3, count);
    return *slots != NULL;
}

/* ---- triangles: wind ---- */

static bool fill_wind(assembly *work, int threads, arena *scratch) {
    size_t const vertices = work->model->vertex_count, triangles = work->model->triangle_count;
    if (!provide(&work->terms.triangle_drags, triangles, scratch)) return false;
    arena_mark const mark = arena_get_mark(scratch);
    if (!provide(&work->terms.air_velocities, vertices, scratch)) return false;
    parallel_for(vertices, VERTICES_PER_CHUNK, threads, assembly_sample_wind, work);
    parallel_for(triangles, SPRINGS_PER_CHUNK, threads, assembly_fill_triangles, work);
    arena_release(scratch, mark);
    return true;
}

/* ---- springs ---- */

static bool add_springs(assembly *work, int threads, arena *scratch) {
    size_t const vertices = work->model->vertex_count, springs = work->model->spring_count;
    if (work->state->guess) {
        work->guessed_positions = ARENA_NEW(scratch, double, 3 * vertices);
        if (!work->guessed_positions) return false;
    }
    parallel_for(vertices, VERTICES_PER_CHUNK, threads, fill_start_velocities, work);
    if (work->has_wind && !work->is_renewed && !fill_wind(work, threads, scratch)) return false;
    work->spring_blocks = ARENA_NEW(scratch, symmetric3, springs);
    if (!work->is_renewed) work->spring_forces = ARENA_NEW(scratch, vec3, springs);
    work->spring_sources = ARENA_NEW(scratch, vec3, springs);
    if (!work->spring_blocks || !work->spring_sources) return false;
    if (!work->is_renewed && !work->spring_forces) return false;
    parallel_for(springs, SPRINGS_PER_CHUNK, threads, assembly_fill_springs, work);
    parallel_for(vertices, VERTICES_PER_CHUNK, threads,
                 work->is_renewed ? assembly_renew_rows : assembly_gather_springs, work);
    return true;
}

/* ---- hinges ---- */

static bool provide_bending(const cloth_model *model, force_terms *terms, arena *scratch) {
    if (model->has_bend_damping &&
        !provide(&terms->bend_forces, 2 * model->triangle_count, scratch))
        return false;
    return model->has_curved_rest ? provide(&terms->hinge_forces, 4 * model->hinge_count, scratch)
                                  : provide(&terms->hinge_moments, model->hinge_count, scratch);
}

static bool add_hinges(assembly *work, int threads, arena *scratch) {
    const cloth_model *const model = work->model;
    size_t const hinges = model->hinge_count;
    work->hinge_deviations = ARENA_NEW(scratch, vec3, hinges);
    if (!work->hinge_deviations || !provide_bending(model, &work->terms, scratch)) return false;
    if (model->has_bend_damping) {
        work->bend_dampings = ARENA_NEW(scratch, bend_damping_response, model->triangle_count);
        if (!work->bend_dampings) return false;
    }
    parallel_for(hinges, HINGES_PER_CHUNK, threads, assembly_evaluate_hinges, work);
    if (model->has_bend_damping)
        parallel_for(model->triangle_count, HINGES_PER_CHUNK, threads, assembly_damp_bending, work);
    parallel_for(hinges, HINGES_PER_CHUNK, threads, assembly_fill_hinges, work);
    parallel_for(model->vertex_count, VERTICES_PER_CHUNK, threads, assembly_gather_hinges, work);
    return true;
}

/* ---- all ---- */

/* What outlives the passes. */
static bool allocate_assembly(assembly *work, arena *scratch) {
    size_t const triangles = work->has_wind ? work->model->triangle_count : 0;
    work->start_velocities = ARENA_NEW(scratch, double, 3 * work->model->vertex_count);
    if (!work->is_renewed) work->triangle_forces = ARENA_NEW(scratch, vec3, triangles);
    return work->start_velocities && (work->is_renewed || work->triangle_forces) &&
           provide(&work->terms.triangle_sources, triangles, scratch);
}

/* Slots that outlive the stage. */
static bool keep_terms(const assembly *work, force_terms *terms, arena *scratch) {
    const cloth_model *const model = work->model;
    bool const ok =
        !work->has_wind || (provide(&terms->triangle_drags, model->triangle_count, scratch) &&
                            provide(&terms->triangle_sources, model->triangle_count, scratch) &&
                            provide(&terms->air_velocities, model->vertex_count, scratch));
    return ok && (!model->has_bending || provide_bending(model, terms, scratch));
}

size_t measure_force_terms(const cloth_model *model, const tulle_wind *wind) {
    size_t count = 0;
    if (wind->drag_coefficient > 0.0) count += 2 * model->triangle_count + model->vertex_count;
    if (model->has_bending) count += (model->has_curved_rest ? 4 : 1) * model->hinge_count;
    if (model->has_bend_damping) count += 2 * model->triangle_count;
    return count * sizeof(vec3);
}

static bool fill_system(assembly *work, int threads, arena *scratch) {
    if (!allocate_assembly(work, scratch)) return false;
    arena_mark const mark = arena_get_mark(scratch);
    bool ok = add_springs(work, threads, scratch);
    arena_release(scratch, mark);
    if (work->is_renewed) return ok;
    if (ok && work->model->has_bending) ok = add_hinges(work, threads, scratch);
    if (ok)
        parallel_for(work->model->vertex_count, VERTICES_PER_CHUNK, threads, assembly_finish_rows,
                     work);
    return ok;
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
    system->matrix.scalar_factors[0] = work.factor.alpha;
    system->matrix.scalar_factors[1] = work.factor.beta;
    force_terms *const kept = state->terms;
    work.is_renewed = kept && kept->is_complete;
    if (kept && !work.is_renewed && !keep_terms(&work, kept, scratch))
        return TULLE_ERROR_OUT_OF_MEMORY;
    if (kept) work.terms = *kept;
    arena_mark const mark = arena_get_mark(scratch);
    bool const ok = fill_system(&work, options.threads, scratch);
    arena_release(scratch, mark);
    if (kept) kept->is_complete = ok;
    return ok ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
