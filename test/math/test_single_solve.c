/* Conjugate gradients with single precision inside, with and without aggregates, against those in
 * double precision. */
#include "math/kernel_target.h"
#include "math/single_solve.h"
#include "math/vec3.h"
#include "support/solve_aim.h"
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
    const spring_matrix *matrix;
} solve_context;
static void apply_matrix(void *context, const double *x, double *y) {
    const solve_context *const work = context;
    spring_system_multiply(work->system, work->matrix, x, y);
}

/* Diagonal blocks with their scalars, inverted. */
static void make_inverse(const spring_system *system, double *inverse) {
    const block_matrix *const matrix = &system->matrix;
    double *const diagonal = malloc(9 * matrix->row_count * sizeof(double));
    block_matrix_get_diagonal(matrix, diagonal, 2);
    for (size_t v = 0; v < matrix->row_count; v++)
        for (uint32_t k = matrix->scalar_begin[v]; k < matrix->scalar_begin[v + 1]; k++)
            for (size_t i = 0; i < 9 && matrix->scalar_columns[k] == v; i += 4)
                diagonal[9 * v + i] += block_matrix_get_scalar(matrix, k);
    conjugate_gradients_invert((preconditioner_source){diagonal, system->is_fixed},
                               matrix->row_count, 1, inverse);
    free(diagonal);
}

typedef struct single_case {
    const spring_system *system;
    const spring_matrix *matrix;
    nested_aggregates *aggregates; /* null: without */
    const late_aggregates *late;   /* of `single`; null: none */
    single_system *single;
    conjugate_gradients_problem *problem;
    size_t apart_count; /* terms between vertices far apart */
    arena *scratch;
} single_case;

/* x = 0, whose residual is b. */
static void begin_at_zero(const conjugate_gradients_problem *problem, double *x) {
    size_t const size = 3 * problem->vertex_count * sizeof(double);
    memset(x, 0, size);
    memcpy(problem->residual, problem->right_hand_side, size);
}

/* x (3 * vertex_count) from zero. */
static conjugate_gradients_result solve_single(const single_case *given, double *x) {
    const spring_matrix *const matrix = given->matrix;
    arena_mark const mark = arena_get_mark(given->scratch);
    single_system own, *const single = given->single ? given->single : &own;
    assert_true(single_system_make(&given->system->matrix, given->scratch, single));
    assert_true(single_system_set_terms(single, matrix->terms, matrix->term_count,
                                        given->problem->threads, given->scratch));
    assert_int_equal(single->apart_count, given->apart_count);
    single->aggregates = given->aggregates;
    begin_at_zero(given->problem, x);
    conjugate_gradients_result result;
    assert_int_equal(single_solve(given->problem, single, given->late, x, given->scratch, &result),
                     TULLE_OK);
    arena_release(given->scratch, mark);
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
            assert_true(result.norm <= given->problem->target && result.iterations > 20);
            if (solves++ == 0) memcpy(first, x, bytes);
            assert_memory_equal(first, x, bytes);
        }
    }
    assert_true(solves >= 2);
    kernel_target_force(usual);
    free(first);
}

/* A system with terms, every other one between vertices far apart, and a right-hand side. */
typedef struct test_problem {
    spring_system system;
    matrix_term terms[12];
    spring_matrix matrix;
    solve_context context;
    double *b, *x, *plain, *inverse, *residual;
    double reference, tolerance;
    conjugate_gradients_problem problem;
    arena scratch;
} test_problem;

static void make_problem_of(test_problem *test, spring_graph mesh, double stiffness,
                            double tolerance) {
    size_t const size = 3 * mesh.vertex_count;
    test->system = spring_system_make(mesh, stiffness, 4);
    for (size_t v = 0; v * v < mesh.vertex_count; v++) test->system.is_fixed[7 * v] = 1;
    vec3 const normal = {0.48, 0.6, 0.64};
    mat3 pull = mat3_outer(normal, normal, 80.0);
    mat3 const slip = mat3_identity(10.0);
    mat3_add_scaled(&pull, &slip, 1.0);
    for (uint32_t t = 0; t < 12; t++)
        test->terms[t] =
            (matrix_term){.vertices = {40 + t, t % 2 ? 41 + t : 700 + t, TULLE_NONE, TULLE_NONE},
                          .weights = {1.0, -0.7, 0.0, 0.0},
                          .stiffness = pull};
    test->matrix = (spring_matrix){test->terms, 12};
    test->context = (solve_context){&test->system, &test->matrix};
    test->b = calloc(size, sizeof(double)), test->x = calloc(size, sizeof(double));
    test->plain = calloc(size, sizeof(double));
    test->inverse = calloc(2 * size, sizeof(double));
    test->residual = calloc(size, sizeof(double));
    uint64_t random = 3;
    for (size_t i = 0; i < size; i++) test->b[i] = random_signed(&random);
    make_inverse(&test->system, test->inverse);
    test->problem = (conjugate_gradients_problem){.vertex_count = mesh.vertex_count,
                                                  .apply = apply_matrix,
                                                  .apply_context = &test->context,
                                                  .right_hand_side = test->b,
                                                  .inverse = test->inverse,
                                                  .limit = 5000,
                                                  .residual = test->residual};
    test->scratch = arena_make(&test->system.heap);
    test->tolerance = tolerance;
    test->reference = aim_solve(&test->problem, test->x, tolerance, 0.0, &test->scratch);
}

