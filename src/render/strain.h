/* render/strain.h - how much each triangle of a cloth is stretched against its shape at rest. */
#ifndef TULLE_RENDER_STRAIN_H
#define TULLE_RENDER_STRAIN_H

#include "tulle/base.h"

/* The two principal stretches of the map from a triangle at rest to where its corners are now, the
 * larger one first: 1 is unstretched, 1.1 a tenth longer. Corners are 3 * 3 coordinates. Both NaN
 * where the triangle at rest has no area. */
void render_get_stretches(const double rest[9], const double now[9], double stretches[2]);

/* strains: 1 a vertex. A triangle has the principal strain (stretch - 1) that is larger in
 * magnitude, signed. A vertex has the mean of the triangles around it, weighted by area at rest, or
 * 0 if there is none.
 * areas: scratch, 1 a vertex. now: positions, 3 a vertex of the mesh at rest. */
void render_get_vertex_strains(tulle_mesh_view rest, const double *now, double *strains,
                               double *areas);

#endif
