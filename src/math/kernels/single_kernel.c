/* math/kernels/single_kernel.c - see single_kernel.h.
 *
 * A block times three numbers is nine products. Wide registers hold them side by side; lanes
 * beyond them are ignored. Each lane adds up the blocks of a row in their order, so all widths give
 * the same bits. */
#include "math/single_kernel.h"
#include "math/single_lanes.h"

#ifdef __AVX2__
#include <immintrin.h>
#endif

/* For places where the number after the three may belong to another thread. */
SINGLE_INLINE floats4 load3(const float *from) {
    floats4 const a = {from[0], from[1], from[2], 0.0F};
    return a;
}
SINGLE_INLINE void store3(float *to, floats4 a) { memcpy(to, &a, 3 * sizeof(float)); }

#ifdef __AVX512F__
/* The six numbers of a block, with the two after them, stand side by side twice. The first six meet
 * the numbers of x that belong to them in the upper triangle, the second six those in the lower
 * one. Other lanes are ignored. */
typedef __m512 column_sums;
SINGLE_INLINE column_sums no_sums(void) { return _mm512_setzero_ps(); }
SINGLE_INLINE column_sums add_columns(column_sums sums, const float *block, floats4 x) {
    __m512i const places = _mm512_setr_epi32(0, 1, 2, 1, 2, 2, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0);
    __m512 const numbers = _mm512_broadcast_f32x8(_mm256_loadu_ps(block));
    __m512 const met = _mm512_permutexvar_ps(places, _mm512_castps128_ps512((__m128)x));
    return _mm512_add_ps(sums, _mm512_mul_ps(numbers, met));
}
SINGLE_INLINE floats4 pick(column_sums sums, int first, int second, int third) {
    __m512i const places = _mm512_castsi128_si512(_mm_setr_epi32(first, second, third, 0));
    return (floats4)_mm512_castps512_ps128(_mm512_permutexvar_ps(places, sums));
}
SINGLE_INLINE floats4 fold(column_sums sums) {
    return (pick(sums, 0, 9, 10) + pick(sums, 1, 3, 12)) + pick(sums, 2, 4, 5);
}
#elif defined __AVX2__
typedef struct column_sums {
    __m256 upper, lower;
} column_sums;
SINGLE_INLINE column_sums no_sums(void) {
    return (column_sums){_mm256_setzero_ps(), _mm256_setzero_ps()};
}
SINGLE_INLINE column_sums add_columns(column_sums sums, const float *block, floats4 x) {
    __m256i const upper = _mm256_setr_epi32(0, 1, 2, 1, 2, 2, 0, 0);
    __m256i const lower = _mm256_setr_epi32(0, 0, 0, 0, 1, 0, 0, 0);
    __m256 const numbers = _mm256_loadu_ps(block), wide = _mm256_castps128_ps256((__m128)x);
    __m256 const u = _mm256_mul_ps(numbers, _mm256_permutevar8x32_ps(wide, upper));
    __m256 const l = _mm256_mul_ps(numbers, _mm256_permutevar8x32_ps(wide, lower));
    return (column_sums){_mm256_add_ps(sums.upper, u), _mm256_add_ps(sums.lower, l)};
}
SINGLE_INLINE floats4 pick(__m256 sums, int first, int second, int third) {
    __m256i const places = _mm256_setr_epi32(first, second, third, 0, 0, 0, 0, 0);
    return (floats4)_mm256_castps256_ps128(_mm256_permutevar8x32_ps(sums, places));
}
SINGLE_INLINE floats4 fold(column_sums sums) {
    floats4 const first =
        (floats4)_mm256_castps256_ps128(_mm256_blend_ps(sums.upper, sums.lower, 6));
    floats4 const second = pick(_mm256_blend_ps(sums.upper, sums.lower, 16), 1, 3, 4);
    return (first + second) + pick(sums.upper, 2, 4, 5);
}
#else
typedef struct column_sums {
    floats4 first, second, third;
} column_sums;
SINGLE_INLINE column_sums no_sums(void) {
    floats4 const zero = {0};
    return (column_sums){zero, zero, zero};
}
SINGLE_INLINE column_sums add_columns(column_sums sums, const float *block, floats4 x) {
    floats4 const low = floats4_load(block), high = floats4_load(block + 2);
    sums.first += low * x[0];
    sums.second += __builtin_shufflevector(low, high, 1, 3, 6, 6) * x[1];
    sums.third += __builtin_shufflevector(low, high, 2, 6, 7, 7) * x[2];
    return sums;
}
SINGLE_INLINE floats4 fold(column_sums sums) { return (sums.first + sums.second) + sums.third; }
#endif

/* One block alone, in narrow registers, whose rearrangements are cheap. */
SINGLE_INLINE floats4 multiply_block(const float *block, const float *x) {
    floats4 const low = floats4_load(block), high = floats4_load(block + 2);
    return (low * x[0] + __builtin_shufflevector(low, high, 1, 3, 6, 6) * x[1]) +
           __builtin_shufflevector(low, high, 2, 6, 7, 7) * x[2];
}

