/* math/simd.h - compares boxes side by side, one a lane, with one box; and writes the lane numbers
 * of a mask without gaps. For kernels: each target has its own instructions, and all give the same
 * bits.
 *
 * Side k of lane l lies at sides[k * stride + l]; k counts low x, y, z, high x, y, z. Loads read
 * all lanes, so arrays end with that much room. The caller masks lanes that are not wanted. */
#ifndef TULLE_MATH_SIMD_H
#define TULLE_MATH_SIMD_H

#include <stddef.h>
#include <stdint.h>

#ifdef __SSE2__
#include <immintrin.h>
#endif

#ifdef __AVX512F__

typedef struct box_lanes8 {
    __m256 sides[6];
} box_lanes8;
typedef struct box_lanes16 {
    __m512 sides[6];
} box_lanes16;

static inline box_lanes8 box_lanes8_load(const float *sides, size_t stride) {
    box_lanes8 lanes;
    for (size_t k = 0; k < 6; k++) lanes.sides[k] = _mm256_loadu_ps(sides + k * stride);
    return lanes;
}
static inline box_lanes16 box_lanes16_load(const float *sides, size_t stride) {
    box_lanes16 lanes;
    for (size_t k = 0; k < 6; k++) lanes.sides[k] = _mm512_loadu_ps(sides + k * stride);
    return lanes;
}

/* Bit l: lane l meets the box whose side k is box[k * stride]. */
static inline uint32_t box_lanes8_meet(const box_lanes8 *lanes, const float *box, size_t stride) {
    __mmask8 low = _mm256_cmp_ps_mask(lanes->sides[0], _mm256_set1_ps(box[3 * stride]), _CMP_LE_OQ);
    __mmask8 high = _mm256_cmp_ps_mask(lanes->sides[3], _mm256_set1_ps(box[0]), _CMP_GE_OQ);
    for (size_t k = 1; k < 3; k++) {
        low = _mm256_mask_cmp_ps_mask(low, lanes->sides[k], _mm256_set1_ps(box[(3 + k) * stride]),
                                      _CMP_LE_OQ);
        high = _mm256_mask_cmp_ps_mask(high, lanes->sides[3 + k], _mm256_set1_ps(box[k * stride]),
                                       _CMP_GE_OQ);
    }
    return (uint32_t)(low & high);
}
static inline uint32_t box_lanes16_meet(const box_lanes16 *lanes, const float *box, size_t stride) {
    __mmask16 low =
        _mm512_cmp_ps_mask(lanes->sides[0], _mm512_set1_ps(box[3 * stride]), _CMP_LE_OQ);
    __mmask16 high = _mm512_cmp_ps_mask(lanes->sides[3], _mm512_set1_ps(box[0]), _CMP_GE_OQ);
    for (size_t k = 1; k < 3; k++) {
        low = _mm512_mask_cmp_ps_mask(low, lanes->sides[k], _mm512_set1_ps(box[(3 + k) * stride]),
                                      _CMP_LE_OQ);
        high = _mm512_mask_cmp_ps_mask(high, lanes->sides[3 + k], _mm512_set1_ps(box[k * stride]),
                                       _CMP_GE_OQ);
    }
    return (uint32_t)(low & high);
}

/* Writes base + l for each bit l of the mask, ascending, and whatever after them, 8 or 16 in all.
 * Compressed in a register: storing compressed is slow on some processors. */
static inline void lanes8_compress(uint32_t mask, uint32_t base, uint32_t *to) {
    __m256i const numbers =
        _mm256_add_epi32(_mm256_set1_epi32((int)base), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    _mm256_storeu_si256((__m256i *)(void *)to,
                        _mm256_maskz_compress_epi32((__mmask8)mask, numbers));
}
static inline void lanes16_compress(uint32_t mask, uint32_t base, uint32_t *to) {
    __m512i const numbers =
        _mm512_add_epi32(_mm512_set1_epi32((int)base),
                         _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32((__mmask16)mask, numbers));
}

/* Bit l: values[l] is `value`. */
static inline uint32_t lanes8_equal(const uint32_t *values, uint32_t value) {
    return _mm256_cmpeq_epi32_mask(_mm256_loadu_si256((const __m256i *)(const void *)values),
                                   _mm256_set1_epi32((int)value));
}
static inline uint32_t lanes16_equal(const uint32_t *values, uint32_t value) {
    return _mm512_cmpeq_epi32_mask(_mm512_loadu_si512(values), _mm512_set1_epi32((int)value));
}

#else

#ifdef __AVX2__

typedef struct box_lanes8 {
    __m256 sides[6];
} box_lanes8;

static inline box_lanes8 box_lanes8_load(const float *sides, size_t stride) {
    box_lanes8 lanes;
    for (size_t k = 0; k < 6; k++) lanes.sides[k] = _mm256_loadu_ps(sides + k * stride);
    return lanes;
}
static inline uint32_t box_lanes8_meet(const box_lanes8 *lanes, const float *box, size_t stride) {
    __m256 meets = _mm256_cmp_ps(lanes->sides[0], _mm256_set1_ps(box[3 * stride]), _CMP_LE_OQ);
    for (size_t k = 1; k < 3; k++)
        meets =
            _mm256_and_ps(meets, _mm256_cmp_ps(lanes->sides[k],
                                               _mm256_set1_ps(box[(3 + k) * stride]), _CMP_LE_OQ));
    for (size_t k = 0; k < 3; k++)
        meets = _mm256_and_ps(
            meets, _mm256_cmp_ps(lanes->sides[3 + k], _mm256_set1_ps(box[k * stride]), _CMP_GE_OQ));
    return (uint32_t)_mm256_movemask_ps(meets);
}
/* Four bits a lane: the number of the lane that goes there, found by the parallel extraction of
 * all lane numbers. */
static inline void lanes8_compress(uint32_t mask, uint32_t base, uint32_t *to) {
    uint64_t const wide = _pdep_u64(mask, 0x0101010101010101U) * 0xffU;
    uint64_t const order = _pext_u64(0x0706050403020100U, wide);
    __m256i const numbers = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)order));
    _mm256_storeu_si256((__m256i *)(void *)to,
                        _mm256_add_epi32(numbers, _mm256_set1_epi32((int)base)));
}
static inline uint32_t lanes8_equal(const uint32_t *values, uint32_t value) {
    __m256i const lanes = _mm256_loadu_si256((const __m256i *)(const void *)values);
    __m256i const equal = _mm256_cmpeq_epi32(lanes, _mm256_set1_epi32((int)value));
    return (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(equal));
}

