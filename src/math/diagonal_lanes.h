/* math/diagonal_lanes.h - vectors of numbers that lie in planes, for kernels: sixteen rows at a
 * time.
 */
#ifndef TULLE_MATH_DIAGONAL_LANES_H
#define TULLE_MATH_DIAGONAL_LANES_H

#include "math/diagonal_kernel.h"
#include "math/single_lanes.h"

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

#endif
