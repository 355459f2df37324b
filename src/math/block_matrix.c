/* math/block_matrix.c - pattern and product of the vertex matrix, see block_matrix.h.
 *
 * The product adds the columns of each block times one entry of x, in vectors of four lanes whose
 * last lane is ignored. */
#include "math/block_matrix.h"

#include "base/parallel.h"
#include "math/vector_width.h"

#include <string.h>

/* Rows a chunk: about 100 KB of blocks, small enough to balance and large enough to pay. */
enum { ROWS_PER_CHUNK = 256 };

const size_t block_places[BLOCK_NUMBERS] = {0, 1, 2, 4, 5, 8};

uint32_t block_matrix_find(const block_matrix *matrix, uint32_t row, uint32_t column) {
    uint32_t low = matrix->row_begin[row], high = matrix->row_begin[row + 1];
    uint32_t const end = high;
    while (low < high) {
        uint32_t const middle = low + (high - low) / 2;
        if (matrix->columns[middle] < column)
            low = middle + 1;
        else
            high = middle;
    }
    return low < end && matrix->columns[low] == column ? low : TULLE_NONE;
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
    matrix.values =
        memory_allocate_zeroed(heap, BLOCK_NUMBERS * matrix.block_count, sizeof(double));
    if (!matrix.scalar_begin || !matrix.diagonal_positions || !matrix.values) {
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
    memory_release(heap, matrix->values, BLOCK_NUMBERS * matrix->block_count * sizeof(double));
    *matrix = (block_matrix){0};
}

typedef struct multiply_task {
    const block_matrix *matrix;
    const double *x;
    double *result;
} multiply_task;

TULLE_VECTOR_CLONES
static void multiply_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const multiply_task *const task = context;
    const block_matrix *const matrix = task->matrix;
    const double *const x = task->x;
    const double *const values = matrix->values;
    /* Four numbers are read for each vertex, its three and the next. The last vertex has no next
     * one. */
    size_t const last = matrix->row_count - 1;
    double const last_entry[4] = {x[3 * last], x[3 * last + 1], x[3 * last + 2], 0.0};
    for (size_t row = begin; row < end; row++) {
        lanes4 sum0 = {0}, sum1 = {0}, sum2 = {0}, sum3 = {0}, sum4 = {0};
        const uint32_t *const columns = matrix->columns + matrix->row_begin[row];
        const double *const blocks = values + BLOCK_NUMBERS * (size_t)matrix->row_begin[row];
        size_t const count = matrix->row_begin[row + 1] - matrix->row_begin[row];
#pragma GCC unroll 4
        for (size_t k = 0; k < count; k++) {
            const double *const block = blocks + BLOCK_NUMBERS * k;
            const double *const entry = x + 3 * (size_t)columns[k];
            lanes4 const low = *(const lanes4 *)block, high = *(const lanes4 *)(block + 2);
            sum0 += low * entry[0];
            sum1 += __builtin_shufflevector(low, high, 1, 3, 6, 6) * entry[1];
            sum2 += __builtin_shufflevector(low, high, 2, 6, 7, 7) * entry[2];
        }
        /* Even and odd entries in two sums, so that additions need not wait for one another. */
        size_t const end_scalar = matrix->scalar_begin[row + 1];
        for (size_t k = matrix->scalar_begin[row]; k < end_scalar; k++) {
            size_t const column = matrix->scalar_columns[k];
            const double *const entry = column == last ? last_entry : x + 3 * column;
            sum3 += block_matrix_get_scalar(matrix, k) * *(const lanes4 *)entry;
            if (++k == end_scalar) break;
            size_t const next_column = matrix->scalar_columns[k];
            const double *const next = next_column == last ? last_entry : x + 3 * next_column;
            sum4 += block_matrix_get_scalar(matrix, k) * *(const lanes4 *)next;
        }
        lanes4 const sum = (sum0 + sum1) + (sum2 + (sum3 + sum4));
        for (size_t i = 0; i < 3; i++) task->result[3 * row + i] = sum[i];
    }
}

void block_matrix_multiply(const block_matrix *matrix, const double *x, double *result,
                           int threads) {
    multiply_task task = {matrix, x, result};
    parallel_for(matrix->row_count, ROWS_PER_CHUNK, threads, multiply_rows, &task);
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
