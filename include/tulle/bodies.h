/* tulle/bodies.h - control of the rigid bodies of a world that runs: velocities, forces, locked
 * axes and drives. A drive closes a gripper with a given force and no more.
 *
 * Forces act for one step. The step uses them up, even if it fails. A tulle_world_load_state that
 * succeeds discards them. Locks and drives hold until they are changed. They are part of the state:
 * saved, restored by tulle_world_load_state, and in the hash of a world that has any. Every call
 * but the last wakes the body. examples/gripper.c is a whole program; docs/method/bodies.md
 * explains how drives are solved.
 *
 * Errors of all calls: TULLE_ERROR_INVALID_ARGUMENT (null where it is not allowed, a stale id, an
 * obstacle that is not a rigid body, a world that has not started, numbers that are not finite or
 * out of range). After an error nothing has changed. Velocities and forces are also refused while
 * the body is absent or follows its script. */
#ifndef TULLE_BODIES_H
#define TULLE_BODIES_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Sets `velocity` [m/s] of the centre of mass and `angular_velocity` [rad/s] of a body, up to 1e6
 * along each axis. Both may be null; null leaves the value as it is. Velocities along locked axes
 * stay 0. */
TULLE_API tulle_status tulle_obstacle_set_velocity(tulle_world *world, tulle_obstacle_id id,
                                                   const double velocity[3],
                                                   const double angular_velocity[3],
                                                   tulle_error *error);
/* Adds `force` [N], up to 1e12 along each axis, at `point` [m] of the world; a null `point` is the
 * centre of mass. The force acts during the whole next step; its point moves with the body's
 * centre. */
TULLE_API tulle_status tulle_obstacle_add_force(tulle_world *world, tulle_obstacle_id id,
                                                const double point[3], const double force[3],
                                                tulle_error *error);
/* Adds `torque` [N m], as tulle_obstacle_add_force does a force. */
TULLE_API tulle_status tulle_obstacle_add_torque(tulle_world *world, tulle_obstacle_id id,
                                                 const double torque[3], tulle_error *error);

/* Axes of the world along which a body is locked. */
typedef enum tulle_lock {
    TULLE_LOCK_X = 1,  /* x */
    TULLE_LOCK_Y = 2,  /* y */
    TULLE_LOCK_Z = 4,  /* z */
    TULLE_LOCK_ALL = 7 /* all three */
} tulle_lock;
/* Locks a body: its centre of mass does not move along the axes in `translations`, and it does not
 * turn about the axes in `rotations`. Both are sets of tulle_lock; 0 is free. Motion along a locked
 * axis stops at once. Locked coordinates of the centre keep their bits. If everything is locked,
 * the whole mesh does. The points of a body that turns about one axis stay in their planes but for
 * rounding. A body that is locked about only one axis turns with an error of first order in the
 * time step. */
TULLE_API tulle_status tulle_obstacle_set_locks(tulle_world *world, tulle_obstacle_id id,
                                                unsigned translations, unsigned rotations,
                                                tulle_error *error);

/* A spring and a damper that pull a body to a position and a velocity, along each axis of the
 * world: force = stiffness (position - x) + damping (velocity - v), cut off at the limit. The
 * torque follows the same formula, with the shortest turn to `rotation` as a vector. Both are
 * implicit: x and v are taken at the end of the step. So a drive is stable with any values, and
 * values of 1e12 hold like a rail. Locked axes get no force. Made by tulle_body_drive_default.
 *
 * The limit is exact: the mean force over a substep never exceeds it. A driven body never sleeps.
 * The target stands still during a step, also if the host moves it between steps. */
typedef struct tulle_body_drive {
    double position[3];         /* [m] -1e100 .. 1e100: of the centre of mass */
    double rotation[4];         /* -2 .. 2, default (1, 0, 0, 0): unit quaternion w, x, y, z; as of
                                   tulle_transform */
    double velocity[3];         /* [m/s] -1e6 .. 1e6 */
    double angular_velocity[3]; /* [rad/s] -1e6 .. 1e6 */
    double stiffness[3];        /* [N/m] 0 .. 1e12 */
    double damping[3];          /* [N s/m] 0 .. 1e12 */
    double force_limit[3]; /* [N] 0 .. INFINITY, default INFINITY; 0: no force at all, INFINITY: no
                              limit */
    double angular_stiffness[3]; /* [N m/rad] 0 .. 1e12 */
    double angular_damping[3];   /* [N m s/rad] 0 .. 1e12 */
    double torque_limit[3]; /* [N m] 0 .. INFINITY, default INFINITY; 0: no torque at all, INFINITY:
                               no limit */
} tulle_body_drive;
/* A drive that does nothing: no stiffness and no damping, no limits, the origin, no turn. */
TULLE_API tulle_body_drive tulle_body_drive_default(void);
/* Gives a body a drive, in place of the one it has; null: none. */
TULLE_API tulle_status tulle_obstacle_set_drive(tulle_world *world, tulle_obstacle_id id,
                                                const tulle_body_drive *drive, tulle_error *error);
/* Gives the mean force and torque of the drive over the last substep of the last accepted step:
 * `force` [N] and `torque` [N m] about the centre of mass. Zero without a drive, and after
 * tulle_world_load_state until the next step. */
TULLE_API tulle_status tulle_obstacle_get_drive_force(const tulle_world *world,
                                                      tulle_obstacle_id id, double force[3],
                                                      double torque[3], tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
