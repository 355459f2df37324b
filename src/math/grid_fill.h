/* math/grid_fill.h - the loop that adds up P^T A P of a grid's blocks (grid_transfer.h). */
#ifndef TULLE_MATH_GRID_FILL_H
#define TULLE_MATH_GRID_FILL_H

#include "math/grid_transfer.h"
#include "math/kernel_target.h"

/* Rows that an entry goes down: none to two. */
enum { GRID_ROWS_DOWN = 3 };
/* A column of blocks has sums for the one before it, itself and the next. */
enum { GRID_WAYS = 3 };
/* Place of a sum of a column of blocks: way 0, 1, 2 to the one before, itself, the next. */
static inline size_t grid_fill_get_place(size_t column, size_t down, size_t way) {
    return (column * GRID_ROWS_DOWN + down) * GRID_WAYS + way;
}

/* Columns from begin to end - 1, whose entries on a diagonal go from parts of two columns of blocks
 * to parts of two. Sums are by pairs of these: lower to lower, lower to upper, upper to lower,
 * upper to upper. */
typedef struct grid_run {
    size_t begin, end;
    size_t places[4]; /* where the sum of a pair goes */
    double times[4];  /* and how often it counts; 0: nowhere */
} grid_run;

/* A diagonal of the matrix: entries that go so many rows down and columns to the right. */
typedef struct grid_diagonal {
    size_t down;
    int step;
    bool has_blocks; /* not scalars alone */
    size_t run_count;
    grid_run *runs;
    double *weights; /* four a column, of the pairs */
} grid_diagonal;

typedef struct grid_fill {
    const grid_axis *rows, *columns;
    const grid_fill_source *source;
    const grid_diagonal *diagonals; /* as the matrix has them */
    double *sums;                   /* GRID_BLOCK * GRID_DIAGONALS a block */
} grid_fill;

/* What the sums of a row of the grid take: a block and a scalar each. */
static inline size_t grid_fill_get_room(const grid_axis *columns, size_t diagonal_count) {
    size_t const sums = GRID_ROWS_DOWN * GRID_WAYS * (GRID_BLOCK + 1) * columns->block_count;
    return sums + diagonal_count * columns->count; /* two entries a diagonal and column */
}

/* Sums of rows begin .. end - 1 of blocks. room: grid_fill_get_room numbers. */
TULLE_DECLARE_KERNEL(void, grid_sum_band,
                     (const grid_fill *fill, size_t begin, size_t end, double *room))

#endif
