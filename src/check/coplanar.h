/* check/coplanar.h - intersection of triangles that lie in one plane, decided in a projection.
 *
 * Dropping one coordinate maps a plane one-to-one onto the plane of the other two, unless the plane
 * is parallel to the dropped axis. It is not parallel if the projection of a triangle in it has
 * area. Then sets in the plane meet exactly where their projections meet.
 */
#ifndef TULLE_CHECK_COPLANAR_H
#define TULLE_CHECK_COPLANAR_H

#include <stdbool.h>
#include <stddef.h>

/* The axis 0 .. 2 to drop so that points a, b, c keep a triangle with area; -1 if they are
 * collinear (or equal). */
int coplanar_choose_axis(const double *a, const double *b, const double *c, size_t *exact_count);

/* orient2d_sign of the points without coordinate `axis`. */
int coplanar_orient(int axis, const double *a, const double *b, const double *c,
                    size_t *exact_count);

/* Whether all `count` points lie strictly outside the line of some edge of the triangle: on the
 * side where the triangle is not. Points and triangle lie in one plane, and the triangle is not
 * degenerate in the projection. */
bool coplanar_edge_separates(int axis, const double *const triangle[3], const double *const *points,
                             int count, size_t *exact_count);

/* Whether two coplanar triangles, none degenerate in the projection, have another common point than
 * a[0] and b[0], which are the same. */
bool coplanar_triangles_meet_beyond_vertex(int axis, const double *const a[3],
                                           const double *const b[3], size_t *exact_count);

#endif
