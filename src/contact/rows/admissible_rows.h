/* contact/rows/admissible_rows.h - which rows shape the response. The safe commit knows no such
 * choice. */
#ifndef TULLE_CONTACT_ROWS_ADMISSIBLE_ROWS_H
#define TULLE_CONTACT_ROWS_ADMISSIBLE_ROWS_H

#include "contact/contact_types.h"

/* Whether the row's normal lies in the normal cone of both features, at time `time` along
 * x0 -> x1: no neighbour of the feature lies nearer to the other body, by more than a slope
 * tolerance (a sine). Tests two tolerances at once: is_within is true where the answer is asked
 * for, and becomes false where the answer is no. Edge/edge rows whose nearest point is an end are
 * left to the vertex's own rows. */
void test_admissible(const contact_scene *scene, const double *x1, const contact_row *row,
                     double time, const double slope_tolerances[2], bool is_within[2]);

/* True when the nearest point is on the rim of a feature, from the weights of a pair: an edge or
 * corner of the triangle, or an end of an edge. */
bool is_on_rim(const double weights[4]);

/* Thins rows sorted by (kind, pair): a vertex/triangle row whose nearest point is on the
 * triangle's rim goes when the vertex is nearer to the inside of a neighbouring triangle, or when
 * another row has the same vertex and the same edge or vertex of the rim. Keeps the order; *count
 * becomes the number of rows that are left. */
tulle_status thin_rim_rows(const contact_scene *scene, contact_row **rows, size_t *count);

#endif
