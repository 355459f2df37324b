/* detect/impact/kernels/pair_lanes.h - loading eight moving pairs at a time. */
#ifndef TULLE_DETECT_IMPACT_KERNELS_PAIR_LANES_H
#define TULLE_DETECT_IMPACT_KERNELS_PAIR_LANES_H

#include "detect/impact/impact_pool.h"
#include "math/simd_double.h"

/* The slots of eight pairs. */
typedef struct slot_lanes {
    uint32_t first[DOUBLE_LANES], second[DOUBLE_LANES];
} slot_lanes;

/* One vector, of a point or from point to point, at the start and the end. */
typedef struct moving_lanes {
    vec3x8 start, end;
} moving_lanes;

/* Up to eight pairs from index `begin`; lanes beyond repeat the last pair. */
SIMD_INLINE slot_lanes load_slots(const slot_pairs *pairs, size_t begin, size_t lane_count) {
    slot_lanes slots;
    if (lane_count == DOUBLE_LANES) {
        memcpy(slots.first, pairs->first + begin, sizeof slots.first);
        memcpy(slots.second, pairs->second + begin, sizeof slots.second);
        return slots;
    }
    for (size_t k = 0; k < DOUBLE_LANES; k++) {
        size_t const from = begin + (k < lane_count ? k : lane_count - 1);
        slots.first[k] = pairs->first[from];
        slots.second[k] = pairs->second[from];
    }
    return slots;
}

SIMD_INLINE double8 load_separations(const slot_pairs *pairs, size_t begin, size_t lane_count) {
    double8 separations = double8_fill(0.0);
    if (!pairs->separations) return separations;
    if (lane_count == DOUBLE_LANES) return double8_load(pairs->separations + begin);
    for (size_t k = 0; k < lane_count; k++) separations[k] = pairs->separations[begin + k];
    return separations;
}

/* Vertex records of the four points of each pair. */
typedef struct record_lanes {
    const vertex_record *points[4][DOUBLE_LANES];
} record_lanes;

SIMD_INLINE void get_records(const pair_tables *tables, feature_kind kind, const slot_lanes *slots,
                             record_lanes *to) {
    const vertex_record *const records = tables->records;
    for (int k = 0; k < DOUBLE_LANES; k++) {
        if (kind == FEATURE_VERTEX_TRIANGLE) {
            const uint32_t *const corners = tables->triangle_corners + 3 * (size_t)slots->second[k];
            to->points[0][k] = records + tables->vertex_corners[slots->first[k]];
            to->points[1][k] = records + corners[0];
            to->points[2][k] = records + corners[1];
            to->points[3][k] = records + corners[2];
        } else {
            const uint32_t *const a = tables->edge_corners + 2 * (size_t)slots->first[k];
            const uint32_t *const b = tables->edge_corners + 2 * (size_t)slots->second[k];
            to->points[0][k] = records + a[0];
            to->points[1][k] = records + a[1];
            to->points[2][k] = records + b[0];
            to->points[3][k] = records + b[1];
        }
    }
}

#ifdef __AVX512F__
#define SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)

