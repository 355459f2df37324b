/* io/animation/rotation.h - the way between two rotations. */
#ifndef TULLE_IO_ANIMATION_ROTATION_H
#define TULLE_IO_ANIMATION_ROTATION_H

#include <math.h>

/* Rotations this near to each other, by the cosine of half the angle, are joined by a line. */
static const double ROTATION_NEAR_COSINE = 0.9995;

static inline void rotation_normalize(double *q) {
    double const length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4 && length > 0.0; i++) q[i] /= length;
}

/* [rad] Between two rotations, the short way. */
static inline double rotation_find_angle(const double *from, const double *to) {
    double cosine = 0.0, lengths[2] = {0.0, 0.0};
    for (int i = 0; i < 4; i++) {
        cosine += from[i] * to[i];
        lengths[0] += from[i] * from[i];
        lengths[1] += to[i] * to[i];
    }
    double const length = sqrt(lengths[0] * lengths[1]);
    return length > 0.0 ? 2.0 * acos(fmin(fabs(cosine) / length, 1.0)) : 0.0;
}

/* From one unit quaternion to the next on the short way, at constant speed. */
static inline void rotation_interpolate(const double *from, const double *to, double part,
                                        double *q) {
    double cosine = 0.0;
    for (int i = 0; i < 4; i++) cosine += from[i] * to[i];
    double const side = cosine < 0.0 ? -1.0 : 1.0;
    cosine = fmin(fabs(cosine), 1.0);
    double first = 1.0 - part, second = part;
    if (cosine < ROTATION_NEAR_COSINE) {
        double const angle = acos(cosine);
        first = sin((1.0 - part) * angle) / sin(angle);
        second = sin(part * angle) / sin(angle);
    }
    for (int i = 0; i < 4; i++) q[i] = first * from[i] + side * second * to[i];
    rotation_normalize(q);
}

#endif
