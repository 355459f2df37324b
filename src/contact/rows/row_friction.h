/* contact/rows/row_friction.h - what friction a row may bear in this step, and in which direction.
 */
#ifndef TULLE_CONTACT_ROWS_ROW_FRICTION_H
#define TULLE_CONTACT_ROWS_ROW_FRICTION_H

#include "contact/contact_types.h"

/* Sets coefficients, restitution, approach and grain of a row whose vertices, weights and normal
 * are known. */
void set_row_friction(const contact_scene *scene, contact_row *row);

/* The point nearest to `tangential` among the impulses that friction can give under the normal
 * impulse `normal` >= 0: a disk, or an ellipse with a grain. *is_inside: it was one of them. */
vec3 limit_friction(const contact_row *row, double normal, vec3 tangential, bool *is_inside);

/* Of a small change of the tangential trial impulse along the bound, the part that its bounded
 * point `friction` follows: 1 on a straight bound, 0 in a corner. */
double measure_bound_follow(const contact_row *row, double normal, vec3 friction, vec3 trial);

#endif
