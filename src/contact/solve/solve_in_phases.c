/* contact/solve/solve_in_phases.c - see solve_in_phases.h.
 *
 * The first phase solves in single precision, preconditioned by the diagonal blocks of vertices. If
 * that takes long, the second takes in the blocks of aggregates. If single precision fails, the
 * third solves in double precision. Which phase runs depends on counts alone, never on time. */
#include "contact/solve/solve_in_phases.h"

#include "base/parallel.h"
#include "contact/solve/eliminate_bodies.h"

#include <math.h>
#include <string.h>

/* Iterations with the blocks of vertices alone. Free flight takes five to seven. To take in the
 * aggregates costs about as much as three. */
enum { PLAIN_ITERATIONS = 8 };

/* A solve in single precision. */
typedef struct single_run {
    phased_solve *phases;
    const conjugate_gradients_problem *problem;
    const matrix_term *terms;
} single_run;

/* Takes in the aggregates, in this solve and those that follow. */
static bool add_aggregates(void *context) {
    single_run *const run = context;
    phased_solve *const phases = run->phases;
    nested_aggregates *const aggregates = phases->system->aggregates;
    aggregated_system const system = {phases->single.matrix, phases->is_fixed, run->terms,
                                      phases->hard_count, phases->system->history->has_sums};
    phases->system->history->has_sums = true;
    if (!nested_aggregates_set(aggregates, &system, run->problem->threads, phases->scene->scratch))
        return false;
    phases->single.aggregates = aggregates;
    return true;
}

/* Tilts are left out: terms then precondition alone. */
static matrix_term *make_terms(const phased_solve *phases) {
    const contact_scene *const scene = phases->scene;
    matrix_term *const terms = ARENA_NEW(scene->scratch, matrix_term, phases->hard_count);
    for (size_t i = 0; terms && i < phases->hard_count; i++) {
        const row_frame *const frame = &phases->hard_rows[i]->frame;
        terms[i] = (matrix_term){.stiffness = phases->hard_rows[i]->solve.pull};
        for (int k = 0; k < 4; k++) {
            bool const is_cloth = frame->vertices[k] < scene->cloth_vertex_count;
            terms[i].vertices[k] = is_cloth ? frame->vertices[k] : TULLE_NONE;
            terms[i].weights[k] = frame->weights[k];
        }
        terms[i].is_apart = frame->has_body;
    }
    return terms;
}

