/* detect/patches/normal_cone.h - circular cones that hold the normals of moving triangles for the
 * whole of a step.
 *
 * A cone (axis, half_angle) holds a vector when it leaves the axis by at most half_angle. All cones
 * made here are rounded outward: they hold the exact normals of the given coordinates, in exact
 * arithmetic, whatever rounding did on the way.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, 3.1 and 3.2. Departure: with CONE_BERNSTEIN the cone of a triangle is the smallest one of
 * the three Bernstein coefficients of its normal. It is tighter than their bound by the longest
 * normal; a change of area does not widen it. */
#ifndef TULLE_DETECT_PATCHES_NORMAL_CONE_H
#define TULLE_DETECT_PATCHES_NORMAL_CONE_H

#include "math/vec3.h"

#include <stdbool.h>

/* Half-angles of valid cones are at least 0 and under pi/2. */
typedef struct normal_cone {
    vec3 axis;         /* unit */
    double half_angle; /* [rad]; negative: no valid cone, the axis is then zero */
} normal_cone;

static inline bool normal_cone_is_valid(normal_cone cone) { return cone.half_angle >= 0.0; }

typedef enum cone_rule {
    CONE_BERNSTEIN, /* smallest cone of the Bernstein coefficients */
    CONE_PAPER      /* axis and bound of Wong & Baciu 2005, 3.1; wider */
} cone_rule;

/* The cone of (b - a) x (c - a) while the corners a, b, c move from `start` to `end` along straight
 * lines, with velocities that do not change. Not valid when the normal might vanish or turn by a
 * half-angle of pi/2 or more, and when coordinates are so large or small that products overflow or
 * lose digits. A valid cone proves that the triangle never degenerates. */
normal_cone normal_cone_of_triangle(cone_rule rule, const vec3 start[3], const vec3 end[3]);

/* The smallest cone that holds two valid ones, if its half-angle is at most `limit` < pi/2 [rad];
 * else false, and *merged is left alone. It may be the same object as a or b. Limits over
 * pi/2 - 1e-6 count as that. */
bool normal_cone_merge(const normal_cone *a, const normal_cone *b, double limit,
                       normal_cone *merged);

#endif
