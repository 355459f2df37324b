/* check/degenerate.h - intersections where at least one triangle is a segment or a point. */
#ifndef TULLE_CHECK_DEGENERATE_H
#define TULLE_CHECK_DEGENERATE_H

#include <stdbool.h>
#include <stddef.h>

/* Of two triangles, at least one of them without area: whether they have a common point outside the
 * hull of the first shared_count corners, which are the same points in both, in the same order.
 * shared_count: 0 .. 2. axis_a, axis_b: the axis of coplanar_choose_axis, -1 for a triangle without
 * area. */
bool degenerate_triangles_meet(const double *const a[3], int axis_a, const double *const b[3],
                               int axis_b, int shared_count, size_t *exact_count);

#endif
