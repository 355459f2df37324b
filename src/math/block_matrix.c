/* math/block_matrix.c - pattern and product of the vertex matrix, see block_matrix.h.
 *
 * The product adds the columns of each block times one entry of x, in vectors of four lanes whose
 * last lane is ignored: a block is nine doubles, so the vector of its last column reads the first
 * number of the next block. That is why `values` has padding at its end. */
#include "math/block_matrix.h"

#include "base/parallel.h"
#include "math/vector_width.h"

#include <string.h>

/* Rows a chunk: about 100 KB of blocks, small enough to balance and large enough to pay. */
enum { ROWS_PER_CHUNK = 256, VALUE_PADDING = 3 };

static bool copy_pattern(memory *heap, block_pattern pattern, size_t row_count, uint32_t **begin,
                         uint32_t **columns) {
    size_t const count = pattern.begin ? pattern.begin[row_count] : 0;
    *begin = memory_allocate_zeroed(heap, row_count + 1, sizeof(uint32_t));
    *columns = memory_allocate(heap, count * sizeof(uint32_t));
    if (!*begin || !*columns) return false;
    if (!pattern.begin) return true;
    memcpy(*begin, pattern.begin, (row_count + 1) * sizeof(uint32_t));
    if (count) memcpy(*columns, pattern.columns, count * sizeof(uint32_t));
    return true;
}

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
                           .scalar_count = scalars.begin ? scalars.begin[row_count] : 0};
    bool const ok =
        copy_pattern(heap, blocks, row_count, &matrix.row_begin, &matrix.columns) &
        copy_pattern(heap, scalars, row_count, &matrix.scalar_begin, &matrix.scalar_columns);
    matrix.diagonal_positions = memory_allocate(heap, row_count * sizeof(uint32_t));
    matrix.values =
        memory_allocate_zeroed(heap, 9 * matrix.block_count + VALUE_PADDING, sizeof(double));
    matrix.scalar_values = memory_allocate_zeroed(heap, matrix.scalar_count, sizeof(double));
    if (!ok || !matrix.diagonal_positions || !matrix.values || !matrix.scalar_values) {
        block_matrix_destroy(heap, &matrix);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    for (size_t row = 0; row < row_count; row++)
        matrix.diagonal_positions[row] = block_matrix_find(&matrix, (uint32_t)row, (uint32_t)row);
    *result = matrix;
    return TULLE_OK;
}

void block_matrix_destroy(memory *heap, block_matrix *matrix) {
    memory_release(heap, matrix->row_begin, (matrix->row_count + 1) * sizeof(uint32_t));
    memory_release(heap, matrix->columns, matrix->block_count * sizeof(uint32_t));
    memory_release(heap, matrix->diagonal_positions, matrix->row_count * sizeof(uint32_t));
    memory_release(heap, matrix->values,
                   (9 * matrix->block_count + VALUE_PADDING) * sizeof(double));
    memory_release(heap, matrix->scalar_begin, (matrix->row_count + 1) * sizeof(uint32_t));
    memory_release(heap, matrix->scalar_columns, matrix->scalar_count * sizeof(uint32_t));
    memory_release(heap, matrix->scalar_values, matrix->scalar_count * sizeof(double));
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
    /* A fourth number may be read behind a vertex, and the last one has none. */
    size_t const last = matrix->row_count - 1;
    double const last_entry[4] = {x[3 * last], x[3 * last + 1], x[3 * last + 2], 0.0};
    for (size_t row = begin; row < end; row++) {
        lanes4 sum0 = {0}, sum1 = {0}, sum2 = {0}, sum3 = {0}, sum4 = {0};
        for (size_t k = matrix->row_begin[row]; k < matrix->row_begin[row + 1]; k++) {
            const double *const block = values + 9 * k;
            const double *const entry = x + 3 * (size_t)matrix->columns[k];
            sum0 += *(const lanes4 *)block * entry[0];
            sum1 += *(const lanes4 *)(block + 3) * entry[1];
            sum2 += *(const lanes4 *)(block + 6) * entry[2];
        }
        /* Even and odd entries in two sums, so that additions need not wait for one another. */
        size_t const end_scalar = matrix->scalar_begin[row + 1];
        for (size_t k = matrix->scalar_begin[row]; k < end_scalar; k++) {
            size_t const column = matrix->scalar_columns[k];
            const double *const entry = column == last ? last_entry : x + 3 * column;
            sum3 += matrix->scalar_values[k] * *(const lanes4 *)entry;
            if (++k == end_scalar) break;
            size_t const next_column = matrix->scalar_columns[k];
            const double *const next = next_column == last ? last_entry : x + 3 * next_column;
            sum4 += matrix->scalar_values[k] * *(const lanes4 *)next;
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

void block_matrix_get_diagonal(const block_matrix *matrix, double *diagonal) {
    for (size_t row = 0; row < matrix->row_count; row++)
        memcpy(diagonal + 9 * row, matrix->values + 9 * (size_t)matrix->diagonal_positions[row],
               9 * sizeof(double));
}
