/* math/sparse_cholesky.h - Cholesky factors of symmetric positive definite matrices of 3x3 blocks
 * with a fixed pattern, in single precision: a preconditioner for conjugate gradients. Order and
 * pattern of the factor are found once, numbers again for each matrix. */
#ifndef TULLE_MATH_SPARSE_CHOLESKY_H
#define TULLE_MATH_SPARSE_CHOLESKY_H

#include "base/arena.h"
#include "math/block_matrix.h"
#include "math/vec3.h"

typedef struct sparse_cholesky sparse_cholesky;

/* Prepares factors of matrices with this pattern (symmetric, as in block_matrix.h). Positions (3 *
 * vertex_count, for example at rest; null: none) only make the factor smaller. Null: no memory. */
sparse_cholesky *sparse_cholesky_build(memory *heap, size_t vertex_count, block_pattern pattern,
                                       const double *positions);
void sparse_cholesky_destroy(memory *heap, sparse_cholesky *factor);

/* What one factor costs: numbers in L, its products and sums, and all the memory held. */
typedef struct sparse_cholesky_size {
    uint64_t entries, operations, bytes;
} sparse_cholesky_size;
sparse_cholesky_size sparse_cholesky_measure(const sparse_cholesky *factor);

/* A term: the stiffness with factors w_i w_j on the blocks of up to four vertices. */
typedef struct cholesky_term {
    uint32_t vertices[4]; /* TULLE_NONE: not there; the first two or three are of one side where
                             `side` says so */
    double weights[4];
    mat3 stiffness; /* symmetric, positive semidefinite: of the weighted sum of the vertices */
    uint32_t side;  /* vertices of the first side, 1 .. 4 */
} cholesky_term;

/* The matrix: blocks less shifts, plus terms. */
typedef struct cholesky_matrix {
    const double *blocks;    /* 9 for each entry of the pattern, column-major */
    const double *shifts[2]; /* one for each entry: multiples of the identity that are taken off
                                the block, times the factors; null: none */
    double shift_factors[2];
    const uint8_t *is_fixed;    /* vertex_count; null: none. Fixed vertices are left out */
    const cholesky_term *terms; /* blocks outside the factor's pattern are dropped, for both sides
                                   of a term at once: what is left is semidefinite */
    size_t term_count;
} cholesky_matrix;

typedef struct cholesky_report {
    uint64_t raised_pivots; /* too small to be told from rounding, or negative */
    uint64_t dropped_terms; /* terms whose sides are not joined in the factor */
} cholesky_report;

/* Factors the matrix. Where rounding leaves no positive pivot a small one is put in its place: the
 * factor is positive definite in any case, but then that of another matrix. Scratch is released.
 * TULLE_OK or TULLE_ERROR_OUT_OF_MEMORY. Bits do not depend on threads or vector width. */
tulle_status sparse_cholesky_factor(sparse_cholesky *factor, const cholesky_matrix *matrix,
                                    int threads, arena *scratch, cholesky_report *report);

/* z = (L L^T)^-1 r, 3 * vertex_count; zero at fixed vertices. Uses storage of the factor: one solve
 * at a time. The same bits for any number of threads. */
void sparse_cholesky_solve(sparse_cholesky *factor, const float *r, float *z, int threads);

#endif
