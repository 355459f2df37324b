/* math/quaternion.h - unit quaternions as rotations, by value. Layout equals double[4]: w, x, y, z.
 */
#ifndef TULLE_MATH_QUATERNION_H
#define TULLE_MATH_QUATERNION_H

#include "math/vec3.h"

typedef struct quaternion {
    double w, x, y, z;
} quaternion;

static inline quaternion quaternion_load(const double *q) {
    return (quaternion){q[0], q[1], q[2], q[3]};
}
static inline double quaternion_norm(quaternion q) {
    return sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
}
/* q / |q|, or the identity where |q| is zero. */
static inline quaternion quaternion_normalize(quaternion q) {
    double const norm = quaternion_norm(q);
    if (!(norm > 0.0)) return (quaternion){1.0, 0.0, 0.0, 0.0};
    return (quaternion){q.w / norm, q.x / norm, q.y / norm, q.z / norm};
}
/* a b: first b, then a. */
static inline quaternion quaternion_multiply(quaternion a, quaternion b) {
    return (quaternion){a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
                        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
/* The inverse of a unit quaternion. */
static inline quaternion quaternion_conjugate(quaternion q) {
    return (quaternion){q.w, -q.x, -q.y, -q.z};
}
/* The quaternion that turns by |v| rad about v; |v| may be more than a turn. */
static inline quaternion quaternion_from_vector(vec3 v) {
    double const angle = vec3_norm(v);
    if (!(angle > 0.0)) return (quaternion){1.0, 0.0, 0.0, 0.0};
    double const share = sin(0.5 * angle) / angle;
    return (quaternion){cos(0.5 * angle), share * v.x, share * v.y, share * v.z};
}
/* [rad] The shorter turn from one unit quaternion to another, as axis times angle. */
static inline vec3 quaternion_find_turn(quaternion from, quaternion to) {
    quaternion const q = quaternion_multiply(to, quaternion_conjugate(from));
    double const sign = q.w < 0.0 ? -1.0 : 1.0, scale = sign / (1.0 + fabs(q.w));
    vec3 const quarter = vec3_make(scale * q.x, scale * q.y, scale * q.z); /* tan(angle / 4) */
    double const size = vec3_norm(quarter);
    return size > 0.0 ? vec3_scale(quarter, 4.0 * atan(size) / size) : quarter;
}
/* The rotation matrix of a unit quaternion. */
static inline mat3 quaternion_to_matrix(quaternion q) {
    return (mat3){{1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y - q.w * q.z),
                   2.0 * (q.x * q.z + q.w * q.y), 2.0 * (q.x * q.y + q.w * q.z),
                   1.0 - 2.0 * (q.x * q.x + q.z * q.z), 2.0 * (q.y * q.z - q.w * q.x),
                   2.0 * (q.x * q.z - q.w * q.y), 2.0 * (q.y * q.z + q.w * q.x),
                   1.0 - 2.0 * (q.x * q.x + q.y * q.y)}};
}
/* R a; with the conjugate R^T a. */
static inline vec3 quaternion_rotate(quaternion q, vec3 a) {
    mat3 const matrix = quaternion_to_matrix(q);
    return mat3_multiply_vec3(&matrix, a);
}

#endif
