/* Matrices whose entries lie on few diagonals: which are taken so, and their product in single
 * precision against the one in double precision. */
#include "base/hash.h"
#include "math/block_matrix.h"
#include "math/kernel_target.h"
#include "math/single_solve.h"
#include "support/spring_system.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MOST_OFFSETS = 12 };

/* Offsets above the main diagonal. One in `gaps` entries is missing; 0: none. */
typedef struct band {
    size_t row_count;
    uint32_t blocks[MOST_OFFSETS], scalars[MOST_OFFSETS];
    size_t block_count, scalar_count;
    unsigned gaps;
} band;

typedef struct band_matrix {
    memory heap;
    block_matrix matrix;
    uint32_t *begins[2], *columns[2];
    double *scalars;
} band_matrix;

/* The same for (a, b) and (b, a). */
static bool is_there(const band *given, size_t a, size_t b, uint64_t salt) {
    uint64_t random = (a < b ? a * 7919 + b : b * 7919 + a) * 2654435761U + salt;
    return given->gaps == 0 || random_next(&random) % given->gaps != 0;
}

/* Fills one pattern; the offset 0 is always there in that of blocks. */
static void fill_pattern(const band *given, bool is_scalar, uint32_t *begin, uint32_t *columns) {
    const uint32_t *const offsets = is_scalar ? given->scalars : given->blocks;
    size_t const count = is_scalar ? given->scalar_count : given->block_count;
    begin[0] = 0;
    for (size_t row = 0; row < given->row_count; row++) {
        uint32_t end = begin[row];
        for (size_t column = 0; column < given->row_count; column++) {
            size_t const offset = column > row ? column - row : row - column;
            bool is_on = offset == 0 && !is_scalar;
            for (size_t k = 0; k < count && !is_on; k++)
                is_on = offset == offsets[k] && offset > 0 &&
                        is_there(given, row, column, is_scalar ? 1 : 2);
            if (is_on) columns[end++] = (uint32_t)column;
        }
        begin[row + 1] = end;
    }
}

static band_matrix *make_matrix(const band *given) {
    band_matrix *const made = calloc(1, sizeof *made);
    size_t const n = given->row_count;
    made->heap = memory_default();
    for (int k = 0; k < 2; k++) {
        made->begins[k] = malloc((n + 1) * sizeof(uint32_t));
        made->columns[k] = malloc((2 * MOST_OFFSETS + 1) * n * sizeof(uint32_t));
        fill_pattern(given, k == 1, made->begins[k], made->columns[k]);
    }
    block_matrix *const m = &made->matrix;
    assert_int_equal(block_matrix_build(&made->heap, n,
                                        (block_pattern){made->begins[0], made->columns[0]},
                                        (block_pattern){made->begins[1], made->columns[1]}, m),
                     TULLE_OK);
    made->scalars = calloc(m->scalar_count + 1, sizeof(double));
    for (size_t row = 0; row < n; row++) {
        for (uint32_t k = m->row_begin[row]; k < m->row_begin[row + 1]; k++) {
            size_t const a = row < m->columns[k] ? row : m->columns[k], b = row + m->columns[k];
            uint64_t random = 31 * a + 7 * b + 5;
            for (size_t i = 0; i < BLOCK_NUMBERS; i++)
                m->values[BLOCK_NUMBERS * (size_t)k + i] = random_signed(&random);
        }
        for (uint32_t k = m->scalar_begin[row]; k < m->scalar_begin[row + 1]; k++) {
            uint64_t random = 11 * (row + m->scalar_columns[k]) + 3;
            made->scalars[k] = random_signed(&random);
        }
    }
    m->scalar_sums = made->scalars;
    return made;
}

static void destroy_matrix(band_matrix *made) {
    block_matrix_destroy(&made->heap, &made->matrix);
    for (int k = 0; k < 2; k++) free(made->begins[k]), free(made->columns[k]);
    free(made->scalars), free(made);
}

