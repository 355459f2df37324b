/* detect/impact/impact_pool.h - pairs on their way through conservative advancement, eight at a
 * time, and the kernels that move them. Each row holds one number of every pair. */
#ifndef TULLE_DETECT_IMPACT_IMPACT_POOL_H
#define TULLE_DETECT_IMPACT_IMPACT_POOL_H

#include "detect/impact/pair_batch.h"
#include "detect/impact/time_of_impact.h"
#include "math/kernel_target.h"

enum { IMPACT_POOL_SIZE = 64 };

enum impact_row {
    ROW_START = 0,  /* corner differences at the start: corner, then x y z */
    ROW_END = 12,   /* at the end */
    ROW_TIME = 24,  /* safe up to here */
    ROW_TOLERANCE,  /* [m] excess over the separation at which it is a hit */
    ROW_SEPARATION, /* [m] rounded upward */
    ROW_ROUND,      /* of advancement; -1 - round: the direction at the end is still to be tried */
    ROW_FIRST,      /* slots */
    ROW_SECOND,
    IMPACT_ROWS
};

typedef struct impact_pool {
    double rows[IMPACT_ROWS][IMPACT_POOL_SIZE + 8]; /* 8 more: kernels read and write whole lanes */
    size_t count;
    uint64_t filtered_count; /* shown apart by the direction at the end */
} impact_pool;

/* A pair that is not separated. */
typedef struct impact_result {
    uint32_t first, second;
    double time;
    toi_state state;
} impact_result;

/* Pairs of one kind, by slots; separations: [m] of each, or null: 0. */
typedef struct slot_pairs {
    feature_kind kind;
    size_t count;
    const uint32_t *first, *second;
    const double *separations;
} slot_pairs;

/* Leaves out pairs that an axis or a diagonal of the cube keeps apart: gaps of points along it
 * exceed the limit, on one side at both ends. The sums of coordinates that are gaps carry rounding.
 * Returns how many are kept. The kept arrays have room for count + 16; none of them is that of the
 * pairs. */
TULLE_DECLARE_KERNEL(size_t, filter_directions,
                     (const pair_tables *tables, const slot_pairs *pairs, float limit,
                      uint32_t *kept_first, uint32_t *kept_second))

/* Leaves out pairs with separation 0 that pair_cannot_cross; returns how many are kept. The kept
 * arrays have room for count + 8; they may be those of the pairs. */
TULLE_DECLARE_KERNEL(size_t, filter_coplanarity,
                     (const pair_tables *tables, const slot_pairs *pairs, uint32_t *kept_first,
                      uint32_t *kept_second, double *kept_separations))

/* Takes pairs through the axes and the direction at the start; those not shown apart go to the
 * pool, which has room for all. Edges come in ascending order of their features. Pairs out of the
 * range of the kernel (not finite, huge or tiny) go to `odd`, by index; returns their number. */
TULLE_DECLARE_KERNEL(size_t, begin_impacts,
                     (const pair_tables *tables, const slot_pairs *pairs, impact_pool *pool,
                      uint32_t *odd))

/* Advances the pairs of the pool to their ends, by the direction at the end and by conservative
 * advancement; fewer than eight may stay in the pool unless is_last. Pairs safe beyond *latest
 * are left out; if lowers_latest it follows the times found. Returns the number of results, which
 * have room for all pairs of the pool. */
TULLE_DECLARE_KERNEL(size_t, advance_impacts,
                     (impact_pool * pool, feature_kind kind, bool is_last, bool lowers_latest,
                      double *latest, impact_result *results))

#endif
