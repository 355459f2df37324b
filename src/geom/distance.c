/* geom/distance.c - see distance.h.
 *
 * In: four finite points (coordinates under 1e150). Out: weights inside their range (exactly 0 or 1
 * at a corner), the difference vector computed from local differences, so that its error is a few
 * ulp of the pair's extent and not of the distance to the origin.
 *
 * Based on: Ericson, Real-Time Collision Detection, 2005, 5.1. Departure: the determinant of the
 * normal equations loses all digits for thin triangles and nearly parallel edges, so they are only
 * used where the directions are well apart (most pairs; two to three times faster). Elsewhere one
 * longest edge u is the base, and the other direction v and the offset q are first made orthogonal
 * to it: t = q'.v' / v'.v'. Where v' is short (h) against the extent L, at distance d, t is off by
 * eps L d / h^2 and at most by 1; the distance then grows by at most
 * min((eps L / h)^2 d, h^2 / d) / 2 <= eps L: never more than rounding. */
#include "geom/distance.h"

#include <stdbool.h>

/* NaN becomes 0. */
static inline double clamp_unit(double t) { return t > 0.0 ? (t < 1.0 ? t : 1.0) : 0.0; }

/* Part of a orthogonal to base; inverse is 1 / |base|^2. */
static inline vec3 remove_component(vec3 a, vec3 base, double inverse) {
    return vec3_add_scaled(a, base, -vec3_dot(a, base) * inverse);
}

/* The foot of the point on the triangle's plane with base corner a, longest edge u and other edge
 * v; false unless it lies strictly inside. Coordinates: foot = a + s u + t v. */
static inline bool compute_interior_foot(vec3 offset, vec3 u, vec3 v, double u_length2,
                                         double foot[2], vec3 *difference) {
    if (!(u_length2 > 0.0)) return false;
    double const inverse = 1.0 / u_length2;
    vec3 const v_normal = remove_component(v, u, inverse);
    double const height2 = vec3_norm2(v_normal);
    if (!(height2 > 0.0)) return false;
    double const t = vec3_dot(remove_component(offset, u, inverse), v_normal) / height2;
    if (!(t > 0.0 && t < 1.0)) return false;
    vec3 const rest = vec3_add_scaled(offset, v, -t);
    double const s = vec3_dot(rest, u) * inverse;
    if (!(s > 0.0 && s + t < 1.0)) return false;
    foot[0] = s;
    foot[1] = t;
    *difference = vec3_add_scaled(rest, u, -s);
    return true;
}

/* Any triangle: the foot if it is inside, else the nearest of the three edges. */
static closest_points closest_on_any_triangle(const vec3 points[4]) {
    vec3 const p = points[0];
    const vec3 *const corner = points + 1;
    vec3 const edge[3] = {vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[1]),
                          vec3_sub(corner[0], corner[2])};
    double const length2[3] = {vec3_norm2(edge[0]), vec3_norm2(edge[1]), vec3_norm2(edge[2])};
    int a = length2[1] > length2[0] ? 1 : 0;
    if (length2[2] > length2[a]) a = 2;
    int const b = a == 2 ? 0 : a + 1;
    int const c = 3 - a - b;

    closest_points result = {.weights = {1.0, 0.0, 0.0, 0.0}};
    double foot[2];
    if (compute_interior_foot(vec3_sub(p, corner[a]), edge[a], vec3_neg(edge[c]), length2[a], foot,
                              &result.difference)) {
        result.weights[1 + a] = -(1.0 - (foot[0] + foot[1]));
        result.weights[1 + b] = -foot[0];
        result.weights[1 + c] = -foot[1];
        result.distance2 = vec3_norm2(result.difference);
        return result;
    }
    /* Outside, or no area: the nearest of the three edges. */
    int nearest = 0;
    double parameter = 0.0; /* of the closest point on that edge */
    for (int k = 0; k < 3; k++) {
        vec3 const offset = vec3_sub(p, corner[k]);
        double const t =
            length2[k] > 0.0 ? clamp_unit(vec3_dot(offset, edge[k]) / length2[k]) : 0.0;
        vec3 const difference = t >= 1.0 ? vec3_sub(p, corner[k == 2 ? 0 : k + 1])
                                         : vec3_add_scaled(offset, edge[k], -t);
        double const distance2 = vec3_norm2(difference);
        if (k > 0 && !(distance2 < result.distance2)) continue;
        nearest = k;
        parameter = t;
        result.difference = difference;
        result.distance2 = distance2;
    }
    result.weights[1 + nearest] = -(1.0 - parameter);
    result.weights[1 + (nearest == 2 ? 0 : nearest + 1)] = -parameter;
    return result;
}

