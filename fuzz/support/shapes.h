/* fuzz/support/shapes.h - small cloths and obstacles, taken from bytes. */
#ifndef TULLE_FUZZ_SHAPES_H
#define TULLE_FUZZ_SHAPES_H

#include "support/fuzz.h"

/* Meshes of some 4 to 42 vertices, turned and moved; release them with tulle_mesh_destroy. */
tulle_mesh shapes_take_cloth(fuzz_bytes *bytes);
/* All but the plane are closed and convex, so that inside means something. */
tulle_mesh shapes_take_obstacle(fuzz_bytes *bytes, int *is_closed);

/* Whether a point lies within a convex mesh, which has these positions, deeper than rounding
 * explains. */
bool shapes_contain(const tulle_mesh *mesh, const double *positions, const double *point);

#endif