/* The product of x by the system, in chunks as a solve has them; returns x . product. */
static double multiply(const single_system *system, arena *scratch, const float *x,
                       float *product) {
    size_t const n = system->matrix->row_count;
    single_vectors vectors;
    assert_true(single_vectors_make(system, scratch, &vectors));
    size_t const vertex_step = vectors.vertex_step, number_step = vectors.number_step;
    for (size_t i = 0; i < 3 * n; i++)
        vectors.direction[i / 3 * vertex_step + i % 3 * number_step] = x[i];
    double sum = 0.0;
    for (size_t begin = 0; begin < n; begin += 512) {
        size_t const end = begin + 512 < n ? begin + 512 : n;
        sum += (double)single_system_multiply(system, &vectors, begin, end);
    }
    for (size_t i = 0; i < 3 * n; i++)
        product[i] = vectors.product[i / 3 * vertex_step + i % 3 * number_step];
    return sum;
}

/* The product by diagonals, with terms, equals that of a copy in double precision; all widths and
 * numbers of threads give the same bits. */
static void check_product(const band *given) {
    band_matrix *const made = make_matrix(given);
    block_matrix *const m = &made->matrix;
    size_t const n = m->row_count, size = 3 * n;
    assert_true(m->diagonals.count > 0);
    double *const x = calloc(size, sizeof(double)), *const plain = calloc(size, sizeof(double));
    float *const direction = calloc(size + 64, sizeof(float));
    float *const product = calloc(size + 64, sizeof(float));
    float *const first = calloc(size, sizeof(float));
    uint64_t random = n;
    for (size_t i = 0; i < size; i++) {
        direction[i] = (float)random_signed(&random);
        x[i] = (double)direction[i];
    }
    matrix_term terms[3], others[3]; /* others: of a round before */
    mat3 const stiffness = mat3_outer((vec3){1.0, 2.0, -0.5}, (vec3){1.0, 2.0, -0.5}, 3.0);
    size_t term_count = 0;
    for (; term_count < 3 && given->gaps == 0 && n > 9; term_count++)
        terms[term_count] = (matrix_term){.stiffness = stiffness,
                                          .weights = {1.0, -0.5, 0.25},
                                          .vertices = {3 + (uint32_t)term_count,
                                                       3 + (uint32_t)term_count + given->blocks[0],
                                                       TULLE_NONE, TULLE_NONE}};
    for (size_t t = 0; t < term_count; t++) {
        others[t] = terms[t];
        for (size_t k = 0; k < 2; k++)
            others[t].vertices[k] = (uint32_t)n - 1 - terms[t].vertices[k];
        others[t].weights[0] = -3.0;
    }
    arena scratch = arena_make(&made->heap);
    kernel_target const usual = kernel_target_get();
    int checks = 0;
    double first_sum = 0.0;
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        for (int threads = 1; threads <= 3; threads += 2) {
            arena_mark const mark = arena_get_mark(&scratch);
            single_system system;
            assert_true(single_system_make(m, &scratch, &system));
            for (int round = 0; round < 2; round++) /* the second one takes the first one's out */
                assert_true(single_system_set_terms(&system, round == 0 ? others : terms,
                                                    term_count, threads, &scratch));
            assert_ptr_equal(system.diagonals.pattern, &m->diagonals);
            assert_int_equal(system.apart_count, 0);
            double const sum = multiply(&system, &scratch, direction, product);
            if (checks++ == 0) memcpy(first, product, size * sizeof(float)), first_sum = sum;
            assert_memory_equal(first, product, size * sizeof(float));
            assert_true(sum == first_sum);
            arena_release(&scratch, mark);
        }
    }
    assert_true(checks >= 2);
    kernel_target_force(usual);
    for (size_t t = 0; t < term_count; t++) assert_true(block_matrix_add_term(m, &terms[t]));
    block_matrix_apply(&(block_matrix_operator){m, 1}, x, plain);
    double dot = 0.0;
    for (size_t i = 0; i < size; i++) {
        assert_true(fabs((double)first[i] - plain[i]) < 1e-5);
        dot += x[i] * plain[i];
    }
    assert_true(fabs(first_sum - dot) < 1e-5 * (double)size);
    arena_destroy(&scratch);
    free(x), free(plain), free(direction), free(product), free(first);
    destroy_matrix(made);
}