/* Rows x0 y0 z0 - x1 y1 z1 - of eight pairs become vectors over the pairs. */
SIMD_INLINE moving_lanes transpose_rows(const double8 rows[DOUBLE_LANES]) {
    double8 xz[4], y[4];
    for (int k = 0; k < 4; k++) {
        xz[k] = SHUFFLE(rows[2 * k], rows[2 * k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
        y[k] = SHUFFLE(rows[2 * k], rows[2 * k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
    }
    double8 const x_low = SHUFFLE(xz[0], xz[1], 0, 1, 4, 5, 8, 9, 12, 13);
    double8 const x_high = SHUFFLE(xz[2], xz[3], 0, 1, 4, 5, 8, 9, 12, 13);
    double8 const z_low = SHUFFLE(xz[0], xz[1], 2, 3, 6, 7, 10, 11, 14, 15);
    double8 const z_high = SHUFFLE(xz[2], xz[3], 2, 3, 6, 7, 10, 11, 14, 15);
    double8 const y_low = SHUFFLE(y[0], y[1], 0, 1, 4, 5, 8, 9, 12, 13);
    double8 const y_high = SHUFFLE(y[2], y[3], 0, 1, 4, 5, 8, 9, 12, 13);
    moving_lanes to;
    to.start.x = SHUFFLE(x_low, x_high, 0, 1, 4, 5, 8, 9, 12, 13);
    to.end.x = SHUFFLE(x_low, x_high, 2, 3, 6, 7, 10, 11, 14, 15);
    to.start.y = SHUFFLE(y_low, y_high, 0, 1, 4, 5, 8, 9, 12, 13);
    to.end.y = SHUFFLE(y_low, y_high, 2, 3, 6, 7, 10, 11, 14, 15);
    to.start.z = SHUFFLE(z_low, z_high, 0, 1, 4, 5, 8, 9, 12, 13);
    to.end.z = SHUFFLE(z_low, z_high, 2, 3, 6, 7, 10, 11, 14, 15);
    return to;
}

/* a - b */
SIMD_INLINE moving_lanes load_difference(const vertex_record *const a[DOUBLE_LANES],
                                         const vertex_record *const b[DOUBLE_LANES]) {
    double8 rows[DOUBLE_LANES];
    for (int k = 0; k < DOUBLE_LANES; k++)
        rows[k] = double8_load(a[k]->start) - double8_load(b[k]->start);
    return transpose_rows(rows);
}

/* The offset of the first corners of both features, then an edge of each. Every record is read
 * once. */
SIMD_INLINE void load_corner_differences(const pair_tables *tables, feature_kind kind,
                                         const uint32_t *first, const uint32_t *second,
                                         moving_lanes to[3]) {
    double8 rows[3][DOUBLE_LANES];
    const vertex_record *const records = tables->records;
    for (int k = 0; k < DOUBLE_LANES; k++) {
        bool const is_vertex_triangle = kind == FEATURE_VERTEX_TRIANGLE;
        const uint32_t *const a = is_vertex_triangle ? tables->vertex_corners + first[k]
                                                     : tables->edge_corners + 2 * (size_t)first[k];
        const uint32_t *const b =
            (is_vertex_triangle ? tables->triangle_corners + 3 * (size_t)second[k]
                                : tables->edge_corners + 2 * (size_t)second[k]);
        double8 const a0 = double8_load(records[a[0]].start);
        double8 const b0 = double8_load(records[b[0]].start);
        rows[0][k] = a0 - b0;
        rows[1][k] = double8_load(records[is_vertex_triangle ? b[1] : a[1]].start) -
                     (is_vertex_triangle ? b0 : a0);
        rows[2][k] = double8_load(records[b[is_vertex_triangle ? 2 : 1]].start) - b0;
    }
    for (int i = 0; i < 3; i++) to[i] = transpose_rows(rows[i]);
}

SIMD_INLINE moving_lanes load_moving(const vertex_record *const from[DOUBLE_LANES]) {
    double8 rows[DOUBLE_LANES];
    for (int k = 0; k < DOUBLE_LANES; k++) rows[k] = double8_load(from[k]->start);
    return transpose_rows(rows);
}
#else
SIMD_INLINE moving_lanes load_difference(const vertex_record *const a[DOUBLE_LANES],
                                         const vertex_record *const b[DOUBLE_LANES]) {
    moving_lanes to;
    for (int k = 0; k < DOUBLE_LANES; k++) {
        to.start.x[k] = a[k]->start[0] - b[k]->start[0];
        to.start.y[k] = a[k]->start[1] - b[k]->start[1];
        to.start.z[k] = a[k]->start[2] - b[k]->start[2];
        to.end.x[k] = a[k]->end[0] - b[k]->end[0];
        to.end.y[k] = a[k]->end[1] - b[k]->end[1];
        to.end.z[k] = a[k]->end[2] - b[k]->end[2];
    }
    return to;
}

SIMD_INLINE moving_lanes load_moving(const vertex_record *const from[DOUBLE_LANES]) {
    moving_lanes to;
    for (int k = 0; k < DOUBLE_LANES; k++) {
        to.start.x[k] = from[k]->start[0];
        to.start.y[k] = from[k]->start[1];
        to.start.z[k] = from[k]->start[2];
        to.end.x[k] = from[k]->end[0];
        to.end.y[k] = from[k]->end[1];
        to.end.z[k] = from[k]->end[2];
    }
    return to;
}

SIMD_INLINE void load_corner_differences(const pair_tables *tables, feature_kind kind,
                                         const uint32_t *first, const uint32_t *second,
                                         moving_lanes to[3]) {
    slot_lanes slots;
    memcpy(slots.first, first, sizeof slots.first);
    memcpy(slots.second, second, sizeof slots.second);
    record_lanes at;
    get_records(tables, kind, &slots, &at);
    bool const is_vertex_triangle = kind == FEATURE_VERTEX_TRIANGLE;
    to[0] = load_difference(at.points[0], at.points[is_vertex_triangle ? 1 : 2]);
    to[1] = is_vertex_triangle ? load_difference(at.points[2], at.points[1])
                               : load_difference(at.points[1], at.points[0]);
    to[2] = load_difference(at.points[3], at.points[is_vertex_triangle ? 1 : 2]);
}
#endif

#endif
