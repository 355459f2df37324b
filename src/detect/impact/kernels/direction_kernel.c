/* detect/impact/kernels/direction_kernel.c - leaves out pairs that an axis or a diagonal of the
 * cube keeps apart at both ends of the step: gaps along a fixed direction are linear in time. It is
 * the first test of every candidate, so it takes float points, half a line of the cache each.
 *
 * Gaps between corners are c + {0, u} - {0, v} for two edges and c - {0, u, v} for a vertex and a
 * triangle, where c is the offset of the first corners and u, v are edges from there. */
#include "detect/impact/impact_pool.h"

#include <string.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#define POINT_INLINE static inline __attribute__((always_inline))
#define POINT_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)

enum { ROWS = 8 };

#ifdef __AVX512F__
enum { POINT_LANES = 16 };
typedef float point_vector __attribute__((vector_size(64)));

POINT_INLINE point_vector lesser(point_vector a, point_vector b) {
    return (point_vector)_mm512_min_ps((__m512)a, (__m512)b);
}
POINT_INLINE point_vector greater(point_vector a, point_vector b) {
    return (point_vector)_mm512_max_ps((__m512)a, (__m512)b);
}
/* Bit l: lane l is above the limit. */
POINT_INLINE uint32_t find_above(point_vector a, float limit) {
    return _mm512_cmp_ps_mask((__m512)a, _mm512_set1_ps(limit), _CMP_GT_OQ);
}
/* Row r holds the points of two pairs: r and r + 4, or from 4 on r + 4 and r + 8. */
POINT_INLINE int get_pair(int row) { return row < ROWS / 2 ? row : row + ROWS / 2; }
POINT_INLINE int get_other(int row) { return get_pair(row) + ROWS / 2; }
POINT_INLINE point_vector load_row(const vertex_point *pair, const vertex_point *other) {
    __m512 const low = _mm512_castps256_ps512(_mm256_loadu_ps(pair->start));
    return (point_vector)_mm512_insertf32x8(low, _mm256_loadu_ps(other->start), 1);
}
#define INTERLEAVE_LOW(a, b)                                                                       \
    POINT_SHUFFLE(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29)
#define INTERLEAVE_HIGH(a, b)                                                                      \
    POINT_SHUFFLE(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31)
#define JOIN_LOW(a, b) POINT_SHUFFLE(a, b, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29)
#define JOIN_HIGH(a, b)                                                                            \
    POINT_SHUFFLE(a, b, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31)
#define JOIN_STARTS(a, b)                                                                          \
    POINT_SHUFFLE(a, b, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27)
#define JOIN_ENDS(a, b)                                                                            \
    POINT_SHUFFLE(a, b, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31)
/* Copies the numbers in `which` side by side, and whatever after them. */
POINT_INLINE void pack_lanes(const uint32_t *from, uint32_t which, uint32_t *to) {
    _mm512_storeu_si512(to,
                        _mm512_maskz_compress_epi32((__mmask16)which, _mm512_loadu_si512(from)));
}
#else
enum { POINT_LANES = 8 };
typedef float point_vector __attribute__((vector_size(32)));

#ifdef __AVX2__
POINT_INLINE point_vector lesser(point_vector a, point_vector b) {
    return (point_vector)_mm256_min_ps((__m256)a, (__m256)b);
}
POINT_INLINE point_vector greater(point_vector a, point_vector b) {
    return (point_vector)_mm256_max_ps((__m256)a, (__m256)b);
}
POINT_INLINE uint32_t find_above(point_vector a, float limit) {
    __m256 const above = _mm256_cmp_ps((__m256)a, _mm256_set1_ps(limit), _CMP_GT_OQ);
    return (uint32_t)_mm256_movemask_ps(above);
}
#else
typedef int32_t lane_choice __attribute__((vector_size(32)));
POINT_INLINE point_vector choose(lane_choice mask, point_vector yes, point_vector no) {
    return (point_vector)((mask & (lane_choice)yes) | (~mask & (lane_choice)no));
}
POINT_INLINE point_vector lesser(point_vector a, point_vector b) { return choose(a < b, a, b); }
POINT_INLINE point_vector greater(point_vector a, point_vector b) { return choose(a > b, a, b); }
POINT_INLINE uint32_t find_above(point_vector a, float limit) {
    uint32_t bits = 0;
    for (uint32_t l = 0; l < POINT_LANES; l++) bits |= (uint32_t)(a[l] > limit) << l;
    return bits;
}
#endif
/* Row r holds the points of pair r. */
POINT_INLINE int get_pair(int row) { return row; }
POINT_INLINE int get_other(int row) { return row; }
POINT_INLINE point_vector load_row(const vertex_point *pair, const vertex_point *other) {
    (void)other;
    point_vector both;
    memcpy(&both, pair->start, sizeof both);
    return both;
}
#define INTERLEAVE_LOW(a, b) POINT_SHUFFLE(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define INTERLEAVE_HIGH(a, b) POINT_SHUFFLE(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define JOIN_LOW(a, b) POINT_SHUFFLE(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define JOIN_HIGH(a, b) POINT_SHUFFLE(a, b, 2, 3, 10, 11, 6, 7, 14, 15)
#define JOIN_STARTS(a, b) POINT_SHUFFLE(a, b, 0, 1, 2, 3, 8, 9, 10, 11)
#define JOIN_ENDS(a, b) POINT_SHUFFLE(a, b, 4, 5, 6, 7, 12, 13, 14, 15)
POINT_INLINE void pack_lanes(const uint32_t *from, uint32_t which, uint32_t *to) {
    for (; which; which &= which - 1) *to++ = from[__builtin_ctz(which)];
}
#endif

