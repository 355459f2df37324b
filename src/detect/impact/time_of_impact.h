/* detect/impact/time_of_impact.h - does a moving feature pair come nearer than a minimum
 * separation, and when at the earliest. Based on: Li, Kaufman, Jiang, Codimensional Incremental
 * Potential Contact, 2021 (additive CCD); Brochu, Edwards, Bridson 2012. */
#ifndef TULLE_DETECT_IMPACT_TIME_OF_IMPACT_H
#define TULLE_DETECT_IMPACT_TIME_OF_IMPACT_H

#include "geom/distance.h"

#include <stdbool.h>

/* A test of the separation s calls a pair a hit up to max(s / 20, d0 / 1000) above s, with d0 the
 * excess at the start, and never farther above s than d0 / 10 (HIT_PART_... in impact_bounds.h). A
 * pair that is left out of a test must keep more than s times this. That covers s / 20, and
 * d0 / 1000 up to d0 = 60 s. Pairs that start farther apart and come together within one step may
 * still be called hits; docs/method/update_patches.md says what follows. */
static const double HIT_RESERVE = 1.06;

/* Paths of the four points: start + t (end - start). */
typedef struct moving_pair {
    vec3 start[4], end[4];
} moving_pair;

typedef enum toi_state {
    TOI_SEPARATED,         /* distance > separation for all t in [0, 1] */
    TOI_HIT,               /* comes near; lower_bound is safe */
    TOI_TOUCHING_AT_START, /* distance <= separation (or not certainly more) at t = 0; lower_bound
                              is 0 */
    TOI_UNRESOLVED         /* iteration limit; counts as a hit; lower_bound is safe */
} toi_state;

typedef struct toi_result {
    toi_state state;
    double lower_bound;     /* in [0, 1]: distance > separation for all t < lower_bound, proven with
                               rounding; 1 when separated */
    closest_points closest; /* at lower_bound */
} toi_result;

/* What proves that a pair keeps its separation. */
typedef enum apart_proof {
    APART_UNPROVEN,     /* it may keep it all the same */
    APART_BY_DIRECTION, /* one fixed direction separates the corners at both ends */
    APART_BY_TURNING    /* a direction that turns with the pair does */
} apart_proof;

/* Whether the pair certainly keeps more than `separation` [m] for all t, with outward rounding. The
 * fixed directions are the axes, the closest direction at t = 0 and that at t = 1. Then comes the
 * direction n(t) = n0 + t (n1 - n0) from the one closest direction to the other: the gaps
 * n(t) . (a_i - b_j)(t) are quadratic, and their Bernstein coefficients exceed `separation`. So
 * edges may rotate about each other. */
apart_proof prove_apart(feature_kind kind, const moving_pair *pair, double separation);

/* True when the coplanarity cubic has no root by Bernstein signs with an error bound: the pair
 * cannot cross (proves nothing about a separation > 0). */
bool pair_cannot_cross(feature_kind kind, const moving_pair *pair);

/* Conservative advancement from t = 0. separation >= 0 [m]. */
toi_result time_of_impact(feature_kind kind, const moving_pair *pair, double separation);

#endif
