/* detect/patches/planar_path.h - moving points projected to a plane, and the signs that
 * certificates are made of.
 *
 * The projection is x -> (across . (x - origin), along . (x - origin)) with two vectors of doubles.
 * Its exact direction is zeta = across x along: for a triangle with edges u and v the planar cross
 * product is zeta . (u x v), so triangles and contours that are judged by the same plane are judged
 * by the same zeta, to the last bit.
 *
 * One number, the planar reach, stands for all that may displace a point: the reach asked for and
 * the rounding of everything computed from the point. A sign is proven when it holds for all
 * displacements up to that. */
#ifndef TULLE_DETECT_PATCHES_PLANAR_PATH_H
#define TULLE_DETECT_PATCHES_PLANAR_PATH_H

#include "math/vec3.h"

#include <stdbool.h>

typedef struct planar_map {
    vec3 across, along, origin; /* across, along: unit and orthogonal up to rounding */
} planar_map;

/* A point that moves from (x[0], y[0]) to (x[1], y[1]) along a straight line; its exact place
 * differs from that by at most the planar reach. */
typedef struct planar_path {
    double x[2], y[2];
} planar_path;

/* Rounding, over the largest coordinate difference R to the origin, of one norm. A difference costs
 * 1/2 ulp, a dot product of three 3 more: 7 units of 2^-53 R a coordinate, 10 R as a length. Points
 * are no farther apart than 3.5 R, so the rounding of a cross product of edges u, v, at most
 * 5 units of |u| |v|, is that of a displacement of u and v by 18 R, and that of a comparison of
 * coordinates one by 12 R. 64 leaves room for the rounding of the bounds themselves. */
static const double PLANAR_ROUNDING = 64.0 * 0x1p-53;

/* [m] Differences to the origin outside this range lose digits to underflow, or overflow. Within it
 * the square of the planar reach exceeds all that underflow can lose. */
static const double PLANAR_SIZE_MIN = 1e-60, PLANAR_SIZE_MAX = 1e70;

/* Twice the largest area of a triangle with corners in the unit disc, rounded up. */
static const double DISC_TRIANGLE = 2.6;

/* For an axis that is not zero; the same bits for the same axis. */
static inline planar_map planar_map_make(vec3 axis, vec3 origin) {
    double const x = fabs(axis.x), y = fabs(axis.y), z = fabs(axis.z);
    vec3 const least = x <= y && x <= z ? vec3_make(1.0, 0.0, 0.0)
                       : y <= z         ? vec3_make(0.0, 1.0, 0.0)
                                        : vec3_make(0.0, 0.0, 1.0);
    vec3 const unit = vec3_normalize(axis);
    vec3 const across = vec3_normalize(vec3_cross(unit, least));
    return (planar_map){across, vec3_cross(unit, across), origin};
}

/* Projects a path and raises *size to no less than its largest coordinate difference to the origin.
 * What is not finite makes *size infinite or NaN, and so it stays. */
static inline planar_path project_path(const planar_map *map, vec3 start, vec3 end, double *size) {
    vec3 const a = vec3_sub(start, map->origin), b = vec3_sub(end, map->origin);
    double const own =
        ((fabs(a.x) + fabs(a.y)) + fabs(a.z)) + ((fabs(b.x) + fabs(b.y)) + fabs(b.z));
    *size = *size >= own || *size != *size ? *size : own;
    return (planar_path){{vec3_dot(map->across, a), vec3_dot(map->across, b)},
                         {vec3_dot(map->along, a), vec3_dot(map->along, b)}};
}

/* The planar reach of points of that size; negative when there is none. */
static inline double compute_planar_reach(double reach, double size) {
    if (!(size < PLANAR_SIZE_MAX && reach >= 0.0 && reach < PLANAR_SIZE_MAX)) return -1.0;
    double const least = size > PLANAR_SIZE_MIN ? size : PLANAR_SIZE_MIN;
    return reach * (1.0 + 1e-12) + PLANAR_ROUNDING * least;
}

/* sqrt(x^2 + y^2) or up to 8.3% more, without a root: from 0 to 45 degrees the unit circle lies
 * inside its chord, larger + tan(22.5 degrees) smaller; here by the sum and difference of both,
 * with (1 + tan) / 2 and (1 - tan) / 2 rounded up. */
static const double LENGTH_OF_SUM = 0.70710679, LENGTH_OF_DIFFERENCE = 0.29289323;
static inline double bound_length(double x, double y) {
    double const a = fabs(x), b = fabs(y);
    return (a + b) * LENGTH_OF_SUM + fabs(a - b) * LENGTH_OF_DIFFERENCE;
}

/* 1 or -1 where the turn a, b, c keeps that sign for the whole step and all displacements; else 0.
 *
 * `value` are the Bernstein coefficients of cross(b - a, c - a)(t), `bound` what they must exceed.
 * Displacements d of the corners by up to r change the cross product by sum d_i . (turned opposite
 * edge), at most r times the perimeter, and by twice the area of the triangle of the d_i. The
 * perimeter is a convex function of t, so the line between its values at both ends, a quadratic
 * with the coefficients p0, (p0 + p1) / 2, p1, is no less. */
static inline int compute_turn_sign(const planar_path *a, const planar_path *b,
                                    const planar_path *c, double reach) {
    double u[2][2], v[2][2], perimeter[2];
    for (int k = 0; k < 2; k++) {
        u[k][0] = b->x[k] - a->x[k], u[k][1] = b->y[k] - a->y[k];
        v[k][0] = c->x[k] - a->x[k], v[k][1] = c->y[k] - a->y[k];
        perimeter[k] = bound_length(u[k][0], u[k][1]) + bound_length(v[k][0], v[k][1]) +
                       bound_length(v[k][0] - u[k][0], v[k][1] - u[k][1]);
    }
    double const second = DISC_TRIANGLE * reach * reach;
    double const value[3] = {
        u[0][0] * v[0][1] - u[0][1] * v[0][0],
        0.5 * ((u[0][0] * v[1][1] - u[0][1] * v[1][0]) + (u[1][0] * v[0][1] - u[1][1] * v[0][0])),
        u[1][0] * v[1][1] - u[1][1] * v[1][0]};
    double const bound[3] = {reach * perimeter[0] + second,
                             reach * (0.5 * (perimeter[0] + perimeter[1])) + second,
                             reach * perimeter[1] + second};
    if (value[0] > bound[0] && value[1] > bound[1] && value[2] > bound[2]) return 1;
    if (-value[0] > bound[0] && -value[1] > bound[1] && -value[2] > bound[2]) return -1;
    return 0;
}

#endif
