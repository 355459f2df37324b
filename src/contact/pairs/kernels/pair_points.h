/* contact/pairs/kernels/pair_points.h - the paths of the points of eight pairs of features. */
#ifndef TULLE_CONTACT_PAIRS_KERNELS_PAIR_POINTS_H
#define TULLE_CONTACT_PAIRS_KERNELS_PAIR_POINTS_H

#include "detect/impact/kernels/pair_lanes.h"

/* Up to eight pairs; lanes beyond repeat the last pair. records: of all vertices. */
SIMD_INLINE void get_pair_records(const topology *topo, const vertex_record *records,
                                  feature_kind kind, const feature_pair *pairs, size_t lane_count,
                                  record_lanes *at) {
    for (size_t k = 0; k < DOUBLE_LANES; k++) {
        uint32_t vertices[4];
        feature_pair_vertices(topo, kind, pairs[k < lane_count ? k : lane_count - 1], vertices);
        for (int i = 0; i < 4; i++) at->points[i][k] = records + vertices[i];
    }
}

SIMD_INLINE void load_pair_points(const topology *topo, const vertex_record *records,
                                  feature_kind kind, const feature_pair *pairs, size_t lane_count,
                                  moving_lanes points[4]) {
    record_lanes at;
    get_pair_records(topo, records, kind, pairs, lane_count, &at);
    for (int i = 0; i < 4; i++) points[i] = load_moving(at.points[i]);
}

#endif
