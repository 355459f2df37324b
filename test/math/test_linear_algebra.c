/* Block matrix and conjugate gradients against dense arithmetic. */
#include "base/hash.h"
#include "base/timer.h"
#include "math/block_matrix.h"
#include "math/kernel_target.h"
#include "math/vec3.h"
#include "support/solve_aim.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { VERTICES = 60, ENTRIES = 3 * VERTICES };

static double random_signed(uint64_t *random) { return 2.0 * random_uniform(random) - 1.0; }

/* A ring with blocks between neighbours and scalars between vertices two and five apart. */
typedef struct ring {
    memory heap;
    block_matrix matrix;
    uint32_t *begin, *columns, *far_begin, *far_columns; /* its patterns */
    double *scalars;
} ring;

static void fill_pattern(size_t count, const int *offsets, int offset_count, uint32_t *begin,
                         uint32_t *columns) {
    uint32_t place = 0;
    for (size_t v = 0; v < count; v++) {
        begin[v] = place;
        for (size_t c = 0; c < count; c++)
            for (int k = 0; k < offset_count; k++)
                if ((v + (size_t)((int)count + offsets[k])) % count == c)
                    columns[place++] = (uint32_t)c;
    }
    begin[count] = place;
}

/* Off-diagonal blocks are symmetric matrices, random; the diagonal dominates by `dominance`. */
static void ring_make(ring *r, size_t count, double dominance) {
    r->heap = memory_default();
    int const near[] = {-1, 0, 1}, far[] = {-5, -2, 2, 5};
    r->begin = malloc((count + 1) * 4), r->columns = malloc(3 * count * 4);
    r->far_begin = malloc((count + 1) * 4), r->far_columns = malloc(4 * count * 4);
    fill_pattern(count, near, 3, r->begin, r->columns);
    fill_pattern(count, far, 4, r->far_begin, r->far_columns);
    assert_int_equal(block_matrix_build(&r->heap, count, (block_pattern){r->begin, r->columns},
                                        (block_pattern){r->far_begin, r->far_columns}, &r->matrix),
                     TULLE_OK);
    uint64_t random = 11;
    block_matrix *const m = &r->matrix;
    r->scalars = malloc(m->scalar_count * sizeof(double));
    m->scalar_parts[0] = m->scalar_parts[1] = r->scalars;
    m->scalar_factors[0] = 0.25, m->scalar_factors[1] = 0.75;
    for (uint32_t v = 0; v < count; v++) {
        uint32_t const other = (uint32_t)((v + 1) % count);
        double *const a = m->values + BLOCK_NUMBERS * (size_t)block_matrix_find(m, v, other);
        double *const b = m->values + BLOCK_NUMBERS * (size_t)block_matrix_find(m, other, v);
        for (int i = 0; i < BLOCK_NUMBERS; i++) a[i] = b[i] = random_signed(&random);
        double *const d = m->values + BLOCK_NUMBERS * (size_t)m->diagonal_positions[v];
        for (int i = 0; i < BLOCK_NUMBERS; i++) {
            bool const is_own = block_places[i] % 4 == 0;
            d[i] = random_signed(&random);
            if (is_own) d[i] = dominance + fabs(d[i]);
        }
        for (uint32_t k = m->scalar_begin[v]; k < m->scalar_begin[v + 1]; k++)
            r->scalars[k] = 0.01 * (double)(v + m->scalar_columns[k]);
    }
}

static void ring_free(ring *r) {
    block_matrix_destroy(&r->heap, &r->matrix);
    free(r->begin), free(r->columns), free(r->far_begin), free(r->far_columns), free(r->scalars);
    assert_int_equal(r->heap.bytes_held, 0);
}

