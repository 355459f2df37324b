/* contact/pairs/kernels/pair_distance_kernel.c - closest_of_pair for eight pairs at a time. */
#include "contact/pairs/kernels/pair_points.h"
#include "contact/pairs/pair_filter.h"
#include "contact/rows/normal_cones.h"
#include "detect/impact/kernels/closest_lanes.h"

SIMD_INLINE void store_lanes(double *to, double8 values, size_t lane_count) {
    if (lane_count == DOUBLE_LANES) {
        double8_store(to, values);
        return;
    }
    for (size_t k = 0; k < lane_count; k++) to[k] = values[k];
}

/* Lanes in which a foot is an end of its edge. */
SIMD_INLINE lane_mask mark_ends(const double8 feet[2]) {
    double8 const one = double8_fill(1.0), least = double8_fill(RIM_WEIGHT);
    lane_mask ends = 0;
    for (int k = 0; k < 2; k++)
        ends |= bool8_bits(
            bool8_or(double8_greater(least, feet[k]), double8_greater(least, one - feet[k])));
    return ends;
}

SIMD_INLINE void measure_kind(const topology *topo, const vertex_record *records, feature_kind kind,
                              const feature_pair *pairs, size_t count,
                              const pair_measures *measures) {
    for (size_t begin = 0; begin < count; begin += DOUBLE_LANES) {
        size_t const rest = count - begin;
        size_t const lane_count = rest < DOUBLE_LANES ? rest : DOUBLE_LANES;
        moving_lanes p[4];
        load_pair_points(topo, records, kind, pairs + begin, lane_count, p);
        const vec3x8 points[4] = {p[0].start, p[1].start, p[2].start, p[3].start};
        bool const is_vertex = kind == FEATURE_VERTEX_TRIANGLE;
        double8 feet[2];
        double8 const distances2 =
            is_vertex ? compute_vertex_distances2(points) : compute_edge_distances2(points, feet);
        store_lanes(measures->distances + begin, double8_sqrt(distances2), lane_count);
        lane_mask const ends = is_vertex ? 0 : mark_ends(feet);
        for (size_t k = 0; k < lane_count; k++) measures->is_at_end[begin + k] = ends >> k & 1;
    }
}

void TULLE_KERNEL(measure_distances)(const topology *topo, const vertex_record *records,
                                     feature_kind kind, const feature_pair *pairs, size_t count,
                                     const pair_measures *measures) {
    if (kind == FEATURE_VERTEX_TRIANGLE)
        measure_kind(topo, records, FEATURE_VERTEX_TRIANGLE, pairs, count, measures);
    else
        measure_kind(topo, records, FEATURE_EDGE_EDGE, pairs, count, measures);
}
