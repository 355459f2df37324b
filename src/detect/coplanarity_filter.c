/* detect/coplanarity_filter.c - pair_cannot_cross, see time_of_impact.h: features can only touch
 * when their four points lie in one plane, and the cubic det(u(t), v(t), w(t)) of three corner
 * differences has no root in [0, 1] when its four Bernstein coefficients have one sign.
 *
 * Based on: Provot, Collision and self-collision handling in cloth model dedicated to design
 * garments, 1997 (the cubic). Departure: its signs are taken with an error bound. */
#include "detect/time_of_impact.h"

/* With u = 2^-53 and M the largest difference component, one determinant carries
 * (3 + 1 + 1 + 1 + 2) u 6 M^3 of rounding and the mean of three another 3 u 6 M^3: 66 u M^3 in
 * all, under half of this. */
#define COPLANARITY_ERROR (64.0 * 2.3e-16)
/* Between these bounds [m] on M no product overflows and underflow is far below the error bound. */
#define LEAST_SIZE 1e-90
#define MOST_SIZE 1e90

static double determinant(vec3 a, vec3 b, vec3 c) { return vec3_dot(a, vec3_cross(b, c)); }

static double largest_component(double most, vec3 a) {
    most = fmax(most, fabs(a.x));
    most = fmax(most, fabs(a.y));
    return fmax(most, fabs(a.z));
}

bool pair_cannot_cross(const moving_pair *pair) {
    vec3 start[3], end[3];
    double most = 0.0;
    for (int k = 0; k < 3; k++) {
        start[k] = vec3_sub(pair->start[k + 1], pair->start[0]);
        end[k] = vec3_sub(pair->end[k + 1], pair->end[0]);
        most = largest_component(largest_component(most, start[k]), end[k]);
    }
    if (!(most > LEAST_SIZE && most < MOST_SIZE)) return false;
    double const coefficients[4] = {
        determinant(start[0], start[1], start[2]),
        (determinant(end[0], start[1], start[2]) + determinant(start[0], end[1], start[2]) +
         determinant(start[0], start[1], end[2])) /
            3.0,
        (determinant(start[0], end[1], end[2]) + determinant(end[0], start[1], end[2]) +
         determinant(end[0], end[1], start[2])) /
            3.0,
        determinant(end[0], end[1], end[2])};
    double const error = COPLANARITY_ERROR * most * most * most;
    bool all_positive = true, all_negative = true;
    for (int k = 0; k < 4; k++) {
        all_positive = all_positive && coefficients[k] > error;
        all_negative = all_negative && coefficients[k] < -error;
    }
    return all_positive || all_negative;
}
