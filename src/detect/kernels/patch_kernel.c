/* detect/kernels/patch_kernel.c - the two loops that every kept patch runs through at each step,
 * four lanes at a time, with the formulas of planar_path.h in the same order of operations. */
#include "detect/patch_kernel.h"

#include "math/kernel_target.h"

#include <string.h>

#define PATCH_INLINE static inline __attribute__((always_inline))

enum { LANES = 4 };

typedef double lanes __attribute__((vector_size(32)));
typedef int64_t lane_flags __attribute__((vector_size(32)));

PATCH_INLINE lanes fill(double a) { return (lanes){a, a, a, a}; }
PATCH_INLINE lanes load(const void *from) {
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
    lanes const a = __builtin_shuffle(row[0], row[1], (lane_flags){0, 4, 2, 6});
    lanes const b = __builtin_shuffle(row[0], row[1], (lane_flags){1, 5, 3, 7});
    lanes const c = __builtin_shuffle(row[2], row[3], (lane_flags){0, 4, 2, 6});
    lanes const d = __builtin_shuffle(row[2], row[3], (lane_flags){1, 5, 3, 7});
    row[0] = __builtin_shuffle(a, c, (lane_flags){0, 1, 4, 5});
    row[1] = __builtin_shuffle(b, d, (lane_flags){0, 1, 4, 5});
    row[2] = __builtin_shuffle(a, c, (lane_flags){2, 3, 6, 7});
    row[3] = __builtin_shuffle(b, d, (lane_flags){2, 3, 6, 7});
}

/* ---- turns ---- */

/* x[0], x[1], y[0], y[1] of corner `which` of four triangles, one a lane. */
typedef struct corner_lanes {
    lanes x[2], y[2];
} corner_lanes;

PATCH_INLINE corner_lanes load_corners(const planar_path *points, const uint32_t *corners,
                                       size_t which) {
    lanes row[4];
    for (size_t i = 0; i < LANES; i++) row[i] = load(&points[corners[3 * i + which]]);
    transpose(row);
    return (corner_lanes){{row[0], row[1]}, {row[2], row[3]}};
}

PATCH_INLINE lanes bound_lengths(lanes x, lanes y) {
    lanes const a = absolute(x), b = absolute(y);
    return (a + b) * LENGTH_OF_SUM + absolute(a - b) * LENGTH_OF_DIFFERENCE;
}

/* All ones where the turn is proven to be to the left. */
PATCH_INLINE lane_flags turn_left(const planar_path *points, const uint32_t *corners,
                                  double reach) {
    corner_lanes const a = load_corners(points, corners, 0);
    corner_lanes const b = load_corners(points, corners, 1);
    corner_lanes const c = load_corners(points, corners, 2);
    lanes ux[2], uy[2], vx[2], vy[2], bound[2];
    lanes const second = fill(DISC_TRIANGLE * reach * reach);
    for (int k = 0; k < 2; k++) {
        ux[k] = b.x[k] - a.x[k], uy[k] = b.y[k] - a.y[k];
        vx[k] = c.x[k] - a.x[k], vy[k] = c.y[k] - a.y[k];
        bound[k] = bound_lengths(ux[k], uy[k]) + bound_lengths(vx[k], vy[k]) +
                   bound_lengths(vx[k] - ux[k], vy[k] - uy[k]);
    }
    lanes const mixed = 0.5 * ((ux[0] * vy[1] - uy[0] * vx[1]) + (ux[1] * vy[0] - uy[1] * vx[0]));
    lane_flags const first = ux[0] * vy[0] - uy[0] * vx[0] > reach * bound[0] + second;
    lane_flags const middle = mixed > reach * (0.5 * (bound[0] + bound[1])) + second;
    lane_flags const last = ux[1] * vy[1] - uy[1] * vx[1] > reach * bound[1] + second;
    return first & middle & last;
}

bool TULLE_KERNEL(patch_turns_left)(const planar_path *points, const uint32_t *corners,
                                    size_t count, double reach) {
    lane_flags all = {-1, -1, -1, -1};
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) all &= turn_left(points, corners + 3 * i, reach);
    bool is_left = (all[0] & all[1] & all[2] & all[3]) != 0;
    for (; i < count && is_left; i++) {
        const uint32_t *const corner = corners + 3 * i;
        is_left =
            find_turn_sign(&points[corner[0]], &points[corner[1]], &points[corner[2]], reach) == 1;
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

PATCH_INLINE lanes dot(vec3 a, vec3_lanes b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

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
        lanes row[4] = {dot(map->across, start), dot(map->across, end), dot(map->along, start),
                        dot(map->along, end)};
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
