/* detect/impact/kernels/impact_kernel.c - fixed directions and conservative advancement for eight
 * pairs at a time, by the same arithmetic as prove_apart and time_of_impact.
 *
 * begin_impacts takes fresh pairs through the axes and the first round of advancement, which
 * includes the direction at the start. A pair for which some gap closes goes to the pool. In
 * advance_impacts every lane holds a pair of its own and takes the next one when that is done. A
 * pair first tries its direction at the end of the step there, as a round of another kind. */
#include "detect/impact/impact_bounds.h"
#include "detect/impact/kernels/closest_lanes.h"
#include "detect/impact/kernels/pair_lanes.h"

typedef struct impact_lanes {
    vec3x8 start[4], end[4]; /* corner differences */
    double8 time, tolerance, separation, round, first, second;
} impact_lanes;

typedef struct closing_lanes {
    bool8 is_apart;   /* at `time` */
    bool8 throughout; /* for all t */
    double8 closing;  /* where is_apart: safe from `time` up to here; > 1: to the end */
} closing_lanes;

SIMD_INLINE int count_corners(feature_kind kind) { return kind == FEATURE_VERTEX_TRIANGLE ? 3 : 4; }

/* bound_gap */
SIMD_INLINE double8 bound_gaps(vec3x8 w, vec3x8 d, double8 separation) {
    double8 const px = w.x * d.x, py = w.y * d.y, pz = w.z * d.z;
    double8 const error =
        DOT_ERROR * (double8_abs(px) + double8_abs(py) + double8_abs(pz)) + UNDERFLOW_ERROR;
    double8 const gap = (px + py + pz - error) - separation;
    return gap - CLOSING_ERROR * double8_abs(gap);
}

/* compute_closing */
SIMD_INLINE closing_lanes compute_closings(const impact_lanes *lanes, vec3x8 w, feature_kind kind) {
    double8 const zero = double8_fill(0.0);
    closing_lanes found = {bool8_from_bits(0xff), bool8_from_bits(0xff), double8_fill(2.0)};
    for (int k = 0; k < count_corners(kind); k++) {
        double8 const gap0 = bound_gaps(w, lanes->start[k], lanes->separation);
        double8 const gap1 = bound_gaps(w, lanes->end[k], lanes->separation);
        bool8 const open0 = double8_greater(gap0, zero), open1 = double8_greater(gap1, zero);
        bool8 const both = bool8_and(open0, open1);
        bool8 const closes = bool8_and(open0, bool8_not(open1));
        bool8 const opens = bool8_and(open1, bool8_not(open0));
        double8 const at = gap0 / (gap0 - gap1) *
                           double8_select(open0, double8_fill(1.0 - CLOSING_ERROR),
                                          double8_fill(1.0 + CLOSING_ERROR));
        bool8 const is_before = bool8_and(closes, double8_greater(at, lanes->time));
        bool8 const is_after = bool8_and(opens, double8_greater(lanes->time, at));
        found.is_apart = bool8_and(found.is_apart, bool8_or(both, bool8_or(is_before, is_after)));
        found.throughout = bool8_and(found.throughout, both);
        found.closing = double8_select(closes, double8_min(at, found.closing), found.closing);
    }
    return found;
}

/* make_direction from the squared length and its root */
SIMD_INLINE vec3x8 make_directions(vec3x8 a, double8 norm2, double8 norm) {
    vec3x8 const zero = {double8_fill(0.0), double8_fill(0.0), double8_fill(0.0)};
    return vec3x8_select(double8_greater(norm2, double8_fill(LEAST_NORM2)),
                         vec3x8_scale(a, 1.0 / norm), zero);
}

SIMD_INLINE void place_corners(const impact_lanes *lanes, double8 time, feature_kind kind,
                               vec3x8 at[4]) {
    for (int k = 0; k < count_corners(kind); k++)
        at[k] =
            vec3x8_add_scaled(lanes->start[k], vec3x8_sub(lanes->end[k], lanes->start[k]), time);
}

/* the tolerance of time_of_impact */
SIMD_INLINE double8 compute_tolerances(double8 excess, double8 separation) {
    double8 const part =
        double8_select(double8_greater(separation, double8_fill(0.0)),
                       double8_fill(HIT_PART_OF_START), double8_fill(HIT_PART_OF_START_TOUCHING));
    double8 const least = double8_max(HIT_PART_OF_SEPARATION * separation, part * excess);
    return double8_min(least, HIT_PART_OF_START_MOST * excess);
}

