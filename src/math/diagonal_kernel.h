/* math/diagonal_kernel.h - the product with a matrix that lies by diagonals (matrix_diagonals.h),
 * in single precision. */
#ifndef TULLE_MATH_DIAGONAL_KERNEL_H
#define TULLE_MATH_DIAGONAL_KERNEL_H

#include "math/matrix_diagonals.h"
#include "math/single_kernel.h"

/* Rows that the product works on at a time. */
enum { DIAGONAL_ROWS = 16 };

/* Planes hold a number a row. Before the first and after the last row they have zeros, as far as
 * the farthest diagonal goes and DIAGONAL_ROWS more. */
typedef struct single_diagonals {
    const matrix_diagonals *pattern;
    size_t stride;    /* numbers from a row to the same one of the next plane */
    float *planes;    /* row 0 of the first; SINGLE_BLOCK a diagonal with blocks, then one each */
    float *direction; /* row 0 of x; then y and z; zero beyond both ends, too */
} single_diagonals;

/* Rows begin .. end - 1: product = A direction, of the direction in planes; returns direction .
 * product, of the one in `vectors`. begin is a multiple of DIAGONAL_ROWS, and unless end is one it
 * is the number of rows; the product has room up to the next. */
TULLE_DECLARE_KERNEL(float, diagonal_multiply,
                     (const single_diagonals *diagonals, const single_vectors *vectors,
                      size_t begin, size_t end))
/* Vertices begin .. end - 1 of a vector go to the planes of the direction. */
TULLE_DECLARE_KERNEL(void, diagonal_split,
                     (const single_diagonals *diagonals, const float *vector, size_t begin,
                      size_t end))

#endif
