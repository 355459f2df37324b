/* contact/rows/stick_anchors.h - how far contacts have slipped since they began to stick. */
#ifndef TULLE_CONTACT_ROWS_STICK_ANCHORS_H
#define TULLE_CONTACT_ROWS_STICK_ANCHORS_H

#include "contact/contact_types.h"

/* Sets the anchor that a row takes over from its contact: the part of `offset` [m] in the row's
 * tangent plane, and the velocity that undoes it. Zero when the contact did not stick or slips at
 * the start. */
void take_anchor(const contact_scene *scene, contact_row *row, vec3 offset);

/* Adds to each anchor what its row slips on the accepted paths x0 -> x1. The anchor of a row that
 * slides becomes zero. */
void move_anchors(const contact_scene *scene, const double *x1, row_list *list);

#endif