#else

typedef struct box_lanes8 {
    const float *sides;
    size_t stride;
} box_lanes8;

static inline box_lanes8 box_lanes8_load(const float *sides, size_t stride) {
    return (box_lanes8){sides, stride};
}
#ifdef __SSE2__
/* Bit l: lane l of four meets the box. */
static inline uint32_t quad_meet(const float *sides, size_t n, const float *box, size_t stride) {
    __m128 meets = _mm_cmple_ps(_mm_loadu_ps(sides), _mm_set1_ps(box[3 * stride]));
    for (size_t k = 1; k < 3; k++)
        meets = _mm_and_ps(
            meets, _mm_cmple_ps(_mm_loadu_ps(sides + k * n), _mm_set1_ps(box[(3 + k) * stride])));
    for (size_t k = 0; k < 3; k++)
        meets = _mm_and_ps(
            meets, _mm_cmpge_ps(_mm_loadu_ps(sides + (3 + k) * n), _mm_set1_ps(box[k * stride])));
    return (uint32_t)_mm_movemask_ps(meets);
}
static inline uint32_t box_lanes8_meet(const box_lanes8 *lanes, const float *box, size_t stride) {
    return quad_meet(lanes->sides, lanes->stride, box, stride) |
           quad_meet(lanes->sides + 4, lanes->stride, box, stride) << 4;
}
#else
static inline uint32_t box_lanes8_meet(const box_lanes8 *lanes, const float *box, size_t stride) {
    const float *const a = lanes->sides;
    size_t const n = lanes->stride;
    uint32_t mask = 0;
    for (size_t l = 0; l < 8; l++) {
        uint32_t const meets = (a[l] <= box[3 * stride]) & (a[n + l] <= box[4 * stride]) &
                               (a[2 * n + l] <= box[5 * stride]) & (a[3 * n + l] >= box[0]) &
                               (a[4 * n + l] >= box[stride]) & (a[5 * n + l] >= box[2 * stride]);
        mask |= meets << l;
    }
    return mask;
}
#endif
static inline void lanes8_compress(uint32_t mask, uint32_t base, uint32_t *to) {
    for (uint32_t l = 0; l < 8; l++) {
        *to = base + l;
        to += mask >> l & 1U;
    }
}
static inline uint32_t lanes8_equal(const uint32_t *values, uint32_t value) {
    uint32_t mask = 0;
    for (uint32_t l = 0; l < 8; l++) mask |= (uint32_t)(values[l] == value) << l;
    return mask;
}

#endif

/* Sixteen lanes as twice eight. */
typedef struct box_lanes16 {
    box_lanes8 halves[2];
} box_lanes16;

static inline box_lanes16 box_lanes16_load(const float *sides, size_t stride) {
    return (box_lanes16){{box_lanes8_load(sides, stride), box_lanes8_load(sides + 8, stride)}};
}
static inline uint32_t box_lanes16_meet(const box_lanes16 *lanes, const float *box, size_t stride) {
    return box_lanes8_meet(&lanes->halves[0], box, stride) |
           box_lanes8_meet(&lanes->halves[1], box, stride) << 8;
}
static inline void lanes16_compress(uint32_t mask, uint32_t base, uint32_t *to) {
    lanes8_compress(mask & 0xffU, base, to);
    lanes8_compress(mask >> 8, base + 8, to + __builtin_popcount(mask & 0xffU));
}
static inline uint32_t lanes16_equal(const uint32_t *values, uint32_t value) {
    return lanes8_equal(values, value) | lanes8_equal(values + 8, value) << 8;
}

#endif

/* Writes a value to 8 or 16 places. */
static inline void lanes8_fill(uint32_t value, uint32_t *to) {
    for (size_t l = 0; l < 8; l++) to[l] = value;
}
static inline void lanes16_fill(uint32_t value, uint32_t *to) {
    for (size_t l = 0; l < 16; l++) to[l] = value;
}

/* The number of bits of a mask. */
static inline uint32_t count_lanes(uint32_t mask) { return (uint32_t)__builtin_popcount(mask); }
/* The lowest bit of a mask that is not 0. */
static inline uint32_t first_lane(uint32_t mask) { return (uint32_t)__builtin_ctz(mask); }

#endif
