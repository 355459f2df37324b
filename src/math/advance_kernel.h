/* math/advance_kernel.h - loops of conjugate gradients over vectors, on every vector width. */
#ifndef TULLE_MATH_ADVANCE_KERNEL_H
#define TULLE_MATH_ADVANCE_KERNEL_H

#include "math/block_matrix.h"
#include "math/kernel_target.h"

/* Vectors of 3 numbers a vertex. */
typedef struct advance_vectors {
    double *x, *residual, *direction, *product, *preconditioned;
    const double *inverse; /* P^-1: BLOCK_NUMBERS a vertex */
} advance_vectors;

/* For vertices begin to end: x += alpha p, r -= alpha A p, z = P^-1 r; returns r . z. */
TULLE_DECLARE_KERNEL(double, advance_along,
                     (const advance_vectors *vectors, double alpha, size_t begin, size_t end))

/* Over the numbers of vertices begin to end: the sum of a times b. */
TULLE_DECLARE_KERNEL(double, measure_along,
                     (const double *a, const double *b, size_t begin, size_t end))

/* Over the same numbers: direction = start + factor * direction. */
TULLE_DECLARE_KERNEL(void, turn_along,
                     (double *direction, const double *start, double factor, size_t begin,
                      size_t end))

#endif
