/* scene/pose.c - rigid placements. */
#include "scene/pose.h"

#include <math.h>
#include <string.h>

void quaternion_multiply(const double a[4], const double b[4], double result[4]) {
    const double product[4] = {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                               a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                               a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                               a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
    memcpy(result, product, sizeof product);
}

void quaternion_rotate(const double rotation[4], const double v[3], double result[3]) {
    const double inverse[4] = {rotation[0], -rotation[1], -rotation[2], -rotation[3]};
    double q[4] = {0, v[0], v[1], v[2]};
    quaternion_multiply(rotation, q, q);
    quaternion_multiply(q, inverse, q);
    memcpy(result, q + 1, 3 * sizeof(double));
}

void quaternion_from_axis(const double axis[3], double angle, double result[4]) {
    result[0] = cos(angle / 2);
    for (int k = 0; k < 3; k++) result[k + 1] = sin(angle / 2) * axis[k];
}

void pose_apply(const pose *placement, const double point[3], double result[3]) {
    quaternion_rotate(placement->rotation, point, result);
    for (int k = 0; k < 3; k++) result[k] += placement->translation[k];
}

pose pose_compose(const pose *outer, const pose *inner) {
    pose composed;
    quaternion_multiply(outer->rotation, inner->rotation, composed.rotation);
    pose_apply(outer, inner->translation, composed.translation);
    return composed;
}