/* Isotropic springs go from the end of a row around to the begin of another. So aggregates have no
 * grid. */
static void make_test_problem(test_problem *test, uint32_t side, double stiffness,
                              double tolerance) {
    make_problem_of(test, spring_graph_make_grid(side, side, true), stiffness, tolerance);
}

/* One whose aggregates have a grid. */
static void make_grid_problem(test_problem *test, uint32_t side, double stiffness,
                              double tolerance) {
    spring_sheets const sheet = {
        .columns = side, .rows = side, .count = 1, .wide_count = 2, .has_hole = true};
    make_problem_of(test, spring_graph_make_sheets(&sheet), stiffness, tolerance);
}

/* As a mesh has it whose vertices are not numbered row by row. */
static void solve_by_rows(test_problem *test) {
    assert_true(test->system.matrix.diagonals.count > 0);
    test->system.matrix.diagonals.count = 0;
}

static void destroy_test_problem(test_problem *test) {
    arena_destroy(&test->scratch);
    free(test->b), free(test->x), free(test->plain);
    free(test->inverse), free(test->residual);
    spring_system_destroy(&test->system);
}

/* The solution in double precision. */
static void solve_plainly(test_problem *test) {
    conjugate_gradients_result result;
    begin_at_zero(&test->problem, test->plain);
    assert_int_equal(
        conjugate_gradients_solve(&test->problem, test->plain, &test->scratch, &result), TULLE_OK);
    assert_int_equal(result.end, CONJUGATE_GRADIENTS_CONVERGED);
}

static void check_solution(const test_problem *test) {
    for (size_t i = 0; i < 3 * test->problem.vertex_count; i++) {
        assert_true(fabs(test->x[i] - test->plain[i]) < 1e-6);
        if (test->system.is_fixed[i / 3]) assert_true(test->x[i] == 0.0);
    }
}

/* Single precision with residuals in double ends at the same residual as double precision, far
 * under what single precision can tell. */
static void check_single_solve(bool is_by_rows) {
    test_problem test;
    make_test_problem(&test, 33, 300.0, 1e-10);
    if (is_by_rows) solve_by_rows(&test);
    solve_plainly(&test);
    single_case const given = {&test.system, &test.matrix,  NULL, NULL,
                               NULL,         &test.problem, 6,    &test.scratch};
    check_bits(&given, test.x);
    check_solution(&test);
    test.problem.limit = 3;
    conjugate_gradients_result const result = solve_single(&given, test.x);
    assert_int_equal(result.end, CONJUGATE_GRADIENTS_ITERATION_LIMIT);
    assert_int_equal(result.iterations, 3);
    assert_true(test.x[3 * 50] != 0.0);
    destroy_test_problem(&test);
}

static void test_single_solve(void **state) {
    (void)state;
    check_single_solve(false);
    check_single_solve(true);
}

/* With aggregates: the same solution, with far fewer iterations, and the same bits too. */
static void check_aggregates(bool is_by_rows, bool has_grid) {
    test_problem test;
    if (has_grid)
        make_grid_problem(&test, 60, 3000.0, 1e-9);
    else
        make_test_problem(&test, 60, 3000.0, 1e-9);
    if (is_by_rows) solve_by_rows(&test);
    solve_plainly(&test);
    single_case given = {&test.system, &test.matrix,  NULL, NULL,
                         NULL,         &test.problem, 6,    &test.scratch};
    test.problem.threads = 1;
    int const without = solve_single(&given, test.x).iterations;
    given.aggregates =
        nested_aggregates_build(&test.system.heap, &test.system.matrix, &test.scratch);
    assert_non_null(given.aggregates);
    assert_true((given.aggregates->grid != NULL) == has_grid);
    aggregated_system const all = {&test.system.matrix, test.system.is_fixed, test.terms, 12,
                                   false};
    assert_true(nested_aggregates_set(given.aggregates, &all, 1, &test.scratch));
    conjugate_gradients_result const result = solve_single(&given, test.x);
    assert_true(result.norm <= test.problem.target && 3 * result.iterations < 2 * without);
    check_bits(&given, test.x);
    check_solution(&test);
    nested_aggregates_destroy(&test.system.heap, given.aggregates);
    destroy_test_problem(&test);
}

