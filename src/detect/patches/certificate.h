/* detect/patches/certificate.h - proof that a patch, a topological disc of triangles, cannot touch
 * itself while its vertices move along straight lines.
 *
 * Theorem. If for all t in [0, 1] every triangle of the disc has zeta . n(t) > 0 and the projection
 * of its boundary along zeta is a simple closed curve, the projection of the disc is injective for
 * all t; so no two of its features touch. The state at t = 0 need not be known to be free of
 * intersections. Proof: docs/method/certificate.md.
 *
 * All signs carry bounds, rounded outward, and hold for every displacement of vertices up to
 * `reach`. */
#ifndef TULLE_DETECT_PATCHES_CERTIFICATE_H
#define TULLE_DETECT_PATCHES_CERTIFICATE_H

#include "base/memory.h"
#include "math/vec3.h"

#include <stdbool.h>

/* For one moving triangle: zeta . n(t) > 0 for all displacements of its corners up to reach [m],
 * and zeta . n(t) >= cos(max_angle) |n(t)| on the given paths; the latter is left out from pi/2 on.
 * zeta is the exact direction that planar_map_make finds for the axis, which may have any length.
 */
bool triangle_faces_axis(const vec3 start[3], const vec3 end[3], vec3 axis, double max_angle,
                         double reach);

typedef enum contour_proof { CONTOUR_UNPROVEN, CONTOUR_STAR, CONTOUR_SWEPT } contour_proof;

/* The boundary of a disc: vertex indices in order, each once, counterclockwise about the axis.
 * scratch needs contour_scratch_size(vertex_count) bytes, aligned for doubles. max_tests bounds the
 * number of pairs of boxes and edges looked at. */
typedef struct contour {
    const uint32_t *vertices;
    size_t vertex_count;
    const double *x0, *x1; /* [m] 3 * all vertices */
    vec3 axis;
    double reach; /* [m] */
} contour;
size_t contour_scratch_size(size_t vertex_count);
/* Whether the projected boundary stays a simple curve; star test first, then all pairs of edges
 * whose swept boxes meet. */
contour_proof prove_contour(const contour *boundary, size_t max_tests, void *scratch);

#endif
