/* math/grid_kernel.h - the loops of grid_transfer.c, and those of a level that lies by diagonals
 * (diagonal_kernel.h). */
#ifndef TULLE_MATH_GRID_KERNEL_H
#define TULLE_MATH_GRID_KERNEL_H

#include "math/single_kernel.h"

/* Rows of a grid that lie in planes, and one line of three planes that is the sum of their parts.
 */
typedef struct line_sum {
    const float *vectors; /* number 0 of the first row's first vertex */
    size_t number_step;
    const float *is_free; /* of that vertex; null: all are */
    size_t row_count, column_count;
    const float *parts; /* row_count */
    float *line;        /* room for column_count and SINGLE_PADDING numbers a plane */
    size_t line_stride;
} line_sum;
TULLE_DECLARE_KERNEL(void, grid_sum_rows, (const line_sum *sum))

/* A part of a row, to which parts of two lines are added. */
typedef struct line_spread {
    const float *lower, *upper; /* of the lines, the number of the first vertex */
    size_t line_stride;
    float share;          /* of the lower one */
    const float *is_free; /* of the first vertex; null: all are */
    float *vectors;       /* number 0 of the first vertex */
    size_t number_step;
    size_t count; /* vertices */
} line_spread;
TULLE_DECLARE_KERNEL(void, grid_add_lines, (const line_spread *spread))

/* Rows begin .. end - 1 of a level as diagonal_kernel.h has them. direction = B residual, where B
 * is vectors.inverse. */
TULLE_DECLARE_KERNEL(void, grid_take_step,
                     (const single_vectors *vectors, size_t begin, size_t end))
/* product = residual - product */
TULLE_DECLARE_KERNEL(void, grid_leave, (const single_vectors *vectors, size_t begin, size_t end))
/* preconditioned = direction + B (residual - product); returns residual . preconditioned. */
TULLE_DECLARE_KERNEL(double, grid_end_step,
                     (const single_vectors *vectors, size_t begin, size_t end))

#endif
