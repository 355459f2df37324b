/* contact/kernels/pair_distance_kernel.c - closest_of_pair for eight pairs at a time. */
#include "contact/kernels/pair_points.h"
#include "contact/pair_filter.h"
#include "detect/kernels/closest_lanes.h"

SIMD_INLINE void store_lanes(double *to, double8 values, size_t lane_count) {
    if (lane_count == DOUBLE_LANES) {
        double8_store(to, values);
        return;
    }
    for (size_t k = 0; k < lane_count; k++) to[k] = values[k];
}

SIMD_INLINE void measure_kind(const topology *topo, const vertex_record *records, feature_kind kind,
                              const feature_pair *pairs, size_t count, double *distances[2]) {
    for (size_t begin = 0; begin < count; begin += DOUBLE_LANES) {
        size_t const rest = count - begin;
        size_t const lane_count = rest < DOUBLE_LANES ? rest : DOUBLE_LANES;
        moving_lanes p[4];
        load_pair_points(topo, records, kind, pairs + begin, lane_count, p);
        const vec3x8 start[4] = {p[0].start, p[1].start, p[2].start, p[3].start};
        const vec3x8 end[4] = {p[0].end, p[1].end, p[2].end, p[3].end};
        store_lanes(distances[0] + begin, double8_sqrt(find_distances2(kind, start)), lane_count);
        store_lanes(distances[1] + begin, double8_sqrt(find_distances2(kind, end)), lane_count);
    }
}

void TULLE_KERNEL(measure_distances)(const topology *topo, const vertex_record *records,
                                     feature_kind kind, const feature_pair *pairs, size_t count,
                                     double *distances[2]) {
    if (kind == FEATURE_VERTEX_TRIANGLE)
        measure_kind(topo, records, FEATURE_VERTEX_TRIANGLE, pairs, count, distances);
    else
        measure_kind(topo, records, FEATURE_EDGE_EDGE, pairs, count, distances);
}
