/* math/kernels/diagonal_kernel.c - see diagonal_kernel.h.
 *
 * Each lane works on a row of its own and adds up its diagonals in their order, so all widths give
 * the same bits. */
#include "math/diagonal_kernel.h"

#include "math/single_lanes.h"

/* The planes of a symmetric block: xx, xy, xz, yy, yz, zz. */
typedef struct block_lanes {
    lanes16 xx, xy, xz, yy, yz, zz;
} block_lanes;
typedef struct lanes3 {
    lanes16 x, y, z;
} lanes3;

SINGLE_INLINE lanes3 load_direction(const single_diagonals *a, size_t row) {
    const float *const from = a->direction + row;
    lanes3 const v = {load16(from), load16(from + a->stride), load16(from + 2 * a->stride)};
    return v;
}

SINGLE_INLINE void add_block(lanes3 *sum, const single_diagonals *a, const float *block, lanes3 v) {
    size_t const stride = a->stride;
    block_lanes const m = {load16(block),
                           load16(block + stride),
                           load16(block + 2 * stride),
                           load16(block + 3 * stride),
                           load16(block + 4 * stride),
                           load16(block + 5 * stride)};
    sum->x += (m.xx * v.x + m.xy * v.y) + m.xz * v.z;
    sum->y += (m.xy * v.x + m.yy * v.y) + m.yz * v.z;
    sum->z += (m.xz * v.x + m.yz * v.y) + m.zz * v.z;
}

SINGLE_INLINE void add_scalar(lanes3 *sum, lanes16 m, lanes3 v) {
    sum->x += m * v.x;
    sum->y += m * v.y;
    sum->z += m * v.z;
}

/* The other way round than split_planes. */
SINGLE_INLINE void join_planes(const lanes3 *sum, float *to) {
    float planes[3][16];
    memcpy(planes, sum, sizeof planes);
    for (size_t k = 0; k < 16; k += 4) {
        floats4 const x = floats4_load(planes[0] + k), y = floats4_load(planes[1] + k);
        floats4 const z = floats4_load(planes[2] + k);
        floats4 const xy = __builtin_shufflevector(x, y, 0, 4, 1, 5);   /* x0 y0 x1 y1 */
        floats4 const high = __builtin_shufflevector(x, y, 2, 6, 3, 7); /* x2 y2 x3 y3 */
        floats4 const zx = __builtin_shufflevector(z, x, 0, 5, 2, 7);   /* z0 x1 z2 x3 */
        floats4 const yz = __builtin_shufflevector(y, z, 1, 5, 3, 7);   /* y1 z1 y3 z3 */
        store4(to + 3 * k, __builtin_shufflevector(xy, zx, 0, 1, 4, 5));
        store4(to + 3 * k + 4, __builtin_shufflevector(yz, high, 0, 1, 4, 5));
        store4(to + 3 * k + 8, __builtin_shufflevector(zx, yz, 2, 3, 6, 7));
    }
}

float TULLE_KERNEL(diagonal_multiply)(const single_diagonals *diagonals,
                                      const single_vectors *vectors, size_t begin, size_t end) {
    single_diagonals const a = *diagonals;
    const uint32_t *const offsets = a.pattern->offsets;
    size_t const block_count = a.pattern->block_count, count = a.pattern->count;
    const float *const scalars = a.planes + SINGLE_BLOCK * block_count * a.stride;
    for (size_t row = begin; row < end; row += DIAGONAL_ROWS) {
        lanes3 sum = {{0.0F}, {0.0F}, {0.0F}};
        add_block(&sum, &a, a.planes + row, load_direction(&a, row));
        for (size_t d = 1; d < block_count; d++) {
            const float *const block = a.planes + SINGLE_BLOCK * d * a.stride + row;
            size_t const offset = offsets[d];
            add_block(&sum, &a, block, load_direction(&a, row + offset));
            add_block(&sum, &a, block - offset, load_direction(&a, row - offset));
        }
        for (size_t d = block_count; d < count; d++) {
            const float *const scalar = scalars + (d - block_count) * a.stride + row;
            size_t const offset = offsets[d];
            add_scalar(&sum, load16(scalar), load_direction(&a, row + offset));
            add_scalar(&sum, load16(scalar - offset), load_direction(&a, row - offset));
        }
        join_planes(&sum, vectors->product + 3 * row);
    }
    return dot(vectors->direction, vectors->product, 3 * begin, 3 * end);
}

void TULLE_KERNEL(diagonal_split)(const single_diagonals *diagonals, const float *vector,
                                  size_t begin, size_t end) {
    float *const x = diagonals->direction, *const y = x + diagonals->stride,
                 *const z = y + diagonals->stride;
    size_t v = begin;
    for (; v + 4 <= end; v += 4) {
        floats4 const a = floats4_load(vector + 3 * v);               /* x0 y0 z0 x1 */
        floats4 const b = floats4_load(vector + 3 * v + 4);           /* y1 z1 x2 y2 */
        floats4 const c = floats4_load(vector + 3 * v + 8);           /* z2 x3 y3 z3 */
        floats4 const ab = __builtin_shufflevector(a, b, 1, 2, 4, 5); /* y0 z0 y1 z1 */
        floats4 const bc = __builtin_shufflevector(b, c, 2, 3, 5, 6); /* x2 y2 x3 y3 */
        store4(x + v, __builtin_shufflevector(a, bc, 0, 3, 4, 6));
        store4(y + v, __builtin_shufflevector(ab, bc, 0, 2, 5, 7));
        floats4 const zs = __builtin_shufflevector(ab, c, 1, 3, 4, 7);
        store4(z + v, zs);
    }
    for (; v < end; v++) {
        x[v] = vector[3 * v];
        y[v] = vector[3 * v + 1];
        z[v] = vector[3 * v + 2];
    }
}
