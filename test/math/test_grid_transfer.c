/* The first level of nested aggregates over a grid: which matrices have one, its weights against
 * means over neighbours, its matrix against a dense product, and its cycle against one in double
 * precision, for sheets of many sizes, holes, fixed vertices and stiff terms. */
#include "base/hash.h"
#include "math/kernel_target.h"
#include "math/vec3.h"
#include "support/dense_levels.h"
#include "support/failing_heap.h"
#include "support/spring_system.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- P ---- */

/* P by its definition: of each vertex the blocks with a weight. */
typedef struct dense_transfer {
    size_t count, block_count; /* vertices, blocks */
    size_t (*blocks)[4];
    double (*weights)[4]; /* 0 where there are fewer than four */
} dense_transfer;

/* The block of a line. */
static size_t find_block(const grid_axis *axis, size_t line) {
    size_t block = 0;
    while (axis->begin[block + 1] <= line) block++;
    return block;
}

/* The share of a line's neighbours and itself that are in a block; none is of another sheet. */
static double find_share(const grid_axis *axis, size_t line, size_t block, size_t sheet_size) {
    size_t count = 0, inside = 0;
    for (size_t other = line > 0 ? line - 1 : 0; other < axis->count && other <= line + 1; other++)
        if (other / sheet_size == line / sheet_size) {
            count++;
            inside += find_block(axis, other) == block;
        }
    return (double)inside / (double)count;
}

/* Blocks of an axis are a partition of its lines and have four to seven of them, or all of a sheet.
 * Their weights are those of the definition. */
static void check_axis(const grid_axis *axis, size_t sheet_size) {
    assert_int_equal(axis->begin[0], 0);
    assert_int_equal(axis->begin[axis->block_count], axis->count);
    for (size_t b = 0; b < axis->block_count; b++) {
        size_t const first = axis->begin[b], end = axis->begin[b + 1];
        assert_true(first < end && first / sheet_size == (end - 1) / sheet_size);
        assert_in_range(end - first, sheet_size < 4 ? sheet_size : 4, 7);
    }
    for (size_t line = 0; line < axis->count; line++) {
        double sum = 0.0;
        for (size_t b = 0; b < axis->block_count; b++) {
            bool const has_part = grid_axis_has_part(axis, line, b);
            double const part = has_part ? grid_axis_get_part(axis, line, b) : 0.0;
            assert_true(fabs(part - find_share(axis, line, b, sheet_size)) < 1e-7);
            line_range const range = grid_axis_get_lines(axis, b);
            assert_true(part == 0.0 || (line >= range.first && line < range.end));
            sum += part;
        }
        assert_true(fabs(sum - 1.0) < 1e-7);
    }
}

static dense_transfer make_transfer(const grid_transfer *grid, const spring_sheets *sheets) {
    const grid_axis *const rows = &grid->rows, *const columns = &grid->columns;
    dense_transfer transfer = {.count = rows->count * columns->count,
                               .block_count = rows->block_count * columns->block_count};
    transfer.blocks = calloc(transfer.count, sizeof *transfer.blocks);
    transfer.weights = calloc(transfer.count, sizeof *transfer.weights);
    assert_true(transfer.blocks && transfer.weights);
    for (size_t v = 0; v < transfer.count; v++) {
        size_t found = 0;
        for (size_t k = 0; k < rows->block_count; k++) {
            double const part = find_share(rows, v / columns->count, k, sheets->rows);
            for (size_t b = 0; b < columns->block_count && part > 0.0; b++) {
                double const share = find_share(columns, v % columns->count, b, columns->count);
                if (share == 0.0) continue;
                assert_true(found < 4);
                transfer.blocks[v][found] = k * columns->block_count + b;
                transfer.weights[v][found++] = part * share;
            }
        }
    }
    return transfer;
}

static void destroy_transfer(const dense_transfer *transfer) {
    free(transfer->blocks), free(transfer->weights);
}

/* ---- P^T A P ---- */

/* Adds a term as blocks count it. */
static void add_term(const nested_aggregates *all, const dense_transfer *transfer,
                     const matrix_term *term, const dense_level *dense) {
    double *const weights = calloc(dense->count, sizeof(double));
    bool *const is_in = calloc(dense->count, sizeof(bool)), is_joined = true;
    for (size_t k = 0; k < 4; k++) {
        uint32_t const v = term->vertices[k];
        for (size_t n = 0; n < 4 && v != TULLE_NONE && !all->is_fixed[v]; n++) {
            weights[transfer->blocks[v][n]] += term->weights[k] * transfer->weights[v][n];
            is_in[transfer->blocks[v][n]] |= transfer->weights[v][n] > 0.0;
        }
    }
    for (uint32_t a = 0; a < dense->count; a++)
        for (uint32_t b = 0; b < dense->count && is_in[a]; b++)
            is_joined &= !is_in[b] || nested_aggregates_find(&all->levels[0], a, b) != TULLE_NONE;
    for (uint32_t a = 0; a < dense->count; a++)
        for (uint32_t b = 0; b < dense->count && is_in[a]; b++)
            for (size_t i = 0; i < 9 && is_in[b] && (is_joined || a == b); i++)
                *dense_level_get(dense, a, b, i / 3, i % 3) +=
                    weights[a] * weights[b] * term->stiffness.m[i];
    free(weights), free(is_in);
}

