/* math/block_matrix.c - pattern and product of the vertex matrix, see block_matrix.h. */
#include "math/block_matrix.h"

#include "base/parallel.h"
#include "math/multiply_kernel.h"

#include <string.h>

/* Rows a chunk: about 100 KB of blocks, small enough to balance and large enough to pay. */
enum { ROWS_PER_CHUNK = 256 };

const size_t block_places[BLOCK_NUMBERS] = {0, 1, 2, 4, 5, 8};

uint32_t find_in_columns(const uint32_t *columns, uint32_t begin, uint32_t end, uint32_t column) {
    uint32_t low = begin, high = end;
    while (low < high) {
        uint32_t const middle = low + (high - low) / 2;
        if (columns[middle] < column)
            low = middle + 1;
        else
            high = middle;
    }
    return low < end && columns[low] == column ? low : TULLE_NONE;
}

uint32_t block_matrix_find(const block_matrix *matrix, uint32_t row, uint32_t column) {
    return find_in_columns(matrix->columns, matrix->row_begin[row], matrix->row_begin[row + 1],
                           column);
}

bool block_matrix_find_term(const block_matrix *matrix, const matrix_term *term,
                            uint32_t places[4][4]) {
    if (term->is_apart) return false;
    for (size_t i = 0; i < 4; i++)
        for (size_t j = 0; j < 4; j++) {
            uint32_t const row = term->vertices[i], column = term->vertices[j];
            places[i][j] = TULLE_NONE;
            if (row == TULLE_NONE || column == TULLE_NONE) continue;
            places[i][j] = block_matrix_find(matrix, row, column);
            if (places[i][j] == TULLE_NONE) return false;
        }
    return true;
}

bool block_matrix_add_term(block_matrix *matrix, const matrix_term *term) {
    uint32_t places[4][4];
    if (!block_matrix_find_term(matrix, term, places)) return false;
    for (size_t i = 0; i < 4; i++)
        for (size_t j = 0; j < 4; j++) {
            if (places[i][j] == TULLE_NONE) continue;
            double *const block = matrix->values + BLOCK_NUMBERS * (size_t)places[i][j];
            double const scale = term->weights[i] * term->weights[j];
            for (size_t k = 0; k < BLOCK_NUMBERS; k++)
                block[k] += scale * term->stiffness.m[block_places[k]];
        }
    return true;
}

tulle_status block_matrix_build(memory *heap, size_t row_count, block_pattern blocks,
                                block_pattern scalars, block_matrix *result) {
    block_matrix matrix = {.row_count = row_count,
                           .block_count = blocks.begin[row_count],
                           .scalar_count = scalars.begin ? scalars.begin[row_count] : 0,
                           .row_begin = blocks.begin,
                           .columns = blocks.columns,
                           .scalar_begin = scalars.begin,
                           .scalar_columns = scalars.columns};
    if (!scalars.begin)
        matrix.scalar_begin = matrix.no_scalars =
            memory_allocate_zeroed(heap, row_count + 1, sizeof(uint32_t));
    matrix.diagonal_positions = memory_allocate(heap, row_count * sizeof(uint32_t));
    matrix.values = memory_allocate_zeroed(heap, BLOCK_NUMBERS * matrix.block_count + BLOCK_PADDING,
                                           sizeof(double));
    bool const has_memory = matrix.scalar_begin && matrix.diagonal_positions && matrix.values;
    if (!has_memory ||
        matrix_diagonals_find(
            heap, row_count, (entry_pattern){matrix.block_count, matrix.row_begin, matrix.columns},
            (entry_pattern){matrix.scalar_count, matrix.scalar_begin, matrix.scalar_columns},
            &matrix.diagonals) != TULLE_OK) {
        block_matrix_destroy(heap, &matrix);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    for (size_t row = 0; row < row_count; row++)
        matrix.diagonal_positions[row] = block_matrix_find(&matrix, (uint32_t)row, (uint32_t)row);
    *result = matrix;
    return TULLE_OK;
}

void block_matrix_destroy(memory *heap, block_matrix *matrix) {
    memory_release(heap, matrix->no_scalars, (matrix->row_count + 1) * sizeof(uint32_t));
    memory_release(heap, matrix->diagonal_positions, matrix->row_count * sizeof(uint32_t));
    memory_release(heap, matrix->diagonals.of_blocks, matrix->block_count);
    memory_release(heap, matrix->diagonals.of_scalars, matrix->scalar_count);
    memory_release(heap, matrix->values,
                   (BLOCK_NUMBERS * matrix->block_count + BLOCK_PADDING) * sizeof(double));
    *matrix = (block_matrix){0};
}

void block_matrix_apply(void *context, const double *x, double *result) {
    const block_matrix_operator *const a = context;
    const block_matrix *const matrix = a->matrix;
    multiply_task task = {matrix, x, result};
    if (matrix->is_idle) memset(result, 0, 3 * matrix->row_count * sizeof *result);
    parallel_for_busy(matrix->is_idle, matrix->row_count, ROWS_PER_CHUNK, a->threads,
                      TULLE_PICK_KERNEL(multiply_rows), &task);
}

typedef struct scalar_task {
    const block_matrix *matrix;
    double *sums;
} scalar_task;

static void sum_scalars(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const scalar_task *const task = context;
    const uint32_t *const rows = task->matrix->scalar_begin;
    for (size_t k = rows[begin]; k < rows[end]; k++)
        task->sums[k] = block_matrix_get_scalar(task->matrix, k);
}

void block_matrix_sum_scalars(const block_matrix *matrix, double *sums, int threads) {
    scalar_task task = {matrix, sums};
    parallel_for(matrix->row_count, ROWS_PER_CHUNK, threads, sum_scalars, &task);
}

typedef struct diagonal_task {
    const block_matrix *matrix;
    double *diagonal;
} diagonal_task;

static void copy_diagonal(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const diagonal_task *const task = context;
    for (size_t row = begin; row < end; row++) {
        const double *const m =
            task->matrix->values + BLOCK_NUMBERS * (size_t)task->matrix->diagonal_positions[row];
        double const full[9] = {m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5]};
        memcpy(task->diagonal + 9 * row, full, sizeof full);
    }
}

void block_matrix_get_diagonal(const block_matrix *matrix, double *diagonal, int threads) {
    diagonal_task task = {matrix, diagonal};
    parallel_for(matrix->row_count, ROWS_PER_CHUNK, threads, copy_diagonal, &task);
}
