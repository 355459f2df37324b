/* detect/patches/normal_cone.c - see normal_cone.h.
 *
 * With u = b - a, v = c - a, n0 = u0 x v0, n1 = u1 x v1 and m = (u0 x v1 + u1 x v0) / 2 the normal
 * is
 *     n(t) = n0 (1-t)^2 + 2 m t (1-t) + n1 t^2,
 * a combination of n0, m, n1 with coefficients that are not negative. Circular cones of a
 * half-angle under pi/2 are convex, so one that holds n0, m and n1 holds n(t) for all t in [0, 1].
 *
 * Rounding: any axis will do. What must be bounded from above is the largest angle between the axis
 * and the exact n0, m, n1; it is measured after the axis is fixed.
 *
 * The paper's cone has the axis zeta = n0 / |n0| + n1 / |n1| and the half-angle
 * acos(min zeta . n(t) / (|zeta| |n_max|)): zeta . n(t) = |zeta| |n(t)| cos(angle) is at most
 * |zeta| |n_max| cos(angle). Here the minimum, of a quadratic, is rounded down, and |n_max|^2, of a
 * quartic, is bounded from above by Bernstein coefficients. */
#include "detect/patches/normal_cone.h"

#include <string.h>

/* [rad] Added to every angle that was computed from unit vectors. Their rounding and that of asin,
 * atan2 and sin come to some 1e-15 rad; 1e-9 leaves room and widens a patch of a million merges by
 * a milliradian. */
static const double ANGLE_SLACK = 1e-9;

/* Rounding of n0, m and n1 over the product of the longest u and v: differences of coordinates 1/2
 * ulp each, a product and a difference in the cross product, and |u_y v_z| + |u_z v_y| for all
 * three components come to 5 sqrt(2) units of 2^-53; the sum in m adds two more. */
static const double NORMAL_ERROR = 16.0 * 0x1p-53;

/* Normals no longer than this many error bounds have no direction worth keeping. */
static const double NORMAL_ERRORS_MIN = 4.0;

/* Products of edges outside this range [m^2] may have lost digits to underflow, or overflow. */
static const double AREA_MIN = 1e-280, AREA_MAX = 1e280;

/* [squared chord] Three directions that are all nearer have no circle beyond rounding. */
static const double CIRCLE_CHORD2_MIN = 1e-18;

static const double HALF_PI = 1.5707963267948966;

/* [rad] Widest merged cone, pi/2 - 1e-6. Its axis lies between axes that may be as far apart as
 * twice that: it is their sum, of length 2e-6 at least, so roundings of 1e-16 turn it by some
 * 1e-10, less than ANGLE_SLACK. */
static const double MERGED_ANGLE_MAX = 1.5707953267948966;

static const normal_cone no_cone = {.half_angle = -1.0};

/* Relative bound on the rounding of the short sums that follow; each loses less than 2^-50. */
static const double SUM_ERROR = 0x1p-48;

/* Squared chord between two unit vectors; exact where they nearly agree, and rising with the angle.
 */
static double chord2(vec3 a, vec3 b) { return vec3_norm2(vec3_sub(a, b)); }

