/* math/single_kernel.h - the loops of conjugate gradients in single precision (single_solve.c).
 * Vectors hold three numbers a vertex and SINGLE_PADDING more. */
#ifndef TULLE_MATH_SINGLE_KERNEL_H
#define TULLE_MATH_SINGLE_KERNEL_H

#include "math/kernel_target.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { SINGLE_PADDING = 16 };

/* Three numbers and the one after them, which is ignored. */
typedef float floats4 __attribute__((vector_size(16)));
static inline floats4 floats4_load(const float *from) {
    floats4 a;
    memcpy(&a, from, sizeof a);
    return a;
}

/* A symmetric 3x3 block is six numbers, those of block_matrix.h. */
enum { SINGLE_BLOCK = 6 };

/* A block_matrix in single precision; values have SINGLE_PADDING more numbers at their end. */
typedef struct single_matrix {
    const uint32_t *row_begin, *columns, *scalar_begin, *scalar_columns;
    float *values; /* SINGLE_BLOCK a block */
    float *scalar_values;
} single_matrix;

/* Number k of vertex v is at v * vertex_step + k * number_step. The kernels here are for steps of 3
 * and 1, and SINGLE_BLOCK and 1 of the inverse. */
typedef struct single_vectors {
    float *x, *residual, *direction, *product, *preconditioned;
    float *inverse; /* SINGLE_BLOCK a vertex, and padding; zero at fixed vertices */
    size_t vertex_step, number_step;
    size_t inverse_step; /* from a vertex to the next */
} single_vectors;

/* Rows begin .. end - 1: product = A direction; returns direction . product. */
TULLE_DECLARE_KERNEL(float, single_multiply,
                     (const single_matrix *matrix, const single_vectors *vectors, size_t begin,
                      size_t end))
/* x += alpha p, r -= alpha A p, z = P^-1 r; returns r . z. */
TULLE_DECLARE_KERNEL(float, single_advance,
                     (const single_vectors *vectors, float alpha, size_t begin, size_t end))
/* p = z + beta p */
TULLE_DECLARE_KERNEL(void, single_turn,
                     (const single_vectors *vectors, float beta, size_t begin, size_t end))
/* What aggregates add to vertices: to each what its parent has, but nothing to fixed ones. */
typedef struct single_correction {
    const float *values; /* 3 a parent, and padding */
    const uint32_t *parents;
    const uint8_t *is_fixed;
} single_correction;
/* p = z + c + beta p */
TULLE_DECLARE_KERNEL(void, single_turn_corrected,
                     (const single_vectors *vectors, const single_correction *correction,
                      float beta, size_t begin, size_t end))

#endif
