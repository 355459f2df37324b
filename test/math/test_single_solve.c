/* Conjugate gradients with single precision inside, with and without a factor, against those in
 * double precision. */
#include "math/kernel_target.h"
#include "math/single_solve.h"
#include "math/vec3.h"
#include "support/spring_system.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct solve_context {
    const spring_system *system;
    const cholesky_matrix *matrix;
} solve_context;
static void apply_matrix(void *context, const double *x, double *y) {
    const solve_context *const work = context;
    spring_system_multiply(work->system, work->matrix, x, y);
}

/* The system of `context` with the right-hand side b; fills the diagonal. */
static conjugate_gradients_problem make_problem(solve_context *context, const double *b,
                                                double *diagonal, double tolerance,
                                                int max_iterations) {
    block_matrix_get_diagonal(&context->system->matrix, diagonal);
    return (conjugate_gradients_problem){.vertex_count = context->system->matrix.row_count,
                                         .apply = apply_matrix,
                                         .apply_context = context,
                                         .right_hand_side = b,
                                         .diagonal = diagonal,
                                         .is_fixed = context->system->is_fixed,
                                         .tolerance = tolerance,
                                         .max_iterations = max_iterations};
}

/* The factor knows nothing of ten stiff rows: conjugate gradients find the same solution in far
 * fewer iterations, the residual being measured in the same way. */
static void test_preconditioner(void **state) {
    (void)state;
    enum { SIDE = 40, SIZE = 3 * SIDE * SIDE, TERMS = 10 };
    spring_system system = spring_system_make(spring_graph_make_grid(SIDE, SIDE, false), 1000.0, 6);
    for (size_t v = 0; v < SIDE; v++) system.is_fixed[v] = 1;
    sparse_cholesky *const factor = spring_system_build_factor(&system);
    cholesky_matrix matrix = spring_system_get_matrix(&system);
    spring_system_run_factor(&system, factor, &matrix, 2);
    cholesky_term terms[TERMS];
    vec3 const normal = {0.0, 0.6, 0.8};
    for (uint32_t t = 0; t < TERMS; t++)
        terms[t] = (cholesky_term){
            .vertices = {SIDE + 5 * t, SIDE * SIDE - 9 * t - 1, TULLE_NONE, TULLE_NONE},
            .weights = {1.0, -1.0, 0.0, 0.0},
            .stiffness = mat3_outer(normal, normal, 500.0)};
    matrix.terms = terms;
    matrix.term_count = TERMS;
    double *const b = malloc(SIZE * sizeof(double));
    double *const diagonal = malloc(3 * SIZE * sizeof(double));
    double *const plain = calloc(SIZE, sizeof(double)), *const x = calloc(SIZE, sizeof(double));
    uint64_t random = 3;
    for (size_t i = 0; i < SIZE; i++) b[i] = random_signed(&random);
    solve_context context = {&system, &matrix};
    conjugate_gradients_problem problem = make_problem(&context, b, diagonal, 1e-9, 3000);
    problem.threads = 2;
    arena scratch = arena_make(&system.heap);
    conjugate_gradients_result slow, quick;
    assert_int_equal(conjugate_gradients_solve(&problem, plain, &scratch, &slow), TULLE_OK);
    problem.reference = slow.reference;
    single_system single;
    assert_true(single_system_make(&system.matrix, terms, TERMS, 2, &scratch, &single));
    assert_int_equal(single.apart_count, TERMS);
    assert_int_equal(single_solve(&problem, &single, factor, x, &scratch, &quick), TULLE_OK);
    assert_int_equal(slow.end, CONJUGATE_GRADIENTS_CONVERGED);
    assert_int_equal(quick.end, CONJUGATE_GRADIENTS_CONVERGED);
    assert_true(quick.reference == slow.reference && quick.residual <= 1e-9);
    assert_in_range(quick.iterations, 2, 40);
    assert_true(slow.iterations > 5 * quick.iterations);
    double largest = 0.0, difference = 0.0;
    for (size_t i = 0; i < SIZE; i++) {
        largest = fmax(largest, fabs(plain[i]));
        difference = fmax(difference, fabs(plain[i] - x[i]));
    }
    assert_true(difference < 1e-6 * largest);
    arena_destroy(&scratch);
    free(b), free(diagonal), free(plain), free(x);
    sparse_cholesky_destroy(&system.heap, factor);
    spring_system_destroy(&system);
}

typedef struct single_case {
    const spring_system *system;
    const cholesky_matrix *matrix;
    conjugate_gradients_problem *problem;
    size_t apart_count; /* terms between vertices far apart */
    arena *scratch;
} single_case;