/* P^T A P of the whole matrix, and terms. */
static dense_level make_first(const spring_system *system, const spring_matrix *matrix,
                              const nested_aggregates *all, const dense_transfer *transfer) {
    dense_level const dense = dense_level_make(transfer->block_count);
    size_t const count = transfer->count;
    double *const x = malloc(3 * count * sizeof(double)), *const y = malloc(3 * count * sizeof *x);
    spring_matrix const none = {NULL, 0};
    for (size_t b = 0; b < dense.count; b++)
        for (size_t axis = 0; axis < 3; axis++) {
            memset(x, 0, 3 * count * sizeof(double));
            for (size_t v = 0; v < count; v++)
                for (size_t n = 0; n < 4 && !system->is_fixed[v]; n++)
                    if (transfer->blocks[v][n] == b) x[3 * v + axis] += transfer->weights[v][n];
            spring_system_multiply(system, &none, x, y);
            for (size_t v = 0; v < count; v++)
                for (size_t n = 0; n < 4 && !system->is_fixed[v]; n++)
                    for (size_t i = 0; i < 3; i++)
                        *dense_level_get(&dense, transfer->blocks[v][n], b, i, axis) +=
                            transfer->weights[v][n] * y[3 * v + i];
        }
    for (size_t t = 0; t < matrix->term_count; t++)
        add_term(all, transfer, &matrix->terms[t], &dense);
    dense_level_invert(&dense);
    free(x), free(y);
    return dense;
}

/* Entries join each block to itself and to those around it. Nothing of the dense matrix is left
 * out. */
static void check_pattern(const nested_aggregates *all, const dense_level *dense) {
    size_t const columns = all->grid->columns.block_count;
    double const largest = dense_level_find_largest(dense);
    for (uint32_t a = 0; a < dense->count; a++)
        for (uint32_t b = 0; b < dense->count; b++) {
            bool const is_near = labs((long)(a / columns) - (long)(b / columns)) <= 1 &&
                                 labs((long)(a % columns) - (long)(b % columns)) <= 1;
            assert_true((nested_aggregates_find(&all->levels[0], a, b) != TULLE_NONE) == is_near);
            for (size_t i = 0; i < 9 && !is_near; i++)
                assert_true(fabs(*dense_level_get(dense, a, b, i / 3, i % 3)) <= 1e-13 * largest);
        }
}

/* The diagonals have the numbers of the dense matrix, and zeros where a block has no neighbour. */
static void check_planes(const grid_transfer *grid, const dense_level *dense) {
    static const int ways[GRID_DIAGONALS][2] = {{0, 0}, {0, 1}, {1, -1}, {1, 0}, {1, 1}};
    size_t const columns = grid->columns.block_count, rows = grid->rows.block_count;
    size_t const stride = grid->matrix.stride;
    double const largest = dense_level_find_largest(dense);
    for (size_t a = 0; a < dense->count; a++) {
        for (size_t d = 0; d < GRID_DIAGONALS; d++) {
            size_t const row = a / columns + (size_t)ways[d][0];
            size_t const column = a % columns + (size_t)ways[d][1];
            size_t const b = row * columns + column;
            for (size_t i = 0; i < BLOCK_NUMBERS; i++) {
                float const value = grid->matrix.planes[(BLOCK_NUMBERS * d + i) * stride + a];
                if (row >= rows || column >= columns) {
                    assert_true(value == 0.0F);
                    continue;
                }
                double const expected =
                    *dense_level_get(dense, a, b, block_places[i] / 3, block_places[i] % 3);
                assert_true(fabs((double)value - expected) <= 1e-6 * largest);
            }
        }
        double most = 0.0;
        for (size_t i = 0; i < 9; i++) most = fmax(most, fabs(dense->inverse[9 * a + i]));
        for (size_t i = 0; i < BLOCK_NUMBERS; i++)
            assert_true(fabs((double)grid->vectors.inverse[i * stride + a] -
                             0.5 * dense->inverse[9 * a + block_places[i]]) <= 1e-4 * most);
    }
}

/* ---- vectors ---- */

/* Zeros in planes. */
static single_vectors make_vectors(size_t count) {
    size_t const step = count + SINGLE_PADDING;
    single_vectors const vectors = {.residual = calloc(3 * step, sizeof(float)),
                                    .preconditioned = calloc(3 * step, sizeof(float)),
                                    .vertex_step = 1,
                                    .number_step = step};
    assert_true(vectors.residual && vectors.preconditioned);
    return vectors;
}

