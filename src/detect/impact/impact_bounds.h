/* detect/impact/impact_bounds.h - the error bounds and limits of impact tests, the same for one
 * pair (time_of_impact.c, coplanarity_filter.c) and for eight at a time (kernels/), so that both
 * give the same bits. */
#ifndef TULLE_DETECT_IMPACT_IMPACT_BOUNDS_H
#define TULLE_DETECT_IMPACT_IMPACT_BOUNDS_H

#include <float.h>

/* One rounding has a relative error of u = 2^-53. A dot product of rounded differences takes 1 + 1
 * + 2 roundings a term; two more for the bound. */
static const double DOT_ERROR = 8.0 * 0x1.0p-53;
/* Covers the length of a normalised direction and the product with it. */
static const double SEPARATION_FACTOR = 1.0 + 16.0 * 0x1.0p-53;
/* Covers the quotient that gives a closing time. */
static const double CLOSING_ERROR = 8.0 * 0x1.0p-53;
/* Underflow of scaled products; scaled differences are about 1, so this is far below rounding. */
static const double UNDERFLOW_ERROR = DBL_MIN;
/* Squares above this lose nothing to underflow. */
static const double LEAST_NORM2 = 1e-280;
/* Corner differences between these bounds [m] are not scaled. */
static const double LEAST_UNSCALED = 0x1.0p-64;
static const double MOST_UNSCALED = 0x1.0p64;

/* Part of the time to the first closing that one step takes; the rest keeps a direction. */
static const double ADVANCE_FACTOR = 0.9;
/* Advancement stops as a hit when the distance exceeds the separation by at most the larger of two
 * lengths. The first length is this part of the separation. */
static const double HIT_PART_OF_SEPARATION = 0.05;
/* The second length is this part of the excess at the start. */
static const double HIT_PART_OF_START = 1e-3;
/* The same part where there is no separation. It is smaller: features that come near need not
 * touch. */
static const double HIT_PART_OF_START_TOUCHING = 1e-4;
/* Both lengths are cut to this part of the excess at the start. So nine tenths of it are used up
 * before a hit, and motion continues. */
static const double HIT_PART_OF_START_MOST = 0.1;
/* Rounds of advancement; sliding edges take some tens. */
enum { MAX_ADVANCES = 200 };

/* The coplanarity cubic c . (u x v) of corner differences, M the largest component: with normals
 * n0, n1 at the ends and n01 between, a component of n0 is off by 8 u M^2, of n01 by 20 u M^2; the
 * coefficients c0 . n0, c1 . n0 + c0 . n01, c0 . n1 + c1 . n01, c1 . n1 of which the middle ones
 * are three times Bernstein's carry at most 174 u M^3. */
static const double COPLANARITY_ERROR = 256.0 * 0x1.0p-53;
/* Between these bounds [m] on M no product overflows and underflow is far below the error bound. */
static const double LEAST_COPLANARITY_SIZE = 1e-90;
static const double MOST_COPLANARITY_SIZE = 1e90;

#endif