/* Dense copy by reading the storage as documented. */
static void make_dense(const block_matrix *m, double *dense) {
    size_t const n = 3 * m->row_count;
    memset(dense, 0, n * n * sizeof(double));
    for (size_t v = 0; v < m->row_count; v++) {
        for (size_t k = m->row_begin[v]; k < m->row_begin[v + 1]; k++)
            for (size_t i = 0; i < BLOCK_NUMBERS; i++) {
                size_t const row = block_places[i] / 3, column = block_places[i] % 3;
                double const value = m->values[BLOCK_NUMBERS * k + i];
                dense[(3 * v + row) * n + 3 * m->columns[k] + column] += value;
                if (row != column) dense[(3 * v + column) * n + 3 * m->columns[k] + row] += value;
            }
        for (size_t k = m->scalar_begin[v]; k < m->scalar_begin[v + 1]; k++)
            for (size_t i = 0; i < 3; i++)
                dense[(3 * v + i) * n + 3 * m->scalar_columns[k] + i] +=
                    block_matrix_get_scalar(m, k);
    }
}

static void product_equals_dense_product(void **state) {
    (void)state;
    ring r;
    ring_make(&r, VERTICES, 1.0);
    static double dense[ENTRIES * ENTRIES];
    make_dense(&r.matrix, dense);
    double *const x = malloc(ENTRIES * sizeof(double)), *const y = malloc(ENTRIES * sizeof(double));
    uint64_t random = 3;
    for (int i = 0; i < ENTRIES; i++) x[i] = random_signed(&random);
    block_matrix_operator product = {&r.matrix, 1};
    block_matrix_apply(&product, x, y);
    for (size_t i = 0; i < ENTRIES; i++) {
        double sum = 0.0;
        for (size_t j = 0; j < ENTRIES; j++) sum += dense[i * ENTRIES + j] * x[j];
        assert_true(fabs(sum - y[i]) < 1e-13);
    }
    /* the same bits with scalars that are added up beforehand */
    double sums[4 * VERTICES], again[ENTRIES];
    for (size_t k = 0; k < r.matrix.scalar_count; k++)
        sums[k] = block_matrix_get_scalar(&r.matrix, k);
    r.matrix.scalar_sums = sums;
    block_matrix_apply(&product, x, again);
    assert_memory_equal(again, y, sizeof again);
    double diagonal[9 * VERTICES];
    block_matrix_get_diagonal(&r.matrix, diagonal, 2);
    for (size_t v = 0; v < VERTICES; v++)
        for (size_t i = 0; i < 3; i++)
            for (size_t j = 0; j < 3; j++)
                assert_true(diagonal[9 * v + 3 * j + i] ==
                            dense[(3 * v + i) * ENTRIES + 3 * v + j]);
    assert_int_equal(block_matrix_find(&r.matrix, 0, 7), TULLE_NONE);
    free(x), free(y);
    ring_free(&r);
}

/* A term joins the matrix if all pairs of its vertices have blocks; else nothing changes. */
static void terms_join_the_matrix_where_they_fit(void **state) {
    (void)state;
    static double before[ENTRIES * ENTRIES], after[ENTRIES * ENTRIES];
    mat3 const stiffness = {{5.0, 1.0, 2.0, 1.0, 4.0, -1.0, 2.0, -1.0, 3.0}};
    static const struct {
        uint32_t vertices[4];
        bool fits;
    } cases[] = {{{7, TULLE_NONE, TULLE_NONE, TULLE_NONE}, true},
                 {{TULLE_NONE, 8, TULLE_NONE, 7}, true},
                 {{0, TULLE_NONE, VERTICES - 1, TULLE_NONE}, true},
                 {{TULLE_NONE, TULLE_NONE, TULLE_NONE, TULLE_NONE}, true},
                 {{7, 8, 9, TULLE_NONE}, false}, /* 7 and 9 share a scalar alone */
                 {{7, 8, TULLE_NONE, 30}, false}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        ring r;
        ring_make(&r, VERTICES, 1.0);
        make_dense(&r.matrix, before);
        matrix_term term = {.weights = {1.0, -0.25, -0.5, 0.75}, .stiffness = stiffness};
        memcpy(term.vertices, cases[c].vertices, sizeof term.vertices);
        assert_true(block_matrix_add_term(&r.matrix, &term) == cases[c].fits);
        for (size_t i = 0; cases[c].fits && i < 16; i++) {
            uint32_t const row = term.vertices[i / 4], column = term.vertices[i % 4];
            for (size_t k = 0; k < 9 && row != TULLE_NONE && column != TULLE_NONE; k++)
                before[(3 * row + k / 3) * ENTRIES + 3 * column + k % 3] +=
                    term.weights[i / 4] * term.weights[i % 4] * stiffness.m[k];
        }
        make_dense(&r.matrix, after);
        for (size_t i = 0; i < ENTRIES * ENTRIES; i++)
            assert_true(fabs(after[i] - before[i]) <= (cases[c].fits ? 1e-14 : 0.0));
        ring_free(&r);
    }
}

