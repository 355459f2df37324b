/* contact/solve/solve_in_phases.c - see solve_in_phases.h.
 *
 * The first phase solves in single precision, preconditioned by the diagonal blocks of vertices. If
 * that takes long, the second takes in the blocks of aggregates. If single precision fails, the
 * third solves in double precision. Which phase runs depends on counts alone, never on time. */
#include "contact/solve/solve_in_phases.h"

/* Iterations with the blocks of vertices alone. Free flight takes five to seven. To take in the
 * aggregates costs about as much as three. */
enum { PLAIN_ITERATIONS = 8 };

/* One solve under way. */
typedef struct solve_run {
    conjugate_gradients_problem problem;
    single_system single;
    single_solver *solver;
    conjugate_gradients_result *result;
    int limit, used; /* iterations */
} solve_run;

/* Runs at most so many iterations in single precision. True when the solve is done; else the next
 * phase keeps the target of this one. */
static bool run_single(solve_run *run, int most) {
    int const left = run->limit - run->used;
    run->problem.max_iterations = left < most ? left : most;
    single_solver_run(run->solver, run->result);
    run->used += run->result->iterations;
    run->problem.patience -= run->result->iterations;
    if (run->problem.early_share > 0.0 && run->problem.reference > 0.0)
        run->problem.tolerance = run->result->target / run->problem.reference;
    run->problem.early_share = 0.0;
    return run->result->end == CONJUGATE_GRADIENTS_CONVERGED || run->used >= run->limit;
}

tulle_status solve_in_phases(phased_solve *phases, const conjugate_gradients_problem *problem,
                             contact_row *const *hard_rows, size_t hard_count, double *u,
                             conjugate_gradients_result *result) {
    const contact_scene *const scene = phases->scene;
    const block_matrix *const matrix = phases->matrix;
    arena *const scratch = scene->scratch;
    arena_mark const mark = arena_get_mark(scratch);
    solve_run run = {.problem = *problem, .result = result, .limit = problem->max_iterations};
    run.problem.residual = phases->residual;
    *result = (conjugate_gradients_result){.reference = problem->reference};
    matrix_term *const terms = ARENA_NEW(scratch, matrix_term, hard_count);
    for (size_t i = 0; terms && i < hard_count; i++) {
        const row_frame *const frame = &hard_rows[i]->frame;
        terms[i] = (matrix_term){.stiffness = hard_rows[i]->solve.pull};
        for (int k = 0; k < 4; k++) {
            bool const is_cloth = frame->vertices[k] < scene->cloth_vertex_count;
            terms[i].vertices[k] = is_cloth ? frame->vertices[k] : TULLE_NONE;
            terms[i].weights[k] = frame->weights[k];
        }
    }
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    bool is_done = false;
    if (terms &&
        single_system_make(matrix, terms, hard_count, problem->threads, scratch, &run.single)) {
        phases->has_residual = true;
        run.solver = single_solver_make(&run.problem, &run.single, u, scratch);
        if (run.solver) status = TULLE_OK;
    }
    /* blocks of the diagonal */
    if (status == TULLE_OK && phases->plain_iterations < PLAIN_ITERATIONS) {
        is_done = run_single(&run, PLAIN_ITERATIONS - phases->plain_iterations);
        phases->plain_iterations += run.used;
    }
    /* aggregates too, in this solve and those that follow */
    if (status == TULLE_OK && !is_done) {
        nested_aggregates *const aggregates = phases->system->aggregates;
        phases->has_aggregates = phases->has_aggregates ||
                                 nested_aggregates_set_matrix(aggregates, matrix, problem->is_fixed,
                                                              problem->threads, scratch);
        if (!phases->has_aggregates) status = TULLE_ERROR_OUT_OF_MEMORY;
        if (status == TULLE_OK) {
            nested_aggregates_set_terms(aggregates, terms, hard_count, problem->threads);
            run.single.aggregates = aggregates;
            is_done = run_single(&run, run.limit);
        }
    }
    /* double precision */
    if (status == TULLE_OK && !is_done) {
        phases->has_residual = false;
        run.problem.max_iterations = run.limit - run.used;
        status = conjugate_gradients_solve(&run.problem, u, scratch, result);
        run.used += result->iterations;
    }
    result->iterations = run.used;
    arena_release(scratch, mark);
    return status;
}