static void destroy_vectors(const single_vectors *vectors) {
    free(vectors->residual), free(vectors->preconditioned);
}

static void fill_randomly(float *planes, size_t number_step, size_t count, uint64_t seed) {
    for (size_t v = 0; v < count; v++)
        for (size_t i = 0; i < 3; i++) planes[v + i * number_step] = (float)random_signed(&seed);
}

/* P^T r */
static double *restrict_vectors(const nested_aggregates *all, const dense_transfer *transfer,
                                const single_vectors *vectors) {
    double *const sums = calloc(3 * transfer->block_count, sizeof(double));
    assert_non_null(sums);
    for (size_t v = 0; v < transfer->count; v++)
        for (size_t n = 0; n < 4 && !all->is_fixed[v]; n++)
            for (size_t i = 0; i < 3; i++)
                sums[3 * transfer->blocks[v][n] + i] +=
                    transfer->weights[v][n] *
                    (double)vectors->residual[v + i * vectors->number_step];
    return sums;
}

/* What a cycle found for a block. */
static double get_found(const nested_aggregates *all, size_t block, size_t i) {
    const single_vectors *const found = &all->grid->vectors;
    return (double)found->preconditioned[block + i * found->number_step];
}

/* residual . P z */
static double multiply_found(const nested_aggregates *all, const double *sums) {
    double dot = 0.0;
    for (size_t i = 0; i < 3 * all->levels[0].count; i++)
        dot += get_found(all, i / 3, i % 3) * sums[i];
    return dot;
}

/* ---- the cycle ---- */

/* The correction is that of a cycle in double precision; with another residual it tells that the
 * cycle is symmetric. */
static void check_cycle(nested_aggregates *all, const dense_level *dense,
                        const dense_transfer *transfer) {
    size_t const size = 3 * transfer->block_count;
    single_vectors const first = make_vectors(transfer->count);
    single_vectors const second = make_vectors(transfer->count);
    fill_randomly(first.residual, first.number_step, transfer->count, 5);
    fill_randomly(second.residual, second.number_step, transfer->count, 6);
    double *const sums = restrict_vectors(all, transfer, &first);
    double *const others = restrict_vectors(all, transfer, &second);
    double *const expected = calloc(size, sizeof(double)), scale = 0.0, dot = 0.0;
    dense_levels_run_cycle(all, dense, 0, sums, expected);
    double const found = nested_aggregates_correct(all, &first, 1);
    for (size_t i = 0; i < size; i++) {
        scale = fmax(scale, fabs(expected[i]));
        dot += expected[i] * sums[i];
    }
    for (size_t i = 0; i < size; i++)
        assert_true(fabs(get_found(all, i / 3, i % 3) - expected[i]) <= 1e-4 * scale);
    assert_true(found >= 0.0 && fabs(found - dot) <= 1e-4 * dot);
    assert_true(fabs(found - multiply_found(all, sums)) <= 1e-5 * found);
    double const across = multiply_found(all, others);
    double const found_for_other = nested_aggregates_correct(all, &second, 1);
    assert_true(found_for_other >= 0.0);
    assert_true(fabs(across - multiply_found(all, sums)) <= 1e-4 * sqrt(found * found_for_other));
    free(expected), free(sums), free(others);
    destroy_vectors(&first), destroy_vectors(&second);
}

/* P z, which is 0 at fixed vertices. */
static double find_correction(const nested_aggregates *all, const dense_transfer *transfer,
                              size_t vertex, size_t i) {
    double sum = 0.0;
    for (size_t n = 0; n < 4 && !all->is_fixed[vertex]; n++)
        sum += transfer->weights[vertex][n] * get_found(all, transfer->blocks[vertex][n], i);
    return sum;
}

/* Vertices begin .. end - 1 get their correction, fixed ones and all others nothing. */
static void check_part(const nested_aggregates *all, const dense_transfer *transfer, size_t begin,
                       size_t end) {
    single_vectors const vectors = make_vectors(transfer->count);
    size_t const step = vectors.number_step;
    double largest = 0.0;
    for (size_t i = 0; i < 3 * transfer->block_count; i++)
        largest = fmax(largest, fabs(get_found(all, i / 3, i % 3)));
    float *const before = vectors.residual, *const after = vectors.preconditioned;
    uint64_t random = begin + end;
    for (size_t k = 0; k < 3 * step; k++) before[k] = (float)(largest * random_signed(&random));
    memcpy(after, before, 3 * step * sizeof(float));
    nested_aggregates_add(all, &vectors, begin, end);
    for (size_t k = 0; k < 3 * step; k++) {
        size_t const v = k % step;
        if (v < begin || v >= end || all->is_fixed[v]) {
            assert_true(before[k] == after[k]);
            continue;
        }
        double const expected = (double)before[k] + find_correction(all, transfer, v, k / step);
        assert_true(fabs((double)after[k] - expected) <= 1e-6 * largest);
    }
    destroy_vectors(&vectors);
}

