/* dynamics/rigid_body.h - free motion of one rigid body.
 *
 * Coordinates of the body: origin in its centre of mass, axes along its principal axes. */
#ifndef TULLE_DYNAMICS_RIGID_BODY_H
#define TULLE_DYNAMICS_RIGID_BODY_H

#include "math/quaternion.h"

#include <stdbool.h>
#include <stddef.h>

/* What does not change with time. */
typedef struct rigid_body {
    double mass;            /* [kg] > 0 */
    vec3 moments;           /* [kg m^2] principal moments of inertia, > 0 */
    double linear_damping;  /* [1/s] >= 0 */
    double angular_damping; /* [1/s] >= 0 */
} rigid_body;

typedef struct rigid_state {
    vec3 position;          /* [m] of the centre of mass */
    quaternion orientation; /* unit, turns body coordinates into those of the world */
    vec3 velocity;          /* [m/s] of the centre */
    vec3 spin;              /* [kg m^2/s] angular momentum about the centre, in the world's axes */
} rigid_state;

/* [rad/s] in the world's axes */
vec3 rigid_compute_angular_velocity(const rigid_body *body, const rigid_state *state);
/* Spin [kg m^2/s] of the body when it turns with `angular_velocity` [rad/s]. */
vec3 rigid_compute_spin(const rigid_body *body, quaternion orientation, vec3 angular_velocity);
/* I [kg m^2] and I^-1 [1/(kg m^2)] in the world's axes. */
mat3 rigid_compute_inertia(const rigid_body *body, quaternion orientation);
mat3 rigid_compute_inverse_inertia(const rigid_body *body, quaternion orientation);

/* Moves the body on by time_step [s] with the mean velocity [m/s] of its centre and no torque: the
 * rotation keeps the spin and its energy but for rounding. Its error in time is of fourth order.
 * False: it makes more than 99 turns, or numbers are not finite; the state is then as before.
 */
bool rigid_drift(const rigid_body *body, vec3 mean_velocity, double time_step, rigid_state *state);

/* Points of the body's coordinates (3 * count doubles) in the world. */
void rigid_place(const rigid_state *state, const double *points, size_t count, double *placed);

#endif