/* x (3 * vertex_count) from zero. */
static conjugate_gradients_result solve_single(const single_case *given, double *x) {
    const cholesky_matrix *const matrix = given->matrix;
    single_system single;
    assert_true(single_system_make(&given->system->matrix, matrix->terms, matrix->term_count,
                                   given->problem->threads, given->scratch, &single));
    assert_int_equal(single.apart_count, given->apart_count);
    memset(x, 0, 3 * given->problem->vertex_count * sizeof(double));
    conjugate_gradients_result result;
    assert_int_equal(single_solve(given->problem, &single, NULL, x, given->scratch, &result),
                     TULLE_OK);
    return result;
}

/* The same bits for every width and number of threads; they are left in x. */
static void check_bits(const single_case *given, double *x) {
    size_t const bytes = 3 * given->problem->vertex_count * sizeof(double);
    double *const first = malloc(bytes);
    kernel_target const usual = kernel_target_get();
    int solves = 0;
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        for (int threads = 1; threads <= 4; threads += 3) {
            given->problem->threads = threads;
            conjugate_gradients_result const result = solve_single(given, x);
            assert_int_equal(result.end, CONJUGATE_GRADIENTS_CONVERGED);
            assert_true(result.residual <= given->problem->tolerance && result.iterations > 20);
            if (solves++ == 0) memcpy(first, x, bytes);
            assert_memory_equal(first, x, bytes);
        }
    }
    assert_true(solves >= 2);
    kernel_target_force(usual);
    free(first);
}

/* Single precision with residuals in double ends at the same residual as double precision, far
 * under what single precision can tell. */
static void test_single_solve(void **state) {
    (void)state;
    enum { SIDE = 33, SIZE = 3 * SIDE * SIDE, TERMS = 12 };
    spring_system system = spring_system_make(spring_graph_make_grid(SIDE, SIDE, true), 300.0, 4);
    for (size_t v = 0; v < SIDE; v++) system.is_fixed[7 * v] = 1;
    cholesky_matrix matrix = spring_system_get_matrix(&system);
    cholesky_term terms[TERMS];
    vec3 const normal = {0.48, 0.6, 0.64};
    mat3 stiffness = mat3_outer(normal, normal, 80.0);
    mat3 const slip = mat3_identity(10.0);
    mat3_add_scaled(&stiffness, &slip, 1.0);
    for (uint32_t t = 0; t < TERMS; t++) /* every other one between vertices far apart */
        terms[t] =
            (cholesky_term){.vertices = {40 + t, t % 2 ? 41 + t : 700 + t, TULLE_NONE, TULLE_NONE},
                            .weights = {1.0, -0.7, 0.0, 0.0},
                            .stiffness = stiffness};
    matrix.terms = terms;
    matrix.term_count = TERMS;
    double *const b = calloc(SIZE, sizeof(double)), *const x = calloc(SIZE, sizeof(double));
    double *const plain = calloc(SIZE, sizeof(double));
    double *const diagonal = calloc(3 * SIZE, sizeof(double));
    uint64_t random = 3;
    for (size_t i = 0; i < SIZE; i++) b[i] = random_signed(&random);
    solve_context context = {&system, &matrix};
    conjugate_gradients_problem problem = make_problem(&context, b, diagonal, 1e-10, 5000);
    arena scratch = arena_make(&system.heap);
    conjugate_gradients_result result;
    assert_int_equal(conjugate_gradients_solve(&problem, plain, &scratch, &result), TULLE_OK);
    problem.reference = result.reference;
    single_case const given = {&system, &matrix, &problem, TERMS / 2, &scratch};
    check_bits(&given, x);
    for (size_t i = 0; i < SIZE; i++) {
        assert_true(fabs(x[i] - plain[i]) < 1e-6);
        if (system.is_fixed[i / 3]) assert_true(x[i] == 0.0);
    }
    problem.max_iterations = 3;
    result = solve_single(&given, x);
    assert_int_equal(result.end, CONJUGATE_GRADIENTS_ITERATION_LIMIT);
    assert_int_equal(result.iterations, 3);
    assert_true(x[3 * 50] != 0.0);
    arena_destroy(&scratch);
    free(b), free(x), free(plain), free(diagonal);
    spring_system_destroy(&system);
}

int main(void) {
    struct CMUnitTest const tests[] = {
        cmocka_unit_test(test_preconditioner),
        cmocka_unit_test(test_single_solve),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