static void check_parts(const nested_aggregates *all, const dense_transfer *transfer) {
    static const size_t sizes[] = {1, 15, 16, 17, 111, 512};
    size_t const count = transfer->count;
    check_part(all, transfer, 0, count);
    check_part(all, transfer, count / 2, count / 2);
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (size_t k = 0; k < 4; k++) {
            size_t const begin = k < 2 ? k * sizes[s] : count * k / 4 + s;
            if (begin >= count) continue;
            size_t const end = begin + sizes[s] < count ? begin + sizes[s] : count;
            check_part(all, transfer, begin, end);
        }
}

/* ---- bits ---- */

/* Sets the numbers and corrects in chunks as a solve has them; returns the dot. */
static double correct(nested_aggregates *all, const aggregated_system *given,
                      const single_vectors *vectors, int threads, arena *scratch) {
    assert_true(nested_aggregates_set(all, given, threads, scratch));
    double const dot = nested_aggregates_correct(all, vectors, threads);
    memset(vectors->preconditioned, 0, 3 * vectors->number_step * sizeof(float));
    for (size_t begin = 0; begin < all->vertex_count; begin += 512)
        nested_aggregates_add(all, vectors, begin,
                              begin + 512 < all->vertex_count ? begin + 512 : all->vertex_count);
    return dot;
}

/* The same bits for every width and number of threads, and whatever fixed vertices have. */
static void check_bits(nested_aggregates *all, const aggregated_system *given, arena *scratch) {
    size_t const count = all->vertex_count;
    single_vectors const first = make_vectors(count), vectors = make_vectors(count);
    size_t const size = 3 * first.number_step * sizeof(float);
    fill_randomly(first.residual, first.number_step, count, 7);
    memcpy(vectors.residual, first.residual, size);
    for (size_t v = 0; v < count; v++)
        for (size_t i = 0; i < 3 && all->is_fixed[v]; i++)
            vectors.residual[v + i * vectors.number_step] = -3e20F;
    double const dot = correct(all, given, &first, 1, scratch);
    kernel_target const usual = kernel_target_get();
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        for (int threads = 1; threads <= 8; threads++) {
            assert_true(correct(all, given, &vectors, threads, scratch) == dot);
            assert_memory_equal(first.preconditioned, vectors.preconditioned, size);
        }
    }
    kernel_target_force(usual);
    destroy_vectors(&first), destroy_vectors(&vectors);
}

/* ---- systems ---- */

static void check_system(const spring_sheets *sheets, const spring_system *system,
                         const spring_matrix *matrix) {
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    nested_aggregates *const all = nested_aggregates_build(&heap, &system->matrix, &scratch);
    assert_true(all && all->grid && all->level_count > 0);
    assert_int_equal(all->grid->columns.count, sheets->columns);
    assert_int_equal(all->grid->rows.count, sheets->rows * sheets->count);
    assert_partition(all);
    check_axis(&all->grid->rows, sheets->rows);
    check_axis(&all->grid->columns, sheets->columns);
    for (size_t v = 0; v < all->vertex_count; v++)
        assert_int_equal(all->levels[0].parents[v],
                         find_block(&all->grid->rows, v / sheets->columns) *
                                 all->grid->columns.block_count +
                             find_block(&all->grid->columns, v % sheets->columns));
    dense_transfer const transfer = make_transfer(all->grid, sheets);
    aggregated_system const given = {&system->matrix, system->is_fixed, matrix->terms,
                                     matrix->term_count, false};
    assert_true(nested_aggregates_set(all, &given, 2, &scratch));
    dense_level dense[AGGREGATE_LEVELS_MAX];
    dense[0] = make_first(system, matrix, all, &transfer);
    check_pattern(all, &dense[0]);
    check_planes(all->grid, &dense[0]);
    for (size_t l = 1; l < all->level_count; l++) {
        assert_weights(all, &system->matrix, l);
        dense[l] = dense_level_make_above(&all->levels[l], &dense[l - 1]);
        assert_entries(&all->levels[l], &dense[l]);
    }
    check_cycle(all, dense, &transfer);
    check_parts(all, &transfer);
    check_bits(all, &given, &scratch);
    for (size_t l = 0; l < all->level_count; l++) dense_level_destroy(&dense[l]);
    destroy_transfer(&transfer);
    arena_destroy(&scratch);
    nested_aggregates_destroy(&heap, all);
    assert_int_equal(heap.bytes_held, 0);
}

