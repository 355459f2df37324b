/* detect/impact/kernels/closest_lanes.h - the vector between the closest points of eight pairs, by
 * the arithmetic of geom/distance.c, to the bit (but for the sign of a zero). */
#ifndef TULLE_DETECT_IMPACT_KERNELS_CLOSEST_LANES_H
#define TULLE_DETECT_IMPACT_KERNELS_CLOSEST_LANES_H

#include "geom/distance.h"
#include "math/simd_double.h"

typedef struct closest_lanes {
    vec3x8 difference; /* second feature to first */
    vec3x8 u, v;       /* two edges of the triangle, or both edges; their cross product is normal */
} closest_lanes;

/* NaN becomes 0. */
SIMD_INLINE double8 clamp_unit(double8 t) {
    double8 const zero = double8_fill(0.0);
    return double8_select(double8_greater(t, zero), double8_min(t, double8_fill(1.0)), zero);
}

SIMD_INLINE bool8 at_least(double8 a, double8 b) { return bool8_not(double8_greater(b, a)); }

SIMD_INLINE vec3 vec3x8_get(vec3x8 a, int lane) { return (vec3){a.x[lane], a.y[lane], a.z[lane]}; }

/* Thin triangles, one by one. d: vertex less corner. */
static void compute_thin_differences(const vec3x8 d[4], lane_mask lanes, vec3x8 *difference) {
    for (; lanes; lanes &= lanes - 1) {
        int const k = __builtin_ctz(lanes);
        vec3 const points[4] = {{0.0, 0.0, 0.0},
                                vec3_neg(vec3x8_get(d[0], k)),
                                vec3_neg(vec3x8_get(d[1], k)),
                                vec3_neg(vec3x8_get(d[2], k))};
        vec3 const found = closest_vertex_triangle(points).difference;
        difference->x[k] = found.x;
        difference->y[k] = found.y;
        difference->z[k] = found.z;
    }
}

/* Dot products of a triangle's edges u, v and the vector from its first corner to the vertex. */
typedef struct triangle_products {
    double8 uu, uv, vv, a_u, a_v, determinant;
} triangle_products;

/* The foot a + f0 u + f1 v on a sound triangle, by the regions of closest_vertex_triangle
 * (geom/distance.c). One division. */
SIMD_INLINE void compute_foot_lanes(const triangle_products *p, double8 foot[2]) {
    double8 const uu = p->uu, uv = p->uv, vv = p->vv, a_u = p->a_u, a_v = p->a_v;
    double8 const determinant = p->determinant;
    double8 const zero = double8_fill(0.0), one = double8_fill(1.0);
    double8 const b_u = a_u - uu, b_v = a_v - uv, c_u = a_u - uv, c_v = a_v - vv;
    double8 const t_area = uu * a_v - uv * a_u, s_area = vv * a_u - uv * a_v;
    double8 const rest_area = determinant - s_area - t_area;
    bool8 const at_a = bool8_and(at_least(zero, a_u), at_least(zero, a_v));
    bool8 const at_b = bool8_and(at_least(b_u, zero), at_least(b_u, b_v));
    bool8 const at_c = bool8_and(at_least(c_v, zero), at_least(c_v, c_u));
    bool8 const on_u =
        bool8_and(at_least(zero, t_area), bool8_and(at_least(a_u, zero), at_least(zero, b_u)));
    bool8 const on_v =
        bool8_and(at_least(zero, s_area), bool8_and(at_least(a_v, zero), at_least(zero, c_v)));
    bool8 const on_w = at_least(zero, rest_area);
    /* Later cases first; earlier ones replace them. */
    double8 above = double8_select(on_w, b_v - b_u, one);
    double8 below = double8_select(on_w, uu - 2.0 * uv + vv, determinant);
    above = double8_select(on_u, a_u, double8_select(on_v, a_v, above));
    below = double8_select(on_u, uu, double8_select(on_v, vv, below));
    double8 const quotient = above / below, clamped = clamp_unit(quotient);
    double8 f0 = double8_select(on_w, 1.0 - clamped, clamp_unit(s_area * quotient));
    double8 f1 = double8_select(on_w, clamped, clamp_unit(t_area * quotient));
    f0 = double8_select(on_u, clamped, double8_select(on_v, zero, f0));
    f1 = double8_select(on_u, zero, double8_select(on_v, clamped, f1));
    f0 = double8_select(at_b, one, double8_select(at_c, zero, f0));
    f1 = double8_select(at_b, zero, double8_select(at_c, one, f1));
    foot[0] = double8_select(at_a, zero, f0);
    foot[1] = double8_select(at_a, zero, f1);
}

/* Vectors of a vertex and a triangle: the vertex less each corner, and two edges from the first
 * corner. */
