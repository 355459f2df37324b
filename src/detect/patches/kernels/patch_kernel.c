/* detect/patches/kernels/patch_kernel.c - the two loops that every kept patch runs through at each
 * step, four or eight lanes at a time, with the formulas of planar_path.h in the same order of
 * operations. */
#include "detect/patches/patch_kernel.h"

#include "math/kernel_target.h"

#include <string.h>

#ifdef __AVX512F__
#include <immintrin.h>
#endif

#define PATCH_INLINE static inline __attribute__((always_inline, unused))

enum { LANES = 4 };

typedef double lanes __attribute__((vector_size(32)));
typedef int64_t lane_flags __attribute__((vector_size(32)));

PATCH_INLINE lanes fill(double a) { return (lanes){a, a, a, a}; }
PATCH_INLINE lanes load_lanes(const void *from) {
    lanes a;
    memcpy(&a, from, sizeof a);
    return a;
}
PATCH_INLINE lanes absolute(lanes a) {
    lane_flags const keep = {INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX};
    return (lanes)((lane_flags)a & keep);
}

/* Rows become columns. */
PATCH_INLINE void transpose(lanes row[4]) {
    lanes const a = __builtin_shufflevector(row[0], row[1], 0, 4, 2, 6);
    lanes const b = __builtin_shufflevector(row[0], row[1], 1, 5, 3, 7);
    lanes const c = __builtin_shufflevector(row[2], row[3], 0, 4, 2, 6);
    lanes const d = __builtin_shufflevector(row[2], row[3], 1, 5, 3, 7);
    row[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
    row[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
    row[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    row[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

/* ---- turns ---- */

#ifdef __AVX512F__
enum { TURN_LANES = 8 };
typedef double turn_lanes __attribute__((vector_size(64)));
typedef int64_t turn_bits __attribute__((vector_size(64)));
typedef __mmask8 turn_flags;

/* Points of four triangles, and of four more in the upper halves; columns become rows. */
PATCH_INLINE void load_columns(const planar_path *points, const uint32_t *corners,
                               turn_lanes column[4]) {
    turn_lanes row[4];
    for (size_t i = 0; i < 4; i++) {
        __m256d const low = _mm256_loadu_pd(points[corners[3 * i]].x);
        __m256d const high = _mm256_loadu_pd(points[corners[3 * (i + 4)]].x);
        row[i] = (turn_lanes)_mm512_insertf64x4(_mm512_castpd256_pd512(low), high, 1);
    }
    turn_lanes const a = (turn_lanes)_mm512_unpacklo_pd((__m512d)row[0], (__m512d)row[1]);
    turn_lanes const b = (turn_lanes)_mm512_unpackhi_pd((__m512d)row[0], (__m512d)row[1]);
    turn_lanes const c = (turn_lanes)_mm512_unpacklo_pd((__m512d)row[2], (__m512d)row[3]);
    turn_lanes const d = (turn_lanes)_mm512_unpackhi_pd((__m512d)row[2], (__m512d)row[3]);
    column[0] = __builtin_shufflevector(a, c, 0, 1, 8, 9, 4, 5, 12, 13);
    column[1] = __builtin_shufflevector(b, d, 0, 1, 8, 9, 4, 5, 12, 13);
    column[2] = __builtin_shufflevector(a, c, 2, 3, 10, 11, 6, 7, 14, 15);
    column[3] = __builtin_shufflevector(b, d, 2, 3, 10, 11, 6, 7, 14, 15);
}
PATCH_INLINE turn_flags exceeds(turn_lanes a, turn_lanes b) {
    return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_GT_OQ);
}
PATCH_INLINE bool is_all(turn_flags flags) { return flags == 0xff; }
#else
enum { TURN_LANES = LANES };
typedef lanes turn_lanes;
typedef lane_flags turn_bits;
typedef lane_flags turn_flags;

PATCH_INLINE void load_columns(const planar_path *points, const uint32_t *corners,
                               turn_lanes column[4]) {
    for (size_t i = 0; i < 4; i++) column[i] = load_lanes(&points[corners[3 * i]]);
    transpose(column);
}
PATCH_INLINE turn_flags exceeds(turn_lanes a, turn_lanes b) { return a > b; }
PATCH_INLINE bool is_all(turn_flags flags) {
    return (flags[0] & flags[1] & flags[2] & flags[3]) != 0;
}
#endif

/* x[0], x[1], y[0], y[1] of corner `which` of triangles, one a lane. */
typedef struct corner_lanes {
    turn_lanes x[2], y[2];
} corner_lanes;

PATCH_INLINE corner_lanes load_corners(const planar_path *points, const uint32_t *corners,
                                       size_t which) {
    turn_lanes column[4];
    load_columns(points, corners + which, column);
    return (corner_lanes){{column[0], column[1]}, {column[2], column[3]}};
}

PATCH_INLINE turn_lanes turn_absolute(turn_lanes a) {
    return (turn_lanes)((turn_bits)a & INT64_MAX);
}

PATCH_INLINE turn_lanes bound_lengths(turn_lanes x, turn_lanes y) {
    turn_lanes const a = turn_absolute(x), b = turn_absolute(y);
    return (a + b) * LENGTH_OF_SUM + turn_absolute(a - b) * LENGTH_OF_DIFFERENCE;
}

/* Whether all of TURN_LANES turns are proven to be to the left. */
PATCH_INLINE bool turn_left(const planar_path *points, const uint32_t *corners, double reach) {
    corner_lanes const a = load_corners(points, corners, 0);
    corner_lanes const b = load_corners(points, corners, 1);
    corner_lanes const c = load_corners(points, corners, 2);
    turn_lanes ux[2], uy[2], vx[2], vy[2], bound[2];
    double const second = DISC_TRIANGLE * reach * reach;
    for (int k = 0; k < 2; k++) {
        ux[k] = b.x[k] - a.x[k], uy[k] = b.y[k] - a.y[k];
        vx[k] = c.x[k] - a.x[k], vy[k] = c.y[k] - a.y[k];
        bound[k] = bound_lengths(ux[k], uy[k]) + bound_lengths(vx[k], vy[k]) +
                   bound_lengths(vx[k] - ux[k], vy[k] - uy[k]);
    }
    turn_lanes const mixed =
        0.5 * ((ux[0] * vy[1] - uy[0] * vx[1]) + (ux[1] * vy[0] - uy[1] * vx[0]));
    turn_flags const first = exceeds(ux[0] * vy[0] - uy[0] * vx[0], reach * bound[0] + second);
    turn_flags const middle = exceeds(mixed, reach * (0.5 * (bound[0] + bound[1])) + second);
    turn_flags const last = exceeds(ux[1] * vy[1] - uy[1] * vx[1], reach * bound[1] + second);
    return is_all((turn_flags)(first & middle & last));
}

bool TULLE_KERNEL(patch_turns_left)(const planar_path *points, const uint32_t *corners,
                                    size_t count, double reach) {
    bool is_left = true;
    size_t i = 0;
    for (; i + TURN_LANES <= count && is_left; i += TURN_LANES)
        is_left = turn_left(points, corners + 3 * i, reach);
    for (; i < count && is_left; i++) {
        const uint32_t *const corner = corners + 3 * i;
        is_left = compute_turn_sign(&points[corner[0]], &points[corner[1]], &points[corner[2]],
                                    reach) == 1;
    }
    return is_left;
}

/* ---- projection ---- */

typedef struct vec3_lanes {
    lanes x, y, z;
} vec3_lanes;

PATCH_INLINE vec3_lanes load_places(const double *places, const uint32_t *vertices, vec3 origin) {
    const double *const a = places + 3 * (size_t)vertices[0];
    const double *const b = places + 3 * (size_t)vertices[1];
    const double *const c = places + 3 * (size_t)vertices[2];
    const double *const d = places + 3 * (size_t)vertices[3];
    return (vec3_lanes){(lanes){a[0], b[0], c[0], d[0]} - origin.x,
                        (lanes){a[1], b[1], c[1], d[1]} - origin.y,
                        (lanes){a[2], b[2], c[2], d[2]} - origin.z};
}

PATCH_INLINE lanes dot_lanes(vec3 a, vec3_lanes b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

PATCH_INLINE lanes sum_of_absolutes(vec3_lanes a) {
    return (absolute(a.x) + absolute(a.y)) + absolute(a.z);
}

double TULLE_KERNEL(project_paths)(const planar_map *map, const uint32_t *vertices, size_t count,
                                   const double *x0, const double *x1, planar_path *points) {
    lanes largest = fill(0.0), total = fill(0.0);
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) {
        vec3_lanes const start = load_places(x0, vertices + i, map->origin);
        vec3_lanes const end = load_places(x1, vertices + i, map->origin);
        lanes row[4] = {dot_lanes(map->across, start), dot_lanes(map->across, end),
                        dot_lanes(map->along, start), dot_lanes(map->along, end)};
        transpose(row);
        memcpy(&points[i], row, sizeof row);
        lanes const own = sum_of_absolutes(start) + sum_of_absolutes(end);
        total += own; /* NaN and infinity stay in it */
        lane_flags const is_larger = own > largest;
        largest = (lanes)(((lane_flags)own & is_larger) | ((lane_flags)largest & ~is_larger));
    }
    double size = 0.0;
    for (int k = 0; k < LANES; k++) {
        if (!(fabs(total[k]) < HUGE_VAL)) size = HUGE_VAL;
        if (largest[k] > size) size = largest[k];
    }
    for (; i < count; i++) {
        points[i] =
            project_path(map, vec3_load(x0, vertices[i]), vec3_load(x1, vertices[i]), &size);
    }
    return size;
}
