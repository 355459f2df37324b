/* contact/kernels/pair_filter_kernel.c - see pair_filter.h. */
#include "contact/kernels/pair_points.h"
#include "contact/pair_filter.h"

/* d: from the middle of the second feature to that of the first. */
SIMD_INLINE vec3x8 find_direction(feature_kind kind, const moving_lanes p[4]) {
    if (kind == FEATURE_VERTEX_TRIANGLE)
        return vec3x8_add_scaled(p[0].start,
                                 vec3x8_add(vec3x8_add(p[1].start, p[2].start), p[3].start),
                                 double8_fill(-1.0 / 3.0));
    return vec3x8_scale(
        vec3x8_sub(vec3x8_add(p[0].start, p[1].start), vec3x8_add(p[2].start, p[3].start)),
        double8_fill(0.5));
}

/* g from the places of the corners along d */
SIMD_INLINE double8 find_gap(feature_kind kind, const double8 at[4]) {
    double8 const later = double8_max(at[2], at[3]);
    return kind == FEATURE_VERTEX_TRIANGLE ? at[0] - double8_max(at[1], later)
                                           : double8_min(at[0], at[1]) - later;
}

/* g > s |d| from s^2 and |d|^2; false where anything is not a number. */
SIMD_INLINE bool8 exceeds(double8 gap, double bound2, double8 norm2) {
    return bool8_and(double8_greater(gap, double8_fill(0.0)),
                     double8_greater(gap * gap, bound2 * norm2));
}

/* Lanes that are kept. */
SIMD_INLINE lane_mask keep_lanes(const pair_filter *filter, feature_kind kind,
                                 const feature_pair *pairs, size_t lane_count) {
    moving_lanes p[4];
    load_pair_points(filter->topo, filter->records, kind, pairs, lane_count, p);
    vec3x8 const direction = find_direction(kind, p);
    double8 const norm2 = vec3x8_dot(direction, direction);
    double8 start[4], end[4];
    for (int k = 0; k < 4; k++) {
        start[k] = vec3x8_dot(direction, p[k].start);
        end[k] = vec3x8_dot(direction, p[k].end);
    }
    bool8 const apart =
        bool8_and(exceeds(find_gap(kind, start), filter->at_start * filter->at_start, norm2),
                  exceeds(find_gap(kind, end), filter->at_end * filter->at_end, norm2));
    return ~bool8_bits(apart) & (((lane_mask)1 << lane_count) - 1);
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