/* The axes of prove_apart; *in_range: finite, not to be scaled. */
SIMD_INLINE bool8 test_axes(const impact_lanes *lanes, feature_kind kind, bool8 *in_range) {
    vec3x8 least = lanes->start[0], most = lanes->start[0];
    double8 sum = double8_fill(0.0);
    for (int k = 0; k < 2 * count_corners(kind); k++) {
        vec3x8 const d =
            k < count_corners(kind) ? lanes->start[k] : lanes->end[k - count_corners(kind)];
        sum = sum + d.x + d.y + d.z; /* NaN if one is */
        least = (vec3x8){double8_min(d.x, least.x), double8_min(d.y, least.y),
                         double8_min(d.z, least.z)};
        most =
            (vec3x8){double8_max(d.x, most.x), double8_max(d.y, most.y), double8_max(d.z, most.z)};
    }
    double8 const high = double8_max(most.x, double8_max(most.y, most.z));
    double8 const low = -double8_min(least.x, double8_min(least.y, least.z));
    double8 const size = double8_max(high, low);
    *in_range = bool8_and(bool8_and(double8_greater(size, double8_fill(LEAST_UNSCALED)),
                                    double8_greater(double8_fill(MOST_UNSCALED), size)),
                          double8_equal(sum, sum));
    double8 const inner = double8_max(double8_max(least.x, least.y), least.z);
    double8 const outer = double8_min(double8_min(most.x, most.y), most.z);
    return bool8_or(double8_greater(inner, lanes->separation),
                    double8_greater(-lanes->separation, outer));
}

SIMD_INLINE void load_corners(const record_lanes *records, feature_kind kind, impact_lanes *to) {
    for (int k = 0; k < count_corners(kind); k++) {
        bool const is_vertex_triangle = kind == FEATURE_VERTEX_TRIANGLE;
        moving_lanes const d =
            load_difference(records->points[is_vertex_triangle ? 0 : k / 2],
                            records->points[is_vertex_triangle ? 1 + k : 2 + k % 2]);
        to->start[k] = d.start;
        to->end[k] = d.end;
    }
}

/* Round 0: the state after it, and who is shown apart. */
SIMD_INLINE bool8 begin_lanes(impact_lanes *lanes, feature_kind kind) {
    double8 const zero = double8_fill(0.0);
    closest_lanes const closest = compute_closest(kind, lanes->start);
    double8 const norm2 = vec3x8_dot(closest.difference, closest.difference);
    double8 const distance = double8_sqrt(norm2);
    lanes->tolerance = compute_tolerances(distance - lanes->separation, lanes->separation);
    lanes->time = zero;
    closing_lanes const found =
        compute_closings(lanes, make_directions(closest.difference, norm2, distance), kind);
    lanes->time = double8_select(found.is_apart, ADVANCE_FACTOR * found.closing, zero);
    lanes->round = double8_select(found.is_apart, double8_fill(-2.0), double8_fill(-1.0));
    return found.throughout;
}

/* Calls ACTION(row of the pool, vector of the lanes) for each number of a pair. */
#define FOR_EACH_ROW(ACTION, pool, lanes)                                                          \
    do {                                                                                           \
        for (int k = 0; k < count_corners(kind); k++) {                                            \
            ACTION((pool)->rows[ROW_START + 3 * k], (lanes)->start[k].x);                          \
            ACTION((pool)->rows[ROW_START + 3 * k + 1], (lanes)->start[k].y);                      \
            ACTION((pool)->rows[ROW_START + 3 * k + 2], (lanes)->start[k].z);                      \
            ACTION((pool)->rows[ROW_END + 3 * k], (lanes)->end[k].x);                              \
            ACTION((pool)->rows[ROW_END + 3 * k + 1], (lanes)->end[k].y);                          \
            ACTION((pool)->rows[ROW_END + 3 * k + 2], (lanes)->end[k].z);                          \
        }                                                                                          \
        ACTION((pool)->rows[ROW_TIME], (lanes)->time);                                             \
        ACTION((pool)->rows[ROW_TOLERANCE], (lanes)->tolerance);                                   \
        ACTION((pool)->rows[ROW_SEPARATION], (lanes)->separation);                                 \
        ACTION((pool)->rows[ROW_ROUND], (lanes)->round);                                           \
        ACTION((pool)->rows[ROW_FIRST], (lanes)->first);                                           \
        ACTION((pool)->rows[ROW_SECOND], (lanes)->second);                                         \
    } while (0)

