/* Kernels of conjugate gradients in double precision against plain loops that add in the order that
 * the kernels promise: every width gives their bits, in rows and runs of any length, and writes
 * nothing else. */
#include "base/hash.h"
#include "math/advance_kernel.h"
#include "math/block_matrix.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MOST_VERTICES = 600, MOST_BLOCKS = 12, MOST_SCALARS = 23, VECTORS = 5 };

static double random_signed(uint64_t *random) { return 2.0 * random_uniform(random) - 1.0; }

static double *make_numbers(size_t count, uint64_t *random) {
    double *const numbers = malloc(count * sizeof *numbers + 1);
    assert_non_null(numbers);
    for (size_t i = 0; i < count; i++) numbers[i] = random_signed(random);
    return numbers;
}

/* ---- the product ---- */

/* Ascending columns of a row: `own` and some others, up to `most`. */
static uint32_t choose_columns(size_t count, uint32_t own, size_t most, uint64_t *random,
                               uint32_t *columns) {
    uint32_t chosen = 0;
    size_t left = most > 0 ? random_next(random) % (most + 1) : 0; /* besides its own */
    for (uint32_t c = 0; c < count; c++) {
        bool const is_last = c + 1 == count && left > 0 && random_next(random) % 2 == 0;
        bool const is_taken = left > 0 && random_next(random) % count < 2 * most;
        if (c != own && !is_taken && !is_last) continue;
        left -= c != own;
        columns[chosen++] = c;
    }
    return chosen;
}

/* sum_k s_k x_k with even and odd entries apart, of one number of each vertex. */
static double add_scalars_plainly(const block_matrix *m, size_t row, const double *x, size_t i) {
    double sums[2] = {0.0, 0.0};
    for (size_t k = m->scalar_begin[row]; k < m->scalar_begin[row + 1]; k++)
        sums[(k - m->scalar_begin[row]) % 2] +=
            block_matrix_get_scalar(m, k) * x[3 * (size_t)m->scalar_columns[k] + i];
    return sums[0] + sums[1];
}

static void multiply_plainly(const block_matrix *m, const double *x, double *result) {
    static const size_t places[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    for (size_t row = 0; row < m->row_count; row++)
        for (size_t i = 0; i < 3; i++) {
            double sums[3] = {0.0, 0.0, 0.0}; /* by column of the blocks */
            for (size_t k = m->row_begin[row]; k < m->row_begin[row + 1]; k++)
                for (size_t j = 0; j < 3; j++)
                    sums[j] += m->values[BLOCK_NUMBERS * k + places[i][j]] *
                               x[3 * (size_t)m->columns[k] + j];
            result[3 * row + i] =
                (sums[0] + sums[1]) + (sums[2] + add_scalars_plainly(m, row, x, i));
        }
}

/* The matrix need not be symmetric for this. */
static void check_product(size_t count, uint64_t *random) {
    memory heap = memory_default();
    uint32_t *const begin = malloc((count + 1) * 4), *const far_begin = malloc((count + 1) * 4);
    uint32_t *const columns = malloc(count * (MOST_BLOCKS + 1) * 4);
    uint32_t *const far = malloc(count * (MOST_SCALARS + 1) * 4);
    assert_true(begin && far_begin && columns && far);
    begin[0] = far_begin[0] = 0;
    for (uint32_t row = 0; row < count; row++) {
        begin[row + 1] =
            begin[row] + choose_columns(count, row, MOST_BLOCKS, random, columns + begin[row]);
        size_t const most = random_next(random) % 3 == 0 ? 0 : MOST_SCALARS;
        uint32_t const own = random_next(random) % 2 ? row : UINT32_MAX; /* may have no scalars */
        far_begin[row + 1] =
            far_begin[row] + choose_columns(count, own, most, random, far + far_begin[row]);
    }
    block_matrix m;
    assert_int_equal(block_matrix_build(&heap, count, (block_pattern){begin, columns},
                                        (block_pattern){far_begin, far}, &m),
                     TULLE_OK);
    for (size_t i = 0; i < BLOCK_NUMBERS * m.block_count; i++) m.values[i] = random_signed(random);
    double *const parts[2] = {make_numbers(m.scalar_count, random),
                              make_numbers(m.scalar_count, random)};
    double *const sums = make_numbers(m.scalar_count, random);
    for (int k = 0; k < 2; k++) m.scalar_parts[k] = parts[k];
    m.scalar_factors[0] = 0.3, m.scalar_factors[1] = -1.7;
    for (size_t k = 0; k < m.scalar_count; k++) sums[k] = block_matrix_get_scalar(&m, k);
    double *const x = make_numbers(3 * count, random);
    double *const plain = make_numbers(3 * count, random);
    double *const result = malloc(3 * count * sizeof(double)); /* not a number more */
    assert_non_null(result);
    multiply_plainly(&m, x, plain);
    for (int threads = 1; threads <= 3; threads += 2)
        for (int has_sums = 0; has_sums < 2; has_sums++) {
            m.scalar_sums = has_sums ? sums : NULL;
            memset(result, 0, 3 * count * sizeof(double));
            block_matrix_apply(&(block_matrix_operator){&m, threads}, x, result);
            assert_memory_equal(result, plain, 3 * count * sizeof(double));
        }
    free(x), free(plain), free(result), free(sums), free(parts[0]), free(parts[1]);
    free(begin), free(far_begin), free(columns), free(far);
    block_matrix_destroy(&heap, &m);
}

static void rows_are_added_in_one_order(void **state) {
    (void)state;
    static const size_t counts[] = {1, 2, 3, 10, 100, 255, 256, 257, MOST_VERTICES};
    kernel_target const usual = kernel_target_get();
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        uint64_t random = 17;
        for (int round = 0; round < 3; round++)
            for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++)
                check_product(counts[i], &random);
    }
    assert_true(kernel_target_force(usual));
}

