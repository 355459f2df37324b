/* world/inside.h - what lies inside closed obstacles. */
#ifndef TULLE_WORLD_INSIDE_H
#define TULLE_WORLD_INSIDE_H

#include "math/vec3.h"
#include "world/world_state.h"

/* Solid angle of triangles seen from a point, over 4 pi: the winding number, 1 inside a closed
 * surface that faces outward, -1 inside one that faces inward, 0 outside. Corners are indices into
 * `positions`. */
double find_winding_number(const uint32_t *triangles, size_t triangle_count,
                           const double *positions, vec3 point);

/* Whether each edge of a surface has two triangles. */
bool surface_is_closed(const topology *topo, const surface_range *range);

/* TULLE_ERROR_INTERSECTING_START when a piece of cloth that intersects nothing lies inside a
 * present obstacle that is closed and faces outward. */
tulle_status world_refuse_cloth_inside(tulle_world *world, const double *positions,
                                       tulle_error *error);

#endif