/* Appends the lanes in `which`. */
SIMD_INLINE void push_lanes(impact_pool *pool, const impact_lanes *lanes, lane_mask which,
                            feature_kind kind) {
#define PUSH(row, vector) double8_store_packed((row) + pool->count, which, vector)
    FOR_EACH_ROW(PUSH, pool, lanes);
#undef PUSH
    pool->count += (size_t)__builtin_popcount(which);
}

/* The lanes in `which` take the pairs of the pool from index `from`. */
SIMD_INLINE void take_lanes(const impact_pool *pool, size_t from, lane_mask which,
                            feature_kind kind, impact_lanes *lanes) {
#define TAKE(row, vector) (vector) = double8_load_spread((row) + from, which, vector)
    FOR_EACH_ROW(TAKE, pool, lanes);
#undef TAKE
}

SIMD_INLINE double8 fill_slots(const uint32_t slots[DOUBLE_LANES]) {
    double values[DOUBLE_LANES];
    for (int k = 0; k < DOUBLE_LANES; k++) values[k] = (double)slots[k];
    return double8_load(values);
}

SIMD_INLINE size_t begin_kind(const pair_tables *tables, const slot_pairs *pairs, feature_kind kind,
                              impact_pool *pool, uint32_t *odd) {
    size_t odd_count = 0;
    for (size_t begin = 0; begin < pairs->count; begin += DOUBLE_LANES) {
        size_t const rest = pairs->count - begin;
        size_t const lane_count = rest < DOUBLE_LANES ? rest : DOUBLE_LANES;
        slot_lanes const slots = load_slots(pairs, begin, lane_count);
        record_lanes records;
        get_records(tables, kind, &slots, &records);
        impact_lanes lanes;
        load_corners(&records, kind, &lanes);
        double8 const separation = load_separations(pairs, begin, lane_count);
        lanes.separation =
            double8_select(double8_greater(separation, double8_fill(0.0)),
                           separation * SEPARATION_FACTOR + UNDERFLOW_ERROR, separation);
        lanes.first = fill_slots(slots.first);
        lanes.second = fill_slots(slots.second);
        bool8 in_range;
        bool8 const along_axis = test_axes(&lanes, kind, &in_range);
        lane_mask const all = ((lane_mask)1 << lane_count) - 1;
        lane_mask out_of_range = all & ~bool8_bits(in_range);
        lane_mask kept = all & bool8_bits(in_range) & ~bool8_bits(along_axis);
        if (kept) kept &= ~bool8_bits(begin_lanes(&lanes, kind));
        if (kept) push_lanes(pool, &lanes, kept, kind);
        for (; out_of_range; out_of_range &= out_of_range - 1)
            odd[odd_count++] = (uint32_t)begin + (uint32_t)__builtin_ctz(out_of_range);
    }
    return odd_count;
}

size_t TULLE_KERNEL(begin_impacts)(const pair_tables *tables, const slot_pairs *pairs,
                                   impact_pool *pool, uint32_t *odd) {
    return pairs->kind == FEATURE_VERTEX_TRIANGLE
               ? begin_kind(tables, pairs, FEATURE_VERTEX_TRIANGLE, pool, odd)
               : begin_kind(tables, pairs, FEATURE_EDGE_EDGE, pool, odd);
}

/* Where the closest direction fails: the common normal, either way. */
static void try_normals(const impact_lanes *lanes, vec3x8 normal, feature_kind kind,
                        closing_lanes *found) {
    double8 const norm2 = vec3x8_dot(normal, normal);
    vec3x8 const direction = make_directions(normal, norm2, double8_sqrt(norm2));
    for (int way = 0; way < 2; way++) {
        closing_lanes const other =
            compute_closings(lanes, way == 0 ? direction : vec3x8_neg(direction), kind);
        found->closing = double8_select(found->is_apart, found->closing, other.closing);
        found->is_apart = bool8_or(found->is_apart, other.is_apart);
    }
}

/* What a round of advancement found out. */
typedef struct round_end {
    lane_mask apart, hit, touching, unresolved; /* pairs that are done; time is their bound */
    lane_mask filtered;                         /* of `apart`, by the direction at the end */
} round_end;

