/* geom/mass_properties.h - volume or area, centre of mass and principal moments of inertia of
 * closed meshes, exactly but for rounding. */
#ifndef TULLE_GEOM_MASS_PROPERTIES_H
#define TULLE_GEOM_MASS_PROPERTIES_H

#include "base/memory.h"
#include "math/quaternion.h"

/* Where a body's mass is. */
typedef enum mass_distribution {
    MASS_IN_VOLUME, /* evenly inside the surface */
    MASS_ON_SURFACE /* evenly on it: thin shells */
} mass_distribution;

/* For a density of 1 kg/m^3 or 1 kg/m^2. */
typedef struct mass_properties {
    double measure;  /* [m^3] or [m^2] > 0 */
    vec3 centre;     /* [m] of mass, in the mesh's coordinates */
    vec3 moments;    /* [m^5] or [m^4] principal moments of inertia about it, > 0, ascending */
    quaternion axes; /* turns coordinates along the principal axes into the mesh's */
} mass_properties;

/* In volume, every edge of the mesh must have as many triangles one way round as the other, and
 * each piece must lie with its normals outwards (a cavity inside another piece: inwards). On the
 * surface any triangles do. `name` is for messages. Errors: TULLE_ERROR_INVALID_MESH names the
 * first edge or piece that is wrong, or says that a moment vanishes; OUT_OF_MEMORY; LIMIT beyond
 * 4096 pieces. */
tulle_status mass_properties_compute(memory *heap, tulle_mesh_view mesh, mass_distribution where,
                                     const char *name, mass_properties *result, tulle_error *error);

#endif