/* ---- the step along a direction ---- */

static double advance_plainly(const advance_vectors *v, double alpha, size_t begin, size_t end) {
    for (size_t i = 3 * begin; i < 3 * end; i++) {
        v->x[i] += alpha * v->direction[i];
        v->residual[i] -= alpha * v->product[i];
    }
    for (size_t k = begin; k < end; k++)
        vec3_store(v->preconditioned, k,
                   block_multiply(v->inverse + BLOCK_NUMBERS * k, vec3_load(v->residual, k)));
    double sums[4] = {0.0, 0.0, 0.0, 0.0}, rest = 0.0;
    size_t const first = 3 * begin, whole = first + (3 * end - first) / 4 * 4;
    for (size_t i = first; i < whole; i++)
        sums[(i - first) % 4] += v->residual[i] * v->preconditioned[i];
    for (size_t i = whole; i < 3 * end; i++) rest += v->residual[i] * v->preconditioned[i];
    return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + rest;
}

static void check_advance(size_t begin, size_t end, size_t count, uint64_t *random) {
    size_t const size = 3 * count, bytes = size * sizeof(double);
    double *vectors[2][VECTORS];
    double *const inverse = make_numbers(BLOCK_NUMBERS * count, random);
    for (int k = 0; k < VECTORS; k++) {
        vectors[0][k] = make_numbers(size, random);
        vectors[1][k] = malloc(bytes);
        assert_non_null(vectors[1][k]);
        memcpy(vectors[1][k], vectors[0][k], bytes);
    }
    double sums[2];
    for (int way = 0; way < 2; way++) {
        double *const *const of = vectors[way];
        advance_vectors const v = {of[0], of[1], of[2], of[3], of[4], inverse};
        sums[way] = way == 0 ? advance_plainly(&v, 0.37, begin, end)
                             : TULLE_PICK_KERNEL(advance_along)(&v, 0.37, begin, end);
    }
    assert_memory_equal(&sums[0], &sums[1], sizeof sums[0]);
    for (int k = 0; k < VECTORS; k++) {
        assert_memory_equal(vectors[0][k], vectors[1][k], bytes); /* beyond begin and end, too */
        free(vectors[0][k]), free(vectors[1][k]);
    }
    free(inverse);
}

static void steps_are_added_in_one_order(void **state) {
    (void)state;
    kernel_target const usual = kernel_target_get();
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        uint64_t random = 19;
        for (size_t begin = 0; begin < 4; begin++)
            for (size_t length = 1; length < 40; length++)
                for (size_t behind = 0; behind < 2; behind++)
                    check_advance(begin, begin + length, begin + length + behind, &random);
    }
    assert_true(kernel_target_force(usual));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(rows_are_added_in_one_order),
                                       cmocka_unit_test(steps_are_added_in_one_order)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
