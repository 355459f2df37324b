/* math/grid_fill.h - the loop that adds up P^T A P of a grid's blocks (grid_transfer.h). */
#ifndef TULLE_MATH_GRID_FILL_H
#define TULLE_MATH_GRID_FILL_H

#include "math/grid_transfer.h"
#include "math/kernel_target.h"

/* A diagonal of the matrix: entries that go so many rows down and columns to the right. */
typedef struct grid_diagonal {
    size_t down;
    int step;
    size_t begin, end; /* columns that have such an entry */
    bool has_blocks;   /* not scalars alone */
    const double
        *weights; /* by column: of the parts that its entry joins, see kernels/grid_fill.c */
} grid_diagonal;

typedef struct grid_fill {
    const grid_axis *rows, *columns;
    const grid_fill_source *source;
    const grid_diagonal *diagonals; /* as the matrix has them */
    double *sums;                   /* GRID_BLOCK * GRID_DIAGONALS a block */
} grid_fill;

/* Rows that an entry goes down: none to two. */
enum { GRID_ROWS_DOWN = 3 };
/* A column of blocks has sums for the one before it, itself and the next. */
enum { GRID_WAYS = 3 };
/* What the sums of a row of the grid take: a block and a scalar each. */
static inline size_t grid_fill_get_room(const grid_axis *columns, size_t diagonal_count) {
    size_t const sums = GRID_ROWS_DOWN * GRID_WAYS * (GRID_BLOCK + 1) * columns->block_count;
    return sums + diagonal_count * columns->count; /* two entries a diagonal and column */
}

/* Sums of rows begin .. end - 1 of blocks. room: grid_fill_get_room numbers. */
TULLE_DECLARE_KERNEL(void, grid_sum_band,
                     (const grid_fill *fill, size_t begin, size_t end, double *room))

#endif
