/* detect/trees/kernels/box_vectors.h - boxes as vectors of eight floats: low x, y, z and one
 * unused, then the same of minus high, so that a union is one minimum. Eight of them are turned
 * into rows, one box a lane. */
#ifndef TULLE_DETECT_TREES_KERNELS_BOX_VECTORS_H
#define TULLE_DETECT_TREES_KERNELS_BOX_VECTORS_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

/* Sanitizers, and targets that must take vectors apart, make much code of each function here: then
 * they are compiled once, not where they are called. */
#if defined(__AVX2__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define BOX_INLINE static inline __attribute__((always_inline))
#else
#define BOX_INLINE static __attribute__((noinline, unused))
#endif

typedef float box_vector __attribute__((vector_size(32)));
typedef int32_t box_index __attribute__((vector_size(32)));

BOX_INLINE box_vector box_vector_load(const float *from) {
    box_vector box;
    memcpy(&box, from, sizeof box);
    return box;
}
BOX_INLINE void box_vector_store(float *to, box_vector box) { memcpy(to, &box, sizeof box); }
BOX_INLINE box_vector box_vector_fill(float x) { return (box_vector){x, x, x, x, x, x, x, x}; }

#ifdef __AVX2__
/* a < b ? a : b and a > b ? a : b: b where a number is NaN. */
BOX_INLINE box_vector box_vector_least(box_vector a, box_vector b) {
    return (box_vector)_mm256_min_ps((__m256)a, (__m256)b);
}
BOX_INLINE box_vector box_vector_most(box_vector a, box_vector b) {
    return (box_vector)_mm256_max_ps((__m256)a, (__m256)b);
}
/* Bit l: lane l is above 0. */
BOX_INLINE uint32_t box_vector_positive(box_vector a) {
    __m256 const above = _mm256_cmp_ps((__m256)a, _mm256_setzero_ps(), _CMP_GT_OQ);
    return (uint32_t)_mm256_movemask_ps(above);
}
#else
BOX_INLINE box_vector box_vector_choose(box_index mask, box_vector yes, box_vector no) {
    return (box_vector)((mask & (box_index)yes) | (~mask & (box_index)no));
}
BOX_INLINE box_vector box_vector_least(box_vector a, box_vector b) {
    return box_vector_choose(a < b, a, b);
}
BOX_INLINE box_vector box_vector_most(box_vector a, box_vector b) {
    return box_vector_choose(a > b, a, b);
}
BOX_INLINE uint32_t box_vector_positive(box_vector a) {
    uint32_t bits = 0;
    for (uint32_t l = 0; l < 8; l++) bits |= (uint32_t)(a[l] > 0.0F) << l;
    return bits;
}
#endif

#define BOX_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)

/* Lane l of row k becomes lane k of box l. */
BOX_INLINE void box_vectors_transpose(const box_vector boxes[8], box_vector rows[8]) {
    box_vector twos[8], fours[8];
    for (int i = 0; i < 8; i += 2) {
        twos[i] = BOX_SHUFFLE(boxes[i], boxes[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        twos[i + 1] = BOX_SHUFFLE(boxes[i], boxes[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
    }
    /* fours[4 h + k]: sides k and 4 + k of boxes 4 h .. 4 h + 3 */
    for (int h = 0; h < 8; h += 4)
        for (int i = 0; i < 2; i++) {
            fours[h + 2 * i] = BOX_SHUFFLE(twos[h + i], twos[h + 2 + i], 0, 1, 8, 9, 4, 5, 12, 13);
            fours[h + 2 * i + 1] =
                BOX_SHUFFLE(twos[h + i], twos[h + 2 + i], 2, 3, 10, 11, 6, 7, 14, 15);
        }
    for (int k = 0; k < 4; k++) {
        rows[k] = BOX_SHUFFLE(fours[k], fours[4 + k], 0, 1, 2, 3, 8, 9, 10, 11);
        rows[4 + k] = BOX_SHUFFLE(fours[k], fours[4 + k], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

/* Rows of `width`: low x, y, z, high x, y, z. */
BOX_INLINE void box_vectors_write_rows(const box_vector boxes[8], float *to, size_t width) {
    box_vector rows[8];
    box_vectors_transpose(boxes, rows);
    for (size_t k = 0; k < 3; k++) {
        box_vector_store(to + k * width, rows[k]);
        box_vector_store(to + (3 + k) * width, -rows[4 + k]);
    }
}

/* Low x, y, z, high x, y, z. */
BOX_INLINE void box_vector_write(box_vector box, float *to) {
    for (int k = 0; k < 3; k++) {
        to[k] = box[k];
        to[3 + k] = -box[4 + k];
    }
}

#endif