enum { TERMS = 40 };
/* Terms of two to four vertices, on fixed ones too. Of every other one they are near each other. */
static spring_matrix make_terms(const spring_graph *mesh, size_t columns, matrix_term *terms) {
    uint64_t seed = 17;
    for (size_t t = 0; t < TERMS; t++) {
        vec3 const normal = {random_signed(&seed), random_signed(&seed), random_signed(&seed)};
        terms[t].stiffness = mat3_outer(normal, normal, 1000.0);
        for (size_t k = 0; k < 4; k++) {
            size_t vertex = (size_t)random_next(&seed) % mesh->vertex_count;
            size_t const down = k % 2 * (1 + t / 2 % 6), right = k / 2 * (1 + t / 2 % 5);
            if (k > 0 && t % 2 == 0) vertex = terms[t].vertices[0] + down * columns + right;
            if (vertex >= mesh->vertex_count) vertex = terms[t].vertices[0];
            terms[t].vertices[k] = k > 1 + t % 3 ? TULLE_NONE : (uint32_t)vertex;
            terms[t].weights[k] = k == 0 ? 1.0 : -0.4;
        }
    }
    return (spring_matrix){terms, TERMS};
}

/* One in fixed_every vertices is fixed; 0: none. */
static void check_sheets(spring_sheets sheets, double stiffness, size_t fixed_every) {
    spring_system system = spring_system_make(spring_graph_make_sheets(&sheets), stiffness, 9);
    size_t const count = system.matrix.row_count;
    for (size_t v = 0; fixed_every > 0 && v < count; v += fixed_every) system.is_fixed[v] = 1;
    spring_matrix const none = {NULL, 0};
    check_system(&sheets, &system, &none);
    matrix_term terms[TERMS];
    spring_matrix const matrix = make_terms(&system.mesh, sheets.columns, terms);
    check_system(&sheets, &system, &matrix);
    spring_system_destroy(&system);
}

static void grids_agree(void **state) {
    (void)state;
    spring_sheets const square = {.columns = 24, .rows = 24, .count = 1, .wide_count = SPRING_WAYS};
    check_sheets(square, 1000.0, 0);
    check_sheets(square, 1000.0, 2);
    spring_sheets const torn = {
        .columns = 30, .rows = 17, .count = 1, .wide_count = SPRING_WAYS, .has_hole = true};
    check_sheets(torn, 1000.0, 11);
    spring_sheets const crossed = {
        .columns = 26, .rows = 31, .count = 1, .wide_count = SPRING_WAYS, .is_crossed = true};
    check_sheets(crossed, 1e5, 0);
    check_sheets(crossed, 10.0, 7);
}

/* A sheet whose blocks fill several chunks of rows. */
static void a_large_grid_agrees(void **state) {
    (void)state;
    spring_sheets const large = {.columns = 61, .rows = 60, .count = 1, .wide_count = SPRING_WAYS};
    check_sheets(large, 1000.0, 31);
}

static void narrow_and_low_grids_agree(void **state) {
    (void)state;
    static const spring_sheets all[] = {
        {.columns = 5, .rows = 200, .count = 1, .wide_count = SPRING_WAYS},
        {.columns = 200, .rows = 5, .count = 1, .wide_count = 1},
        {.columns = 11, .rows = 90, .count = 1, .wide_count = SPRING_WAYS},
        {.columns = 7, .rows = 40, .count = 1, .wide_count = 3, .is_crossed = true},
        {.columns = 8, .rows = 40, .count = 1, .wide_count = 2},
        {.columns = 100, .rows = 1, .count = 1, .wide_count = 2}};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        check_sheets(all[k], 1000.0, 0);
        check_sheets(all[k], 1000.0, 3);
    }
}

static void sheets_agree(void **state) {
    (void)state;
    static const spring_sheets all[] = {
        {.columns = 20, .rows = 9, .count = 2, .wide_count = SPRING_WAYS},
        {.columns = 12, .rows = 5, .count = 4, .wide_count = 2, .has_hole = true},
        {.columns = 10, .rows = 3, .count = 9, .wide_count = 2},
        {.columns = 40, .rows = 1, .count = 3, .wide_count = 2}};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        check_sheets(all[k], 1000.0, 0);
        check_sheets(all[k], 1000.0, 5);
    }
}

/* The blocks are the last level, or all is fixed. */
static void small_grids_agree(void **state) {
    (void)state;
    check_sheets((spring_sheets){.columns = 5, .rows = 5, .count = 1}, 10.0, 0);
    check_sheets((spring_sheets){.columns = 5, .rows = 5, .count = 1}, 10.0, 2);
    spring_sheets const few = {.columns = 12, .rows = 8, .count = 1, .wide_count = 1};
    check_sheets(few, 100.0, 0);
    check_sheets(few, 100.0, 5);
    check_sheets(few, 100.0, 1);
    spring_sheets const square = {.columns = 24, .rows = 24, .count = 1, .wide_count = 2};
    check_sheets(square, 100.0, 1);
}

