/* contact/pairs/kernels/pair_filter_kernel.c - see pair_filter.h. */
#include "contact/pairs/kernels/pair_points.h"
#include "contact/pairs/pair_filter.h"

/* Three vectors that tell all of a pair but where it is: from each corner of the triangle to the
 * vertex; or from the second edge's first end to the first one's, and along both edges. */
SIMD_INLINE void load_vectors(feature_kind kind, const record_lanes *at, moving_lanes v[3]) {
    bool const is_vertex = kind == FEATURE_VERTEX_TRIANGLE;
    v[0] = load_difference(at->points[0], at->points[is_vertex ? 1 : 2]);
    v[1] = load_difference(at->points[is_vertex ? 0 : 1], at->points[is_vertex ? 2 : 0]);
    v[2] = load_difference(at->points[is_vertex ? 0 : 3], at->points[is_vertex ? 3 : 2]);
}

/* d: from the middle of the second feature to that of the first. */
SIMD_INLINE vec3x8 compute_direction(feature_kind kind, const moving_lanes v[3]) {
    if (kind == FEATURE_VERTEX_TRIANGLE)
        return vec3x8_scale(vec3x8_add(vec3x8_add(v[0].start, v[1].start), v[2].start),
                            double8_fill(1.0 / 3.0));
    return vec3x8_add_scaled(v[0].start, vec3x8_sub(v[1].start, v[2].start), double8_fill(0.5));
}

/* n: the common normal of both features, towards the first. */
SIMD_INLINE vec3x8 compute_normal(feature_kind kind, const moving_lanes v[3]) {
    vec3x8 const normal =
        kind == FEATURE_VERTEX_TRIANGLE
            ? vec3x8_cross(vec3x8_sub(v[0].start, v[1].start), vec3x8_sub(v[0].start, v[2].start))
            : vec3x8_cross(v[1].start, v[2].start);
    double8 const across = vec3x8_dot(normal, v[0].start);
    return vec3x8_select(double8_greater(double8_fill(0.0), across), vec3x8_neg(normal), normal);
}

/* g from the extents of the vectors along d */
SIMD_INLINE double8 compute_gap(feature_kind kind, const double8 along[3]) {
    double8 const zero = double8_fill(0.0);
    if (kind == FEATURE_VERTEX_TRIANGLE)
        return double8_min(along[0], double8_min(along[1], along[2]));
    return along[0] + double8_min(zero, along[1]) - double8_max(zero, along[2]);
}

/* g > s |d| from s^2 and |d|^2; false where anything is not a number. */
SIMD_INLINE bool8 exceeds(double8 gap, double bound2, double8 norm2) {
    return bool8_and(double8_greater(gap, double8_fill(0.0)),
                     double8_greater(gap * gap, bound2 * norm2));
}

/* The lanes that a fixed direction keeps apart. */
SIMD_INLINE bool8 separates(const pair_filter *filter, feature_kind kind, vec3x8 direction,
                            const moving_lanes v[3]) {
    double8 const norm2 = vec3x8_dot(direction, direction);
    double8 start[3], end[3];
    for (int k = 0; k < 3; k++) {
        start[k] = vec3x8_dot(direction, v[k].start);
        end[k] = vec3x8_dot(direction, v[k].end);
    }
    return bool8_and(exceeds(compute_gap(kind, start), filter->at_start * filter->at_start, norm2),
                     exceeds(compute_gap(kind, end), filter->at_end * filter->at_end, norm2));
}

/* Lanes that are kept. */
SIMD_INLINE lane_mask keep_lanes(const pair_filter *filter, feature_kind kind,
                                 const feature_pair *pairs, size_t lane_count) {
    record_lanes at;
    moving_lanes v[3];
    get_pair_records(filter->topo, filter->records, kind, pairs, lane_count, &at);
    load_vectors(kind, &at, v);
    lane_mask const all = ((lane_mask)1 << lane_count) - 1;
    lane_mask const kept =
        all & ~bool8_bits(separates(filter, kind, compute_direction(kind, v), v));
    if (kept == 0) return 0;
    return kept & ~bool8_bits(separates(filter, kind, compute_normal(kind, v), v));
}

SIMD_INLINE size_t filter_kind(const pair_filter *filter, feature_kind kind,
                               const feature_pair *pairs, size_t count, feature_pair *kept) {
    size_t kept_count = 0;
    for (size_t begin = 0; begin < count; begin += DOUBLE_LANES) {
        size_t const rest = count - begin;
        size_t const lane_count = rest < DOUBLE_LANES ? rest : DOUBLE_LANES;
        lane_mask const mask = keep_lanes(filter, kind, pairs + begin, lane_count);
        /* without branches: most masks have some bits */
        for (size_t k = 0; k < lane_count; k++) {
            kept[kept_count] = pairs[begin + k];
            kept_count += mask >> k & 1;
        }
    }
    return kept_count;
}

size_t TULLE_KERNEL(filter_pairs)(const pair_filter *filter, feature_kind kind,
                                  const feature_pair *pairs, size_t count, feature_pair *kept) {
    return kind == FEATURE_VERTEX_TRIANGLE
               ? filter_kind(filter, FEATURE_VERTEX_TRIANGLE, pairs, count, kept)
               : filter_kind(filter, FEATURE_EDGE_EDGE, pairs, count, kept);
}
