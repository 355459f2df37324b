/* math/front_kernel.h - the dense loops of sparse_cholesky: one front of single precision numbers
 * factored, and solved with. */
#ifndef TULLE_MATH_FRONT_KERNEL_H
#define TULLE_MATH_FRONT_KERNEL_H

#include "math/kernel_target.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Rows are padded to this many, for every vector width. */
enum { FRONT_ROWS = 16 };

static inline size_t front_round_up(size_t rows) {
    return (rows + FRONT_ROWS - 1) / FRONT_ROWS * FRONT_ROWS;
}

/* A front: `own` columns of `own` and then `others` rows, both multiples of three. Columns are
 * `stride` apart, a multiple of FRONT_ROWS and at least own + front_round_up(others); rows after
 * own + others are zero. Only entries on and below the diagonal count. */
typedef struct front_panel {
    float *columns;
    size_t own, others, stride;
} front_panel;

static inline size_t front_stride(size_t own, size_t others) {
    size_t const stride = front_round_up(own + front_round_up(others));
    /* A distance of many equal low bits would put columns into the same few lines of a cache. */
    return stride % 128 == 0 ? stride + FRONT_ROWS : stride;
}

/* Factors the columns in place, L L^T; the diagonal then holds the inverses of L's. A pivot under
 * its `floors` entry (own) becomes that. Subtracts the product of the other rows with themselves
 * from `update` (columns front_round_up(others) apart, as many rows). Returns the number of pivots
 * that were raised. */
TULLE_DECLARE_KERNEL(uint32_t, factor_front,
                     (const front_panel *front, const float *floors, float *update))

/* A front as it is kept, in half the room: entries below the diagonal are numbers of 16 bits times
 * their column's scale, zero above; the inverses of the diagonal by themselves. */
typedef struct packed_front {
    int16_t *columns;         /* as in front_panel */
    float *scales, *inverses; /* own */
    size_t own, others, stride;
} packed_front;
TULLE_DECLARE_KERNEL(void, pack_front, (const front_panel *front, const packed_front *packed))

/* Solves with L: x has `stride` entries; its first `own` become the solution and their product with
 * the other rows is subtracted from the others. */
TULLE_DECLARE_KERNEL(void, solve_front_down, (const packed_front *front, float *x))

/* Solves with L^T: the entries after `own` are known (zero after own + others). */
TULLE_DECLARE_KERNEL(void, solve_front_up, (const packed_front *front, float *x))

/* `count` numbers, one after another both among a front's other rows and in the front above it. */
typedef struct front_run {
    uint32_t from, to, count;
} front_run;
/* Adds the lower triangle of a front's update to the front above: rows and columns before its own
 * columns' number to its panel, later ones to its update. No run has some of both. */
typedef struct update_sum {
    const float *from;
    size_t from_stride;
    const front_run *runs; /* in vertices of three numbers */
    size_t run_count;
    front_panel panel;
    float *update;
} update_sum;
TULLE_DECLARE_KERNEL(void, add_update, (const update_sum *sum))

#endif