/* The blocks of a row times their columns' numbers. */
SINGLE_INLINE floats4 multiply_blocks(const float *values, const uint32_t *columns, size_t count,
                                      const float *x) {
    column_sums sums = no_sums();
#pragma GCC unroll 4
    for (size_t k = 0; k < count; k++)
        sums =
            add_columns(sums, values + SINGLE_BLOCK * k, floats4_load(x + 3 * (size_t)columns[k]));
    return fold(sums);
}

/* Even and odd scalars in two sums, so that additions need not wait for one another. */
SINGLE_INLINE floats4 multiply_scalars(const float *values, const uint32_t *columns, size_t count,
                                       const float *x) {
    size_t k = 0;
    floats4 even = {0}, odd = {0};
#ifdef __AVX512F__
    __m256i const places = _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1);
    __m256 both = _mm256_setzero_ps();
#pragma GCC unroll 4
    for (; k + 2 <= count; k += 2) {
        __m256 const first = _mm256_castps128_ps256(_mm_loadu_ps(x + 3 * (size_t)columns[k]));
        __m256 const entries =
            _mm256_insertf128_ps(first, _mm_loadu_ps(x + 3 * (size_t)columns[k + 1]), 1);
        __m128 const pair = _mm_castsi128_ps(_mm_loadl_epi64((const void *)(values + k)));
        __m256 const scalars = _mm256_permutevar8x32_ps(_mm256_castps128_ps256(pair), places);
        both = _mm256_add_ps(both, _mm256_mul_ps(entries, scalars));
    }
    even = (floats4)_mm256_castps256_ps128(both);
    odd = (floats4)_mm256_extractf128_ps(both, 1);
#else
#pragma GCC unroll 2
    for (; k + 2 <= count; k += 2) {
        even += floats4_load(x + 3 * (size_t)columns[k]) * values[k];
        odd += floats4_load(x + 3 * (size_t)columns[k + 1]) * values[k + 1];
    }
#endif
    if (k < count) even += floats4_load(x + 3 * (size_t)columns[k]) * values[k];
    return even + odd;
}

float TULLE_KERNEL(single_multiply)(const single_matrix *matrix, const single_vectors *vectors,
                                    size_t begin, size_t end) {
    const float *restrict const x = vectors->direction;
    float *restrict const product = vectors->product;
    single_matrix const m = *matrix;
    floats4 sum = {0};
    for (size_t row = begin; row < end; row++) {
        size_t const block = m.row_begin[row], scalar = m.scalar_begin[row];
        floats4 const y = multiply_blocks(m.values + SINGLE_BLOCK * block, m.columns + block,
                                          m.row_begin[row + 1] - block, x) +
                          multiply_scalars(m.scalar_values + scalar, m.scalar_columns + scalar,
                                           m.scalar_begin[row + 1] - scalar, x);
        sum += y * floats4_load(x + 3 * row);
        if (row + 1 < end)
            store4(product + 3 * row, y); /* the next row puts its first number right */
        else
            store3(product + 3 * row, y);
    }
    return (sum[0] + sum[1]) + sum[2];
}

float TULLE_KERNEL(single_advance)(const single_vectors *vectors, float alpha, size_t begin,
                                   size_t end) {
    float *restrict const x = vectors->x, *restrict const residual = vectors->residual;
    const float *restrict const direction = vectors->direction;
    const float *restrict const product = vectors->product;
    for (size_t i = 3 * begin; i < 3 * end; i++) x[i] += direction[i] * alpha;
    for (size_t i = 3 * begin; i < 3 * end; i++) residual[i] -= product[i] * alpha;
    const float *restrict const inverse = vectors->inverse;
    float *restrict const z = vectors->preconditioned;
    for (size_t v = begin; v + 1 < end; v++)
        store4(z + 3 * v, multiply_block(inverse + SINGLE_BLOCK * v, residual + 3 * v));
    size_t const last = end - 1; /* chunks are not empty; the next one's numbers are others' */
    store3(z + 3 * last, multiply_block(inverse + SINGLE_BLOCK * last, residual + 3 * last));
    return dot(vectors->preconditioned, vectors->residual, 3 * begin, 3 * end);
}

void TULLE_KERNEL(single_turn)(const single_vectors *vectors, float beta, size_t begin,
                               size_t end) {
    for (size_t i = 3 * begin; i < 3 * end; i++)
        vectors->direction[i] = vectors->preconditioned[i] + beta * vectors->direction[i];
}

void TULLE_KERNEL(single_turn_corrected)(const single_vectors *vectors,
                                         const single_correction *correction, float beta,
                                         size_t begin, size_t end) {
    float *restrict const direction = vectors->direction;
    const float *restrict const z = vectors->preconditioned;
    const float *restrict const values = correction->values;
    const uint32_t *restrict const parents = correction->parents;
    for (size_t v = begin; v < end; v++) {
        floats4 const c = floats4_load(values + 3 * (size_t)parents[v]);
        float const share = correction->is_fixed[v] ? 0.0F : 1.0F;
        floats4 const before =
            v + 1 < end ? floats4_load(direction + 3 * v) : load3(direction + 3 * v);
        store3(direction + 3 * v, (floats4_load(z + 3 * v) + c * share) + before * beta);
    }
}
