/* support/wide_normals.h - normals of moving triangles in long double, against which cones are
 * judged. */
#ifndef TULLE_TEST_WIDE_NORMALS_H
#define TULLE_TEST_WIDE_NORMALS_H

#include "base/hash.h"
#include "math/vec3.h"

static const double DEGREE = 0.017453292519943295; /* [rad] */

static inline double random_between(uint64_t *seed, double low, double high) {
    return low + (high - low) * random_uniform(seed);
}

static inline vec3 random_vector(uint64_t *seed, double size) {
    double const x = random_between(seed, -size, size), y = random_between(seed, -size, size);
    return vec3_make(x, y, random_between(seed, -size, size));
}

typedef struct wide3 {
    long double x, y, z;
} wide3;

static inline wide3 wide(vec3 a) { return (wide3){a.x, a.y, a.z}; }
static inline wide3 wide_cross(wide3 a, wide3 b) {
    return (wide3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline long double wide_norm(wide3 a) { return sqrtl(a.x * a.x + a.y * a.y + a.z * a.z); }
static inline double angle_between(wide3 a, wide3 b) {
    return (double)atan2l(wide_norm(wide_cross(a, b)), a.x * b.x + a.y * b.y + a.z * b.z);
}

/* An edge of the triangle at time t. */
static inline wide3 find_edge(const vec3 start[3], const vec3 end[3], int corner, long double t) {
    wide3 const a0 = wide(start[0]), a1 = wide(end[0]);
    wide3 const b0 = wide(start[corner]), b1 = wide(end[corner]);
    return (wide3){(1.0L - t) * (b0.x - a0.x) + t * (b1.x - a1.x),
                   (1.0L - t) * (b0.y - a0.y) + t * (b1.y - a1.y),
                   (1.0L - t) * (b0.z - a0.z) + t * (b1.z - a1.z)};
}

static inline wide3 find_normal(const vec3 start[3], const vec3 end[3], long double t) {
    return wide_cross(find_edge(start, end, 1, t), find_edge(start, end, 2, t));
}

/* Largest angle between the axis and n(t) at `count` + 1 times. */
static inline double sample_angle(vec3 axis, const vec3 start[3], const vec3 end[3], int count) {
    double largest = 0.0;
    for (int i = 0; i <= count; i++) {
        long double const t = (long double)i / (long double)count;
        wide3 const n = find_normal(start, end, t);
        largest = fmax(largest, angle_between(wide(axis), n));
    }
    return largest;
}

#endif