/* Blocks of several chunks: the same bits, and the dot of the whole. */
static void many_blocks_give_the_same_bits(void **state) {
    (void)state;
    spring_sheets const sheets = {.columns = 181, .rows = 102, .count = 1, .wide_count = 2};
    spring_system system = spring_system_make(spring_graph_make_sheets(&sheets), 100.0, 3);
    for (size_t v = 0; v < system.matrix.row_count; v += 97) system.is_fixed[v] = 1;
    arena scratch = arena_make(&system.heap);
    nested_aggregates *const all = nested_aggregates_build(&system.heap, &system.matrix, &scratch);
    assert_true(all && all->grid && all->levels[0].count > 1024);
    aggregated_system const given = {&system.matrix, system.is_fixed, NULL, 0, false};
    assert_true(nested_aggregates_set(all, &given, 2, &scratch));
    check_bits(all, &given, &scratch);
    dense_transfer const transfer = make_transfer(all->grid, &sheets);
    single_vectors const vectors = make_vectors(transfer.count);
    fill_randomly(vectors.residual, vectors.number_step, transfer.count, 8);
    double const dot = correct(all, &given, &vectors, 3, &scratch);
    double sum = 0.0;
    for (size_t v = 0; v < transfer.count; v++)
        for (size_t i = 0; i < 3; i++)
            sum += (double)vectors.residual[v + i * vectors.number_step] *
                   find_correction(all, &transfer, v, i);
    assert_true(dot > 0.0 && fabs(dot - sum) <= 1e-5 * dot);
    destroy_vectors(&vectors);
    destroy_transfer(&transfer);
    nested_aggregates_destroy(&system.heap, all);
    arena_destroy(&scratch);
    spring_system_destroy(&system);
}

/* Numbers of one matrix leave nothing behind for the next. */
static void numbers_are_set_anew(void **state) {
    (void)state;
    spring_sheets const sheets = {.columns = 24, .rows = 24, .count = 1, .wide_count = 2};
    spring_system system = spring_system_make(spring_graph_make_sheets(&sheets), 100.0, 3);
    size_t const count = system.matrix.row_count;
    arena scratch = arena_make(&system.heap);
    nested_aggregates *const all = nested_aggregates_build(&system.heap, &system.matrix, &scratch);
    assert_true(all && all->grid);
    matrix_term terms[TERMS];
    spring_matrix const stiff = make_terms(&system.mesh, sheets.columns, terms);
    single_vectors const vectors = make_vectors(count), first = make_vectors(count);
    fill_randomly(vectors.residual, vectors.number_step, count, 8);
    memcpy(first.residual, vectors.residual, 3 * vectors.number_step * sizeof(float));
    aggregated_system const free_one = {&system.matrix, NULL, NULL, 0, false};
    aggregated_system const other = {&system.matrix, system.is_fixed, stiff.terms, TERMS, false};
    double const dot = correct(all, &free_one, &first, 1, &scratch);
    for (size_t v = 0; v < count; v += 3) system.is_fixed[v] = 1;
    assert_true(correct(all, &other, &vectors, 1, &scratch) != dot);
    assert_true(correct(all, &free_one, &vectors, 1, &scratch) == dot);
    assert_memory_equal(first.preconditioned, vectors.preconditioned,
                        3 * vectors.number_step * sizeof(float));
    destroy_vectors(&vectors), destroy_vectors(&first);
    nested_aggregates_destroy(&system.heap, all);
    arena_destroy(&scratch);
    spring_system_destroy(&system);
}

/* What is said to be known is not read again: only the terms are. */
static void sums_are_kept(void **state) {
    (void)state;
    spring_sheets const sheets = {.columns = 24, .rows = 24, .count = 1, .wide_count = 2};
    spring_system system = spring_system_make(spring_graph_make_sheets(&sheets), 100.0, 3);
    size_t const number_count = BLOCK_NUMBERS * system.matrix.block_count;
    arena scratch = arena_make(&system.heap);
    nested_aggregates *const all = nested_aggregates_build(&system.heap, &system.matrix, &scratch);
    assert_true(all && all->grid && all->matrix_sums);
    matrix_term terms[TERMS];
    spring_matrix const stiff = make_terms(&system.mesh, sheets.columns, terms);
    single_vectors const vectors = make_vectors(system.matrix.row_count);
    fill_randomly(vectors.residual, vectors.number_step, system.matrix.row_count, 8);
    aggregated_system given = {&system.matrix, NULL, NULL, 0, true};
    double const before = correct(all, &given, &vectors, 1, &scratch); /* the first of all */
    given.terms = stiff.terms;
    given.term_count = TERMS;
    given.is_known = false;
    double const with_terms = correct(all, &given, &vectors, 1, &scratch);
    assert_true(with_terms != before);
    for (size_t i = 0; i < number_count; i++) system.matrix.values[i] *= 2.0;
    given.is_known = true;
    assert_true(correct(all, &given, &vectors, 2, &scratch) == with_terms);
    given.term_count = 0;
    assert_true(correct(all, &given, &vectors, 2, &scratch) == before);
    given.is_known = false;
    assert_true(correct(all, &given, &vectors, 2, &scratch) < 0.9 * before);
    destroy_vectors(&vectors);
    nested_aggregates_destroy(&system.heap, all);
    arena_destroy(&scratch);
    spring_system_destroy(&system);
}