static void test_aggregates(void **state) {
    (void)state;
    check_aggregates(false, false);
    check_aggregates(true, false);
    check_aggregates(false, true);
}

/* Aggregates that a system gets when it asks for them. */
typedef struct aggregate_offer {
    single_system *system;
    nested_aggregates *aggregates; /* null: no memory */
    int calls;
} aggregate_offer;

static bool accept_offer(void *context) {
    aggregate_offer *const offer = context;
    offer->calls++;
    offer->system->aggregates = offer->aggregates;
    return offer->aggregates != NULL;
}

/* A solve that takes long goes on with aggregates, once. Without memory for them it fails. */
static void test_late_aggregates(void **state) {
    (void)state;
    test_problem test;
    make_test_problem(&test, 60, 3000.0, 1e-9);
    solve_plainly(&test);
    test.problem.threads = 1;
    single_case given = {&test.system, &test.matrix,  NULL, NULL,
                         NULL,         &test.problem, 6,    &test.scratch};
    int const without = solve_single(&given, test.x).iterations;
    nested_aggregates *const aggregates =
        nested_aggregates_build(&test.system.heap, &test.system.matrix, &test.scratch);
    assert_non_null(aggregates);
    aggregated_system const all = {&test.system.matrix, test.system.is_fixed, test.terms, 12,
                                   false};
    assert_true(nested_aggregates_set(aggregates, &all, 1, &test.scratch));
    given.aggregates = aggregates;
    int const with = solve_single(&given, test.x).iterations;
    given.aggregates = NULL;
    single_system single;
    aggregate_offer offer = {&single, aggregates, 0};
    late_aggregates late = {8, accept_offer, &offer};
    given.single = &single;
    given.late = &late;
    conjugate_gradients_result const result = solve_single(&given, test.x);
    assert_int_equal(offer.calls, 1);
    assert_int_equal(result.end, CONJUGATE_GRADIENTS_CONVERGED);
    assert_true(result.norm <= test.problem.target && result.iterations != with);
    assert_true(3 * result.iterations < 2 * without);
    check_solution(&test);
    late.plain_iterations = without + 1; /* it is done before */
    assert_int_equal(solve_single(&given, test.x).iterations, without);
    assert_int_equal(offer.calls, 1);
    late.plain_iterations = 8;
    offer.aggregates = NULL;
    arena_mark const mark = arena_get_mark(&test.scratch);
    assert_true(single_system_make(&test.system.matrix, &test.scratch, &single));
    assert_true(single_system_set_terms(&single, test.terms, 12, 1, &test.scratch));
    begin_at_zero(&test.problem, test.x);
    conjugate_gradients_result failed;
    assert_int_equal(single_solve(&test.problem, &single, &late, test.x, &test.scratch, &failed),
                     TULLE_ERROR_OUT_OF_MEMORY);
    arena_release(&test.scratch, mark);
    assert_int_equal(offer.calls, 2);
    nested_aggregates_destroy(&test.system.heap, aggregates);
    destroy_test_problem(&test);
}

static conjugate_gradients_result solve_double(test_problem *test) {
    begin_at_zero(&test->problem, test->x);
    conjugate_gradients_result result;
    assert_int_equal(conjugate_gradients_solve(&test->problem, test->x, &test->scratch, &result),
                     TULLE_OK);
    return result;
}

/* A solve ends at the late target as soon as it has met it and its patience is over. */
static void test_patience(void **state) {
    (void)state;
    test_problem test;
    make_test_problem(&test, 33, 300.0, 1e-4);
    solve_plainly(&test);
    test.problem.threads = 1;
    conjugate_gradients_problem *const problem = &test.problem;
    single_case const given = {&test.system, &test.matrix, NULL, NULL,
                               NULL,         problem,      6,    &test.scratch};
    for (int is_single = 0; is_single < 2; is_single++) {
        problem->late_target = problem->target; /* then patience means nothing */
        problem->patience = 5;
        conjugate_gradients_result const whole =
            is_single ? solve_single(&given, test.x) : solve_double(&test);
        problem->late_target = 1e-2 * test.reference;
        problem->patience = whole.iterations + 1; /* it does not come to that */
        conjugate_gradients_result const early =
            is_single ? solve_single(&given, test.x) : solve_double(&test);
        assert_int_equal(early.iterations, whole.iterations);
        assert_true(early.norm == whole.norm);
        problem->patience = whole.iterations - 4;
        conjugate_gradients_result const late =
            is_single ? solve_single(&given, test.x) : solve_double(&test);
        assert_int_equal(late.iterations, problem->patience);
        assert_true(late.norm > problem->target && late.norm <= problem->late_target);
        problem->patience = 1; /* over before the late target is met */
        conjugate_gradients_result const least =
            is_single ? solve_single(&given, test.x) : solve_double(&test);
        assert_int_equal(least.end, CONJUGATE_GRADIENTS_CONVERGED);
        assert_true(least.iterations > 1 && least.iterations < late.iterations);
        assert_true(least.norm <= problem->late_target && least.norm > late.norm);
    }
    destroy_test_problem(&test);
}