static void products_agree(void **state) {
    (void)state;
    static const size_t counts[] = {111, 112, 113, 120, 511, 512, 513, 700, 1040};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        for (unsigned gaps = 0; gaps <= 4; gaps += 4) {
            /* scalars also where blocks are, and in gaps of them */
            check_product(&(band){counts[i], {1, 8, 9}, {2, 8, 10, 17}, 3, 4, gaps});
            check_product(&(band){counts[i], {1}, {0}, 1, 0, gaps});
        }
}

/* A grid is taken by diagonals; what has too many, or hardly filled ones, by rows. */
static void only_full_diagonals_are_taken(void **state) {
    (void)state;
    static const struct {
        band given;
        size_t block_count, count;
    } cases[] = {
        {{400, {1, 20, 21}, {2, 19, 22, 40, 41, 42}, 3, 6, 0}, 4, 10},
        {{400, {1, 20, 21}, {2, 20, 42}, 3, 3, 3}, 4, 6}, /* one diagonal has both */
        {{400, {1, 20, 21}, {2}, 3, 1, 0}, 4, 5},
        {{400, {1, 20, 21}, {399}, 3, 1, 0}, 0, 0}, /* zeros beyond the ends take too much */
        {{400, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, {0}, 10, 0, 0}, 0, 0},
        {{400, {100, 120, 140, 160, 180}, {200, 220, 250, 280, 300, 320, 340}, 5, 7, 0}, 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        band_matrix *const made = make_matrix(&cases[i].given);
        const matrix_diagonals *const diagonals = &made->matrix.diagonals;
        assert_int_equal(diagonals->block_count, cases[i].block_count);
        assert_int_equal(diagonals->count, cases[i].count);
        for (size_t row = 0; row < made->matrix.row_count && diagonals->count > 0; row++)
            for (uint32_t k = made->begins[1][row]; k < made->begins[1][row + 1]; k++) {
                uint32_t const column = made->columns[1][k];
                if (column < row)
                    assert_int_equal(diagonals->of_scalars[k], NO_DIAGONAL);
                else
                    assert_int_equal(diagonals->offsets[diagonals->of_scalars[k]], column - row);
            }
        destroy_matrix(made);
    }
    spring_system grid = spring_system_make(spring_graph_make_grid(20, 30, true), 10.0, 1);
    assert_true(grid.matrix.diagonals.count > 0);
    spring_system_destroy(&grid);
    spring_system other = spring_system_make(spring_graph_make_random(300, 900, 5), 10.0, 1);
    assert_int_equal(other.matrix.diagonals.count, 0);
    spring_system_destroy(&other);
}

/* Rows of chunks that are idle count as zero, whatever the memory held. */
static void idle_rows_give_nothing(void **state) {
    (void)state;
    band const given = {1100, {1, 30, 31}, {2, 60}, 3, 2, 0};
    band_matrix *const made = make_matrix(&given);
    uint8_t *const is_idle = calloc(given.row_count, 1);
    memset(is_idle, 1, 512);
    made->matrix.is_idle = is_idle;
    arena scratch = arena_make(&made->heap);
    arena_mark const mark = arena_get_mark(&scratch);
    memset(ARENA_NEW(&scratch, float, 200000), 0xff, 200000 * sizeof(float)); /* NaN */
    arena_release(&scratch, mark);
    single_system system;
    assert_true(single_system_make(&made->matrix, &scratch, &system) &&
                single_system_set_terms(&system, NULL, 0, 2, &scratch));
    float *const x = calloc(3 * given.row_count + 64, sizeof(float));
    float *const product = calloc(3 * given.row_count + 64, sizeof(float));
    for (size_t i = 0; i < 3 * given.row_count; i++) x[i] = 1.0F;
    assert_true(isfinite(multiply(&system, &scratch, x, product)));
    for (size_t i = 0; i < 3 * (512 - 60); i++) assert_true(product[i] == 0.0F);
    for (size_t i = 0; i < 3 * given.row_count; i++) assert_true(isfinite(product[i]));
    arena_destroy(&scratch);
    free(x), free(product), free(is_idle);
    destroy_matrix(made);
}

/* Steps of conjugate gradients in planes have the bits of those in rows. */
static void steps_agree(void **state) {
    (void)state;
    static const size_t counts[] = {1, 3, 15, 16, 17, 100, 515};
    enum { MOST = 515, PARENTS = 9 };
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        size_t const n = counts[i];
        memory heap = memory_default();
        arena scratch = arena_make(&heap);
        block_matrix const rows = {.row_count = n};
        matrix_diagonals const pattern = {.block_count = 1, .count = 1};
        size_t const stride = 16 + (n / 16 + 1) * 16 + 16;
        single_system const systems[2] = {
            {.matrix = &rows},
            {.matrix = &rows, .diagonals = {.pattern = &pattern, .reach = 16, .stride = stride}}};
        static uint32_t parents[MOST];
        static uint8_t is_fixed[MOST];
        float values[3 * PARENTS + SINGLE_PADDING] = {0.0F};
        uint64_t random = n;
        for (size_t k = 0; k < 3 * PARENTS; k++) values[k] = (float)random_signed(&random);
        for (size_t v = 0; v < n; v++) {
            parents[v] = (uint32_t)(random_next(&random) % PARENTS);
            is_fixed[v] = random_next(&random) % 4 == 0;
        }
        single_correction const correction = {values, parents, is_fixed};
        nested_aggregates const aggregates = {
            .level_count = 1,
            .levels[0] = {.parents = parents, .correction = values},
            .is_fixed = is_fixed};
        single_vectors all[2];
        for (int way = 0; way < 2; way++) {
            single_vectors *const v = &all[way];
            assert_true(single_vectors_make(&systems[way], &scratch, v));
            float *const vectors[] = {v->x, v->residual, v->direction, v->product};
            random = n + 1;
            for (size_t k = 0; k < 4 * 3 * n; k++) {
                size_t const at = k % (3 * n);
                vectors[k / (3 * n)][at / 3 * v->vertex_step + at % 3 * v->number_step] =
                    (float)random_signed(&random);
            }
            for (size_t k = 0; k < 6 * n; k++)
                v->inverse[k / 6 * v->inverse_step + k % 6 * v->number_step] =
                    (float)random_signed(&random);
            double const dot = (double)single_system_advance(&systems[way], v, 0.37F, 0, n);
            double expected = 0.0;
            for (size_t k = 0; k < 3 * n; k++) {
                size_t const at = k / 3 * v->vertex_step + k % 3 * v->number_step;
                expected += (double)v->residual[at] * (double)v->preconditioned[at];
            }
            assert_true(fabs(dot - expected) < 1e-5 * (double)n);
            if (way == 0) { /* once with a correction by either way */
                TULLE_PICK_KERNEL(single_turn_corrected)(v, &correction, -0.6F, 0, n);
                nested_aggregates_add(&aggregates, v, 0, n);
            } else {
                nested_aggregates_add(&aggregates, v, 0, n);
                TULLE_PICK_KERNEL(diagonal_turn)(v, -0.6F, 0, n);
            }
            single_system_turn(&systems[way], v, 0.8F, 0, n); /* without aggregates */
        }
        for (size_t k = 0; k < 3 * n; k++) {
            size_t const at = k / 3 + k % 3 * all[1].number_step;
            assert_true(all[0].x[k] == all[1].x[at]);
            assert_true(all[0].residual[k] == all[1].residual[at]);
            assert_true(all[0].preconditioned[k] == all[1].preconditioned[at]);
            assert_true(all[0].direction[k] == all[1].direction[at]);
        }
        arena_destroy(&scratch);
    }
}

int main(void) {
    struct CMUnitTest const tests[] = {
        cmocka_unit_test(products_agree),
        cmocka_unit_test(steps_agree),
        cmocka_unit_test(only_full_diagonals_are_taken),
        cmocka_unit_test(idle_rows_give_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
