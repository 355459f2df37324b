/* math/kernels/multiply_kernel.c - the product adds the columns of each block times one entry of x,
 * in vectors of four lanes whose last lane is ignored. */
#include "math/multiply_kernel.h"

/* Four doubles, loaded from any address of a double. */
typedef double lanes4 __attribute__((vector_size(32), aligned(8), may_alias));

void TULLE_KERNEL(multiply_rows)(void *context, size_t begin, size_t end, size_t chunk,
                                 int worker) {
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
