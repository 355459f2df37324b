/* support/query_families.h - random moving pairs of many kinds, most of them degenerate. */
#ifndef TULLE_TEST_QUERY_FAMILIES_H
#define TULLE_TEST_QUERY_FAMILIES_H

#include "detect/impact/time_of_impact.h"

#include <stdint.h>

typedef enum query_family {
    QUERY_UNIFORM,    /* anywhere, moving far */
    QUERY_SLOW,       /* motion a tenth of the size */
    QUERY_GRID,       /* coordinates 0 .. 3: touching, parallel, coincident, of no area */
    QUERY_GRID_NOISE, /* the same with some coordinates off by an ulp */
    QUERY_COPLANAR,   /* all in one plane for all t */
    QUERY_PARALLEL,   /* directions equal at both ends; half of them in one plane */
    QUERY_NEEDLES,    /* a million times longer than wide */
    QUERY_TOUCHING,   /* touching at a chosen time, but for rounding */
    QUERY_NEAR_MISS,  /* passing at a small distance */
    QUERY_COINCIDENT, /* some points equal others */
    QUERY_SCALED,     /* any of the above times 2^-300 .. 2^300 */
    QUERY_OFFSET,     /* any of the above, far from the origin, rounded */
    QUERY_FAMILY_COUNT
} query_family;

extern const char *const query_family_names[QUERY_FAMILY_COUNT];

moving_pair make_query(query_family family, feature_kind kind, uint64_t *seed);

#endif