typedef struct point_lanes {
    point_vector x, y, z;
} point_lanes;

/* A difference of points, at the start and at the end. */
typedef struct moving_points {
    point_lanes at[2];
} moving_points;

/* Rows x0 y0 z0 - x1 y1 z1 - of pairs become vectors over the pairs. */
POINT_INLINE moving_points transpose_rows(const point_vector rows[ROWS]) {
    point_lanes halves[2];
    for (int h = 0; h < 2; h++) {
        const point_vector *const own = rows + h * ROWS / 2;
        point_vector const xy0 = INTERLEAVE_LOW(own[0], own[1]);
        point_vector const xy1 = INTERLEAVE_LOW(own[2], own[3]);
        point_vector const z0 = INTERLEAVE_HIGH(own[0], own[1]);
        point_vector const z1 = INTERLEAVE_HIGH(own[2], own[3]);
        halves[h] = (point_lanes){JOIN_LOW(xy0, xy1), JOIN_HIGH(xy0, xy1), JOIN_LOW(z0, z1)};
    }
    moving_points to;
    to.at[0] =
        (point_lanes){JOIN_STARTS(halves[0].x, halves[1].x), JOIN_STARTS(halves[0].y, halves[1].y),
                      JOIN_STARTS(halves[0].z, halves[1].z)};
    to.at[1] =
        (point_lanes){JOIN_ENDS(halves[0].x, halves[1].x), JOIN_ENDS(halves[0].y, halves[1].y),
                      JOIN_ENDS(halves[0].z, halves[1].z)};
    return to;
}

/* The first corners of the features of a pair, then the others. */
typedef struct pair_points {
    const vertex_point *a0, *b0, *u, *v;
} pair_points;

POINT_INLINE pair_points find_points(const pair_tables *tables, feature_kind kind, uint32_t first,
                                     uint32_t second) {
    const vertex_point *const points = tables->points;
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        const uint32_t *const b = tables->triangle_corners + 3 * (size_t)second;
        return (pair_points){points + tables->vertex_corners[first], points + b[0], points + b[1],
                             points + b[2]};
    }
    const uint32_t *const a = tables->edge_corners + 2 * (size_t)first;
    const uint32_t *const b = tables->edge_corners + 2 * (size_t)second;
    return (pair_points){points + a[0], points + b[0], points + a[1], points + b[1]};
}

/* c, u and v of pairs. Each point is read once. */
POINT_INLINE void load_differences(const pair_tables *tables, feature_kind kind,
                                   const uint32_t *first, const uint32_t *second,
                                   moving_points to[3]) {
    point_vector rows[3][ROWS];
#pragma GCC unroll 8
    for (int r = 0; r < ROWS; r++) {
        int const k = get_pair(r), l = get_other(r);
        pair_points const p = find_points(tables, kind, first[k], second[k]);
        pair_points const q = find_points(tables, kind, first[l], second[l]);
        point_vector const a0 = load_row(p.a0, q.a0), b0 = load_row(p.b0, q.b0);
        rows[0][r] = a0 - b0;
        rows[1][r] = load_row(p.u, q.u) - (kind == FEATURE_VERTEX_TRIANGLE ? b0 : a0);
        rows[2][r] = load_row(p.v, q.v) - b0;
    }
    for (int i = 0; i < 3; i++) to[i] = transpose_rows(rows[i]);
}

