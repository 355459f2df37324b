/* contact/solve/solve_in_phases.c - see solve_in_phases.h.
 *
 * The first phase solves in single precision, preconditioned by the diagonal blocks of vertices. If
 * that takes long, the second takes in the blocks of aggregates. If single precision fails, the
 * third solves in double precision. Which phase runs depends on counts alone, never on time. */
#include "contact/solve/solve_in_phases.h"

#include "base/parallel.h"
#include "contact/solve/eliminate_bodies.h"

#include <string.h>

/* Iterations with the blocks of vertices alone. Free flight takes five to seven. To take in the
 * aggregates costs about as much as three. */
enum { PLAIN_ITERATIONS = 8 };

/* A solve in single precision. */
typedef struct single_run {
    phased_solve *phases;
    const conjugate_gradients_problem *problem;
    const matrix_term *terms;
    size_t term_count;
} single_run;

/* Takes in the aggregates, in this solve and those that follow. */
static bool add_aggregates(void *context) {
    single_run *const run = context;
    phased_solve *const phases = run->phases;
    nested_aggregates *const aggregates = phases->system->aggregates;
    aggregated_system const system = {phases->single.matrix, run->problem->is_fixed, run->terms,
                                      run->term_count, phases->system->history->has_sums};
    phases->system->history->has_sums = true;
    if (!nested_aggregates_set(aggregates, &system, run->problem->threads, phases->scene->scratch))
        return false;
    phases->single.aggregates = aggregates;
    return true;
}

/* Tilts are left out: terms then precondition alone. */
static matrix_term *make_terms(const contact_scene *scene, contact_row *const *rows, size_t count) {
    matrix_term *const terms = ARENA_NEW(scene->scratch, matrix_term, count);
    for (size_t i = 0; terms && i < count; i++) {
        const row_frame *const frame = &rows[i]->frame;
        terms[i] = (matrix_term){.stiffness = rows[i]->solve.pull};
        for (int k = 0; k < 4; k++) {
            bool const is_cloth = frame->vertices[k] < scene->cloth_vertex_count;
            terms[i].vertices[k] = is_cloth ? frame->vertices[k] : TULLE_NONE;
            terms[i].weights[k] = frame->weights[k];
        }
        terms[i].is_apart = frame->has_body;
    }
    return terms;
}

static void settle(void *context, double *u) { settle_bodies(context, u); }
static double yield(void *context, double *pulls) { return yield_bodies(context, pulls); }

/* Makes bodies follow the cloth: unknowns of the solve are those of cloth alone. */
static bool eliminate_bodies(single_run *run, contact_row *const *hard_rows,
                             eliminated_bodies *bodies, outer_unknowns *outer) {
    single_system *const single = &run->phases->single;
    const contact_scene *const scene = run->phases->scene;
    contact_row **const rows = ARENA_NEW(scene->scratch, contact_row *, single->apart_count);
    for (size_t i = 0; rows && i < single->apart_count; i++)
        rows[i] = hard_rows[single->apart[i] - run->terms];
    *bodies = (eliminated_bodies){.scene = scene,
                                  .rows = rows,
                                  .row_count = single->apart_count,
                                  .right_hand_side = run->problem->right_hand_side,
                                  .diagonal = run->problem->diagonal};
    *outer = (outer_unknowns){settle, yield, bodies};
    single->outer = outer;
    return rows && factor_bodies(bodies, scene->scratch);
}

/* In single precision, the unknowns being those of `of_cloth`. If that fails, `whole` is solved in
 * double precision to the same target. */
static tulle_status solve_single_first(const single_run *run,
                                       const conjugate_gradients_problem *of_cloth,
                                       conjugate_gradients_problem whole,
                                       const late_aggregates *late, double *u,
                                       conjugate_gradients_result *result) {
    phased_solve *const phases = run->phases;
    arena *const scratch = phases->scene->scratch;
    tulle_status const status = single_solve(of_cloth, &phases->single, late, u, scratch, result);
    if (status != TULLE_OK) return status;
    int const used = result->iterations;
    phases->plain_iterations += used < late->plain_iterations ? used : late->plain_iterations;
    phases->has_residual = result->end == CONJUGATE_GRADIENTS_CONVERGED ||
                           result->end == CONJUGATE_GRADIENTS_ITERATION_LIMIT;
    if (phases->has_residual) return TULLE_OK;
    whole.max_iterations -= used;
    whole.patience -= used;
    whole.early_share = 0.0;
    if (whole.reference > 0.0) whole.tolerance = result->target / whole.reference;
    tulle_status const end = conjugate_gradients_solve(&whole, u, scratch, result);
    result->iterations += used;
    return end;
}