/* ---- which systems have a grid ---- */

/* Takes the graph over. */
static void check_is_grid(spring_graph graph, size_t columns) {
    spring_system system = spring_system_make(graph, 10.0, 2);
    grid_transfer *grid = NULL;
    assert_true(grid_transfer_build(&system.heap, &system.matrix, &grid));
    assert_true((grid != NULL) == (columns > 0));
    if (grid) assert_int_equal(grid->columns.count, columns);
    grid_transfer_destroy(&system.heap, grid);
    spring_system_destroy(&system);
}

/* The same of one whose entries lie on few diagonals: it has no grid for other reasons. */
static void check_is_no_grid(spring_graph graph) {
    spring_system system = spring_system_make(graph, 10.0, 2);
    assert_true(system.matrix.diagonals.count > 0);
    grid_transfer *grid = NULL;
    assert_true(grid_transfer_build(&system.heap, &system.matrix, &grid));
    assert_null(grid);
    spring_system_destroy(&system);
}

static spring_graph make_sheet(size_t columns, size_t rows) {
    spring_sheets const sheet = {.columns = columns, .rows = rows, .count = 1, .wide_count = 2};
    return spring_graph_make_sheets(&sheet);
}

/* Joins two vertices by one edge more; `is_wide`: by an isotropic spring. */
static void join(spring_graph *graph, bool is_wide, size_t a, size_t b) {
    size_t *const count = is_wide ? &graph->wide_count : &graph->edge_count;
    uint32_t(**const edges)[2] = is_wide ? &graph->wide : &graph->edges;
    *edges = realloc(*edges, (*count + 1) * sizeof **edges);
    assert_non_null(*edges);
    (*edges)[*count][0] = (uint32_t)a;
    (*edges)[(*count)++][1] = (uint32_t)b;
}

static void grids_are_found(void **state) {
    (void)state;
    check_is_grid(make_sheet(5, 200), 5);
    check_is_grid(make_sheet(24, 24), 24);
    check_is_grid(make_sheet(70, 20), 70);
    spring_sheets const sheets = {.columns = 20, .rows = 9, .count = 3, .wide_count = SPRING_WAYS};
    check_is_grid(spring_graph_make_sheets(&sheets), 20);
    spring_sheets const torn = {.columns = 30, .rows = 30, .count = 1, .has_hole = true};
    check_is_grid(spring_graph_make_sheets(&torn), 30);
    /* vertices that nothing joins make rows, too */
    spring_graph alone = make_sheet(24, 24);
    alone.vertex_count += 48;
    check_is_grid(alone, 24);
}

static void others_have_none(void **state) {
    (void)state;
    enum { SIDE = 24 };
    check_is_grid(spring_graph_make_random(300, 500, 3), 0);
    check_is_grid(spring_graph_make_random(120, 30, 4), 0);
    check_is_no_grid(make_sheet(2, 200));
    check_is_no_grid(make_sheet(3, 200));
    check_is_no_grid(make_sheet(4, 200)); /* two to the right is two to the left of the next row */
    check_is_no_grid(spring_graph_make_grid(SIDE, SIDE, false)); /* springs go around */
    spring_graph unfinished = make_sheet(SIDE, SIDE);
    unfinished.vertex_count += 5;
    check_is_no_grid(unfinished);
    for (int is_wide = 0; is_wide < 2; is_wide++) {
        size_t const middle = 10 * SIDE + 10;
        spring_graph far_column = make_sheet(SIDE, SIDE);
        join(&far_column, is_wide, middle, middle + 3);
        check_is_no_grid(far_column);
        spring_graph far_row = make_sheet(SIDE, SIDE);
        join(&far_row, is_wide, middle, middle + (size_t)3 * SIDE);
        check_is_no_grid(far_row);
        spring_graph cylinder = make_sheet(SIDE, SIDE), spiral = make_sheet(SIDE, SIDE);
        for (size_t row = 0; row < SIDE; row++) {
            join(&cylinder, is_wide, row * SIDE, row * SIDE + SIDE - 1);
            if (row > 0) join(&spiral, is_wide, row * SIDE - 1, row * SIDE);
        }
        check_is_no_grid(cylinder);
        check_is_no_grid(spiral);
    }
}

