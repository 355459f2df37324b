/* tulle/bodies.h - what a host does with the rigid bodies of a world that runs: velocities, forces,
 * locked axes, and drives, by which a gripper closes with so many newtons and no more.
 *
 * Forces are for one step. That step uses them up, also when it fails, and so does
 * tulle_world_load_state when it succeeds. Locks and drives hold until they are changed. They are
 * part of the state: saved, put back by tulle_world_load_state, and in the hash of a world that has
 * any. Every call but the last wakes the body. examples/gripper.c is a whole program;
 * docs/method/bodies.md tells how drives are solved.
 *
 * Errors of all: TULLE_ERROR_INVALID_ARGUMENT (null where it is not allowed, a stale id, an
 * obstacle that is no body, a world that has not started, numbers that are not finite or out of
 * range); nothing has changed then. Velocities and forces are also refused while the body is absent
 * or follows its script. */
#ifndef TULLE_BODIES_H
#define TULLE_BODIES_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Sets `velocity` [m/s] of the centre of mass and `angular_velocity` [rad/s] of a body at once, up
 * to 1e6 along each axis; null leaves one as it is. What is locked stays at 0. */
TULLE_API tulle_status tulle_obstacle_set_velocity(tulle_world *world, tulle_obstacle_id id,
                                                   const double velocity[3],
                                                   const double angular_velocity[3],
                                                   tulle_error *error);
/* Adds `force` [N] at `point` [m] of the world, which goes along with the body's centre; null: at
 * the centre of mass. It acts all through the next step, up to 1e12 along each axis. */
TULLE_API tulle_status tulle_obstacle_add_force(tulle_world *world, tulle_obstacle_id id,
                                                const double point[3], const double force[3],
                                                tulle_error *error);
/* Adds `torque` [N m], as tulle_obstacle_add_force does a force. */
TULLE_API tulle_status tulle_obstacle_add_torque(tulle_world *world, tulle_obstacle_id id,
                                                 const double torque[3], tulle_error *error);

/* Axes of the world that a body is locked along. */
typedef enum tulle_lock {
    TULLE_LOCK_X = 1,  /* x */
    TULLE_LOCK_Y = 2,  /* y */
    TULLE_LOCK_Z = 4,  /* z */
    TULLE_LOCK_ALL = 7 /* all three */
} tulle_lock;
/* Locks a body: its centre of mass does not move along the axes in `translations`, and it does not
 * turn about those in `rotations`; sets of tulle_lock, 0: free. What it moves along them stops at
 * once. Coordinates of the centre that are locked keep their bits, and so does the whole mesh where
 * all is locked; what turns about one axis stays in its plane but for rounding. A body locked about
 * one axis alone turns with an error of first order in the time step. */
TULLE_API tulle_status tulle_obstacle_set_locks(tulle_world *world, tulle_obstacle_id id,
                                                unsigned translations, unsigned rotations,
                                                tulle_error *error);

/* A spring and a damper that pull a body to a place and a velocity, along each axis of the world:
 * force = stiffness (position - x) + damping (velocity - v), cut off at the limit. The same for the
 * turn, with the shortest turn to `rotation` as a vector. They are implicit: x and v are those at
 * the end of the step, so it is stable with any values, and those of 1e12 hold like a rail. Locked
 * axes get none. Made by tulle_body_drive_default.
 *
 * The limit is exact: the mean force over a substep is never above it. A body that is driven never
 * sleeps. The target stands still within a step, wherever the host moves it before the next. */
typedef struct tulle_body_drive {
    double position[3];          /* [m] of the centre of mass, up to 1e100 */
    double rotation[4];          /* unit quaternion w, x, y, z; as of tulle_transform */
    double velocity[3];          /* [m/s] up to 1e6 */
    double angular_velocity[3];  /* [rad/s] up to 1e6 */
    double stiffness[3];         /* [N/m] 0 .. 1e12 */
    double damping[3];           /* [N s/m] 0 .. 1e12 */
    double force_limit[3];       /* [N] >= 0; 0: no force at all, INFINITY: no limit */
    double angular_stiffness[3]; /* [N m/rad] 0 .. 1e12 */
    double angular_damping[3];   /* [N m s/rad] 0 .. 1e12 */
    double torque_limit[3];      /* [N m] >= 0; 0: no torque at all, INFINITY: no limit */
} tulle_body_drive;
/* A drive that does nothing: no stiffness and no damping, no limits, the origin, no turn. */
TULLE_API tulle_body_drive tulle_body_drive_default(void);
/* Gives a body a drive, in place of the one it has; null: none. */
TULLE_API tulle_status tulle_obstacle_set_drive(tulle_world *world, tulle_obstacle_id id,
                                                const tulle_body_drive *drive, tulle_error *error);
/* What the drive gave in the last substep of the last accepted step, as a mean: `force` [N] and
 * `torque` [N m] about the centre of mass. Zero without a drive, and after tulle_world_load_state
 * until the next step. */
TULLE_API tulle_status tulle_obstacle_get_drive_force(const tulle_world *world,
                                                      tulle_obstacle_id id, double force[3],
                                                      double torque[3], tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
