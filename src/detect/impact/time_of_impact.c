/* detect/impact/time_of_impact.c - see time_of_impact.h.
 *
 * Every proof here rests on one fact: if along a fixed direction w the gap w . (a_i(t) - b_j(t))
 * between every corner a_i of one feature and every corner b_j of the other exceeds s |w|, the
 * features are more than s apart at t. Each gap is linear in t, so its values at both ends of the
 * step, rounded downward, bound it in between. The direction may come from any computation, exact
 * or not: the closest points only suggest it. Nothing rests on the accuracy of the distance.
 *
 * Advancement: take the closest direction at the current time, go on to 0.9 of the way to the first
 * closing of a gap, repeat; separated when no gap closes before the end. The step is never smaller
 * than that of additive CCD, 0.9 (distance - separation) / (largest relative corner speed), since
 * no gap closes faster than a corner moves.
 *
 * A direction that turns, n(t) = n0 + t (n1 - n0), proves as much: n(t) . (a_i - b_j)(t) is
 * quadratic and no less than its smallest Bernstein coefficient, n0 . d0, (n0 . d1 + n1 . d0) / 2
 * or n1 . d1, and |n(t)| is no more than the larger of |n0| and |n1|.
 *
 * Corner differences are formed first, so a common translation or motion costs no accuracy, and
 * scaled by a power of two to about 1, so nothing overflows.
 *
 * Based on: Li, Kaufman, Jiang, Codimensional Incremental Potential Contact, 2021 (additive CCD,
 * minimum separation). Departure: the directional step above, and bounds with rounding. */
#include "detect/impact/time_of_impact.h"

#include "detect/impact/impact_bounds.h"

/* The corner differences a_i - b_j, scaled, at both ends of the step. */
typedef struct gap_corners {
    vec3 start[4], end[4];
    int count;         /* 3 for vertex/triangle: corners 0, 1, 2; 4 for edge/edge: 00, 01, 10, 11 */
    double separation; /* scaled, rounded upward */
    double scale;      /* power of two; differences are true ones times scale */
    bool is_finite;
} gap_corners;

static gap_corners make_gap_corners(feature_kind kind, const moving_pair *pair, double separation) {
    gap_corners corners;
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        corners.count = 3;
        for (int k = 0; k < 3; k++) {
            corners.start[k] = vec3_sub(pair->start[0], pair->start[1 + k]);
            corners.end[k] = vec3_sub(pair->end[0], pair->end[1 + k]);
        }
        corners.start[3] = corners.end[3] = vec3_make(0.0, 0.0, 0.0);
    } else {
        corners.count = 4;
        for (int k = 0; k < 4; k++) {
            corners.start[k] = vec3_sub(pair->start[k / 2], pair->start[2 + k % 2]);
            corners.end[k] = vec3_sub(pair->end[k / 2], pair->end[2 + k % 2]);
        }
    }

    /* Scale them to about 1 by a power of two. */
    double most = 0.0;
    corners.is_finite = true;
    for (int k = 0; k < corners.count; k++) {
        vec3 const ends[2] = {corners.start[k], corners.end[k]};
        for (int e = 0; e < 2; e++) {
            vec3 const d = ends[e];
            most = fabs(d.x) > most ? fabs(d.x) : most;
            most = fabs(d.y) > most ? fabs(d.y) : most;
            most = fabs(d.z) > most ? fabs(d.z) : most;
            /* x - x is zero for finite x and NaN otherwise */
            corners.is_finite = corners.is_finite && (d.x - d.x) + (d.y - d.y) + (d.z - d.z) == 0.0;
        }
    }
    corners.scale = 1.0;
    if (corners.is_finite && (most > MOST_UNSCALED || (most < LEAST_UNSCALED && most > 0.0))) {
        int exponent;
        frexp(most, &exponent);
        if (exponent < -1000) exponent = -1000;
        corners.scale = ldexp(1.0, -exponent);
        for (int k = 0; k < corners.count; k++) {
            corners.start[k] = vec3_scale(corners.start[k], corners.scale);
            corners.end[k] = vec3_scale(corners.end[k], corners.scale);
        }
    }
    corners.separation = separation * corners.scale;
    if (separation > 0.0)
        corners.separation = corners.separation * SEPARATION_FACTOR + UNDERFLOW_ERROR;
    return corners;
}