typedef struct solve_input {
    const block_matrix *matrix;
    const double *b;
    const uint8_t *is_fixed;
    double tolerance, reference;
    int max_iterations, threads;
    double *residual;
} solve_input;
/* The norm of the result is over the reference. */
static conjugate_gradients_result solve(solve_input in, double *x) {
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    size_t const count = in.matrix->row_count;
    double *const diagonal = malloc(9 * count * sizeof(double));
    double *const inverse = malloc(BLOCK_NUMBERS * count * sizeof(double));
    double *const residual = malloc(3 * count * sizeof(double));
    block_matrix_get_diagonal(in.matrix, diagonal, 2);
    conjugate_gradients_invert((preconditioner_source){diagonal, in.is_fixed}, count, in.threads,
                               inverse);
    block_matrix_operator context = {in.matrix, in.threads};
    conjugate_gradients_problem problem = {.vertex_count = count,
                                           .apply = block_matrix_apply,
                                           .apply_context = &context,
                                           .right_hand_side = in.b,
                                           .inverse = inverse,
                                           .limit = in.max_iterations,
                                           .residual = in.residual ? in.residual : residual,
                                           .threads = in.threads};
    double const reference = aim_solve(&problem, x, in.tolerance, in.reference, &scratch);
    conjugate_gradients_result result;
    assert_int_equal(conjugate_gradients_solve(&problem, x, &scratch, &result), TULLE_OK);
    if (reference > 0.0) result.norm /= reference;
    uint64_t const heap_calls = heap.allocate_count;
    conjugate_gradients_result again;
    double *const copy = malloc(3 * count * sizeof(double));
    memcpy(copy, x, 3 * count * sizeof(double));
    if (in.residual) memcpy(residual, in.residual, 3 * count * sizeof(double));
    problem.residual = residual;
    assert_int_equal(conjugate_gradients_solve(&problem, copy, &scratch, &again), TULLE_OK);
    assert_int_equal(heap.allocate_count, heap_calls);
    free(copy), free(residual), free(inverse);
    arena_destroy(&scratch);
    free(diagonal);
    return result;
}

/* Gaussian elimination without pivoting on the free unknowns (the matrix is positive definite). */
static void solve_dense(double *a, double *b, const uint8_t *is_fixed, const double *x) {
    size_t const n = ENTRIES;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) {
            if (is_fixed[i / 3])
                a[i * n + j] = i == j;
            else if (is_fixed[j / 3]) {
                b[i] -= a[i * n + j] * x[j];
                a[i * n + j] = 0.0;
            }
        }
    for (size_t i = 0; i < n; i++)
        if (is_fixed[i / 3]) b[i] = x[i];
    for (size_t k = 0; k < n; k++) {
        assert_true(a[k * n + k] > 0.0);
        for (size_t i = k + 1; i < n; i++) {
            double const f = a[i * n + k] / a[k * n + k];
            for (size_t j = k; j < n; j++) a[i * n + j] -= f * a[k * n + j];
            b[i] -= f * b[k];
        }
    }
    for (size_t k = n; k-- > 0;) {
        for (size_t j = k + 1; j < n; j++) b[k] -= a[k * n + j] * b[j];
        b[k] /= a[k * n + k];
    }
}

