/* contact/solve/solve_in_stages.c - see solve_in_stages.h.
 *
 * In single precision by blocks of the diagonal; where that takes long, with those of aggregates
 * too; where single precision fails, in double precision. Which stage runs depends on counts alone,
 * never on time. */
#include "contact/solve/solve_in_stages.h"

/* Iterations by blocks of the diagonal of vertices alone: free flight takes five to seven. To take
 * in the aggregates costs about as much as three. */
#define PLAIN_ITERATIONS 8

/* One solve under way. */
typedef struct solve_run {
    staged_solve *stages;
    conjugate_gradients_problem problem;
    single_system single;
    single_solver *solver;
    conjugate_gradients_result *result;
    int limit, used; /* iterations */
} solve_run;

/* At most so many iterations in single precision. True when the solve is done; what follows ends
 * where this was to. */
static bool run_single(solve_run *run, int most) {
    int const left = run->limit - run->used;
    run->problem.max_iterations = left < most ? left : most;
    single_solver_run(run->solver, run->result);
    run->used += run->result->iterations;
    if (run->problem.early_share > 0.0 && run->problem.reference > 0.0)
        run->problem.tolerance = run->result->target / run->problem.reference;
    run->problem.early_share = 0.0;
    return run->result->end == CONJUGATE_GRADIENTS_CONVERGED || run->used >= run->limit;
}

/* Runs one stage after the other. terms: of the hard rows. */
static tulle_status run_stages(solve_run *run, const matrix_term *terms, size_t term_count,
                               double *u) {
    staged_solve *const stages = run->stages;
    arena *const scratch = stages->scene->scratch;
    nested_aggregates *const aggregates = stages->system->aggregates;
    int const threads = run->problem.threads;
    stages->has_residual = true;
    run->solver = single_solver_make(&run->problem, &run->single, u, scratch);
    if (!run->solver) return TULLE_ERROR_OUT_OF_MEMORY;
    if (stages->plain_iterations < PLAIN_ITERATIONS) {
        bool const is_done = run_single(run, PLAIN_ITERATIONS - stages->plain_iterations);
        stages->plain_iterations += run->used;
        if (is_done) return TULLE_OK;
    }
    /* the aggregates become a preconditioner of the solves that follow */
    if (!stages->has_aggregates &&
        !nested_aggregates_set_matrix(aggregates, stages->system->matrix, run->problem.is_fixed,
                                      threads, scratch))
        return TULLE_ERROR_OUT_OF_MEMORY;
    stages->has_aggregates = true;
    nested_aggregates_set_terms(aggregates, terms, term_count, threads);
    run->single.aggregates = aggregates;
    if (run_single(run, run->limit)) return TULLE_OK;
    stages->has_residual = false;
    run->problem.max_iterations = run->limit - run->used;
    tulle_status const status = conjugate_gradients_solve(&run->problem, u, scratch, run->result);
    run->used += run->result->iterations;
    return status;
}

tulle_status solve_in_stages(staged_solve *stages, const conjugate_gradients_problem *problem,
                             contact_row *const *hard_rows, size_t hard_count, double *u,
                             conjugate_gradients_result *result) {
    const contact_scene *const scene = stages->scene;
    arena_mark const mark = arena_get_mark(scene->scratch);
    matrix_term *const terms = ARENA_NEW(scene->scratch, matrix_term, hard_count);
    for (size_t i = 0; terms && i < hard_count; i++) {
        const row_frame *const frame = &hard_rows[i]->frame;
        terms[i] = (matrix_term){.stiffness = hard_rows[i]->solve.pull};
        for (int k = 0; k < 4; k++) {
            bool const is_cloth = frame->vertices[k] < scene->cloth_vertex_count;
            terms[i].vertices[k] = is_cloth ? frame->vertices[k] : TULLE_NONE;
            terms[i].weights[k] = frame->weights[k];
        }
    }
    solve_run run = {
        .stages = stages, .problem = *problem, .result = result, .limit = problem->max_iterations};
    run.problem.residual = stages->residual;
    *result = (conjugate_gradients_result){.reference = problem->reference};
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    if (terms && single_system_make(stages->system->matrix, terms, hard_count, problem->threads,
                                    scene->scratch, &run.single))
        status = run_stages(&run, terms, hard_count, u);
    result->iterations = run.used;
    arena_release(scene->scratch, mark);
    return status;
}