/* The four points at time t, about the first point, from the corner differences. */
static void place_points(feature_kind kind, const gap_corners *corners, double t, vec3 points[4]) {
    vec3 difference[4];
    for (int k = 0; k < 4; k++)
        difference[k] = k < corners->count ? vec3_lerp(corners->start[k], corners->end[k], t)
                                           : vec3_make(0.0, 0.0, 0.0);
    points[0] = vec3_make(0.0, 0.0, 0.0);
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        for (int k = 0; k < 3; k++) points[1 + k] = vec3_neg(difference[k]);
    } else {
        points[1] = vec3_sub(difference[2], difference[0]);
        points[2] = vec3_neg(difference[0]);
        points[3] = vec3_neg(difference[1]);
    }
}

/* a / |a|, or zero, which separates nothing, where |a|^2 is not accurate any more. */
static vec3 make_direction(vec3 a) {
    double const norm2 = vec3_norm2(a);
    return norm2 > LEAST_NORM2 ? vec3_scale(a, 1.0 / sqrt(norm2)) : vec3_make(0.0, 0.0, 0.0);
}

/* The gap w . d less the separation, |w| <= 1 up to rounding; rounded downward. */
static double bound_gap(vec3 w, vec3 d, double separation) {
    double const px = w.x * d.x, py = w.y * d.y, pz = w.z * d.z;
    double const error = DOT_ERROR * (fabs(px) + fabs(py) + fabs(pz)) + UNDERFLOW_ERROR;
    double const gap = (px + py + pz - error) - separation;
    return gap - CLOSING_ERROR * fabs(gap);
}

/* Does direction w keep the features apart at time t? Then all times up to *closing are safe;
 * *closing > 1 when no gap closes. False also where anything is not a number. */
static bool compute_closing(const gap_corners *corners, vec3 w, double t, double *closing) {
    double first_closing = 2.0;
    for (int k = 0; k < corners->count; k++) {
        double const gap0 = bound_gap(w, corners->start[k], corners->separation);
        double const gap1 = bound_gap(w, corners->end[k], corners->separation);
        if (gap0 > 0.0 && gap1 > 0.0) continue;
        if (gap0 > 0.0) {
            double const closes = gap0 / (gap0 - gap1) * (1.0 - CLOSING_ERROR);
            if (!(t < closes)) return false;
            if (closes < first_closing) first_closing = closes;
        } else {
            if (!(gap1 > 0.0)) return false;
            double const opens = gap0 / (gap0 - gap1) * (1.0 + CLOSING_ERROR);
            if (!(t > opens)) return false;
        }
    }
    *closing = first_closing;
    return true;
}

