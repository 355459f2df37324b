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

/* Lanes that are kept, of eight pairs; separations: of each, or null. */
SIMD_INLINE lane_mask keep_lanes(const pair_tables *tables, feature_kind kind,
                                 const uint32_t *first, const uint32_t *second,
                                 const double *separations) {
    moving_lanes d[3];
    load_corner_differences(tables, kind, first, second, d);
    lane_mask gone = bool8_bits(cannot_cross(&d[0], &d[1], &d[2]));
    if (separations)
        gone &= ~bool8_bits(double8_greater(double8_load(separations), double8_fill(0.0)));
    return ~gone & 0xffU;
}

SIMD_INLINE size_t filter_kind(const pair_tables *tables, const slot_pairs *pairs,
                               feature_kind kind, uint32_t *kept_first, uint32_t *kept_second,
                               double *kept_separations) {
    size_t kept_count = 0;
    for (size_t begin = 0; begin < pairs->count; begin += DOUBLE_LANES) {
        size_t const rest = pairs->count - begin;
        const uint32_t *first = pairs->first + begin, *second = pairs->second + begin;
        const double *separations = pairs->separations ? pairs->separations + begin : NULL;
        slot_lanes slots;
        double8 last;
        lane_mask lanes = 0xffU;
        if (rest < DOUBLE_LANES) {
            slots = load_slots(pairs, begin, rest);
            last = load_separations(pairs, begin, rest);
            lanes = ((lane_mask)1 << rest) - 1;
            first = slots.first;
            second = slots.second;
            if (separations) separations = (const double *)&last;
        }
        lane_mask kept = lanes & keep_lanes(tables, kind, first, second, separations);
        for (; kept; kept &= kept - 1) {
            int const k = __builtin_ctz(kept);
            if (separations) kept_separations[kept_count] = separations[k];
            kept_first[kept_count] = first[k];
            kept_second[kept_count++] = second[k];
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