tulle_status solve_in_phases(phased_solve *phases, const conjugate_gradients_problem *problem,
                             contact_row *const *hard_rows, size_t hard_count, double *u,
                             conjugate_gradients_result *result) {
    const contact_scene *const scene = phases->scene;
    arena *const scratch = scene->scratch;
    arena_mark const mark = arena_get_mark(scratch);
    bool const has_bodies = problem->vertex_count > scene->cloth_vertex_count;
    conjugate_gradients_problem whole = *problem, of_cloth = *problem;
    whole.residual = of_cloth.residual = phases->residual;
    of_cloth.vertex_count = scene->cloth_vertex_count;
    if (has_bodies) whole.is_idle = NULL; /* which has no slots */
    single_run run = {.phases = phases,
                      .problem = problem,
                      .terms = make_terms(scene, hard_rows, hard_count),
                      .term_count = hard_count};
    late_aggregates const late = {PLAIN_ITERATIONS - phases->plain_iterations, add_aggregates,
                                  &run};
    phases->single.aggregates = NULL; /* until they have these terms */
    eliminated_bodies bodies;
    outer_unknowns outer;
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    if (run.terms &&
        single_system_set_terms(&phases->single, run.terms, hard_count, problem->threads,
                                scratch) &&
        (!has_bodies || eliminate_bodies(&run, hard_rows, &bodies, &outer)))
        status = has_bodies && !bodies.is_definite
                     ? conjugate_gradients_solve(&whole, u, scratch, result)
                     : solve_single_first(&run, &of_cloth, whole, &late, u, result);
    phases->single.outer = NULL;
    arena_release(scratch, mark);
    return status;
}

/* ---- in double precision ---- */

enum { VERTICES_PER_CHUNK = 512 };

/* What aggregates of the cloth add to a residual of cloth, or of cloth and bodies. */
typedef struct cloth_correction {
    nested_aggregates *aggregates;
    aggregated_system system;
    int threads;
    arena *scratch;
    const double *from;     /* residual */
    double *to;             /* what is added to */
    single_vectors vectors; /* of the cloth: residual and preconditioned, in planes */
    bool is_ready, has_memory;
} cloth_correction;

static bool make_vectors(arena *scratch, size_t count, single_vectors *vectors) {
    size_t const step = count + SINGLE_PADDING;
    *vectors = (single_vectors){.residual = ARENA_NEW_ZEROED(scratch, float, 3 * step),
                                .preconditioned = ARENA_NEW(scratch, float, 3 * step),
                                .vertex_step = 1,
                                .number_step = step};
    return vectors->residual && vectors->preconditioned;
}

static void round_residual(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const cloth_correction *const task = context;
    for (size_t v = begin; v < end; v++)
        for (size_t i = 0; i < 3; i++)
            task->vectors.residual[v + i * task->vectors.number_step] =
                (float)task->from[3 * v + i];
}

static void add_correction(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const cloth_correction *const task = context;
    const single_vectors *const found = &task->vectors;
    for (size_t i = 0; i < 3; i++)
        memset(found->preconditioned + i * found->number_step + begin, 0,
               (end - begin) * sizeof(float));
    nested_aggregates_add(task->aggregates, found, begin, end);
    for (size_t v = begin; v < end; v++)
        for (size_t i = 0; i < 3; i++)
            task->to[3 * v + i] += (double)found->preconditioned[v + i * found->number_step];
}

static double correct_cloth(void *context, const double *residual, double *preconditioned) {
    cloth_correction *const task = context;
    nested_aggregates *const aggregates = task->aggregates;
    if (!task->is_ready)
        task->has_memory =
            nested_aggregates_set(aggregates, &task->system, task->threads, task->scratch);
    task->is_ready = true;
    if (!task->has_memory || aggregates->level_count == 0) return 0.0;
    task->from = residual;
    task->to = preconditioned;
    size_t const count = aggregates->vertex_count;
    parallel_for(count, VERTICES_PER_CHUNK, task->threads, round_residual, task);
    double const dot = nested_aggregates_correct(aggregates, &task->vectors, task->threads);
    parallel_for(count, VERTICES_PER_CHUNK, task->threads, add_correction, task);
    return dot;
}

tulle_status solve_in_double(phased_solve *phases, const conjugate_gradients_problem *problem,
                             contact_row *const *hard_rows, size_t hard_count, double *u,
                             conjugate_gradients_result *result) {
    const contact_scene *const scene = phases->scene;
    arena *const scratch = scene->scratch;
    if (!phases->system->aggregates) return conjugate_gradients_solve(problem, u, scratch, result);
    arena_mark const mark = arena_get_mark(scratch);
    const matrix_term *const terms = make_terms(scene, hard_rows, hard_count);
    cloth_correction task = {
        .aggregates = phases->system->aggregates,
        .system = {phases->single.matrix, problem->is_fixed, terms, hard_count, false},
        .threads = problem->threads,
        .scratch = scratch,
        .has_memory = true};
    conjugate_gradients_problem now = *problem;
    now.correct = correct_cloth;
    now.correct_context = &task;
    now.plain_iterations = PLAIN_ITERATIONS;
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    if (terms && make_vectors(scratch, scene->cloth_vertex_count, &task.vectors))
        status = conjugate_gradients_solve(&now, u, scratch, result);
    if (!task.has_memory) status = TULLE_ERROR_OUT_OF_MEMORY;
    arena_release(scratch, mark);
    return status;
}