/* What adds aggregates to a solve in double precision. */
typedef struct double_correction {
    nested_aggregates *aggregates;
    single_vectors vectors; /* residual and preconditioned, in planes */
    int calls;
} double_correction;

static double correct(void *context, const double *residual, double *preconditioned) {
    double_correction *const task = context;
    const single_vectors *const vectors = &task->vectors;
    size_t const count = task->aggregates->vertex_count, step = vectors->number_step;
    task->calls++;
    memset(vectors->preconditioned, 0, 3 * step * sizeof(float));
    for (size_t i = 0; i < 3 * count; i++)
        vectors->residual[i / 3 + i % 3 * step] = (float)residual[i];
    double const dot = nested_aggregates_correct(task->aggregates, vectors, 2);
    nested_aggregates_add(task->aggregates, vectors, 0, count);
    for (size_t i = 0; i < 3 * count; i++)
        preconditioned[i] += (double)vectors->preconditioned[i / 3 + i % 3 * step];
    return dot;
}

/* In double precision, too, the solution is the same with fewer iterations; the correction comes in
 * after the plain ones. */
static void check_double_correction(bool has_grid) {
    test_problem test;
    if (has_grid)
        make_grid_problem(&test, 60, 3000.0, 1e-9);
    else
        make_test_problem(&test, 60, 3000.0, 1e-9);
    solve_plainly(&test);
    conjugate_gradients_problem problem = test.problem;
    problem.threads = 2;
    conjugate_gradients_result plain, corrected;
    begin_at_zero(&problem, test.x);
    assert_int_equal(conjugate_gradients_solve(&problem, test.x, &test.scratch, &plain), TULLE_OK);
    size_t const step = problem.vertex_count + SINGLE_PADDING;
    double_correction task = {.aggregates = nested_aggregates_build(
                                  &test.system.heap, &test.system.matrix, &test.scratch),
                              .vectors = {.residual = calloc(3 * step, sizeof(float)),
                                          .preconditioned = calloc(3 * step, sizeof(float)),
                                          .vertex_step = 1,
                                          .number_step = step}};
    assert_true(task.aggregates && task.vectors.residual && task.vectors.preconditioned);
    assert_true((task.aggregates->grid != NULL) == has_grid);
    aggregated_system const all = {&test.system.matrix, test.system.is_fixed, test.terms, 12,
                                   false};
    assert_true(nested_aggregates_set(task.aggregates, &all, 2, &test.scratch));
    problem.correct = correct;
    problem.correct_context = &task;
    problem.plain_iterations = 5;
    begin_at_zero(&problem, test.x);
    assert_int_equal(conjugate_gradients_solve(&problem, test.x, &test.scratch, &corrected),
                     TULLE_OK);
    assert_int_equal(corrected.end, CONJUGATE_GRADIENTS_CONVERGED);
    assert_int_equal(task.calls, corrected.iterations - 4);
    assert_true(3 * corrected.iterations < 2 * plain.iterations);
    check_solution(&test);
    problem.plain_iterations = plain.iterations + 1; /* it is done before */
    begin_at_zero(&problem, test.x);
    task.calls = 0;
    assert_int_equal(conjugate_gradients_solve(&problem, test.x, &test.scratch, &corrected),
                     TULLE_OK);
    assert_true(task.calls == 0 && corrected.iterations == plain.iterations);
    free(task.vectors.residual), free(task.vectors.preconditioned);
    nested_aggregates_destroy(&test.system.heap, task.aggregates);
    destroy_test_problem(&test);
}

static void test_double_correction(void **state) {
    (void)state;
    check_double_correction(false);
    check_double_correction(true);
}

int main(void) {
    struct CMUnitTest const tests[] = {
        cmocka_unit_test(test_single_solve),    cmocka_unit_test(test_aggregates),
        cmocka_unit_test(test_late_aggregates), cmocka_unit_test(test_double_correction),
        cmocka_unit_test(test_patience),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