typedef struct triangle_lanes {
    vec3x8 from_corner[3], u, v;
} triangle_lanes;

/* Not of thin triangles, whose lanes go to *thin. */
SIMD_INLINE vec3x8 compute_sound_difference(const triangle_lanes *at, lane_mask *thin) {
    double8 const one = double8_fill(1.0);
    vec3x8 const u = at->u, v = at->v, offset = at->from_corner[0];
    double8 const uu = vec3x8_dot(u, u), uv = vec3x8_dot(u, v), vv = vec3x8_dot(v, v);
    double8 const a_u = vec3x8_dot(u, offset), a_v = vec3x8_dot(v, offset);
    double8 const longer2 = double8_max(uu, vv), determinant = uu * vv - uv * uv;
    bool8 const is_sound = bool8_and(double8_greater(determinant, SOUND_RATIO * longer2 * longer2),
                                     double8_greater(determinant, double8_fill(DETERMINANT_MIN)));
    double8 foot[2];
    triangle_products const products = {uu, uv, vv, a_u, a_v, determinant};
    compute_foot_lanes(&products, foot);
    vec3x8 difference = vec3x8_add_scaled(vec3x8_add_scaled(offset, u, -foot[0]), v, -foot[1]);
    difference = vec3x8_select(at_least(foot[1], one), at->from_corner[2], difference);
    difference = vec3x8_select(at_least(foot[0], one), at->from_corner[1], difference);
    *thin = ~bool8_bits(is_sound) & 0xff;
    return difference;
}

/* d: vertex less each corner. */
SIMD_INLINE closest_lanes compute_closest_vertex_triangle(const vec3x8 d[4]) {
    triangle_lanes const at = {{d[0], d[1], d[2]}, vec3x8_sub(d[0], d[1]), vec3x8_sub(d[0], d[2])};
    lane_mask thin;
    vec3x8 difference = compute_sound_difference(&at, &thin);
    if (thin) compute_thin_differences(d, thin, &difference);
    return (closest_lanes){difference, at.u, at.v};
}

/* Part of a orthogonal to base. */
SIMD_INLINE vec3x8 remove_component(vec3x8 a, vec3x8 base, double8 inverse) {
    return vec3x8_add_scaled(a, base, -vec3x8_dot(a, base) * inverse);
}

/* compute_edge_parameters of geom/distance.c, for edges of any direction; |u| >= |v|. */
SIMD_INLINE void compute_edge_parameters(vec3x8 offset, vec3x8 u, vec3x8 v, double8 uu, double8 vv,
                                         double8 parameters[2]) {
    double8 const zero = double8_fill(0.0);
    bool8 const has_u = double8_greater(uu, zero);
    double8 const inverse = 1.0 / uu;
    vec3x8 const v_normal = remove_component(v, u, inverse);
    double8 const height2 = vec3x8_dot(v_normal, v_normal);
    double8 const foot =
        clamp_unit(-vec3x8_dot(remove_component(offset, u, inverse), v_normal) / height2);
    double8 t = double8_select(double8_greater(height2, zero), foot, zero);
    double8 const s_free = vec3x8_dot(vec3x8_add_scaled(offset, v, t), u) * inverse;
    double8 const s = clamp_unit(s_free);
    vec3x8 const back = vec3x8_add_scaled(vec3x8_neg(offset), u, s);
    double8 const t_back = clamp_unit(vec3x8_dot(back, v) / vv);
    bool8 const is_free = double8_equal(s, s_free);
    t = double8_select(bool8_and(bool8_not(is_free), double8_greater(vv, zero)), t_back, t);
    parameters[0] = double8_select(has_u, s, zero);
    parameters[1] = double8_select(has_u, t, zero);
}

/* The same for edges in `parallel`, the longer one as base; replaces s and t there. */
static void compute_parallel_parameters(const closest_lanes *edges, vec3x8 offset, bool8 parallel,
                                        double8 *s, double8 *t) {
    double8 const uu = vec3x8_dot(edges->u, edges->u), vv = vec3x8_dot(edges->v, edges->v);
    bool8 const swapped = double8_greater(vv, uu);
    double8 at[2];
    compute_edge_parameters(vec3x8_select(swapped, vec3x8_neg(offset), offset),
                            vec3x8_select(swapped, edges->v, edges->u),
                            vec3x8_select(swapped, edges->u, edges->v),
                            double8_select(swapped, vv, uu), double8_select(swapped, uu, vv), at);
    *s = double8_select(parallel, double8_select(swapped, at[1], at[0]), *s);
    *t = double8_select(parallel, double8_select(swapped, at[0], at[1]), *t);
}

/* The parameters s and t of the closest points on two edges u and v; offset: from the first one's
 * first corner to the second one's. */
