/* math/simd_double.h - eight doubles at a time, for kernels (see kernel_target.h): the same bits on
 * every vector width. Comparisons with NaN are false. */
#ifndef TULLE_MATH_SIMD_DOUBLE_H
#define TULLE_MATH_SIMD_DOUBLE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#define SIMD_INLINE static inline __attribute__((always_inline))

enum { DOUBLE_LANES = 8 };

typedef double double8 __attribute__((vector_size(64)));
typedef int64_t int64x8 __attribute__((vector_size(64)));
typedef uint32_t lane_mask; /* bit k: lane k */

/* One truth value a lane. */
#ifdef __AVX512F__
typedef __mmask8 bool8;
#else
typedef int64x8 bool8; /* 0 or -1 */
#endif

typedef struct vec3x8 {
    double8 x, y, z;
} vec3x8;

SIMD_INLINE double8 double8_fill(double a) { return (double8){a, a, a, a, a, a, a, a}; }

SIMD_INLINE double8 double8_load(const double *from) {
    double8 a;
    memcpy(&a, from, sizeof a);
    return a;
}

SIMD_INLINE void double8_store(double *to, double8 a) { memcpy(to, &a, sizeof a); }

#ifdef __AVX512F__
SIMD_INLINE bool8 double8_greater(double8 a, double8 b) {
    return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_GT_OQ);
}
SIMD_INLINE bool8 double8_equal(double8 a, double8 b) {
    return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_EQ_OQ);
}
SIMD_INLINE bool8 bool8_and(bool8 a, bool8 b) { return (bool8)(a & b); }
SIMD_INLINE bool8 bool8_or(bool8 a, bool8 b) { return (bool8)(a | b); }
SIMD_INLINE bool8 bool8_not(bool8 a) { return (bool8)~a; }
SIMD_INLINE double8 double8_select(bool8 which, double8 a, double8 b) {
    return (double8)_mm512_mask_blend_pd(which, (__m512d)b, (__m512d)a);
}
SIMD_INLINE lane_mask bool8_bits(bool8 a) { return a; }
SIMD_INLINE bool8 bool8_from_bits(lane_mask bits) { return (bool8)bits; }
SIMD_INLINE double8 double8_min(double8 a, double8 b) {
    return (double8)_mm512_min_pd((__m512d)a, (__m512d)b);
}
SIMD_INLINE double8 double8_max(double8 a, double8 b) {
    return (double8)_mm512_max_pd((__m512d)a, (__m512d)b);
}
SIMD_INLINE double8 double8_sqrt(double8 a) { return (double8)_mm512_sqrt_pd((__m512d)a); }
/* Lanes in `which`, moved together, to to[0 ..]; lanes after them are written too. */
SIMD_INLINE void double8_store_packed(double *to, lane_mask which, double8 a) {
    double8_store(to, (double8)_mm512_maskz_compress_pd((__mmask8)which, (__m512d)a));
}
/* The lanes in `which` become from[0], from[1] ..; up to from[7] is read. */
SIMD_INLINE double8 double8_load_spread(const double *from, lane_mask which, double8 others) {
    return (double8)_mm512_mask_expand_pd((__m512d)others, (__mmask8)which,
                                          (__m512d)double8_load(from));
}
#else
#ifdef __AVX2__
/* By halves: the compiler would take vectors as wide as this apart into single numbers. */
typedef union double8_halves {
    double8 all;
    __m256d half[2];
} double8_halves;

#define BY_HALVES(operation, a, b)                                                                 \
    double8_halves x = {(a)}, y = {(b)};                                                           \
    x.half[0] = operation(x.half[0], y.half[0]);                                                   \
    x.half[1] = operation(x.half[1], y.half[1])
#define COMPARE_GREATER(a, b) _mm256_cmp_pd(a, b, _CMP_GT_OQ)
#define COMPARE_EQUAL(a, b) _mm256_cmp_pd(a, b, _CMP_EQ_OQ)