/* The least and the largest gap along a direction, from the differences along it. */
typedef struct gap_range {
    point_vector low, high;
} gap_range;

POINT_INLINE gap_range bound_gaps(feature_kind kind, point_vector c, point_vector u,
                                  point_vector v) {
    point_vector const zero = {0.0F};
    if (kind == FEATURE_EDGE_EDGE) /* the same whichever edge comes first */
        return (gap_range){c + (lesser(u, zero) - greater(v, zero)),
                           c + (greater(u, zero) - lesser(v, zero))};
    return (gap_range){c - greater(greater(u, v), zero), c - lesser(lesser(u, v), zero)};
}

/* Three axes and four diagonals. */
enum { DIRECTIONS = 7 };

POINT_INLINE void project(const point_lanes *d, point_vector along[DIRECTIONS]) {
    point_vector const sum = d->x + d->y, difference = d->x - d->y;
    along[0] = d->x;
    along[1] = d->y;
    along[2] = d->z;
    along[3] = sum + d->z;
    along[4] = sum - d->z;
    along[5] = difference + d->z;
    along[6] = difference - d->z;
}

/* Lanes of pairs that no direction keeps farther apart than the limit at both ends. */
POINT_INLINE uint32_t find_near(feature_kind kind, const pair_tables *tables, const uint32_t *first,
                                const uint32_t *second, float limit) {
    moving_points d[3];
    load_differences(tables, kind, first, second, d);
    gap_range gaps[2][DIRECTIONS];
    for (int end = 0; end < 2; end++) {
        point_vector c[DIRECTIONS], u[DIRECTIONS], v[DIRECTIONS];
        project(&d[0].at[end], c);
        project(&d[1].at[end], u);
        project(&d[2].at[end], v);
        for (int k = 0; k < DIRECTIONS; k++) gaps[end][k] = bound_gaps(kind, c[k], u[k], v[k]);
    }
    point_vector widest = lesser(gaps[0][0].low, gaps[1][0].low);
    point_vector least = greater(gaps[0][0].high, gaps[1][0].high);
    for (int k = 1; k < DIRECTIONS; k++) {
        widest = greater(widest, lesser(gaps[0][k].low, gaps[1][k].low));
        least = lesser(least, greater(gaps[0][k].high, gaps[1][k].high));
    }
    return ~find_above(greater(widest, -least), limit) & ((1U << POINT_LANES) - 1);
}

/* One function for each kind, without the caller's variables in their registers. */
static __attribute__((noinline)) uint32_t find_near_faces(const pair_tables *tables,
                                                          const uint32_t *first,
                                                          const uint32_t *second, float limit) {
    return find_near(FEATURE_VERTEX_TRIANGLE, tables, first, second, limit);
}
static __attribute__((noinline)) uint32_t find_near_edges(const pair_tables *tables,
                                                          const uint32_t *first,
                                                          const uint32_t *second, float limit) {
    return find_near(FEATURE_EDGE_EDGE, tables, first, second, limit);
}

size_t TULLE_KERNEL(filter_directions)(const pair_tables *tables, const slot_pairs *pairs,
                                       float limit, uint32_t *kept_first, uint32_t *kept_second) {
    size_t kept_count = 0;
    for (size_t begin = 0; begin < pairs->count; begin += POINT_LANES) {
        size_t const rest = pairs->count - begin;
        const uint32_t *first = pairs->first + begin, *second = pairs->second + begin;
        uint32_t last_first[POINT_LANES], last_second[POINT_LANES];
        uint32_t lanes = (1U << POINT_LANES) - 1;
        if (rest < POINT_LANES) { /* lanes beyond repeat the last pair */
            for (size_t k = 0; k < POINT_LANES; k++) {
                last_first[k] = first[k < rest ? k : rest - 1];
                last_second[k] = second[k < rest ? k : rest - 1];
            }
            first = last_first;
            second = last_second;
            lanes = (1U << rest) - 1;
        }
        lanes &= pairs->kind == FEATURE_VERTEX_TRIANGLE
                     ? find_near_faces(tables, first, second, limit)
                     : find_near_edges(tables, first, second, limit);
        pack_lanes(first, lanes, kept_first + kept_count);
        pack_lanes(second, lanes, kept_second + kept_count);
        kept_count += (size_t)__builtin_popcount(lanes);
    }
    return kept_count;
}
