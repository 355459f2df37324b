/* contact/rows/stick_anchors.h - how far contacts that stick have slipped since they began to. */
#ifndef TULLE_CONTACT_ROWS_STICK_ANCHORS_H
#define TULLE_CONTACT_ROWS_STICK_ANCHORS_H

#include "contact/contact_types.h"

/* The anchor that a row takes over from its contact: the offset [m] in the row's tangent plane, and
 * the speed that undoes it. None when the contact did not stick or slips at the start. */
void take_anchor(const contact_scene *scene, contact_row *row, vec3 offset);

/* Adds what each row slips on the accepted paths x0 -> x1; the offset of what slides is let go. */
void move_anchors(const contact_scene *scene, const double *x1, row_list *list);

#endif
