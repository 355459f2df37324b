/* support/dense_levels.h - what nested aggregates hold and do, in dense matrices and double
 * precision. Calls assert what must not fail. */
#ifndef TULLE_TEST_SUPPORT_DENSE_LEVELS_H
#define TULLE_TEST_SUPPORT_DENSE_LEVELS_H

#include "math/nested_aggregates.h"

/* A of a level, all of its 3 count x 3 count numbers. */
typedef struct dense_level {
    size_t count, size; /* size: 3 * count */
    double *a;
    double *inverse; /* 9 a member: of its block on the diagonal */
} dense_level;

/* All zero. */
dense_level dense_level_make(size_t count);
/* P^T A P of the level below. */
dense_level dense_level_make_above(const aggregate_level *level, const dense_level *below);
/* Inverts the blocks on the diagonal; one that is zero becomes the identity. */
void dense_level_invert(const dense_level *dense);
void dense_level_destroy(const dense_level *dense);

static inline double *dense_level_get(const dense_level *dense, size_t row, size_t column, size_t i,
                                      size_t j) {
    return dense->a + (3 * row + i) * dense->size + 3 * column + j;
}
double dense_level_find_largest(const dense_level *dense);

/* z = C r, where C is the cycle that begins at level l; dense has all levels. */
void dense_levels_run_cycle(const nested_aggregates *all, const dense_level *dense, size_t l,
                            const double *r, double *z);

/* Aggregates of each level are a partition of its members. Most have several. */
void assert_partition(const nested_aggregates *all);
/* The weights of level l, above the first: each member's are the mean of it and its neighbours and
 * add up to one, its parent has one of them, and both lists say the same. */
void assert_weights(const nested_aggregates *all, const block_matrix *matrix, size_t l);
/* Entries by rows and inverses are those of the dense level, and outside of them it has none. */
void assert_entries(const aggregate_level *level, const dense_level *dense);

#endif