/* A row so short that it needs no aggregates. */
static void a_grid_without_levels_adds_nothing(void **state) {
    (void)state;
    spring_sheets const row = {.columns = 8, .rows = 1, .count = 1};
    spring_system system = spring_system_make(spring_graph_make_sheets(&row), 10.0, 2);
    arena scratch = arena_make(&system.heap);
    nested_aggregates *const all = nested_aggregates_build(&system.heap, &system.matrix, &scratch);
    assert_true(all && all->grid && all->level_count == 0);
    aggregated_system const given = {&system.matrix, NULL, NULL, 0, false};
    single_vectors const vectors = make_vectors(8);
    fill_randomly(vectors.residual, vectors.number_step, 8, 8);
    assert_true(correct(all, &given, &vectors, 1, &scratch) == 0.0);
    for (size_t k = 0; k < 3 * vectors.number_step; k++)
        assert_true(vectors.preconditioned[k] == 0.0F);
    destroy_vectors(&vectors);
    nested_aggregates_destroy(&system.heap, all);
    arena_destroy(&scratch);
    spring_system_destroy(&system);
}

/* A matrix that is not multiplied by diagonals has vectors that are not in planes. */
static void a_grid_by_rows_is_none(void **state) {
    (void)state;
    spring_sheets const sheets = {.columns = 20, .rows = 20, .count = 1};
    spring_system system = spring_system_make(spring_graph_make_sheets(&sheets), 10.0, 2);
    block_matrix by_rows = system.matrix;
    by_rows.diagonals.count = 0;
    arena scratch = arena_make(&system.heap);
    nested_aggregates *const all = nested_aggregates_build(&system.heap, &by_rows, &scratch);
    assert_true(all && !all->grid && all->level_count > 0);
    nested_aggregates_destroy(&system.heap, all);
    arena_destroy(&scratch);
    spring_system_destroy(&system);
}

/* ---- memory ---- */

/* Whichever allocation fails, all is given back. Numbers can be set once there is memory again. */
static void check_numbers(nested_aggregates *all, const block_matrix *matrix, memory *heap,
                          int *left) {
    single_vectors const first = make_vectors(all->vertex_count);
    fill_randomly(first.residual, first.number_step, all->vertex_count, 8);
    aggregated_system const given = {matrix, NULL, NULL, 0, false};
    size_t const held = heap->bytes_held;
    int fails = 0;
    for (bool is_set = false; !is_set; fails++) {
        *left = fails;
        arena scratch = arena_make(heap);
        is_set = nested_aggregates_set(all, &given, 1, &scratch);
        arena_destroy(&scratch);
        assert_int_equal(heap->bytes_held, held);
    }
    assert_true(fails > 4);
    double const dot = nested_aggregates_correct(all, &first, 1);
    *left = 1000;
    arena scratch = arena_make(heap);
    assert_true(dot > 0.0 && correct(all, &given, &first, 1, &scratch) == dot);
    arena_destroy(&scratch);
    destroy_vectors(&first);
}

/* So large that the arena needs several blocks. */
static void failures_give_all_back(void **state) {
    (void)state;
    spring_sheets const sheets = {.columns = 300, .rows = 20, .count = 2, .wide_count = 2};
    spring_system system = spring_system_make(spring_graph_make_sheets(&sheets), 10.0, 1);
    nested_aggregates *all = NULL;
    int fails = 0;
    for (; !all; fails++) {
        int left = fails;
        memory heap = failing_heap_make(&left);
        arena scratch = arena_make(&heap);
        all = nested_aggregates_build(&heap, &system.matrix, &scratch);
        arena_destroy(&scratch);
        if (all) {
            assert_non_null(all->grid);
            check_numbers(all, &system.matrix, &heap, &left);
            nested_aggregates_destroy(&heap, all);
        }
        assert_int_equal(heap.bytes_held, 0);
    }
    assert_true(fails > 20);
    spring_system_destroy(&system);
}

int main(void) {
    struct CMUnitTest const tests[] = {
        cmocka_unit_test(grids_agree),
        cmocka_unit_test(a_large_grid_agrees),
        cmocka_unit_test(narrow_and_low_grids_agree),
        cmocka_unit_test(sheets_agree),
        cmocka_unit_test(small_grids_agree),
        cmocka_unit_test(many_blocks_give_the_same_bits),
        cmocka_unit_test(numbers_are_set_anew),
        cmocka_unit_test(sums_are_kept),
        cmocka_unit_test(grids_are_found),
        cmocka_unit_test(others_have_none),
        cmocka_unit_test(a_grid_without_levels_adds_nothing),
        cmocka_unit_test(a_grid_by_rows_is_none),
        cmocka_unit_test(failures_give_all_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
