/* scene/pose.h - rigid placements: x -> translation + R x, R from a unit quaternion (w, x, y, z).
 */
#ifndef TULLE_SCENE_POSE_H
#define TULLE_SCENE_POSE_H

typedef struct pose {
    double rotation[4];
    double translation[3];
} pose;

#define POSE_IDENTITY                                                                              \
    (pose) {                                                                                       \
        {1, 0, 0, 0}, { 0, 0, 0 }                                                                  \
    }

/* result = a b, the turn b followed by a; result may be a or b. */
void multiply_rotations(const double a[4], const double b[4], double result[4]);
/* result = R v; result may be v. */
void rotate_vector(const double rotation[4], const double v[3], double result[3]);
/* The turn about a unit axis. */
void make_rotation(const double axis[3], double angle, double result[4]);
/* The inner placement followed by the outer one. */
pose pose_compose(const pose *outer, const pose *inner);
void pose_apply(const pose *placement, const double point[3], double result[3]);

#endif
