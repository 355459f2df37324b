/* contact/body_paths.h - where rigid bodies go in a step. */
#ifndef TULLE_CONTACT_BODY_PATHS_H
#define TULLE_CONTACT_BODY_PATHS_H

#include "contact/contact_types.h"

/* Orientations among positions: modified Rodrigues parameters, (x, y, z) / (1 + w) of the
 * quaternion with w >= 0. Both ways lose no more than rounding. */
vec3 pack_orientation(quaternion q);
quaternion unpack_orientation(vec3 parameters);

/* Tells how free bodies fall: those that no row of the list holds go with the mean of their
 * velocities at the start and the end, others with that at the end. */
void set_body_lifts(const contact_scene *scene, const row_list *list);

/* Moves a free body on by `share` of the step with u: x1 of its slots and its vertices. The
 * rotation is that of a free body with the spin that u stands for. Where that cannot be computed,
 * as beyond 99 turns, x1 becomes NaN. */
void place_body(const contact_scene *scene, size_t body, const double *u, double share, double *x1);
/* The same of all free bodies; slots of the others keep x0. */
void place_bodies(const contact_scene *scene, const double *u, double share, double *x1);

#endif
