/* math/kernels/advance_kernel.c - see advance_kernel.h. Sums are of four lanes, whatever the width.
 */
#include "math/advance_kernel.h"

/* Four doubles, at any address of a double. */
typedef double lanes4 __attribute__((vector_size(32), aligned(8), may_alias));

double TULLE_KERNEL(advance_along)(const advance_vectors *vectors, double alpha, size_t begin,
                                   size_t end) {
    double *const x = vectors->x, *const r = vectors->residual, *const z = vectors->preconditioned;
    const double *const p = vectors->direction, *const product = vectors->product;
    size_t const first = 3 * begin, last = 3 * end;
    size_t i = first;
    for (; i + 4 <= last; i += 4) {
        *(lanes4 *)(x + i) += alpha * *(const lanes4 *)(p + i);
        *(lanes4 *)(r + i) -= alpha * *(const lanes4 *)(product + i);
    }
    for (; i < last; i++) {
        x[i] += alpha * p[i];
        r[i] -= alpha * product[i];
    }
    for (size_t vertex = begin; vertex < end; vertex++) {
        const double *const m = vectors->inverse + BLOCK_NUMBERS * vertex;
        const double *const of = r + 3 * vertex;
        lanes4 const middle = *(const lanes4 *)(m + 1), high = *(const lanes4 *)(m + 2);
        lanes4 const sum = *(const lanes4 *)m * of[0] +
                           __builtin_shufflevector(middle, middle, 0, 2, 3, 3) * of[1] +
                           __builtin_shufflevector(high, high, 0, 2, 3, 3) * of[2];
        for (size_t k = 0; k < 3; k++) z[3 * vertex + k] = sum[k];
    }
    lanes4 sums = {0};
    for (i = first; i + 4 <= last; i += 4)
        sums += *(const lanes4 *)(r + i) * *(const lanes4 *)(z + i);
    double rest = 0.0;
    for (; i < last; i++) rest += r[i] * z[i];
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
