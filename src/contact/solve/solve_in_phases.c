/* contact/solve/solve_in_phases.c - see solve_in_phases.h.
 *
 * The first phase solves in single precision, preconditioned by the diagonal blocks of vertices. If
 * that takes long, the second takes in the blocks of aggregates. If single precision fails, the
 * third solves in double precision. Which phase runs depends on counts alone, never on time. */
#include "contact/solve/solve_in_phases.h"

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
                                      run->term_count};
    if (!nested_aggregates_set(aggregates, &system, run->problem->threads, phases->scene->scratch))
        return false;
    phases->single.aggregates = aggregates;
    return true;
}

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
    }
    return terms;
}

tulle_status solve_in_phases(phased_solve *phases, const conjugate_gradients_problem *problem,
                             contact_row *const *hard_rows, size_t hard_count, double *u,
                             conjugate_gradients_result *result) {
    const contact_scene *const scene = phases->scene;
    arena *const scratch = scene->scratch;
    arena_mark const mark = arena_get_mark(scratch);
    conjugate_gradients_problem now = *problem;
    now.residual = phases->residual;
    single_run run = {.phases = phases,
                      .problem = problem,
                      .terms = make_terms(scene, hard_rows, hard_count),
                      .term_count = hard_count};
    late_aggregates const late = {PLAIN_ITERATIONS - phases->plain_iterations, add_aggregates,
                                  &run};
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    phases->single.aggregates = NULL; /* until they have these terms */
    if (run.terms &&
        single_system_set_terms(&phases->single, run.terms, hard_count, problem->threads, scratch))
        status = single_solve(&now, &phases->single, &late, u, scratch, result);
    if (status == TULLE_OK) {
        phases->has_residual = true;
        int const used = result->iterations;
        phases->plain_iterations += used < late.plain_iterations ? used : late.plain_iterations;
        bool const is_done = result->end == CONJUGATE_GRADIENTS_CONVERGED ||
                             result->end == CONJUGATE_GRADIENTS_ITERATION_LIMIT;
        if (!is_done) { /* in double precision, to the same target */
            phases->has_residual = false;
            now.max_iterations -= used;
            now.patience -= used;
            now.early_share = 0.0;
            if (now.reference > 0.0) now.tolerance = result->target / now.reference;
            status = conjugate_gradients_solve(&now, u, scratch, result);
            result->iterations += used;
        }
    }
    arena_release(scratch, mark);
    return status;
}
