/* math/kernels/diagonal_kernel.c - see diagonal_kernel.h.
 *
 * Each lane works on a row of its own and adds up its diagonals in their order, so all widths give
 * the same bits. */
#include "math/diagonal_kernel.h"

#include "math/diagonal_lanes.h"

/* Rows ahead of which planes are called for. The processor by itself foresees fewer streams than
 * there are planes. */
enum { ROWS_AHEAD = 64 };

SINGLE_INLINE void call_for(const float *planes, size_t stride, size_t count) {
    for (size_t k = 0; k < count; k++) __builtin_prefetch(planes + k * stride + ROWS_AHEAD);
}

SINGLE_INLINE void add_block(lanes3 *sum, const float *block, size_t stride, lanes3 v) {
    lanes3 const product = multiply_block(block, stride, v);
    sum->x += product.x;
    sum->y += product.y;
    sum->z += product.z;
}
SINGLE_INLINE void add_scalar(lanes3 *sum, lanes16 m, lanes3 v) {
    sum->x += m * v.x;
    sum->y += m * v.y;
    sum->z += m * v.z;
}

float TULLE_KERNEL(diagonal_multiply)(const single_diagonals *diagonals,
                                      const single_vectors *vectors, size_t begin, size_t end) {
    const matrix_diagonals *const pattern = diagonals->pattern;
    size_t const stride = diagonals->stride;
    size_t const block_count = pattern->block_count, count = pattern->count;
    const float *const planes = diagonals->planes;
    const float *const scalars = planes + SINGLE_BLOCK * block_count * stride;
    const float *const direction = vectors->direction;
    lanes16 dot = {0.0F};
    for (size_t row = begin; row < end; row += DIAGONAL_ROWS) {
        lanes3 const own = load3(direction + row, stride);
        call_for(planes + row, stride, SINGLE_BLOCK);
        lanes3 sum = multiply_block(planes + row, stride, own);
        for (size_t d = 1; d < block_count; d++) {
            const float *const block = planes + SINGLE_BLOCK * d * stride + row;
            size_t const offset = pattern->offsets[d];
            call_for(block, stride, SINGLE_BLOCK);
            add_block(&sum, block, stride, load3(direction + row + offset, stride));
            add_block(&sum, block - offset, stride, load3(direction + row - offset, stride));
        }
        for (size_t d = block_count; d < count; d++) {
            const float *const scalar = scalars + (d - block_count) * stride + row;
            size_t const offset = pattern->offsets[d];
            call_for(scalar, stride, 1);
            add_scalar(&sum, load16(scalar), load3(direction + row + offset, stride));
            add_scalar(&sum, load16(scalar - offset), load3(direction + row - offset, stride));
        }
        store3(vectors->product + row, stride, sum);
        dot += multiply3(sum, own);
    }
    return sum16(dot);
}

float TULLE_KERNEL(diagonal_advance)(const single_vectors *vectors, float alpha, size_t begin,
                                     size_t end) {
    size_t const stride = vectors->number_step;
    lanes16 dot = {0.0F};
    for (size_t row = begin; row < end; row += DIAGONAL_ROWS) {
        lanes3 x = load3(vectors->x + row, stride), r = load3(vectors->residual + row, stride);
        add_scaled(&x, load3(vectors->direction + row, stride), alpha);
        add_scaled(&r, load3(vectors->product + row, stride), -alpha);
        lanes3 const z = multiply_block(vectors->inverse + row, stride, r);
        store3(vectors->x + row, stride, x);
        store3(vectors->residual + row, stride, r);
        store3(vectors->preconditioned + row, stride, z);
        dot += multiply3(z, r);
    }
    return sum16(dot);
}

void TULLE_KERNEL(diagonal_turn)(const single_vectors *vectors, float beta, size_t begin,
                                 size_t end) {
    size_t const stride = vectors->number_step;
    size_t v = begin;
    for (; v + DIAGONAL_ROWS <= end; v += DIAGONAL_ROWS) {
        lanes3 to = load3(vectors->preconditioned + v, stride);
        add_scaled(&to, load3(vectors->direction + v, stride), beta);
        store3(vectors->direction + v, stride, to);
    }
    for (; v < end; v++)
        for (size_t k = 0; k < 3; k++) {
            float *const p = vectors->direction + k * stride + v;
            *p = vectors->preconditioned[k * stride + v] + *p * beta;
        }
}