/* The smallest cone of the coefficients. */
static normal_cone make_bernstein_cone(const vec3 normals[3]) {
    /* The coefficients as unit vectors, and the most [rad] that one may point from the exact one;
     * none may vanish. */
    vec3 d[3];
    double error = 0.0, farthest2 = 0.0;
    for (int k = 0; k < 3; k++) {
        double const length = vec3_norm(normals[k]);
        if (!(length > NORMAL_ERRORS_MIN * NORMAL_ERROR)) return no_cone;
        double const inverse = 1.0 / length;
        d[k] = vec3_scale(normals[k], inverse);
        /* asin(x) <= pi/2 x, and x is at most 1/4 */
        error = fmax(error, HALF_PI * NORMAL_ERROR * inverse);
    }

    /* The axis is the middle of the two that are farthest apart, or goes through the circle of all
     * three where the third is farther from that. */
    double const chords[3] = {chord2(d[0], d[1]), chord2(d[1], d[2]), chord2(d[2], d[0])};
    int widest = chords[1] > chords[0] ? 1 : 0; /* pair {widest, widest + 1} */
    if (chords[2] > chords[widest]) widest = 2;
    vec3 axis = vec3_normalize(vec3_add(d[widest], d[(widest + 1) % 3]));
    bool const is_third_inside = chord2(axis, d[(widest + 2) % 3]) <= chord2(axis, d[widest]);
    if (!is_third_inside && chords[widest] > CIRCLE_CHORD2_MIN) {
        axis = vec3_normalize(vec3_cross(vec3_sub(d[1], d[0]), vec3_sub(d[2], d[0])));
        if (vec3_dot(axis, d[0]) < 0.0) axis = vec3_neg(axis);
    }

    /* The half-angle that holds all three; an axis between opposite directions holds nothing. */
    if (vec3_norm2(axis) == 0.0) return no_cone;
    for (int k = 0; k < 3; k++) {
        double const distance2 = chord2(axis, d[k]);
        if (!(distance2 < 2.0)) return no_cone; /* at a right angle or more */
        if (distance2 > farthest2) farthest2 = distance2;
    }
    double const half_angle = 2.0 * asin(0.5 * sqrt(farthest2)) + error + ANGLE_SLACK;
    return half_angle < HALF_PI - ANGLE_SLACK ? (normal_cone){axis, half_angle} : no_cone;
}

/* An upper bound on a quartic over [0, 1] from its Bernstein coefficients, above the true maximum
 * by no more than some 1e-9 of it where it does not wiggle. The largest coefficient bounds each
 * part; values at the ends of parts bound the maximum from below. */
static double bound_quartic(const double coefficients[5]) {
    enum { HALVINGS = 40 };
    double part[5], rest[HALVINGS][5];
    double reached = fmax(coefficients[0], coefficients[4]), bound = 0.0;
    int waiting = 0, halvings = 0;
    memcpy(part, coefficients, sizeof part);
    for (;;) {
        double largest = part[0];
        for (int i = 1; i < 5; i++) largest = fmax(largest, part[i]);
        if (largest > reached * (1.0 + 1e-9) && halvings < HALVINGS) {
            double *const right = rest[waiting++]; /* de Casteljau: part becomes the left half */
            halvings++;
            memcpy(right, part, sizeof part);
            for (int level = 1; level < 5; level++) {
                for (int i = 0; i + level < 5; i++) right[i] = 0.5 * (right[i] + right[i + 1]);
                part[level] = right[0];
            }
            reached = fmax(reached, part[4]);
            continue;
        }
        bound = fmax(bound, largest);
        if (waiting == 0) return bound;
        memcpy(part, rest[--waiting], sizeof part);
    }
}

/* The paper's cone: its axis, and its bound by the longest normal. */
static normal_cone make_paper_cone(const vec3 n[3]) {
    double const lengths[2] = {vec3_norm(n[0]), vec3_norm(n[2])};
    double const shortest = fmin(lengths[0], lengths[1]);
    if (!(shortest > NORMAL_ERRORS_MIN * NORMAL_ERROR)) return no_cone;
    vec3 const axis = vec3_normalize(
        vec3_add(vec3_scale(n[0], 1.0 / lengths[0]), vec3_scale(n[2], 1.0 / lengths[1])));

    /* The minimum of axis . n(t), a quadratic with these Bernstein coefficients, from below. */
    double const a = vec3_dot(axis, n[0]), b = vec3_dot(axis, n[1]), c = vec3_dot(axis, n[2]);
    double least = b >= a || b >= c ? fmin(a, c) : a - (a - b) * (a - b) / ((a - b) + (c - b));
    double largest = 0.0, largest2 = 0.0;
    for (int k = 0; k < 3; k++) {
        largest = fmax(largest, vec3_norm(n[k]));
        largest2 = fmax(largest2, vec3_norm2(n[k]));
    }
    least = least - NORMAL_ERROR - SUM_ERROR * largest;
    if (!(least > 0.0)) return no_cone;

    /* The maximum of |n(t)|^2 from above. */
    double const quartic[5] = {vec3_norm2(n[0]), vec3_dot(n[0], n[1]),
                               (vec3_dot(n[0], n[2]) + 2.0 * vec3_norm2(n[1])) / 3.0,
                               vec3_dot(n[1], n[2]), vec3_norm2(n[2])};
    double const longest = sqrt(bound_quartic(quartic) + SUM_ERROR * largest2) + NORMAL_ERROR;
    double const cosine = least / sqrt(longest * longest) * (1.0 - SUM_ERROR);
    double const half_angle = acos(fmin(cosine, 1.0)) + ANGLE_SLACK;
    return half_angle < HALF_PI - ANGLE_SLACK ? (normal_cone){axis, half_angle} : no_cone;
}

