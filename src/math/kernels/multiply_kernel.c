/* math/kernels/multiply_kernel.c - the product adds the columns of each block times one entry of x,
 * in vectors of four lanes whose last lane is ignored. What counts is how often memory is read: a
 * block is read in one piece or two, from which the columns are put together. */
#include "math/multiply_kernel.h"

#ifdef __AVX512F__
#include <immintrin.h>
#endif

#define MULTIPLY_INLINE static inline __attribute__((always_inline))

/* Two and four doubles, at any address of a double. */
typedef double lanes2 __attribute__((vector_size(16), aligned(8), may_alias));
typedef double lanes4 __attribute__((vector_size(32), aligned(8), may_alias));

/* Entry of x for a column that is not the last one: its three numbers and the next. */
MULTIPLY_INLINE lanes4 load_entry(const double *x, uint32_t column) {
    return *(const lanes4 *)(x + 3 * (size_t)column);
}

MULTIPLY_INLINE double get_scalar(const block_matrix *matrix, size_t index, bool has_sums) {
    return has_sums ? matrix->scalar_sums[index] : block_matrix_get_scalar(matrix, index);
}

/* The scalars of a row times their entries of x. Even and odd ones have sums of their own, so that
 * additions need not wait for one another. */
typedef struct scalar_sums {
    lanes4 even, odd;
} scalar_sums;

/* Adds scalars, two at a time, up to the last or the last but one. Returns where it stopped. */
MULTIPLY_INLINE size_t add_pairs(const block_matrix *matrix, size_t begin, size_t end,
                                 const double *x, bool has_sums, scalar_sums *result) {
    const uint32_t *const columns = matrix->scalar_columns;
    size_t k = begin;
#ifdef __AVX512F__
    if (has_sums) { /* both sums in one register */
        __m512i const places = _mm512_setr_epi64(0, 0, 0, 0, 1, 1, 1, 1);
        __m512d sums = _mm512_setzero_pd();
#pragma GCC unroll 2
        for (; k + 2 <= end; k += 2) {
            __m512d const first = _mm512_castpd256_pd512((__m256d)load_entry(x, columns[k]));
            __m512d const entries =
                _mm512_insertf64x4(first, (__m256d)load_entry(x, columns[k + 1]), 1);
            __m512d const pair = _mm512_castpd128_pd512(_mm_loadu_pd(matrix->scalar_sums + k));
            sums = _mm512_add_pd(sums, _mm512_mul_pd(_mm512_permutexvar_pd(places, pair), entries));
        }
        result->even = (lanes4)_mm512_castpd512_pd256(sums);
        result->odd = (lanes4)_mm512_extractf64x4_pd(sums, 1);
        return k;
    }
#endif
    lanes4 even = {0}, odd = {0};
#pragma GCC unroll 2
    for (; k + 2 <= end; k += 2) {
        even += get_scalar(matrix, k, has_sums) * load_entry(x, columns[k]);
        odd += get_scalar(matrix, k + 1, has_sums) * load_entry(x, columns[k + 1]);
    }
    *result = (scalar_sums){even, odd};
    return k;
}

/* sum_k s_k x_k over the scalars of a row. Columns ascend, so only the last one can be that of the
 * last vertex, whose x is in last_entry. */
MULTIPLY_INLINE lanes4 add_scalars(const block_matrix *matrix, size_t begin, size_t end,
                                   const double *x, lanes4 last_entry, bool has_sums) {
    const uint32_t *const columns = matrix->scalar_columns;
    bool const has_last = begin < end && columns[end - 1] == matrix->row_count - 1;
    size_t const plain_end = has_last ? end - 1 : end;
    scalar_sums sums;
    size_t const left = add_pairs(matrix, begin, plain_end, x, has_sums, &sums);
    if (left < plain_end) {
        sums.even += get_scalar(matrix, left, has_sums) * load_entry(x, columns[left]);
        if (has_last) sums.odd += get_scalar(matrix, end - 1, has_sums) * last_entry;
    } else if (has_last) {
        sums.even += get_scalar(matrix, end - 1, has_sums) * last_entry;
    }
    return sums.even + sums.odd;
}

