/* math/diagonal_kernel.h - the loops of conjugate gradients in single precision where the matrix
 * lies by diagonals (matrix_diagonals.h), as single_kernel.h has them for one by rows.
 *
 * Matrix and vectors lie in planes, of a number a vertex each: three of a vector, SINGLE_BLOCK of
 * the inverse. Rows are worked on DIAGONAL_ROWS at a time. So begin is a multiple of that, and
 * unless end is one it is the number of rows, behind which planes have zeros. */
#ifndef TULLE_MATH_DIAGONAL_KERNEL_H
#define TULLE_MATH_DIAGONAL_KERNEL_H

#include "math/matrix_diagonals.h"
#include "math/single_kernel.h"

enum { DIAGONAL_ROWS = 16 };

/* A matrix in single precision. Before the first and after the last row planes have zeros, as far
 * as the farthest diagonal goes and DIAGONAL_ROWS more. Vectors have planes of the same length, and
 * the direction has zeros beyond its ends, too. */
typedef struct single_diagonals {
    const matrix_diagonals *pattern;
    size_t reach;  /* numbers of a plane before row 0 */
    size_t stride; /* numbers from a row to the same one of the next plane */
    float *planes; /* row 0 of the first; SINGLE_BLOCK a diagonal with blocks, then one each */
} single_diagonals;

/* product = A direction; returns direction . product. */
TULLE_DECLARE_KERNEL(float, diagonal_multiply,
                     (const single_diagonals *diagonals, const single_vectors *vectors,
                      size_t begin, size_t end))
/* x += alpha p, r -= alpha A p, z = P^-1 r; returns r . z. */
TULLE_DECLARE_KERNEL(float, diagonal_advance,
                     (const single_vectors *vectors, float alpha, size_t begin, size_t end))
/* p = z + beta p; end may be any. */
TULLE_DECLARE_KERNEL(void, diagonal_turn,
                     (const single_vectors *vectors, float beta, size_t begin, size_t end))

#endif
