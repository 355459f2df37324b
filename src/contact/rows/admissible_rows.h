/* contact/rows/admissible_rows.h - which rows shape the response. The safe commit knows no such
 * choice: it tests all pairs. */
#ifndef TULLE_CONTACT_ROWS_ADMISSIBLE_ROWS_H
#define TULLE_CONTACT_ROWS_ADMISSIBLE_ROWS_H

#include "contact/contact_types.h"

/* Whether the row of a pair is kept. A reserved row is kept only if a contact is carried over to
 * it.
 */
typedef enum row_choice { ROW_DROPPED, ROW_RESERVED, ROW_KEPT } row_choice;

/* Whether the row's normal lies in the normal cone of both features, at time `time` along
 * x0 -> x1: no neighbour of a feature lies nearer to the other body than the feature itself, by
 * more than a slope tolerance (a sine). Tests two tolerances at once: is_within is true where the
 * answer is asked for, and becomes false where the answer is no. The caller drops edge/edge rows
 * that touch at an end, because the vertex's own rows stand for them. */
void test_admissible(const contact_scene *scene, const double *x1, const contact_row *row,
                     double time, const double slope_tolerances[2], bool is_within[2]);

/* True when the nearest point is on the rim of a feature, from the weights of a pair: an edge or
 * corner of the triangle, or an end of an edge. */
bool is_on_rim(const double weights[4]);

/* Thins the kept ones among rows sorted by (kind, pair); `choices` holds the row_choice of each. A
 * vertex/triangle row whose nearest point is on the triangle's rim is dropped when the vertex is
 * nearer to the inside of a neighbouring triangle, or when another row has the same vertex and the
 * same edge or vertex of the rim. */
tulle_status thin_rim_rows(const contact_scene *scene, contact_row *const *rows, uint8_t *choices,
                           size_t count);

#endif
