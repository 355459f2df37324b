/* contact/rows/row_friction.h - how much friction a row may bear in this step, in each direction.
 */
#ifndef TULLE_CONTACT_ROWS_ROW_FRICTION_H
#define TULLE_CONTACT_ROWS_ROW_FRICTION_H

#include "contact/contact_types.h"

/* Sets coefficients, grain, restitution, approach and fall of a row whose vertices, weights,
 * normal, bodies and turning are known. */
void set_row_friction(const contact_scene *scene, contact_row *row);

/* Under the normal impulse `normal` >= 0 friction can give the impulses of a disk, or with a grain
 * of an ellipse. Returns its point nearest to `tangential`. *is_inside: whether `tangential` lies
 * in it. */
vec3 limit_friction(const contact_row *row, double normal, vec3 tangential, bool *is_inside);

/* `friction` is the point of the bound that is nearest to the impulse `trial`. Returns the
 * displacement of this point over a small displacement of the trial along the bound: 1 on a
 * straight bound, 0 in a corner. */
double measure_bound_follow(const contact_row *row, double normal, vec3 friction, vec3 trial);

#endif
