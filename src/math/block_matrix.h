/* math/block_matrix.h - a sparse symmetric matrix over vertices.
 *
 * It has 3x3 blocks where two vertices share a mesh edge, and multiples of the 3x3 identity
 * where bending couples them more loosely: the wide stencil costs one number a pair. Each block
 * is symmetric. Both patterns hold both triangles of the matrix, rows ascending. Patterns are
 * fixed; only values change. */
#ifndef TULLE_MATH_BLOCK_MATRIX_H
#define TULLE_MATH_BLOCK_MATRIX_H

#include "base/memory.h"
#include "math/matrix_diagonals.h"
#include "math/matrix_term.h"
#include "math/vec3.h"

/* A symmetric 3x3 block is six numbers: xx, xy, xz, yy, yz, zz. */
enum { BLOCK_NUMBERS = 6 };
/* Numbers after the last block, so that kernels may load eight. */
enum { BLOCK_PADDING = 2 };
/* Where they are in one of nine. */
extern const size_t block_places[BLOCK_NUMBERS];

static inline vec3 block_multiply(const double *block, vec3 a) {
    return (vec3){block[0] * a.x + block[1] * a.y + block[2] * a.z,
                  block[1] * a.x + block[3] * a.y + block[4] * a.z,
                  block[2] * a.x + block[4] * a.y + block[5] * a.z};
}

typedef struct block_matrix {
    size_t row_count;    /* vertices */
    size_t block_count;  /* 3x3 blocks, the diagonal ones included */
    size_t scalar_count; /* multiples of the identity */
    /* The patterns, borrowed. */
    const uint32_t *row_begin;      /* row_count + 1, into columns and blocks */
    const uint32_t *columns;        /* ascending in a row */
    const uint32_t *scalar_begin;   /* row_count + 1, into scalar_columns */
    const uint32_t *scalar_columns; /* ascending in a row */
    uint32_t *no_scalars;           /* in place of a pattern without scalars; else null */
    uint32_t *diagonal_positions;   /* row_count: index of the diagonal block */
    matrix_diagonals diagonals;
    double *values; /* BLOCK_NUMBERS * block_count, and BLOCK_PADDING */
    /* Scalars are sums of two, borrowed: see block_matrix_get_scalar. Set by the user. */
    const double *scalar_parts[2]; /* scalar_count each */
    double scalar_factors[2];
    /* row_count, borrowed, set by the user: rows that no product is asked of, and which give 0, are
     * not 0; null: none */
    const uint8_t *is_idle;
    const double *scalar_sums; /* scalar_count, borrowed: the sums, which spares adding them up in
                                  each product; null: not at hand */
} block_matrix;

static inline double block_matrix_get_scalar(const block_matrix *matrix, size_t index) {
    if (matrix->scalar_sums) return matrix->scalar_sums[index];
    return matrix->scalar_factors[0] * matrix->scalar_parts[0][index] +
           matrix->scalar_factors[1] * matrix->scalar_parts[1][index];
}

/* The pattern as compressed rows: begin has row_count + 1 entries; columns ascending and unique in
 * a row. The block pattern holds every diagonal entry; both patterns are symmetric. */
typedef struct block_pattern {
    const uint32_t *begin, *columns;
} block_pattern;

/* Borrows the patterns, which must outlive the matrix, and zeroes all values. scalars.begin null:
 * no scalar part. */
tulle_status block_matrix_build(memory *heap, size_t row_count, block_pattern blocks,
                                block_pattern scalars, block_matrix *result);
void block_matrix_destroy(memory *heap, block_matrix *matrix);

/* Adds up the scalars: scalar_count doubles, for scalar_sums. */
void block_matrix_sum_scalars(const block_matrix *matrix, double *sums, int threads);

/* Index of `column` among ascending ones from begin to end - 1; TULLE_NONE if it is not there. */
uint32_t find_in_columns(const uint32_t *columns, uint32_t begin, uint32_t end, uint32_t column);

/* Index of block (row, column) in columns; TULLE_NONE if it is not in the pattern. */
uint32_t block_matrix_find(const block_matrix *matrix, uint32_t row, uint32_t column);

/* The block of each pair of a term's vertices, TULLE_NONE where one of them is none. False: the
 * pattern lacks one, or the term is apart. */
bool block_matrix_find_term(const block_matrix *matrix, const matrix_term *term,
                            uint32_t places[4][4]);

/* Adds a term if the pattern has blocks for all pairs of its vertices. False: it has not, and
 * nothing is added. */
bool block_matrix_add_term(block_matrix *matrix, const matrix_term *term);

/* A matrix as a linear_operator for conjugate_gradients_solve; context is a block_matrix_operator.
 * result = matrix * x, arrays of 3 * row_count doubles that do not overlap. The same bits for any
 * number of threads and any vector width. */
typedef struct block_matrix_operator {
    const block_matrix *matrix;
    int threads;
} block_matrix_operator;
void block_matrix_apply(void *context, const double *x, double *result);

/* The diagonal blocks in full, 9 * row_count doubles. */
void block_matrix_get_diagonal(const block_matrix *matrix, double *diagonal, int threads);

#endif
