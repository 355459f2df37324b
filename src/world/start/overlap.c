/* world/start/overlap.c - see overlap.h.
 *
 * Two convex shapes are parted soonest along the normal of a face or across an edge of each. So the
 * depth is the least overlap of the triangles' shadows on these eleven axes.
 *
 * Based on: Ericson, Real-Time Collision Detection, 2005, 5.2.1 (separating axes). */
#include "world/start/overlap.h"

#include <stdbool.h>

/* Below this share of its sides' lengths, a cross product is rounding and no axis. */
static const double PARALLEL_SHARE = 1e-12;

/* [m] Overlap of the shadows on an axis that is the cross product of two sides; INFINITY where the
 * sides are parallel. */
static double measure_shadow(const vec3 a[3], const vec3 b[3], vec3 side, vec3 other_side) {
    vec3 const axis = vec3_cross(side, other_side);
    double const length = vec3_norm(axis);
    if (!(length > PARALLEL_SHARE * vec3_norm(side) * vec3_norm(other_side)))
        return (double)INFINITY;
    double low[2] = {(double)INFINITY, (double)INFINITY};
    double high[2] = {-(double)INFINITY, -(double)INFINITY};
    for (int k = 0; k < 3; k++) {
        /* seen from a corner, so that a scene far from the origin loses no digits */
        double const at[2] = {vec3_dot(vec3_sub(a[k], a[0]), axis) / length,
                              vec3_dot(vec3_sub(b[k], a[0]), axis) / length};
        for (int i = 0; i < 2; i++) {
            low[i] = fmin(low[i], at[i]);
            high[i] = fmax(high[i], at[i]);
        }
    }
    return fmin(high[0] - low[1], high[1] - low[0]);
}

/* Adds the points at which edges of `a` pass through `b`; how many. */
static int add_crossings(const vec3 a[3], const vec3 b[3], vec3 *sum) {
    vec3 const normal = vec3_cross(vec3_sub(b[1], b[0]), vec3_sub(b[2], b[0]));
    int count = 0;
    for (int k = 0; k < 3; k++) {
        vec3 const begin = a[k], end = a[(k + 1) % 3];
        double const above = vec3_dot(vec3_sub(begin, b[0]), normal);
        double const below = vec3_dot(vec3_sub(end, b[0]), normal);
        if ((above > 0.0) == (below > 0.0)) continue;
        vec3 const point = vec3_lerp(begin, end, above / (above - below));
        bool is_inside = true;
        for (int i = 0; i < 3; i++) {
            vec3 const side = vec3_sub(b[(i + 1) % 3], b[i]);
            is_inside &= vec3_dot(vec3_cross(side, vec3_sub(point, b[i])), normal) >= 0.0;
        }
        if (!is_inside) continue;
        *sum = vec3_add(*sum, point);
        count++;
    }
    return count;
}

triangle_overlap measure_overlap(const vec3 a[3], const vec3 b[3]) {
    vec3 sides[2][3];
    for (int k = 0; k < 3; k++) {
        sides[0][k] = vec3_sub(a[(k + 1) % 3], a[k]);
        sides[1][k] = vec3_sub(b[(k + 1) % 3], b[k]);
    }
    double depth = fmin(measure_shadow(a, b, sides[0][0], sides[0][1]),
                        measure_shadow(a, b, sides[1][0], sides[1][1]));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            depth = fmin(depth, measure_shadow(a, b, sides[0][i], sides[1][j]));
    vec3 sum = {0.0, 0.0, 0.0};
    int count = add_crossings(a, b, &sum) + add_crossings(b, a, &sum);
    if (count == 0) {
        for (int k = 0; k < 3; k++) sum = vec3_add(sum, vec3_add(a[k], b[k]));
        count = 6;
    }
    return (triangle_overlap){fmax(depth, 0.0), vec3_scale(sum, 1.0 / count)};
}
