/* scene/pose.c - rigid placements. */
#include "scene/pose.h"

#include "math/quaternion.h"

#include <math.h>
#include <string.h>

void multiply_rotations(const double a[4], const double b[4], double result[4]) {
    quaternion const product = quaternion_multiply(quaternion_load(a), quaternion_load(b));
    memcpy(result, &product, sizeof product);
}

void rotate_vector(const double rotation[4], const double v[3], double result[3]) {
    quaternion const q = quaternion_load(rotation), point = {0.0, v[0], v[1], v[2]};
    quaternion const turned =
        quaternion_multiply(quaternion_multiply(q, point), quaternion_conjugate(q));
    vec3_store(result, 0, vec3_make(turned.x, turned.y, turned.z));
}

void make_rotation(const double axis[3], double angle, double result[4]) {
    result[0] = cos(angle / 2);
    for (int k = 0; k < 3; k++) result[k + 1] = sin(angle / 2) * axis[k];
}

void pose_apply(const pose *placement, const double point[3], double result[3]) {
    rotate_vector(placement->rotation, point, result);
    for (int k = 0; k < 3; k++) result[k] += placement->translation[k];
}

pose pose_compose(const pose *outer, const pose *inner) {
    pose composed;
    multiply_rotations(outer->rotation, inner->rotation, composed.rotation);
    pose_apply(outer, inner->translation, composed.translation);
    return composed;
}