static void solution_equals_dense_solution(void **state) {
    (void)state;
    ring r;
    ring_make(&r, VERTICES, 9.0);
    static double dense[ENTRIES * ENTRIES];
    for (int fixed_every = 0; fixed_every < 5; fixed_every += 4) {
        make_dense(&r.matrix, dense);
        double b[ENTRIES], x[ENTRIES], expected[ENTRIES];
        uint8_t is_fixed[VERTICES] = {0};
        uint64_t random = 5;
        for (int v = 0; v < VERTICES; v++)
            is_fixed[v] = fixed_every && v % fixed_every == 0 ? 1 : 0;
        for (int i = 0; i < ENTRIES; i++) {
            b[i] = expected[i] = random_signed(&random);
            x[i] = random_signed(&random);
        }
        double start[ENTRIES];
        memcpy(start, x, sizeof x);
        solve_dense(dense, expected, is_fixed, x);
        double few[ENTRIES], residual[ENTRIES];
        memcpy(few, x, sizeof x);
        solve_input const in = {&r.matrix, b, is_fixed, 1e-13, 0.0, 500, 1, NULL};
        solve_input cut = in; /* what five iterations leave is told */
        cut.max_iterations = 5;
        cut.residual = residual;
        solve(cut, few);
        make_dense(&r.matrix, dense);
        for (size_t i = 0; i < ENTRIES; i++) {
            double left = b[i];
            for (size_t j = 0; j < ENTRIES; j++) left -= dense[i * ENTRIES + j] * few[j];
            assert_true(fabs(left - residual[i]) < 1e-13);
        }
        conjugate_gradients_result const result = solve(in, x);
        assert_int_equal(result.end, CONJUGATE_GRADIENTS_CONVERGED);
        assert_true(result.norm <= 1e-13 && result.iterations > 5);
        for (int i = 0; i < ENTRIES; i++) {
            assert_true(fabs(x[i] - expected[i]) < 1e-12);
            if (is_fixed[i / 3]) assert_true(x[i] == start[i]);
        }
        /* The solution as a start needs no iteration. */
        solve_input loose = in;
        loose.tolerance = 1e-10;
        assert_int_equal(solve(loose, x).iterations, 0);
    }
    ring_free(&r);
}

static void ends_are_told_apart(void **state) {
    (void)state;
    ring r;
    ring_make(&r, VERTICES, 9.0);
    double b[ENTRIES], x[ENTRIES] = {0};
    for (int i = 0; i < ENTRIES; i++) b[i] = 1.0 + i % 7;
    solve_input in = {&r.matrix, b, NULL, 1e-12, 0.0, 3, 1, NULL};
    conjugate_gradients_result result = solve(in, x);
    assert_int_equal(result.end, CONJUGATE_GRADIENTS_ITERATION_LIMIT);
    assert_int_equal(result.iterations, 3);
    assert_true(result.norm > 1e-12);
    /* A large reference is met at once. */
    in.reference = 1e15;
    memset(x, 0, sizeof x);
    result = solve(in, x);
    assert_int_equal(result.end, CONJUGATE_GRADIENTS_CONVERGED);
    assert_int_equal(result.iterations, 0);
    /* Zero right-hand side from zero: nothing to do. */
    memset(b, 0, sizeof b);
    in.reference = 0.0;
    result = solve(in, x);
    assert_int_equal(result.end, CONJUGATE_GRADIENTS_CONVERGED);
    for (int i = 0; i < ENTRIES; i++) assert_true(x[i] == 0.0);
    /* Zero right-hand side from elsewhere: goes to zero. */
    for (int i = 0; i < ENTRIES; i++) x[i] = 1.0;
    in.max_iterations = 500;
    result = solve(in, x);
    assert_int_equal(result.end, CONJUGATE_GRADIENTS_CONVERGED);
    for (int i = 0; i < ENTRIES; i++) assert_true(fabs(x[i]) < 1e-10);
    /* Not positive definite, and not a number. */
    for (int i = 0; i < ENTRIES; i++) b[i] = 1.0;
    for (size_t k = 0; k < BLOCK_NUMBERS * r.matrix.block_count; k++) r.matrix.values[k] *= -1.0;
    memset(x, 0, sizeof x);
    assert_int_equal(solve(in, x).end, CONJUGATE_GRADIENTS_NOT_POSITIVE);
    r.matrix.values[40] = NAN;
    assert_int_equal(solve(in, x).end, CONJUGATE_GRADIENTS_NOT_FINITE);
    for (int i = 0; i < ENTRIES; i++) assert_true(isfinite(x[i]));
    ring_free(&r);
}

