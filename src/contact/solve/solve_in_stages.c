/* contact/solve/solve_in_stages.c - see solve_in_stages.h.
 *
 * In single precision by blocks of the diagonal; where that takes long, with those of aggregates
 * too; where single precision fails, in double precision. Which stage runs depends on counts alone,
 * never on time. */
#include "contact/solve/solve_in_stages.h"

/* Iterations by blocks of the diagonal of vertices alone: free flight takes five to seven. To take
 * in the aggregates costs about as much as three. */
#define PLAIN_ITERATIONS 8

static matrix_term *list_terms(const contact_scene *scene, contact_row *const *hard_rows,
                               size_t hard_count) {
    matrix_term *const terms = ARENA_NEW(scene->scratch, matrix_term, hard_count);
    for (size_t i = 0; terms && i < hard_count; i++) {
        const contact_row *const row = hard_rows[i];
        terms[i] = (matrix_term){.stiffness = row->solve.pull};
        for (int k = 0; k < 4; k++) {
            bool const is_cloth = row->frame.vertices[k] < scene->cloth_vertex_count;
            terms[i].vertices[k] = is_cloth ? row->frame.vertices[k] : TULLE_NONE;
            terms[i].weights[k] = row->frame.weights[k];
        }
    }
    return terms;
}

/* One solve under way. */
typedef struct solve_run {
    staged_solve *stages;
    conjugate_gradients_problem problem;
    single_system single;
    single_solver *solver;
    const matrix_term *terms;
    size_t term_count;
    double *u;
    conjugate_gradients_result *result;
    int limit, used; /* iterations */
} solve_run;

/* The stages that follow end where the first was to. */
static void keep_target(solve_run *run) {
    if (run->problem.early_share > 0.0 && run->problem.reference > 0.0)
        run->problem.tolerance = run->result->target / run->problem.reference;
    run->problem.early_share = 0.0;
}

/* At most so many iterations in single precision. */
static void run_single(solve_run *run, int most) {
    int const left = run->limit - run->used;
    run->problem.max_iterations = left < most ? left : most;
    single_solver_run(run->solver, run->result);
    run->used += run->result->iterations;
    keep_target(run);
}

static bool is_done(const solve_run *run) {
    return run->result->end == CONJUGATE_GRADIENTS_CONVERGED || run->used >= run->limit;
}

/* Takes the aggregates in as a preconditioner of the solves that follow. */
static tulle_status add_aggregates(solve_run *run) {
    staged_solve *const stages = run->stages;
    nested_aggregates *const aggregates = stages->system->aggregates;
    int const threads = run->problem.threads;
    if (!stages->has_aggregates &&
        !nested_aggregates_set_matrix(aggregates, stages->system->matrix, run->problem.is_fixed,
                                      threads, stages->scene->scratch))
        return TULLE_ERROR_OUT_OF_MEMORY;
    stages->has_aggregates = true;
    nested_aggregates_set_terms(aggregates, run->terms, run->term_count, threads);
    run->single.aggregates = aggregates;
    return TULLE_OK;
}

static tulle_status run_stages(solve_run *run) {
    staged_solve *const stages = run->stages;
    stages->has_residual = true;
    run->solver = single_solver_make(&run->problem, &run->single, run->u, stages->scene->scratch);
    if (!run->solver) return TULLE_ERROR_OUT_OF_MEMORY;
    if (stages->plain_iterations < PLAIN_ITERATIONS) {
        run_single(run, PLAIN_ITERATIONS - stages->plain_iterations);
        stages->plain_iterations += run->used;
        if (is_done(run)) return TULLE_OK;
    }
    tulle_status status = add_aggregates(run);
    if (status != TULLE_OK) return status;
    run_single(run, run->limit);
    if (is_done(run)) return TULLE_OK;
    stages->has_residual = false;
    run->problem.max_iterations = run->limit - run->used;
    status = conjugate_gradients_solve(&run->problem, run->u, stages->scene->scratch, run->result);
    run->used += run->result->iterations;
    return status;
}

tulle_status solve_in_stages(staged_solve *stages, const conjugate_gradients_problem *problem,
                             contact_row *const *hard_rows, size_t hard_count, double *u,
                             conjugate_gradients_result *result) {
    arena *const scratch = stages->scene->scratch;
    arena_mark const mark = arena_get_mark(scratch);
    solve_run run = {.stages = stages,
                     .problem = *problem,
                     .terms = list_terms(stages->scene, hard_rows, hard_count),
                     .term_count = hard_count,
                     .u = u,
                     .result = result,
                     .limit = problem->max_iterations};
    run.problem.residual = stages->residual;
    *result = (conjugate_gradients_result){.reference = problem->reference};
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    if (run.terms && single_system_make(stages->system->matrix, run.terms, hard_count,
                                        problem->threads, scratch, &run.single))
        status = run_stages(&run);
    result->iterations = run.used;
    arena_release(scratch, mark);
    return status;
}