/* The columns of a row's blocks, summed times the entries of x: first, second, third. */
typedef struct block_sums {
    lanes4 x, y, z;
} block_sums;

MULTIPLY_INLINE block_sums add_blocks(const block_matrix *matrix, size_t begin, size_t end,
                                      const double *x) {
#ifdef __AVX512F__
    /* the first two in one register */
    __m512i const first_columns = _mm512_setr_epi64(0, 1, 2, 2, 1, 3, 4, 4);
    __m512i const last_column = _mm512_setr_epi64(2, 4, 5, 5, 2, 4, 5, 5);
    __m512i const places = _mm512_setr_epi64(0, 0, 0, 0, 1, 1, 1, 1);
    __m512d sums = _mm512_setzero_pd();
    __m256d last = _mm256_setzero_pd();
#pragma GCC unroll 4
    for (size_t k = begin; k < end; k++) {
        __m512d const block = _mm512_loadu_pd(matrix->values + BLOCK_NUMBERS * k);
        const double *const entry = x + 3 * (size_t)matrix->columns[k];
        __m512d const entries =
            _mm512_permutexvar_pd(places, _mm512_castpd128_pd512(_mm_loadu_pd(entry)));
        sums = _mm512_add_pd(sums,
                             _mm512_mul_pd(_mm512_permutexvar_pd(first_columns, block), entries));
        __m256d const column = _mm512_castpd512_pd256(_mm512_permutexvar_pd(last_column, block));
        last = _mm256_add_pd(last, _mm256_mul_pd(column, _mm256_set1_pd(entry[2])));
    }
    return (block_sums){(lanes4)_mm512_castpd512_pd256(sums),
                        (lanes4)_mm512_extractf64x4_pd(sums, 1), (lanes4)last};
#else
    block_sums sums = {{0}, {0}, {0}};
#pragma GCC unroll 4
    for (size_t k = begin; k < end; k++) {
        const double *const block = matrix->values + BLOCK_NUMBERS * k;
        const double *const entry = x + 3 * (size_t)matrix->columns[k];
        lanes4 const low = *(const lanes4 *)block;
        lanes2 const rest = *(const lanes2 *)(block + 4);
        lanes4 const high = __builtin_shufflevector(rest, rest, 0, 1, -1, -1);
        sums.x += low * entry[0];
        sums.y += __builtin_shufflevector(low, high, 1, 3, 4, 4) * entry[1];
        sums.z += __builtin_shufflevector(low, high, 2, 4, 5, 5) * entry[2];
    }
    return sums;
#endif
}

MULTIPLY_INLINE void multiply(const multiply_task *task, size_t begin, size_t end, bool has_sums) {
    block_matrix const own = *task->matrix, *const matrix = &own;
    const double *const x = task->x;
    double *const result = task->result;
    /* Four numbers are read for each vertex, its three and the next. The last vertex has no next
     * one. */
    size_t const last = matrix->row_count - 1;
    lanes4 const last_entry = {x[3 * last], x[3 * last + 1], x[3 * last + 2], 0.0};
    size_t k = matrix->row_begin[begin], s = matrix->scalar_begin[begin];
    for (size_t row = begin; row < end; row++) {
        size_t const block_end = matrix->row_begin[row + 1];
        block_sums const blocks = add_blocks(matrix, k, block_end, x);
        k = block_end;
        size_t const scalar_end = matrix->scalar_begin[row + 1];
        lanes4 const scalars = add_scalars(matrix, s, scalar_end, x, last_entry, has_sums);
        s = scalar_end;
        lanes4 const sum = (blocks.x + blocks.y) + (blocks.z + scalars);
        if (row + 1 < end)
            *(lanes4 *)(result + 3 * row) = sum; /* the next row puts its first number right */
        else
            for (size_t i = 0; i < 3; i++) result[3 * row + i] = sum[i];
    }
}

void TULLE_KERNEL(multiply_rows)(void *context, size_t begin, size_t end, size_t chunk,
                                 int worker) {
    (void)chunk, (void)worker;
    const multiply_task *const task = context;
    if (task->matrix->scalar_sums)
        multiply(task, begin, end, true);
    else
        multiply(task, begin, end, false);
}
