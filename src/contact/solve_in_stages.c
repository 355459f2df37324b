/* contact/solve_in_stages.c - see solve_in_stages.h.
 *
 * First by blocks of the diagonal in single precision; then, where that takes long and it pays,
 * with a factor of the mesh's edges and of hard rows; then, where single precision fails, in double
 * precision. Which stage runs depends on counts alone, never on time. */
#include "contact/solve_in_stages.h"

/* Iterations by blocks of the diagonal before a factor is made, which costs about as much as forty:
 * free flight takes five to seven, and what is not done after these takes over a hundred. */
#define PLAIN_ITERATIONS 24
/* More hard rows than this between vertices that the factor does not join, and it is not made: each
 * costs it about one iteration, at the price of seven. */
#define MOST_ROWS_APART 12
/* Iterations with the factor of another round, which knows other hard rows, before it is renewed:
 * they cost about as much. */
#define STALE_ITERATIONS 8
/* Iterations with a new factor, of 3 to 30, after which it is no good. */
#define FACTORED_ITERATIONS 100

static cholesky_term *list_terms(const contact_scene *scene, contact_row *const *hard_rows,
                                 size_t hard_count) {
    cholesky_term *const terms = ARENA_NEW(scene->scratch, cholesky_term, hard_count);
    for (size_t i = 0; terms && i < hard_count; i++) {
        const contact_row *const row = hard_rows[i];
        terms[i] = (cholesky_term){.stiffness = row->pull,
                                   .side = row->kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2};
        for (int k = 0; k < 4; k++) {
            bool const is_cloth = row->vertices[k] < scene->cloth_vertex_count;
            terms[i].vertices[k] = is_cloth ? row->vertices[k] : TULLE_NONE;
            terms[i].weights[k] = row->weights[k];
        }
    }
    return terms;
}

/* One solve under way. */
typedef struct solve_run {
    staged_solve *stages;
    conjugate_gradients_problem problem;
    single_system single;
    const cholesky_term *terms;
    size_t term_count;
    double *u;
    conjugate_gradients_result *result;
    int limit, used; /* iterations */
} solve_run;

/* A single precision solve of at most so many iterations. */
static tulle_status run_single(solve_run *run, sparse_cholesky *factor, int most) {
    int const left = run->limit - run->used;
    run->problem.max_iterations = left < most ? left : most;
    tulle_status const status = single_solve(&run->problem, &run->single, factor, run->u,
                                             run->stages->scene->scratch, run->result);
    if (status == TULLE_OK) run->used += run->result->iterations;
    return status;
}

static bool is_done(const solve_run *run) {
    return run->result->end == CONJUGATE_GRADIENTS_CONVERGED || run->used >= run->limit;
}

static tulle_status renew_factor(solve_run *run) {
    staged_solve *const stages = run->stages;
    cholesky_matrix matrix = stages->system->edge_matrix;
    matrix.is_fixed = run->problem.is_fixed;
    matrix.terms = run->terms;
    matrix.term_count = run->term_count;
    cholesky_report report;
    tulle_status const status = sparse_cholesky_factor(
        stages->system->factor, &matrix, run->problem.threads, stages->scene->scratch, &report);
    stages->has_factor = status == TULLE_OK;
    return status;
}

static tulle_status run_stages(solve_run *run) {
    staged_solve *const stages = run->stages;
    sparse_cholesky *const factor = stages->system->factor;
    bool const may_factor = factor && run->single.apart_count <= MOST_ROWS_APART;
    tulle_status status = TULLE_OK;
    if (!may_factor) {
        status = run_single(run, NULL, run->limit);
    } else if (stages->has_factor) {
        status = run_single(run, factor, STALE_ITERATIONS);
    } else {
        int const left = PLAIN_ITERATIONS - stages->plain_iterations;
        status = run_single(run, NULL, left > 0 ? left : 0);
        stages->plain_iterations += run->used;
    }
    if (status != TULLE_OK || is_done(run)) return status;
    if (may_factor) {
        status = renew_factor(run);
        if (status == TULLE_OK) status = run_single(run, factor, FACTORED_ITERATIONS);
        if (status != TULLE_OK || is_done(run)) return status;
    }
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
    *result = (conjugate_gradients_result){.reference = problem->reference};
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    if (run.terms && single_system_make(stages->system->matrix, run.terms, hard_count,
                                        problem->threads, scratch, &run.single))
        status = run_stages(&run);
    result->iterations = run.used;
    arena_release(scratch, mark);
    return status;
}
