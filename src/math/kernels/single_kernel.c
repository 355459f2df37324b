/* math/kernels/single_kernel.c - see single_kernel.h.
 *
 * A block times three numbers is nine products: one lane each where a register has sixteen, else
 * three times four lanes. Each lane's sum is over the blocks of a row in their order, so both give
 * the same bits. */
#include "math/single_kernel.h"

#include <stdbool.h>
#include <string.h>

#define SINGLE_INLINE static inline __attribute__((always_inline))

typedef float lanes4 __attribute__((vector_size(16)));

SINGLE_INLINE lanes4 load4(const float *from) {
    lanes4 a;
    memcpy(&a, from, sizeof a);
    return a;
}
SINGLE_INLINE void store4(float *to, lanes4 a) { memcpy(to, &a, sizeof a); }
SINGLE_INLINE void store3(float *to, lanes4 a) { memcpy(to, &a, 3 * sizeof(float)); }

/* Dots are summed in sixteen lanes, whatever the registers are. */
typedef float lanes16 __attribute__((vector_size(64)));
SINGLE_INLINE lanes16 load16(const float *from) {
    lanes16 a;
    memcpy(&a, from, sizeof a);
    return a;
}
SINGLE_INLINE void store16(float *to, lanes16 a) { memcpy(to, &a, sizeof a); }
SINGLE_INLINE float add_lanes(lanes16 a) {
    float sums[16];
    store16(sums, a);
    for (size_t half = 8; half > 0; half /= 2)
        for (size_t l = 0; l < half; l++) sums[l] += sums[l + half];
    return sums[0];
}

SINGLE_INLINE float dot(const float *a, const float *b, size_t begin, size_t end) {
    lanes16 sum = {0};
    size_t i = begin;
    for (; i + 16 <= end; i += 16) sum += load16(a + i) * load16(b + i);
    float rest = 0.0F;
    for (; i < end; i++) rest += a[i] * b[i];
    return add_lanes(sum) + rest;
}

#ifdef __AVX512F__
/* Lanes of a block's nine products: the three numbers of x, each thrice. */
SINGLE_INLINE lanes16 spread(lanes16 x) {
    return __builtin_shufflevector(x, x, 0, 0, 0, 1, 1, 1, 2, 2, 2, 0, 0, 0, 0, 0, 0, 0);
}
/* Sums of the columns' lanes. */
SINGLE_INLINE lanes4 fold(lanes16 a) {
    lanes16 const second =
        __builtin_shufflevector(a, a, 3, 4, 5, 6, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3);
    lanes16 const third =
        __builtin_shufflevector(a, a, 6, 7, 8, 9, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6);
    lanes16 const sum = (a + second) + third;
    return __builtin_shufflevector(sum, sum, 0, 1, 2, 3);
}
#endif

/* The blocks of a row times their columns' numbers. */
SINGLE_INLINE lanes4 multiply_blocks(const single_matrix *matrix, const float *x, size_t row) {
    uint32_t const end = matrix->row_begin[row + 1];
#ifdef __AVX512F__
    lanes16 sum = {0};
    for (uint32_t k = matrix->row_begin[row]; k < end; k++)
        sum += load16(matrix->values + 9 * (size_t)k) *
               spread(load16(x + 3 * (size_t)matrix->columns[k]));
    return fold(sum);
#else
    lanes4 sum0 = {0}, sum1 = {0}, sum2 = {0};
    for (uint32_t k = matrix->row_begin[row]; k < end; k++) {
        const float *const block = matrix->values + 9 * (size_t)k;
        const float *const entry = x + 3 * (size_t)matrix->columns[k];
        sum0 += load4(block) * entry[0];
        sum1 += load4(block + 3) * entry[1];
        sum2 += load4(block + 6) * entry[2];
    }
    return (sum0 + sum1) + sum2;
#endif
}

/* Even and odd scalars in two sums, so that additions need not wait for one another. */
SINGLE_INLINE lanes4 multiply_scalars(const single_matrix *matrix, const float *x, size_t row) {
    lanes4 even = {0}, odd = {0};
    uint32_t k = matrix->scalar_begin[row];
    uint32_t const end = matrix->scalar_begin[row + 1];
    for (; k + 2 <= end; k += 2) {
        even += load4(x + 3 * (size_t)matrix->scalar_columns[k]) * matrix->scalar_values[k];
        odd += load4(x + 3 * (size_t)matrix->scalar_columns[k + 1]) * matrix->scalar_values[k + 1];
    }
    if (k < end)
        even += load4(x + 3 * (size_t)matrix->scalar_columns[k]) * matrix->scalar_values[k];
    return even + odd;
}

float TULLE_KERNEL(single_multiply)(const single_matrix *matrix, const single_vectors *vectors,
                                    size_t begin, size_t end) {
    const float *const x = vectors->direction;
    lanes4 sum = {0};
    for (size_t row = begin; row < end; row++) {
        lanes4 const y = multiply_blocks(matrix, x, row) + multiply_scalars(matrix, x, row);
        sum += y * load4(x + 3 * row);
        if (row + 1 < end)
            store4(vectors->product + 3 * row, y); /* the next row puts its first number right */
        else
            store3(vectors->product + 3 * row, y);
    }
    return (sum[0] + sum[1]) + sum[2];
}

/* z = P^-1 r of a vertex; `has_room`: as many numbers as a register holds may be read after r. */
SINGLE_INLINE lanes4 multiply_inverse(const float *m, const float *r, const bool has_room) {
#ifdef __AVX512F__
    if (has_room) return fold(load16(m) * spread(load16(r)));
#endif
    (void)has_room;
    return (load4(m) * r[0] + load4(m + 3) * r[1]) + load4(m + 6) * r[2];
}

float TULLE_KERNEL(single_advance)(const single_vectors *vectors, float alpha, size_t begin,
                                   size_t end) {
    for (size_t i = 3 * begin; i < 3 * end; i++) vectors->x[i] += vectors->direction[i] * alpha;
    for (size_t i = 3 * begin; i < 3 * end; i++)
        vectors->residual[i] -= vectors->product[i] * alpha;
    size_t v = begin;
    for (; v + 6 <= end; v++)
        store4(vectors->preconditioned + 3 * v,
               multiply_inverse(vectors->inverse + 9 * v, vectors->residual + 3 * v, true));
    for (; v < end; v++)
        store3(vectors->preconditioned + 3 * v,
               multiply_inverse(vectors->inverse + 9 * v, vectors->residual + 3 * v, false));
    return dot(vectors->preconditioned, vectors->residual, 3 * begin, 3 * end);
}

void TULLE_KERNEL(single_turn)(const single_vectors *vectors, float beta, size_t begin,
                               size_t end) {
    for (size_t i = 3 * begin; i < 3 * end; i++)
        vectors->direction[i] = vectors->preconditioned[i] + beta * vectors->direction[i];
}

void TULLE_KERNEL(single_dots)(const single_vectors *vectors, size_t begin, size_t end,
                               float dots[2]) {
    dots[0] = dot(vectors->preconditioned, vectors->residual, 3 * begin, 3 * end);
    dots[1] = dot(vectors->preconditioned, vectors->product, 3 * begin, 3 * end);
}
