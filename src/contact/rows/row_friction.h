/* contact/rows/row_friction.h - how much friction a row may bear in this step, in each direction.
 */
#ifndef TULLE_CONTACT_ROWS_ROW_FRICTION_H
#define TULLE_CONTACT_ROWS_ROW_FRICTION_H

#include "contact/contact_types.h"

/* Sets coefficients, grain, restitution, approach and fall of a row whose vertices, weights,
 * normal, bodies and turning are known. */
void set_row_friction(const contact_scene *scene, contact_row *row);

/* Friction under the normal impulse `normal` >= 0 can give the impulses of a disk, or with a grain
 * those of an ellipse. Returns the one of them that is nearest to `tangential`. *is_inside: whether
 * `tangential` itself is one. */
vec3 limit_friction(const contact_row *row, double normal, vec3 tangential, bool *is_inside);

/* `friction` is the point of the bound that is nearest to the impulse `trial`. When the trial moves
 * a little along the bound, the point moves by this part of that: by all of it (1) on a straight
 * bound, not at all (0) in a corner. */
double measure_bound_follow(const contact_row *row, double normal, vec3 friction, vec3 trial);

#endif
