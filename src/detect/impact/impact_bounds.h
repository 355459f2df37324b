/* detect/impact/impact_bounds.h - the error bounds and limits of stage 8, the same for one pair
 * (time_of_impact.c, coplanarity_filter.c) and for eight at a time (detect/kernels), so that both
 * give the same bits. */
#ifndef TULLE_DETECT_IMPACT_IMPACT_BOUNDS_H
#define TULLE_DETECT_IMPACT_IMPACT_BOUNDS_H

#include <float.h>

/* Half a unit in the last place of 1: the relative error of one rounding. */
#define ROUNDING 0x1.0p-53
/* A dot product of rounded differences takes 1 + 1 + 2 roundings a term; two more for the bound. */
#define DOT_ERROR (8.0 * ROUNDING)
/* Covers the length of a normalised direction and the product with it. */
#define SEPARATION_FACTOR (1.0 + 16.0 * ROUNDING)
/* Covers the quotient that gives a closing time. */
#define CLOSING_ERROR (8.0 * ROUNDING)
/* Underflow of scaled products; scaled differences are about 1, so this is far below rounding. */
#define UNDERFLOW_ERROR DBL_MIN
/* Squares above this lose nothing to underflow. */
#define LEAST_NORM2 1e-280
/* Corner differences between these bounds [m] are not scaled. */
#define LEAST_UNSCALED 0x1.0p-64
#define MOST_UNSCALED 0x1.0p64

/* Part of the way to the first closing that one step takes; what is left keeps the next direction
 * well defined. */
#define ADVANCE_FACTOR 0.9
/* Advancement stops as a hit within this part of the separation above it ... */
#define HIT_PART_OF_SEPARATION 0.05
/* ... or of the initial excess over the separation, whichever is larger ... */
#define HIT_PART_OF_START 1e-3
/* ... a smaller part without a separation, where what comes near need not touch ... */
#define HIT_PART_OF_START_TOUCHING 1e-4
/* ... but never before nine tenths of the initial excess are used up, so that motion goes on. */
#define HIT_PART_OF_START_MOST 0.1
/* Rounds of advancement; sliding edges take some tens. */
enum { MAX_ADVANCES = 200 };

/* The coplanarity cubic c . (u x v) of corner differences, M the largest component: with normals
 * n0, n1 at the ends and n01 between, a component of n0 is off by 8 u M^2, of n01 by 20 u M^2; the
 * coefficients c0 . n0, c1 . n0 + c0 . n01, c0 . n1 + c1 . n01, c1 . n1 of which the middle ones
 * are three times Bernstein's carry at most 174 u M^3, u = ROUNDING. */
#define COPLANARITY_ERROR (256.0 * ROUNDING)
/* Between these bounds [m] on M no product overflows and underflow is far below the error bound. */
#define LEAST_COPLANARITY_SIZE 1e-90
#define MOST_COPLANARITY_SIZE 1e90

#endif
