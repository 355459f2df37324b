/* render/surface_gap.h - how far each vertex of a cloth is from the nearest surface. */
#ifndef TULLE_RENDER_SURFACE_GAP_H
#define TULLE_RENDER_SURFACE_GAP_H

#include "base/memory.h"

typedef struct render_gap_surface {
    tulle_mesh_view mesh;   /* as it is now; indices in range */
    const double *rest;     /* [m] 3 a vertex, the shape at rest; null: an obstacle */
    const uint32_t *pieces; /* of cloth: the piece of each triangle, see rest_coordinates.h */
    size_t piece_count;
} render_gap_surface;

typedef struct render_gap_def {
    const render_gap_surface *surfaces;
    size_t surface_count;
    double farthest; /* [m] beyond, nothing is looked for */
    int threads;     /* 0: one per processor; the result does not depend on it */
} render_gap_def;

/* gaps[i] [m]: 1 a vertex of surface i if it is a cloth, else null. A gap is the distance to the
 * nearest place of another surface or of the cloth itself, at most `farthest`. A place of the
 * vertex's own piece counts only if it is nearer than half of its distance at rest. So a fold
 * counts, and the sheet around the vertex does not. Gaps between two edges are not looked for,
 * only those from vertices. Errors: TULLE_ERROR_OUT_OF_MEMORY,
 * TULLE_ERROR_LIMIT (over 2^30 triangles). */
tulle_status render_measure_gaps(memory *heap, const render_gap_def *def, double *const *gaps,
                                 tulle_error *error);

/* Weights of the corners of the triangle's point that is nearest to p; gives the distance. Corners:
 * 3 * 3 coordinates. */
double render_get_triangle_distance(const double p[3], const double corners[9], double weights[3]);

#endif
