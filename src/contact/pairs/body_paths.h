/* contact/pairs/body_paths.h - where rigid bodies go in a step. */
#ifndef TULLE_CONTACT_PAIRS_BODY_PATHS_H
#define TULLE_CONTACT_PAIRS_BODY_PATHS_H

#include "contact/contact_types.h"

/* [rad] Turn of a step, at most, for the next to hold. */
static const double BODY_TURN_MAX = 0.4;
/* A vertex of a free body leaves the chord of its path by at most this times r a^2. Here r is its
 * distance from the centre, and a = |w| h is the angle that the body turns by, with w at the start.
 * Relative to the centre, the acceleration is at most |w|^2 r + |dw/dt| r. By Euler's
 * equations |dw/dt| <= |w|^2 / sqrt 3, as no moment is more than the sum of the others. A path
 * leaves its chord by no more than an eighth of the acceleration times h^2. And |w| gains no more
 * than 0.3 of itself in a turn of BODY_TURN_MAX. */
static const double BODY_CHORD_FACTOR = 0.36;

/* Orientations among positions: modified Rodrigues parameters, (x, y, z) / (1 + w) of the
 * quaternion with w >= 0. Both ways lose no more than rounding. */
vec3 pack_orientation(quaternion q);
quaternion unpack_orientation(vec3 parameters);

/* rigid_drift of a body whose spin is set. A body that is locked along an axis of its turn turns
 * evenly with `turn_rate` [rad/s] instead: the lock gives the torque. */
bool drift_body(const contact_body *body, vec3 velocity, vec3 turn_rate, double time,
                rigid_state *state);

/* Moves free bodies on by `share` of the step with u, and sets x1 of their slots and vertices. They
 * turn as free bodies with the spin that u stands for. Where that turn cannot be computed, as
 * beyond 99 turns, x1 becomes NaN. Slots of other bodies keep x0. */
void place_bodies(const contact_scene *scene, const double *u, double share, double *x1);

#endif