static void bits_do_not_depend_on_threads_and_widths(void **state) {
    (void)state;
    enum { MANY = 5001 };
    kernel_target const usual = kernel_target_get();
    ring r;
    ring_make(&r, MANY, 60.0 + 2 * 0.02 * MANY * 2);
    double *const b = malloc(3 * MANY * sizeof(double));
    double *const first = calloc(3 * MANY, sizeof(double));
    double *const other = calloc(3 * MANY, sizeof(double));
    for (int i = 0; i < 3 * MANY; i++) b[i] = sin(i * 0.7);
    int iterations = 0;
    for (int k = 0; k < 5 * KERNEL_TARGET_COUNT; k++) {
        int const threads = 1 + k / KERNEL_TARGET_COUNT;
        if (!kernel_target_force((kernel_target)(k % KERNEL_TARGET_COUNT))) continue;
        memset(other, 0, 3 * MANY * sizeof(double));
        solve_input const in = {&r.matrix, b, NULL, 1e-9, 0.0, 500, threads, NULL};
        conjugate_gradients_result const result = solve(in, other);
        assert_int_equal(result.end, CONJUGATE_GRADIENTS_CONVERGED);
        if (k == 0) {
            iterations = result.iterations;
            memcpy(first, other, 3 * MANY * sizeof(double));
        }
        assert_int_equal(result.iterations, iterations);
        assert_memory_equal(first, other, 3 * MANY * sizeof(double));
    }
    assert_true(kernel_target_force(usual));
    free(b), free(first), free(other);
    ring_free(&r);
}

static void failing_memory_is_reported(void **state) {
    (void)state;
    uint32_t const begin[] = {0, 1, 2}, columns[] = {0, 1};
    bool succeeded = false;
    for (size_t limit = 1; !succeeded; limit += 60) {
        memory heap = {.allocator = {.byte_limit = limit}};
        block_matrix matrix;
        tulle_status const status = block_matrix_build(&heap, 2, (block_pattern){begin, columns},
                                                       (block_pattern){NULL, NULL}, &matrix);
        succeeded = status == TULLE_OK;
        if (succeeded)
            block_matrix_destroy(&heap, &matrix);
        else
            assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
        assert_int_equal(heap.bytes_held, 0);
    }
    ring r;
    ring_make(&r, VERTICES, 9.0);
    memory heap = {.allocator = {.byte_limit = 1000}};
    arena scratch = arena_make(&heap);
    double b[ENTRIES] = {1.0}, x[ENTRIES] = {0.5}, diagonal[9 * VERTICES], residual[ENTRIES];
    double inverse[BLOCK_NUMBERS * VERTICES], norm;
    block_matrix_get_diagonal(&r.matrix, diagonal, 2);
    conjugate_gradients_invert((preconditioner_source){.diagonal = diagonal}, VERTICES, 1, inverse);
    block_matrix_operator context = {&r.matrix, 1};
    conjugate_gradients_problem const problem = {.vertex_count = VERTICES,
                                                 .apply = block_matrix_apply,
                                                 .apply_context = &context,
                                                 .right_hand_side = b,
                                                 .inverse = inverse,
                                                 .limit = 9,
                                                 .residual = residual,
                                                 .threads = 1};
    assert_int_equal(conjugate_gradients_measure(&problem, b, &scratch, &norm),
                     TULLE_ERROR_OUT_OF_MEMORY);
    assert_int_equal(conjugate_gradients_leave(&problem, x, &scratch, &norm),
                     TULLE_ERROR_OUT_OF_MEMORY);
    conjugate_gradients_result result;
    assert_int_equal(conjugate_gradients_solve(&problem, x, &scratch, &result),
                     TULLE_ERROR_OUT_OF_MEMORY);
    assert_true(x[0] == 0.5);
    arena_destroy(&scratch);
    ring_free(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(product_equals_dense_product),
        cmocka_unit_test(terms_join_the_matrix_where_they_fit),
        cmocka_unit_test(solution_equals_dense_solution),
        cmocka_unit_test(ends_are_told_apart),
        cmocka_unit_test(bits_do_not_depend_on_threads_and_widths),
        cmocka_unit_test(failing_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
