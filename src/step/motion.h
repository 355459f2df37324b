/* step/motion.h - scripted rigid motion: keyframes to positions. */
#ifndef TULLE_STEP_MOTION_H
#define TULLE_STEP_MOTION_H

#include "base/memory.h"
#include "math/quaternion.h"
#include "tulle/world.h"

/* A quaternion may be off unit length by this much before it is refused. */
static const double QUATERNION_TOLERANCE = 1e-6;

/* A keyframe, and how the motion comes to it from the one before it. */
typedef struct motion_key {
    double time;         /* [s] */
    vec3 translation;    /* [m] */
    quaternion rotation; /* of unit length */
    vec3 turn;           /* [rad] axis times angle: from the rotation before to this one */
    double turned;       /* [rad] angles of all turns up to here */
} motion_key;

/* An owned copy of a tulle_motion. */
typedef struct world_motion {
    motion_key *keys;
    size_t key_count;
    double pivot[3]; /* [m] */
    int is_eased;
} world_motion;

/* Checks a def's motion: finite values, times strictly increasing, turns that doubles resolve. */
tulle_status motion_validate(const tulle_motion *motion, const char *owner, tulle_error *error);
tulle_status motion_copy(memory *heap, const tulle_motion *source, world_motion *target);
void motion_destroy(memory *heap, world_motion *motion);

/* The pose at `time` [s]: x -> R (x - pivot) + pivot + translation. The identity without keys.
 * If `turned` is not null, it gets the sum of the angles [rad] by which the motion has turned up to
 * there. */
typedef struct motion_pose {
    vec3 translation;    /* [m] */
    quaternion rotation; /* R */
} motion_pose;
motion_pose motion_compute_pose(const world_motion *motion, double time, double *turned);

/* The rigid change from the pose at `from` to the pose at `to`: x -> matrix x + offset. */
void motion_compute_change(const world_motion *motion, double from, double to, mat3 *matrix,
                           vec3 *offset);

/* Applies the pose at `time` to `count` points: 3 * count doubles in, the same out. */
void motion_apply(const world_motion *motion, double time, const double *source, size_t count,
                  double *target);

#endif
