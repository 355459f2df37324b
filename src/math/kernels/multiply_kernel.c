/* math/kernels/multiply_kernel.c - the product adds the columns of each block times one entry of x,
 * in vectors of four lanes whose last lane is ignored. */
#include "math/multiply_kernel.h"

/* Four doubles, loaded from any address of a double. */
typedef double lanes4 __attribute__((vector_size(32), aligned(8), may_alias));

/* sum_k s_k x_k over the scalars of a row; even and odd entries in two sums, so that additions need
 * not wait for one another. Columns ascend, so only the last entry can be that of the last vertex,
 * whose x is in last_entry. */
static inline __attribute__((always_inline)) lanes4 add_scalars(const block_matrix *matrix,
                                                                size_t row, const double *x,
                                                                const double *last_entry,
                                                                bool has_sums) {
    lanes4 even = {0}, odd = {0};
    size_t k = matrix->scalar_begin[row];
    size_t const end = matrix->scalar_begin[row + 1];
    const uint32_t *const columns = matrix->scalar_columns;
    const double *const sums = matrix->scalar_sums;
    bool const has_last = k < end && columns[end - 1] == matrix->row_count - 1;
    size_t const plain_end = has_last ? end - 1 : end;
    for (; k < plain_end; k++) {
        double const value = has_sums ? sums[k] : block_matrix_get_scalar(matrix, k);
        even += value * *(const lanes4 *)(x + 3 * (size_t)columns[k]);
        if (++k == plain_end) break;
        double const next = has_sums ? sums[k] : block_matrix_get_scalar(matrix, k);
        odd += next * *(const lanes4 *)(x + 3 * (size_t)columns[k]);
    }
    if (has_last) {
        lanes4 const product =
            block_matrix_get_scalar(matrix, end - 1) * *(const lanes4 *)last_entry;
        if ((end - 1 - matrix->scalar_begin[row]) % 2 == 0)
            even += product;
        else
            odd += product;
    }
    return even + odd;
}

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
        lanes4 sum0 = {0}, sum1 = {0}, sum2 = {0};
        const uint32_t *const columns = matrix->columns + matrix->row_begin[row];
        const double *const blocks = values + BLOCK_NUMBERS * (size_t)matrix->row_begin[row];
        size_t const count = matrix->row_begin[row + 1] - matrix->row_begin[row];
#pragma GCC unroll 4
        for (size_t k = 0; k < count; k++) {
            const double *const block = blocks + BLOCK_NUMBERS * k;
            const double *const entry = x + 3 * (size_t)columns[k];
            lanes4 const middle = *(const lanes4 *)(block + 1), high = *(const lanes4 *)(block + 2);
            sum0 += *(const lanes4 *)block * entry[0];
            sum1 += __builtin_shufflevector(middle, middle, 0, 2, 3, 3) * entry[1];
            sum2 += __builtin_shufflevector(high, high, 0, 2, 3, 3) * entry[2];
        }
        lanes4 const scalars = matrix->scalar_sums ? add_scalars(matrix, row, x, last_entry, true)
                                                   : add_scalars(matrix, row, x, last_entry, false);
        lanes4 const sum = (sum0 + sum1) + (sum2 + scalars);
        for (size_t i = 0; i < 3; i++) task->result[3 * row + i] = sum[i];
    }
}
