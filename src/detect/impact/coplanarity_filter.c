/* detect/impact/coplanarity_filter.c - pair_cannot_cross, see time_of_impact.h: features can only
 * touch when their four points lie in one plane, and the cubic c(t) . (u(t) x v(t)) of three corner
 * differences has no root in [0, 1] when its four Bernstein coefficients have one sign. The normal
 * u x v has the coefficients n0, n01 / 2, n1.
 *
 * Based on: Provot, Collision and self-collision handling in cloth model dedicated to design
 * garments, 1997 (the cubic). Departure: its signs are taken with an error bound. */
#include "detect/impact/impact_bounds.h"
#include "detect/impact/time_of_impact.h"

typedef struct moving_vector {
    vec3 start, end;
} moving_vector;

static moving_vector make_difference(const moving_pair *pair, int a, int b) {
    return (moving_vector){vec3_sub(pair->start[a], pair->start[b]),
                           vec3_sub(pair->end[a], pair->end[b])};
}

static double larger_component(double most, vec3 a) {
    most = fabs(a.x) > most ? fabs(a.x) : most;
    most = fabs(a.y) > most ? fabs(a.y) : most;
    return fabs(a.z) > most ? fabs(a.z) : most;
}

bool pair_cannot_cross(feature_kind kind, const moving_pair *pair) {
    bool const is_vertex_triangle = kind == FEATURE_VERTEX_TRIANGLE;
    moving_vector const offset = make_difference(pair, 0, is_vertex_triangle ? 1 : 2);
    moving_vector const u = make_difference(pair, is_vertex_triangle ? 2 : 1, is_vertex_triangle);
    moving_vector const v = make_difference(pair, 3, is_vertex_triangle ? 1 : 2);
    double most = larger_component(larger_component(0.0, offset.start), offset.end);
    most = larger_component(larger_component(most, u.start), u.end);
    most = larger_component(larger_component(most, v.start), v.end);
    if (!(most > LEAST_COPLANARITY_SIZE && most < MOST_COPLANARITY_SIZE)) return false;
    vec3 const first = vec3_cross(u.start, v.start), last = vec3_cross(u.end, v.end);
    vec3 const middle = vec3_add(vec3_cross(u.end, v.start), vec3_cross(u.start, v.end));
    double const coefficients[4] = {
        vec3_dot(offset.start, first), vec3_dot(offset.end, first) + vec3_dot(offset.start, middle),
        vec3_dot(offset.start, last) + vec3_dot(offset.end, middle), vec3_dot(offset.end, last)};
    double const error = COPLANARITY_ERROR * most * most * most;
    bool all_positive = true, all_negative = true;
    for (int k = 0; k < 4; k++) {
        all_positive = all_positive && coefficients[k] > error;
        all_negative = all_negative && -coefficients[k] > error;
    }
    return all_positive || all_negative;
}
