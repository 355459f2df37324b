/* detect/impact/kernels/coplanarity_kernel.c - pair_cannot_cross for eight pairs at a time, the
 * same arithmetic as coplanarity_filter.c. */
#include "detect/impact/impact_bounds.h"
#include "detect/impact/kernels/pair_lanes.h"

SIMD_INLINE double8 larger_component(double8 most, vec3x8 a) {
    most = double8_max(double8_abs(a.x), most);
    most = double8_max(double8_abs(a.y), most);
    return double8_max(double8_abs(a.z), most);
}

/* True where the cubic of the offset and the directions u, v has coefficients of one sign. */
SIMD_INLINE bool8 cannot_cross(const moving_lanes *offset, const moving_lanes *u,
                               const moving_lanes *v) {
    double8 most = larger_component(double8_fill(0.0), offset->start);
    most = larger_component(larger_component(most, offset->end), u->start);
    most = larger_component(larger_component(most, u->end), v->start);
    most = larger_component(most, v->end);
    vec3x8 const first = vec3x8_cross(u->start, v->start), last = vec3x8_cross(u->end, v->end);
    vec3x8 const middle =
        vec3x8_add(vec3x8_cross(u->end, v->start), vec3x8_cross(u->start, v->end));
    double8 const coefficients[4] = {
        vec3x8_dot(offset->start, first),
        vec3x8_dot(offset->end, first) + vec3x8_dot(offset->start, middle),
        vec3x8_dot(offset->start, last) + vec3x8_dot(offset->end, middle),
        vec3x8_dot(offset->end, last)};
    double8 const error = COPLANARITY_ERROR * most * most * most;
    bool8 positive = double8_greater(coefficients[0], error);
    bool8 negative = double8_greater(-coefficients[0], error);
    for (int k = 1; k < 4; k++) {
        positive = bool8_and(positive, double8_greater(coefficients[k], error));
        negative = bool8_and(negative, double8_greater(-coefficients[k], error));
    }
    bool8 const in_range = bool8_and(double8_greater(most, double8_fill(LEAST_COPLANARITY_SIZE)),
                                     double8_greater(double8_fill(MOST_COPLANARITY_SIZE), most));
    return bool8_and(in_range, bool8_or(positive, negative));
}

/* Lanes that are kept. */
SIMD_INLINE lane_mask keep_lanes(const pair_tables *tables, const slot_pairs *pairs, size_t begin,
                                 size_t lane_count, feature_kind kind, slot_lanes *slots) {
    *slots = load_slots(pairs, begin, lane_count);
    record_lanes at;
    get_records(tables, kind, slots, &at);
    bool const is_vertex_triangle = kind == FEATURE_VERTEX_TRIANGLE;
    moving_lanes const offset =
        load_difference(at.points[0], at.points[is_vertex_triangle ? 1 : 2]);
    moving_lanes const u = is_vertex_triangle ? load_difference(at.points[2], at.points[1])
                                              : load_difference(at.points[1], at.points[0]);
    moving_lanes const v = is_vertex_triangle ? load_difference(at.points[3], at.points[1])
                                              : load_difference(at.points[3], at.points[2]);
    lane_mask gone = bool8_bits(cannot_cross(&offset, &u, &v));
    if (pairs->separations)
        gone &= ~bool8_bits(
            double8_greater(load_separations(pairs, begin, lane_count), double8_fill(0.0)));
    return ~gone & (((lane_mask)1 << lane_count) - 1);
}

SIMD_INLINE size_t filter_kind(const pair_tables *tables, const slot_pairs *pairs,
                               feature_kind kind, uint32_t *kept_first, uint32_t *kept_second,
                               double *kept_separations) {
    size_t kept_count = 0;
    for (size_t begin = 0; begin < pairs->count; begin += DOUBLE_LANES) {
        size_t const rest = pairs->count - begin;
        slot_lanes slots;
        lane_mask kept = keep_lanes(tables, pairs, begin, rest < DOUBLE_LANES ? rest : DOUBLE_LANES,
                                    kind, &slots);
        for (; kept; kept &= kept - 1) {
            int const k = __builtin_ctz(kept);
            if (pairs->separations)
                kept_separations[kept_count] = pairs->separations[begin + (size_t)k];
            kept_first[kept_count] = slots.first[k];
            kept_second[kept_count++] = slots.second[k];
        }
    }
    return kept_count;
}

size_t TULLE_KERNEL(filter_coplanarity)(const pair_tables *tables, const slot_pairs *pairs,
                                        uint32_t *kept_first, uint32_t *kept_second,
                                        double *kept_separations) {
    return pairs->kind == FEATURE_VERTEX_TRIANGLE
               ? filter_kind(tables, pairs, FEATURE_VERTEX_TRIANGLE, kept_first, kept_second,
                             kept_separations)
               : filter_kind(tables, pairs, FEATURE_EDGE_EDGE, kept_first, kept_second,
                             kept_separations);
}
