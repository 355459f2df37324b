/* world/bodies/body_access.h - rigid bodies as the host sees them (tulle/bodies.h). */
#ifndef TULLE_WORLD_BODIES_BODY_ACCESS_H
#define TULLE_WORLD_BODIES_BODY_ACCESS_H

#include "world/world_state.h"

/* Number of a body, or TULLE_NONE with an error. */
uint32_t world_find_body(const tulle_world *world, tulle_obstacle_id id, tulle_error *error);
/* body_control.c: gives a body of the state other velocities, three of its centre and three of its
 * turn, zero along what is locked. */
void world_set_body_velocity(tulle_world *world, size_t body, const double *velocities);

#endif