closest_points closest_vertex_triangle(const vec3 points[4]) {
    vec3 const u = vec3_sub(points[2], points[1]), v = vec3_sub(points[3], points[1]);
    vec3 const offset = vec3_sub(points[0], points[1]);
    double const uu = vec3_norm2(u), uv = vec3_dot(u, v), vv = vec3_norm2(v);
    double const longer2 = uu > vv ? uu : vv, determinant = uu * vv - uv * uv;
    if (!(determinant > SOUND_RATIO * longer2 * longer2 && determinant > DETERMINANT_MIN))
        return closest_on_any_triangle(points);

    /* Ericson's regions of a triangle a, b, c: u and v times p - a, p - b, p - c, and the areas
     * that the foot makes with the edges. One division gives the foot, a + s u + t v. */
    double const a_u = vec3_dot(u, offset), a_v = vec3_dot(v, offset);
    double const b_u = a_u - uu, b_v = a_v - uv, c_u = a_u - uv, c_v = a_v - vv;
    double const t_area = uu * a_v - uv * a_u, s_area = vv * a_u - uv * a_v;
    double const rest_area = determinant - s_area - t_area;
    double s = 0.0, t = 0.0;
    if (a_u <= 0.0 && a_v <= 0.0) {
        s = t = 0.0; /* at a */
    } else if (b_u >= 0.0 && b_v <= b_u) {
        s = 1.0;
    } else if (c_v >= 0.0 && c_u <= c_v) {
        t = 1.0;
    } else if (t_area <= 0.0 && a_u >= 0.0 && b_u <= 0.0) {
        s = clamp_unit(a_u / uu);
    } else if (s_area <= 0.0 && a_v >= 0.0 && c_v <= 0.0) {
        t = clamp_unit(a_v / vv);
    } else if (rest_area <= 0.0) {
        t = clamp_unit((b_v - b_u) / (uu - 2.0 * uv + vv));
        s = 1.0 - t;
    } else {
        double const inverse = 1.0 / determinant;
        s = clamp_unit(s_area * inverse);
        t = clamp_unit(t_area * inverse);
    }

    double const sum = s + t;
    closest_points result = {.weights = {1.0, sum < 1.0 ? -(1.0 - sum) : -0.0, -s, -t}};
    if (s >= 1.0)
        result.difference = vec3_sub(points[0], points[2]);
    else if (t >= 1.0)
        result.difference = vec3_sub(points[0], points[3]);
    else
        result.difference = vec3_add_scaled(vec3_add_scaled(offset, u, -s), v, -t);
    result.distance2 = vec3_norm2(result.difference);
    return result;
}

closest_points closest_edge_edge(const vec3 points[4]) {
    vec3 const first = vec3_sub(points[1], points[0]), second = vec3_sub(points[3], points[2]);
    vec3 const offset = vec3_sub(points[2], points[0]);
    double const products[3] = {vec3_norm2(first), vec3_dot(first, second), vec3_norm2(second)};
    double const determinant = products[0] * products[2] - products[1] * products[1];
    double s = 0.0, t = 0.0;
    if (determinant > SOUND_RATIO * products[0] * products[2] && determinant > DETERMINANT_MIN) {
        /* Well apart in direction: the normal equations. */
        double const uu = products[0], uv = products[1], vv = products[2];
        double const u_q = vec3_dot(first, offset), v_q = vec3_dot(second, offset);
        t = clamp_unit((uv * u_q - uu * v_q) / determinant);
        double const s_free = (u_q + uv * t) / uu;
        s = clamp_unit(s_free);
        if (s != s_free) t = clamp_unit((uv * s - v_q) / vv);
    } else {
        /* The longer edge is the base: a + s u and b + t v, q = b - a, |u| >= |v|. Exact minimum of
         * the convex quadratic on the unit square: the free t, clamped; the best s for it; and
         * where that had to be clamped, the best t for that s. */
        bool const is_swapped = products[0] < products[2];
        vec3 const u = is_swapped ? second : first, v = is_swapped ? first : second;
        vec3 const q = is_swapped ? vec3_neg(offset) : offset;
        double const uu = products[is_swapped ? 2 : 0], vv = products[is_swapped ? 0 : 2];
        if (uu > 0.0) {
            double const inverse = 1.0 / uu;
            vec3 const v_normal = remove_component(v, u, inverse);
            double const height2 = vec3_norm2(v_normal);
            if (height2 > 0.0)
                t = clamp_unit(-vec3_dot(remove_component(q, u, inverse), v_normal) / height2);
            double const s_free = vec3_dot(vec3_add_scaled(q, v, t), u) * inverse;
            s = clamp_unit(s_free);
            if (s != s_free && vv > 0.0)
                t = clamp_unit(vec3_dot(vec3_add_scaled(vec3_neg(q), u, s), v) / vv);
        }
        if (is_swapped) {
            double const of_first = t;
            t = s;
            s = of_first;
        }
    }
    /* From the corner itself where a parameter is at its end, so that the difference is exact. */
    bool const at_end_first = s >= 1.0, at_end_second = t >= 1.0;
    closest_points result = {.weights = {1.0 - s, s, -(1.0 - t), -t}};
    vec3 difference = vec3_sub(points[at_end_first ? 1 : 0], points[at_end_second ? 3 : 2]);
    if (!at_end_first) difference = vec3_add_scaled(difference, first, s);
    if (!at_end_second) difference = vec3_add_scaled(difference, second, -t);
    result.difference = difference;
    result.distance2 = vec3_norm2(difference);
    return result;
}

closest_points closest_of_pair(feature_kind kind, const vec3 points[4]) {
    return kind == FEATURE_VERTEX_TRIANGLE ? closest_vertex_triangle(points)
                                           : closest_edge_edge(points);
}