normal_cone normal_cone_of_triangle(cone_rule rule, const vec3 start[3], const vec3 end[3]) {
    vec3 const u0 = vec3_sub(start[1], start[0]), v0 = vec3_sub(start[2], start[0]);
    vec3 const u1 = vec3_sub(end[1], end[0]), v1 = vec3_sub(end[2], end[0]);
    double const longest_u = sqrt(fmax(vec3_norm2(u0), vec3_norm2(u1)));
    double const longest_v = sqrt(fmax(vec3_norm2(v0), vec3_norm2(v1)));
    double const area = longest_u * longest_v;
    if (!(area > AREA_MIN && area < AREA_MAX)) return no_cone;

    /* n0, m, n1 over the product of the longest u and v, each within NORMAL_ERROR of the exact one
     * over the same number; so their squares stay within range. */
    double const scale = 1.0 / area;
    vec3 const normals[3] = {
        vec3_scale(vec3_cross(u0, v0), scale),
        vec3_scale(vec3_add(vec3_cross(u0, v1), vec3_cross(u1, v0)), 0.5 * scale),
        vec3_scale(vec3_cross(u1, v1), scale)};
    return rule == CONE_PAPER ? make_paper_cone(normals) : make_bernstein_cone(normals);
}

bool normal_cone_merge(const normal_cone *a, const normal_cone *b, double limit,
                       normal_cone *merged) {
    limit = fmin(limit, MERGED_ANGLE_MAX);
    /* settled without trigonometry: a holds b, or together they are too wide. For an angle x, its
     * chord 2 sin(x/2) is at most x and at least x - x^3/24. */
    double const distance2 = chord2(a->axis, b->axis);
    double const spare = a->half_angle - b->half_angle - ANGLE_SLACK;
    double const spare_chord = spare - spare * spare * spare / 24.0;
    if (spare > 0.0 && distance2 <= spare_chord * spare_chord && a->half_angle <= limit) {
        *merged = *a;
        return true;
    }
    double const room = fmax(2.0 * limit - a->half_angle - b->half_angle, 0.0);
    if (distance2 > room * room) return false;
    double const between =
        atan2(vec3_norm(vec3_cross(a->axis, b->axis)), vec3_dot(a->axis, b->axis));
    bool const keeps_a = between + ANGLE_SLACK + b->half_angle <= a->half_angle;
    bool const takes_b = between + ANGLE_SLACK + a->half_angle <= b->half_angle;
    if (keeps_a || takes_b) {
        const normal_cone *const larger = keeps_a ? a : b;
        if (larger->half_angle > limit) return false;
        *merged = *larger;
        return true;
    }
    /* a's axis is turned toward b's; at no more than the limit they are no half turn apart */
    double const ideal = 0.5 * (between + a->half_angle + b->half_angle);
    double const turn = fmin(fmax(ideal - a->half_angle, 0.0), between);
    double const half_angle =
        fmax(a->half_angle + turn, b->half_angle + (between - turn)) + 2.0 * ANGLE_SLACK;
    if (half_angle > limit) return false;
    vec3 axis = a->axis;
    if (between > ANGLE_SLACK) {
        axis = vec3_normalize(
            vec3_add_scaled(vec3_scale(a->axis, sin(between - turn)), b->axis, sin(turn)));
    }
    *merged = (normal_cone){axis, half_angle};
    return true;
}
