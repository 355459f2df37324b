/* math/simd_wide.h - as many doubles at a time as a register of the target holds, for kernels (see
 * kernel_target.h) that do the same for each: the same bits on every vector width. Comparisons with
 * NaN are false. Where a kernel needs eight on every target, see simd_double.h. */
#ifndef TULLE_MATH_SIMD_WIDE_H
#define TULLE_MATH_SIMD_WIDE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#define SIMD_INLINE static inline __attribute__((always_inline))

#if defined __AVX512F__
enum { WIDE_LANES = 8 };
#elif defined __AVX2__
enum { WIDE_LANES = 4 };
#else
enum { WIDE_LANES = 2 };
#endif

typedef double wide __attribute__((vector_size(8 * WIDE_LANES)));
typedef int64_t wide_integer __attribute__((vector_size(8 * WIDE_LANES)));

/* One truth value a lane. */
#ifdef __AVX512F__
typedef __mmask8 wide_bool;
#else
typedef wide_integer wide_bool; /* 0 or -1 */
#endif

typedef struct wide3 {
    wide x, y, z;
} wide3;

SIMD_INLINE wide wide_load(const double *from) {
    wide a;
    memcpy(&a, from, sizeof a);
    return a;
}

SIMD_INLINE void wide_store(double *to, wide a) { memcpy(to, &a, sizeof a); }

#if defined __AVX512F__
SIMD_INLINE wide wide_fill(double a) { return (wide)_mm512_set1_pd(a); }
SIMD_INLINE wide_bool wide_greater(wide a, wide b) {
    return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_GT_OQ);
}
SIMD_INLINE wide_bool wide_not(wide_bool a) { return (wide_bool)~a; }
SIMD_INLINE wide wide_select(wide_bool which, wide a, wide b) {
    return (wide)_mm512_mask_blend_pd(which, (__m512d)b, (__m512d)a);
}
SIMD_INLINE wide wide_min(wide a, wide b) { return (wide)_mm512_min_pd((__m512d)a, (__m512d)b); }
SIMD_INLINE wide wide_max(wide a, wide b) { return (wide)_mm512_max_pd((__m512d)a, (__m512d)b); }
SIMD_INLINE wide wide_sqrt(wide a) { return (wide)_mm512_sqrt_pd((__m512d)a); }
#elif defined __AVX2__
SIMD_INLINE wide wide_fill(double a) { return (wide)_mm256_set1_pd(a); }
SIMD_INLINE wide_bool wide_greater(wide a, wide b) {
    return (wide_bool)_mm256_cmp_pd((__m256d)a, (__m256d)b, _CMP_GT_OQ);
}
SIMD_INLINE wide_bool wide_not(wide_bool a) { return ~a; }
SIMD_INLINE wide wide_select(wide_bool which, wide a, wide b) {
    return (wide)_mm256_blendv_pd((__m256d)b, (__m256d)a, (__m256d)which);
}
SIMD_INLINE wide wide_min(wide a, wide b) { return (wide)_mm256_min_pd((__m256d)a, (__m256d)b); }
SIMD_INLINE wide wide_max(wide a, wide b) { return (wide)_mm256_max_pd((__m256d)a, (__m256d)b); }
SIMD_INLINE wide wide_sqrt(wide a) { return (wide)_mm256_sqrt_pd((__m256d)a); }
#else
SIMD_INLINE wide wide_fill(double a) { return (wide){a, a}; }
SIMD_INLINE wide_bool wide_greater(wide a, wide b) { return (wide_bool)(a > b); }
SIMD_INLINE wide_bool wide_not(wide_bool a) { return ~a; }
SIMD_INLINE wide wide_select(wide_bool which, wide a, wide b) {
    return (wide)((which & (wide_integer)a) | (~which & (wide_integer)b));
}
SIMD_INLINE wide wide_min(wide a, wide b) { return wide_select(a < b, a, b); }
SIMD_INLINE wide wide_max(wide a, wide b) { return wide_select(a > b, a, b); }
SIMD_INLINE wide wide_sqrt(wide a) {
    for (int k = 0; k < WIDE_LANES; k++) a[k] = sqrt(a[k]);
    return a;
}
#endif

SIMD_INLINE wide wide_abs(wide a) { return (wide)((wide_integer)a & INT64_MAX); }

SIMD_INLINE wide3 wide3_sub(wide3 a, wide3 b) { return (wide3){a.x - b.x, a.y - b.y, a.z - b.z}; }
SIMD_INLINE wide3 wide3_add(wide3 a, wide3 b) { return (wide3){a.x + b.x, a.y + b.y, a.z + b.z}; }
SIMD_INLINE wide3 wide3_neg(wide3 a) { return (wide3){-a.x, -a.y, -a.z}; }
SIMD_INLINE wide3 wide3_scale(wide3 a, wide s) { return (wide3){a.x * s, a.y * s, a.z * s}; }
/* a + s b */
SIMD_INLINE wide3 wide3_add_scaled(wide3 a, wide3 b, wide s) {
    return (wide3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
SIMD_INLINE wide wide3_dot(wide3 a, wide3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SIMD_INLINE wide3 wide3_cross(wide3 a, wide3 b) {
    return (wide3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

#endif
