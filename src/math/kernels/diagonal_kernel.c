/* math/kernels/diagonal_kernel.c - see diagonal_kernel.h.
 *
 * Each lane works on a row of its own and adds up its diagonals in their order, so all widths give
 * the same bits. */
#include "math/diagonal_kernel.h"

#include "math/single_lanes.h"

/* Rows ahead of which planes are called for. The processor by itself foresees fewer streams than
 * there are planes. */
enum { ROWS_AHEAD = 64 };

SINGLE_INLINE void call_for(const float *planes, size_t stride, size_t count) {
    for (size_t k = 0; k < count; k++) __builtin_prefetch(planes + k * stride + ROWS_AHEAD);
}

/* Three numbers of DIAGONAL_ROWS vertices. */
typedef struct lanes3 {
    lanes16 x, y, z;
} lanes3;

SINGLE_INLINE lanes3 load3(const float *from, size_t stride) {
    lanes3 const v = {load16(from), load16(from + stride), load16(from + 2 * stride)};
    return v;
}
SINGLE_INLINE void store3(float *to, size_t stride, lanes3 v) {
    memcpy(to, &v.x, sizeof v.x);
    memcpy(to + stride, &v.y, sizeof v.y);
    memcpy(to + 2 * stride, &v.z, sizeof v.z);
}
/* a += b s */
SINGLE_INLINE void add_scaled(lanes3 *a, lanes3 b, float s) {
    a->x += b.x * s;
    a->y += b.y * s;
    a->z += b.z * s;
}
SINGLE_INLINE lanes16 multiply3(lanes3 a, lanes3 b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }

/* A symmetric block, whose six numbers are in planes, times v. */
SINGLE_INLINE lanes3 multiply_block(const float *block, size_t stride, lanes3 v) {
    lanes16 const xx = load16(block), xy = load16(block + stride);
    lanes16 const xz = load16(block + 2 * stride), yy = load16(block + 3 * stride);
    lanes16 const yz = load16(block + 4 * stride), zz = load16(block + 5 * stride);
    lanes3 const product = {(xx * v.x + xy * v.y) + xz * v.z, (xy * v.x + yy * v.y) + yz * v.z,
                            (xz * v.x + yz * v.y) + zz * v.z};
    return product;
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

/* Corrections of four vertices, by number. */
SINGLE_INLINE void load_corrections(const single_correction *correction, size_t v,
                                    floats4 numbers[3]) {
    const uint32_t *const parents = correction->parents + v;
    const uint8_t *const fixed = correction->is_fixed + v;
    floats4 const share = {1.0F - (float)fixed[0], 1.0F - (float)fixed[1], 1.0F - (float)fixed[2],
                           1.0F - (float)fixed[3]};
    floats4 of[4];
    for (size_t k = 0; k < 4; k++)
        of[k] = floats4_load(correction->values + 3 * (size_t)parents[k]);
    floats4 const a = __builtin_shufflevector(of[0], of[1], 0, 4, 1, 5); /* x0 x1 y0 y1 */
    floats4 const b = __builtin_shufflevector(of[2], of[3], 0, 4, 1, 5); /* x2 x3 y2 y3 */
    floats4 const c = __builtin_shufflevector(of[0], of[1], 2, 6, 2, 6); /* z0 z1 */
    floats4 const d = __builtin_shufflevector(of[2], of[3], 2, 6, 2, 6); /* z2 z3 */
    numbers[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5) * share;
    numbers[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7) * share;
    numbers[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5) * share;
}

void TULLE_KERNEL(diagonal_turn)(const single_vectors *vectors, const single_correction *correction,
                                 float beta, size_t begin, size_t end) {
    size_t const stride = vectors->number_step;
    size_t v = begin;
    for (; v + 4 <= end; v += 4) {
        floats4 c[3] = {{0.0F}, {0.0F}, {0.0F}};
        if (correction) load_corrections(correction, v, c);
        for (size_t k = 0; k < 3; k++) {
            float *const p = vectors->direction + k * stride + v;
            floats4 const z = floats4_load(vectors->preconditioned + k * stride + v);
            store4(p, (z + c[k]) + floats4_load(p) * beta);
        }
    }
    for (; v < end; v++)
        for (size_t k = 0; k < 3; k++) {
            float *const p = vectors->direction + k * stride + v;
            float c = 0.0F;
            if (correction && !correction->is_fixed[v])
                c = correction->values[3 * (size_t)correction->parents[v] + k];
            *p = (vectors->preconditioned[k * stride + v] + c) + *p * beta;
        }
}
