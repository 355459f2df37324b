/* math/matrix_diagonals.h - the diagonals on which the entries of a symmetric sparse matrix lie.
 *
 * Where vertices are numbered row by row, as on grids, each row has its entries in the same places
 * relative to the main diagonal. A product by diagonals then loads what lies side by side, and the
 * entries above the main diagonal serve for those below. */
#ifndef TULLE_MATH_MATRIX_DIAGONALS_H
#define TULLE_MATH_MATRIX_DIAGONALS_H

#include "base/memory.h"

enum { BLOCK_DIAGONALS_MAX = 10, DIAGONALS_MAX = 30, NO_DIAGONAL = 255 };

/* The main diagonal and those above it: first the ones with blocks, then the ones with scalars
 * alone. Entry (row, row + offset) lies on the diagonal of this offset. */
typedef struct matrix_diagonals {
    size_t block_count, count; /* 0: the entries lie on too many diagonals */
    uint32_t offsets[DIAGONALS_MAX];
    uint8_t *of_blocks, *of_scalars; /* of each entry of a pattern; below the main diagonal
                                        NO_DIAGONAL */
} matrix_diagonals;

/* A pattern as compressed rows, both triangles of it. */
typedef struct entry_pattern {
    size_t entry_count;
    const uint32_t *begin, *columns;
} entry_pattern;

/* Finds the diagonals where they are few and mostly full. The block pattern holds the main
 * diagonal. */
tulle_status matrix_diagonals_find(memory *heap, size_t row_count, entry_pattern blocks,
                                   entry_pattern scalars, matrix_diagonals *diagonals);

#endif
