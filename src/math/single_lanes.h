/* math/single_lanes.h - vectors of single precision for kernels of the linear solve. */
#ifndef TULLE_MATH_SINGLE_LANES_H
#define TULLE_MATH_SINGLE_LANES_H

#include "math/single_kernel.h"

#include <string.h>

#define SINGLE_INLINE static inline __attribute__((always_inline))

SINGLE_INLINE void store4(float *to, floats4 a) { memcpy(to, &a, sizeof a); }

/* Dots are summed in sixteen lanes, whatever the registers are. */
typedef float lanes16 __attribute__((vector_size(64)));
SINGLE_INLINE lanes16 load16(const float *from) {
    lanes16 a;
    memcpy(&a, from, sizeof a);
    return a;
}
SINGLE_INLINE float sum16(lanes16 sum) {
    float lanes[16];
    memcpy(lanes, &sum, sizeof lanes);
    for (size_t half = 8; half > 0; half /= 2)
        for (size_t l = 0; l < half; l++) lanes[l] += lanes[l + half];
    return lanes[0];
}
SINGLE_INLINE float dot(const float *a, const float *b, size_t begin, size_t end) {
    lanes16 sum = {0};
    size_t i = begin;
    for (; i + 16 <= end; i += 16) sum += load16(a + i) * load16(b + i);
    float rest = 0.0F;
    for (; i < end; i++) rest += a[i] * b[i];
    return sum16(sum) + rest;
}

#endif
