/* app/mend/plate.h - the bending of a sheet that is flat at rest, as the library's cloth of springs
 * has it: a constant matrix K of one number for each pair of vertices.
 *
 * A world in which such cloth is pulled by K g, g the given positions, resists K (x - g): what
 * bends it is the departure x - g alone, whatever g is and however it turns. Based on what
 * docs/method/compute_forces.md says of bending, with a rigidity of 1 N m. */
#ifndef TULLE_APP_MEND_PLATE_H
#define TULLE_APP_MEND_PLATE_H

#include "tulle/base.h"

typedef struct mend_hinge {
    uint32_t vertices[4]; /* ends of the edge, then the corners opposite to it */
    double weights[4];    /* c is the sum of weights * vertices */
    double softening;
} mend_hinge;

typedef struct mend_plate {
    size_t vertex_count, triangle_count, hinge_count;
    mend_hinge *hinges;
    uint32_t *triangle_hinges; /* of edge k, from corner k to corner k + 1; TULLE_NONE: a border */
    double *couplings;         /* [1/m^2] 6 a triangle: of edges 0 0, 1 1, 2 2, 0 1, 1 2, 2 0 */
    double *areas;             /* [m^2] of vertices: a third of the triangles around */
    double *moments;           /* scratch: 3 a hinge, twice */
    /* neighbours of each vertex along edges: those of v from neighbour_begin[v] on */
    uint32_t *neighbour_begin, *neighbours;
} mend_plate;

/* From an oriented manifold at rest, without triangles that have no area. Errors:
 * TULLE_ERROR_OUT_OF_MEMORY. Release with mend_plate_close, also after a failure. */
tulle_status mend_plate_open(tulle_mesh_view rest, mend_plate *plate, tulle_error *error);
void mend_plate_close(mend_plate *plate);

/* result = K values, 3 numbers a vertex. */
void mend_plate_apply(const mend_plate *plate, const double *values, double *result);

#endif
