/* math/grid_fill.h - the loop that adds up P^T A P of a grid's blocks (grid_transfer.h). */
#ifndef TULLE_MATH_GRID_FILL_H
#define TULLE_MATH_GRID_FILL_H

#include "math/grid_transfer.h"
#include "math/kernel_target.h"

typedef struct grid_fill {
    const grid_transfer *grid;
    const grid_fill_source *source;
    double *sums; /* GRID_BLOCK * GRID_DIAGONALS a block */
} grid_fill;

/* What the sums of a row of the grid take: a block and a scalar each. */
static inline size_t grid_fill_get_room(const grid_transfer *grid) {
    size_t const sums = GRID_ROWS_DOWN * GRID_WAYS * (GRID_BLOCK + 1) * grid->columns.block_count;
    return sums + grid->diagonal_count * grid->columns.count; /* two entries a diagonal, column */
}

/* Sums of rows begin .. end - 1 of blocks. room: grid_fill_get_room numbers. */
TULLE_DECLARE_KERNEL(void, grid_sum_band,
                     (const grid_fill *fill, size_t begin, size_t end, double *room))

#endif
