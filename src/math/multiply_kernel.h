/* math/multiply_kernel.h - rows of the product of the vertex matrix and a vector, on every vector
 * width. */
#ifndef TULLE_MATH_MULTIPLY_KERNEL_H
#define TULLE_MATH_MULTIPLY_KERNEL_H

#include "math/block_matrix.h"
#include "math/kernel_target.h"

typedef struct multiply_task {
    const block_matrix *matrix;
    const double *x;
    double *result;
} multiply_task;

/* A chunk of block_matrix_apply, as parallel_for calls it; `context` is a multiply_task. */
TULLE_DECLARE_KERNEL(void, multiply_rows,
                     (void *context, size_t begin, size_t end, size_t chunk, int worker))

#endif
