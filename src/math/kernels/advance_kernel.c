/* math/kernels/advance_kernel.c - see advance_kernel.h. Sums are of four lanes, whatever the width.
 */
#include "math/advance_kernel.h"

/* Four doubles, at any address of a double. */
typedef double lanes4 __attribute__((vector_size(32), aligned(8), may_alias));

#ifdef __AVX2__
/* Two doubles, at any address of a double. */
typedef double lanes2 __attribute__((vector_size(16), aligned(8), may_alias));

/* Three numbers of a block times its vertex, as block_multiply; the fourth is ignored. */
static inline __attribute__((always_inline)) lanes4 precondition(const double *block, double a,
                                                                 double b, double c) {
    lanes4 const low = *(const lanes4 *)block;
    lanes2 const rest = *(const lanes2 *)(block + 4);
    lanes4 const high = __builtin_shufflevector(rest, rest, 0, 1, -1, -1);
    return low * a + __builtin_shufflevector(low, high, 1, 3, 4, 4) * b +
           __builtin_shufflevector(low, high, 2, 4, 5, 5) * c;
}
#endif

double TULLE_KERNEL(advance_along)(const advance_vectors *vectors, double alpha, size_t begin,
                                   size_t end) {
    double *restrict const x = vectors->x, *restrict const r = vectors->residual;
    double *restrict const z = vectors->preconditioned;
    const double *restrict const p = vectors->direction, *restrict const product = vectors->product;
    lanes4 sums = {0};
    size_t vertex = begin;
#ifdef __AVX2__
    for (; vertex + 4 <= end; vertex += 4) { /* twelve numbers: all in registers */
        lanes4 residuals[3], own[4];
        for (size_t k = 0; k < 3; k++) {
            size_t const i = 3 * vertex + 4 * k;
            *(lanes4 *)(x + i) += alpha * *(const lanes4 *)(p + i);
            residuals[k] = *(const lanes4 *)(r + i) - alpha * *(const lanes4 *)(product + i);
            *(lanes4 *)(r + i) = residuals[k];
        }
        for (size_t k = 0; k < 4; k++) {
            size_t const a = 3 * k, b = a + 1, c = a + 2;
            own[k] = precondition(vectors->inverse + BLOCK_NUMBERS * (vertex + k),
                                  residuals[a / 4][a % 4], residuals[b / 4][b % 4],
                                  residuals[c / 4][c % 4]);
        }
        lanes4 const joined[3] = {__builtin_shufflevector(own[0], own[1], 0, 1, 2, 4),
                                  __builtin_shufflevector(own[1], own[2], 1, 2, 4, 5),
                                  __builtin_shufflevector(own[2], own[3], 2, 4, 5, 6)};
        for (size_t k = 0; k < 3; k++) {
            *(lanes4 *)(z + 3 * vertex + 4 * k) = joined[k];
            sums += residuals[k] * joined[k];
        }
    }
#endif
    size_t i = 3 * vertex;
    for (size_t k = i; k < 3 * end; k++) {
        x[k] += alpha * p[k];
        r[k] -= alpha * product[k];
    }
    for (; vertex < end; vertex++)
        vec3_store(z, vertex,
                   block_multiply(vectors->inverse + BLOCK_NUMBERS * vertex, vec3_load(r, vertex)));
    for (; i + 4 <= 3 * end; i += 4) sums += *(const lanes4 *)(r + i) * *(const lanes4 *)(z + i);
    double rest = 0.0;
    for (; i < 3 * end; i++) rest += r[i] * z[i];
    return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + rest;
}

double TULLE_KERNEL(measure_along)(const double *a, const double *b, size_t begin, size_t end) {
    lanes4 sums = {0};
    size_t i = 3 * begin;
    for (; i + 4 <= 3 * end; i += 4) sums += *(const lanes4 *)(a + i) * *(const lanes4 *)(b + i);
    double first = sums[0];
    for (; i < 3 * end; i++) first += a[i] * b[i];
    return (first + sums[1]) + (sums[2] + sums[3]);
}

void TULLE_KERNEL(turn_along)(double *direction, const double *start, double factor, size_t begin,
                              size_t end) {
    size_t i = 3 * begin;
    for (; i + 4 <= 3 * end; i += 4)
        *(lanes4 *)(direction + i) =
            *(const lanes4 *)(start + i) + factor * *(const lanes4 *)(direction + i);
    for (; i < 3 * end; i++) direction[i] = start[i] + factor * direction[i];
}