/* Makes the first residual of the problem and with it the targets. */
static tulle_status begin(phased_solve *phases, solve_goal *goal, const double *u,
                          conjugate_gradients_problem *problem) {
    arena *const scratch = phases->scene->scratch;
    double first = 0.0;
    tulle_status status = TULLE_OK;
    if (!(goal->reference > 0.0))
        status = conjugate_gradients_measure(problem, problem->right_hand_side, scratch,
                                             &goal->reference);
    if (status == TULLE_OK)
        status =
            conjugate_gradients_leave(problem, phases->has_product ? NULL : u, scratch, &first);
    if (!(goal->reference > 0.0)) goal->reference = first;
    double const early = fmin(goal->early_share * first, goal->early_tolerance * goal->reference);
    problem->target = fmax(goal->tolerance * goal->reference, early);
    problem->late_target = fmax(goal->late_tolerance * goal->reference, problem->target);
    problem->patience = goal->patience;
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

/* Aggregates null: the blocks of the diagonal alone. */
static tulle_status solve_in_double(phased_solve *phases,
                                    const conjugate_gradients_problem *problem, solve_goal *goal,
                                    nested_aggregates *aggregates, double *u,
                                    conjugate_gradients_result *result) {
    const contact_scene *const scene = phases->scene;
    arena *const scratch = scene->scratch;
    arena_mark const mark = arena_get_mark(scratch);
    const matrix_term *const terms = aggregates ? make_terms(phases) : NULL;
    cloth_correction task = {
        .aggregates = aggregates,
        .system = {phases->single.matrix, phases->is_fixed, terms, phases->hard_count, false},
        .threads = problem->threads,
        .scratch = scratch,
        .has_memory = true};
    conjugate_gradients_problem now = *problem;
    now.residual = phases->residual;
    if (now.vertex_count > scene->cloth_vertex_count) now.is_idle = NULL; /* which has no slots */
    if (aggregates) {
        now.correct = correct_cloth;
        now.correct_context = &task;
        now.plain_iterations = PLAIN_ITERATIONS;
        task.has_memory = terms && make_vectors(scratch, scene->cloth_vertex_count, &task.vectors);
    }
    tulle_status status = TULLE_OK;
    if (task.has_memory) status = begin(phases, goal, u, &now);
    if (task.has_memory && status == TULLE_OK)
        status = conjugate_gradients_solve(&now, u, scratch, result);
    if (!task.has_memory) status = TULLE_ERROR_OUT_OF_MEMORY;
    arena_release(scratch, mark);
    return status;
}

/* ---- in single precision ---- */

static void settle(void *context, double *u) { settle_bodies(context, u); }
static double yield(void *context, double *pulls) { return yield_bodies(context, pulls); }

/* Makes bodies follow the cloth: unknowns of the solve are those of cloth alone. */
static bool eliminate_bodies(single_run *run, eliminated_bodies *bodies, outer_unknowns *outer) {
    single_system *const single = &run->phases->single;
    const contact_scene *const scene = run->phases->scene;
    contact_row **const rows = ARENA_NEW(scene->scratch, contact_row *, single->apart_count);
    for (size_t i = 0; rows && i < single->apart_count; i++)
        rows[i] = run->phases->hard_rows[single->apart[i] - run->terms];
    *bodies = (eliminated_bodies){.scene = scene,
                                  .rows = rows,
                                  .row_count = single->apart_count,
                                  .right_hand_side = run->problem->right_hand_side,
                                  .diagonal = run->phases->diagonal};
    *outer = (outer_unknowns){settle, yield, bodies};
    single->outer = outer;
    return rows && factor_bodies(bodies, scene->scratch);
}

/* The unknowns are those of the cloth. If single precision comes no nearer, the whole is solved in
 * double precision to the same target. */
static tulle_status solve_single_first(const single_run *run, solve_goal *goal,
                                       const late_aggregates *late, double *u,
                                       conjugate_gradients_result *result) {
    phased_solve *const phases = run->phases;
    arena *const scratch = phases->scene->scratch;
    conjugate_gradients_problem whole = *run->problem, of_cloth = whole;
    of_cloth.vertex_count = phases->scene->cloth_vertex_count;
    of_cloth.residual = phases->residual;
    if (phases->single.outer) phases->single.outer->settle(phases->single.outer->context, u);
    tulle_status status = begin(phases, goal, u, &of_cloth);
    if (status == TULLE_OK)
        status = single_solve(&of_cloth, &phases->single, late, u, scratch, result);
    if (status != TULLE_OK) return status;
    int const used = result->iterations;
    phases->plain_iterations += used < late->plain_iterations ? used : late->plain_iterations;
    phases->has_residual = result->end == CONJUGATE_GRADIENTS_CONVERGED ||
                           result->end == CONJUGATE_GRADIENTS_ITERATION_LIMIT;
    if (phases->has_residual) return TULLE_OK;
    solve_goal rest = *goal;
    rest.early_share = 0.0;
    rest.patience -= used;
    if (goal->reference > 0.0) rest.tolerance = of_cloth.target / goal->reference;
    whole.limit -= used;
    phases->has_product = false;
    status = solve_in_double(phases, &whole, &rest, NULL, u, result);
    result->iterations += used;
    return status;
}

tulle_status solve_in_phases(phased_solve *phases, const conjugate_gradients_problem *problem,
                             solve_goal *goal, bool is_single, double *u,
                             conjugate_gradients_result *result) {
    phases->has_residual = !is_single;
    if (!is_single)
        return solve_in_double(phases, problem, goal, phases->system->aggregates, u, result);
    const contact_scene *const scene = phases->scene;
    arena *const scratch = scene->scratch;
    arena_mark const mark = arena_get_mark(scratch);
    bool const has_bodies = problem->vertex_count > scene->cloth_vertex_count;
    single_run run = {phases, problem, make_terms(phases)};
    late_aggregates const late = {PLAIN_ITERATIONS - phases->plain_iterations, add_aggregates,
                                  &run};
    phases->single.aggregates = NULL; /* until they have these terms */
    eliminated_bodies bodies;
    outer_unknowns outer;
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    if (run.terms &&
        single_system_set_terms(&phases->single, run.terms, phases->hard_count, problem->threads,
                                scratch) &&
        (!has_bodies || eliminate_bodies(&run, &bodies, &outer)))
        status = has_bodies && !bodies.is_definite
                     ? solve_in_double(phases, problem, goal, phases->system->aggregates, u, result)
                     : solve_single_first(&run, goal, &late, u, result);
    phases->single.outer = NULL;
    arena_release(scratch, mark);
    return status;
}