SIMD_INLINE round_end advance_lanes(impact_lanes *lanes, lane_mask active, feature_kind kind) {
    double8 const zero = double8_fill(0.0), one = double8_fill(1.0);
    bool8 const at_end = double8_greater(zero, lanes->round);
    vec3x8 at[4];
    place_corners(lanes, double8_select(at_end, one, lanes->time), kind, at);
    closest_lanes const closest = compute_closest(kind, at);
    double8 const norm2 = vec3x8_dot(closest.difference, closest.difference);
    double8 const distance = double8_sqrt(norm2);
    closing_lanes found =
        compute_closings(lanes, make_directions(closest.difference, norm2, distance), kind);
    bool8 const is_near =
        bool8_not(double8_greater(distance - lanes->separation, lanes->tolerance));
    bool8 const has_moved = double8_greater(lanes->round, zero);
    bool8 const is_over = bool8_or(at_end, bool8_and(has_moved, is_near));
    if (active & ~bool8_bits(bool8_or(is_over, found.is_apart)))
        try_normals(lanes, vec3x8_cross(closest.u, closest.v), kind, &found);
    round_end end = {.hit = bool8_bits(bool8_and(has_moved, is_near))};
    end.unresolved = bool8_bits(double8_equal(lanes->round, double8_fill(MAX_ADVANCES))) & ~end.hit;
    lane_mask const ended = end.hit | end.unresolved | bool8_bits(at_end);
    lane_mask const blocked = ~bool8_bits(found.is_apart) & 0xff & ~ended;
    end.hit |= blocked & bool8_bits(has_moved);
    end.touching = blocked & ~bool8_bits(has_moved);
    end.filtered = bool8_bits(bool8_and(at_end, found.throughout));
    end.apart = end.filtered |
                (bool8_bits(double8_greater(found.closing, one)) & ~(ended | blocked) & 0xff);
    lane_mask const moves = ~(ended | blocked | end.apart) & 0xff;
    double8 const next = lanes->time + ADVANCE_FACTOR * (found.closing - lanes->time);
    end.hit |= moves & ~bool8_bits(double8_greater(next, lanes->time));
    lanes->time = double8_select(bool8_from_bits(moves), next, lanes->time);
    lanes->round = double8_select(at_end, -1.0 - lanes->round, lanes->round + 1.0);
    return end;
}

/* Writes the pairs in `which`; returns how many. */
SIMD_INLINE size_t write_results(const impact_lanes *lanes, const round_end *end, lane_mask which,
                                 impact_result *results) {
    size_t count = 0;
    for (; which; which &= which - 1) {
        int const k = __builtin_ctz(which);
        toi_state const state = end->hit >> k & 1        ? TOI_HIT
                                : end->touching >> k & 1 ? TOI_TOUCHING_AT_START
                                                         : TOI_UNRESOLVED;
        results[count++] = (impact_result){(uint32_t)lanes->first[k], (uint32_t)lanes->second[k],
                                           lanes->time[k], state};
    }
    return count;
}

SIMD_INLINE size_t advance_kind(impact_pool *pool, feature_kind kind, bool is_last, double *latest,
                                bool lowers_latest, impact_result *results) {
    impact_lanes lanes;
    memset(&lanes, 0, sizeof lanes);
    size_t from = 0, result_count = 0;
    lane_mask active = 0;
    for (;;) {
        size_t const rest = pool->count - from;
        if (active != 0xff && rest > 0) {
            lane_mask empty = ~active & 0xff;
            while ((size_t)__builtin_popcount(empty) > rest) empty &= empty - 1;
            take_lanes(pool, from, empty, kind, &lanes);
            from += (size_t)__builtin_popcount(empty);
            active |= empty;
        } else if (!active || (active != 0xff && !is_last)) {
            break;
        }
        round_end const end = advance_lanes(&lanes, active, kind);
        lane_mask const found = active & (end.hit | end.touching | end.unresolved);
        size_t const found_count = write_results(&lanes, &end, found, results + result_count);
        pool->filtered_count += (size_t)__builtin_popcount(active & end.filtered);
        for (size_t k = 0; lowers_latest && k < found_count; k++)
            *latest = fmin(*latest, results[result_count + k].time);
        result_count += found_count;
        active &= ~(found | end.apart);
        active &= ~bool8_bits(double8_greater(lanes.time, double8_fill(*latest)));
    }
    pool->count = 0;
    if (active) push_lanes(pool, &lanes, active, kind);
    return result_count;
}

size_t TULLE_KERNEL(advance_impacts)(impact_pool *pool, feature_kind kind, bool is_last,
                                     bool lowers_latest, double *latest, impact_result *results) {
    return kind == FEATURE_VERTEX_TRIANGLE
               ? advance_kind(pool, FEATURE_VERTEX_TRIANGLE, is_last, latest, lowers_latest,
                              results)
               : advance_kind(pool, FEATURE_EDGE_EDGE, is_last, latest, lowers_latest, results);
}