toi_result time_of_impact(feature_kind kind, const moving_pair *pair, double separation) {
    gap_corners const corners = make_gap_corners(kind, pair, separation);
    vec3 points[4];
    place_points(kind, &corners, 0.0, points);
    closest_points closest = closest_of_pair(kind, points);
    double t = 0.0;
    toi_state state = corners.is_finite ? TOI_UNRESOLVED : TOI_TOUCHING_AT_START;
    double const excess = sqrt(closest.distance2) - corners.separation;
    /* Advancement stops where no more than this is left of the excess. */
    double const part = corners.separation > 0.0 ? HIT_PART_OF_START : HIT_PART_OF_START_TOUCHING;
    double const tolerance = fmin(fmax(HIT_PART_OF_SEPARATION * corners.separation, part * excess),
                                  HIT_PART_OF_START_MOST * excess);
    for (int round = 0; round < MAX_ADVANCES && state == TOI_UNRESOLVED; round++) {
        double closing;
        bool is_apart = compute_closing(&corners, make_direction(closest.difference), t, &closing);
        if (!is_apart) {
            /* The common normal of both features, either way: it is exact where the closest points
             * are too near to say more. */
            bool const has_face = kind == FEATURE_VERTEX_TRIANGLE;
            vec3 const u = vec3_sub(points[has_face ? 2 : 1], points[has_face ? 1 : 0]);
            vec3 const v = vec3_sub(points[3], points[has_face ? 1 : 2]);
            vec3 const normal = make_direction(vec3_cross(u, v));
            is_apart = compute_closing(&corners, normal, t, &closing) ||
                       compute_closing(&corners, vec3_neg(normal), t, &closing);
        }
        if (!is_apart) {
            state = round == 0 ? TOI_TOUCHING_AT_START : TOI_HIT;
            break;
        }
        bool const is_separated = closing > 1.0;
        double const next = is_separated ? 1.0 : t + ADVANCE_FACTOR * (closing - t);
        bool const has_advanced = next > t;
        t = next;
        place_points(kind, &corners, t, points);
        closest = closest_of_pair(kind, points);
        if (is_separated)
            state = TOI_SEPARATED;
        else if (!has_advanced || sqrt(closest.distance2) - corners.separation <= tolerance)
            state = TOI_HIT;
    }
    closest.difference = vec3_scale(closest.difference, 1.0 / corners.scale);
    closest.distance2 = vec3_norm2(closest.difference);
    return (toi_result){.state = state, .lower_bound = t, .closest = closest};
}

apart_proof prove_apart(feature_kind kind, const moving_pair *pair, double separation) {
    gap_corners const corners = make_gap_corners(kind, pair, separation);
    if (!corners.is_finite) return APART_UNPROVEN;
    double const s = corners.separation;

    /* An axis separates them at both ends. A rounded difference that exceeds the rounded-up
     * separation does so exactly. */
    vec3 least = corners.start[0], most = corners.start[0];
    for (int k = 0; k < 2 * corners.count; k++) {
        vec3 const d = k < corners.count ? corners.start[k] : corners.end[k - corners.count];
        least = (vec3){d.x < least.x ? d.x : least.x, d.y < least.y ? d.y : least.y,
                       d.z < least.z ? d.z : least.z};
        most = (vec3){d.x > most.x ? d.x : most.x, d.y > most.y ? d.y : most.y,
                      d.z > most.z ? d.z : most.z};
    }
    if (least.x > s || least.y > s || least.z > s || most.x < -s || most.y < -s || most.z < -s)
        return APART_BY_DIRECTION;

    /* One direction, the closest one at either end: all gaps along it exceed the separation at both
     * ends, hence in between. */
    vec3 n[2];
    for (int end = 0; end < 2; end++) {
        vec3 points[4];
        place_points(kind, &corners, (double)end, points);
        n[end] = make_direction(closest_of_pair(kind, points).difference);
        bool separates = true;
        for (int k = 0; k < corners.count && separates; k++)
            separates = bound_gap(n[end], corners.start[k], s) > 0.0 &&
                        bound_gap(n[end], corners.end[k], s) > 0.0;
        if (separates) return APART_BY_DIRECTION;
    }

    /* The direction that turns from the one to the other. Its middle coefficient is the mean of two
     * bounds, whose sum has the sign of the exact one; the others are gaps along n[0] at the start
     * and along n[1] at the end. |n(t)| <= 1 up to rounding. */
    for (int k = 0; k < corners.count; k++) {
        vec3 const start = corners.start[k], end = corners.end[k];
        if (!(bound_gap(n[0], start, s) > 0.0) || !(bound_gap(n[1], end, s) > 0.0) ||
            !(bound_gap(n[0], end, s) + bound_gap(n[1], start, s) > 0.0))
            return APART_UNPROVEN;
    }
    return APART_BY_TURNING;
}