SIMD_INLINE void compute_edge_feet(vec3x8 offset, vec3x8 u, vec3x8 v, double8 feet[2]) {
    double8 const uu = vec3x8_dot(u, u), uv = vec3x8_dot(u, v), vv = vec3x8_dot(v, v);
    double8 const determinant = uu * vv - uv * uv;
    bool8 const is_sound = bool8_and(double8_greater(determinant, SOUND_RATIO * uu * vv),
                                     double8_greater(determinant, double8_fill(DETERMINANT_MIN)));
    double8 const u_q = vec3x8_dot(u, offset), v_q = vec3x8_dot(v, offset);
    double8 const t_free = clamp_unit((uv * u_q - uu * v_q) / determinant);
    double8 const s_free = (u_q + uv * t_free) / uu;
    double8 s = clamp_unit(s_free);
    bool8 const is_free = double8_equal(s, s_free);
    double8 t = double8_select(is_free, t_free, clamp_unit((uv * s - v_q) / vv));
    closest_lanes const edges = {.u = u, .v = v};
    lane_mask const parallel = ~bool8_bits(is_sound) & 0xff;
    if (parallel) compute_parallel_parameters(&edges, offset, bool8_not(is_sound), &s, &t);
    feet[0] = s;
    feet[1] = t;
}

/* The difference from d: corners of the first edge less those of the second, 00 01 10 11. */
SIMD_INLINE vec3x8 compute_edge_difference(const vec3x8 d[4], vec3x8 u, vec3x8 v,
                                           const double8 feet[2]) {
    double8 const zero = double8_fill(0.0), one = double8_fill(1.0);
    double8 const s = feet[0], t = feet[1];
    bool8 const at_end_first = at_least(s, one), at_end_second = at_least(t, one);
    vec3x8 difference = vec3x8_select(at_end_first, vec3x8_select(at_end_second, d[3], d[2]),
                                      vec3x8_select(at_end_second, d[1], d[0]));
    difference = vec3x8_add_scaled(difference, u, double8_select(at_end_first, zero, s));
    return vec3x8_add_scaled(difference, v, double8_select(at_end_second, zero, -t));
}

SIMD_INLINE closest_lanes compute_closest_edge_edge(const vec3x8 d[4]) {
    vec3x8 const u = vec3x8_sub(d[2], d[0]), v = vec3x8_sub(d[0], d[1]);
    /* as closest_edge_edge finds them from points about the first one */
    vec3x8 const corners[4] = {d[0], d[1], vec3x8_add(u, d[0]), vec3x8_add(u, d[1])};
    double8 feet[2];
    compute_edge_feet(vec3x8_neg(corners[0]), u, v, feet);
    return (closest_lanes){compute_edge_difference(corners, u, v, feet), u, v};
}

SIMD_INLINE closest_lanes compute_closest(feature_kind kind, const vec3x8 d[4]) {
    return kind == FEATURE_VERTEX_TRIANGLE ? compute_closest_vertex_triangle(d)
                                           : compute_closest_edge_edge(d);
}

/* The squared distances of vertices and triangles. */
SIMD_INLINE double8 compute_vertex_distances2(const vec3x8 p[4]) {
    triangle_lanes const at = {
        {vec3x8_sub(p[0], p[1]), vec3x8_sub(p[0], p[2]), vec3x8_sub(p[0], p[3])},
        vec3x8_sub(p[2], p[1]),
        vec3x8_sub(p[3], p[1])};
    lane_mask thin;
    vec3x8 const difference = compute_sound_difference(&at, &thin);
    double8 distances2 = vec3x8_dot(difference, difference);
    for (; thin; thin &= thin - 1) {
        int const k = __builtin_ctz(thin);
        vec3 const points[4] = {vec3x8_get(p[0], k), vec3x8_get(p[1], k), vec3x8_get(p[2], k),
                                vec3x8_get(p[3], k)};
        distances2[k] = closest_vertex_triangle(points).distance2;
    }
    return distances2;
}

/* The same of edges, with the parameters of the closest points. */
SIMD_INLINE double8 compute_edge_distances2(const vec3x8 p[4], double8 feet[2]) {
    vec3x8 const corners[4] = {vec3x8_sub(p[0], p[2]), vec3x8_sub(p[0], p[3]),
                               vec3x8_sub(p[1], p[2]), vec3x8_sub(p[1], p[3])};
    vec3x8 const u = vec3x8_sub(p[1], p[0]), v = vec3x8_sub(p[3], p[2]);
    compute_edge_feet(vec3x8_neg(corners[0]), u, v, feet);
    vec3x8 const difference = compute_edge_difference(corners, u, v, feet);
    return vec3x8_dot(difference, difference);
}

#endif