SIMD_INLINE bool8 double8_greater(double8 a, double8 b) {
    BY_HALVES(COMPARE_GREATER, a, b);
    return (bool8)x.all;
}
SIMD_INLINE bool8 double8_equal(double8 a, double8 b) {
    BY_HALVES(COMPARE_EQUAL, a, b);
    return (bool8)x.all;
}
SIMD_INLINE double8 double8_min(double8 a, double8 b) {
    BY_HALVES(_mm256_min_pd, a, b);
    return x.all;
}
SIMD_INLINE double8 double8_max(double8 a, double8 b) {
    BY_HALVES(_mm256_max_pd, a, b);
    return x.all;
}
SIMD_INLINE double8 double8_sqrt(double8 a) {
    double8_halves x = {a};
    x.half[0] = _mm256_sqrt_pd(x.half[0]);
    x.half[1] = _mm256_sqrt_pd(x.half[1]);
    return x.all;
}
SIMD_INLINE double8 double8_select(bool8 which, double8 a, double8 b) {
    double8_halves x = {a}, y = {b}, z = {(double8)which};
    x.half[0] = _mm256_blendv_pd(y.half[0], x.half[0], z.half[0]);
    x.half[1] = _mm256_blendv_pd(y.half[1], x.half[1], z.half[1]);
    return x.all;
}
SIMD_INLINE lane_mask bool8_bits(bool8 a) {
    double8_halves x = {(double8)a};
    return (lane_mask)_mm256_movemask_pd(x.half[0]) | (lane_mask)_mm256_movemask_pd(x.half[1]) << 4;
}
#else
SIMD_INLINE bool8 double8_greater(double8 a, double8 b) { return (bool8)(a > b); }
SIMD_INLINE bool8 double8_equal(double8 a, double8 b) { return (bool8)(a == b); }
SIMD_INLINE double8 double8_select(bool8 which, double8 a, double8 b) {
    return (double8)((which & (int64x8)a) | (~which & (int64x8)b));
}
SIMD_INLINE double8 double8_min(double8 a, double8 b) { return double8_select(a < b, a, b); }
SIMD_INLINE double8 double8_max(double8 a, double8 b) { return double8_select(a > b, a, b); }
SIMD_INLINE double8 double8_sqrt(double8 a) {
    for (int k = 0; k < DOUBLE_LANES; k++) a[k] = sqrt(a[k]);
    return a;
}
SIMD_INLINE lane_mask bool8_bits(bool8 a) {
    lane_mask bits = 0;
    for (int k = 0; k < DOUBLE_LANES; k++) bits |= (lane_mask)(a[k] & 1) << k;
    return bits;
}
#endif
SIMD_INLINE bool8 bool8_and(bool8 a, bool8 b) { return a & b; }
SIMD_INLINE bool8 bool8_or(bool8 a, bool8 b) { return a | b; }
SIMD_INLINE bool8 bool8_not(bool8 a) { return ~a; }
SIMD_INLINE bool8 bool8_from_bits(lane_mask bits) {
    bool8 a;
    for (int k = 0; k < DOUBLE_LANES; k++) a[k] = -(int64_t)(bits >> k & 1);
    return a;
}
SIMD_INLINE void double8_store_packed(double *to, lane_mask which, double8 a) {
    for (; which; which &= which - 1) *to++ = a[__builtin_ctz(which)];
}
SIMD_INLINE double8 double8_load_spread(const double *from, lane_mask which, double8 others) {
    for (; which; which &= which - 1) others[__builtin_ctz(which)] = *from++;
    return others;
}
#endif

SIMD_INLINE double8 double8_abs(double8 a) { return (double8)((int64x8)a & INT64_MAX); }

SIMD_INLINE vec3x8 vec3x8_sub(vec3x8 a, vec3x8 b) {
    return (vec3x8){a.x - b.x, a.y - b.y, a.z - b.z};
}
SIMD_INLINE vec3x8 vec3x8_add(vec3x8 a, vec3x8 b) {
    return (vec3x8){a.x + b.x, a.y + b.y, a.z + b.z};
}
SIMD_INLINE vec3x8 vec3x8_neg(vec3x8 a) { return (vec3x8){-a.x, -a.y, -a.z}; }
SIMD_INLINE vec3x8 vec3x8_scale(vec3x8 a, double8 s) { return (vec3x8){a.x * s, a.y * s, a.z * s}; }
/* a + s b */
SIMD_INLINE vec3x8 vec3x8_add_scaled(vec3x8 a, vec3x8 b, double8 s) {
    return (vec3x8){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
SIMD_INLINE double8 vec3x8_dot(vec3x8 a, vec3x8 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SIMD_INLINE vec3x8 vec3x8_cross(vec3x8 a, vec3x8 b) {
    return (vec3x8){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
SIMD_INLINE vec3x8 vec3x8_select(bool8 which, vec3x8 a, vec3x8 b) {
    return (vec3x8){double8_select(which, a.x, b.x), double8_select(which, a.y, b.y),
                    double8_select(which, a.z, b.z)};
}

#endif
