/* detect/patches/patches.h - cuts a moving surface into patches: edge-connected sets of triangles
 * whose normals stay within one cone during the step, the paper's (zeta, alpha, I)-surfaces.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, 3.2. That no normal of a patch turns away from its axis by more than alpha is what is
 * proven here; by itself this does not prove that the patch cannot touch itself. */
#ifndef TULLE_DETECT_PATCHES_PATCHES_H
#define TULLE_DETECT_PATCHES_PATCHES_H

#include "base/arena.h"
#include "detect/patches/normal_cone.h"
#include "geom/topology.h"

/* Triangles begin .. end - 1 of a topology, whose vertices move along x0 -> x1. */
typedef struct patch_surface {
    const topology *topo;
    uint32_t triangle_begin, triangle_end;
    const double *x0, *x1; /* [m] 3 * vertex_count of the topology; read at these triangles only */
} patch_surface;

typedef struct patch_settings {
    double max_angle; /* [rad] alpha_max, > 0 and < pi/2: no patch gets a wider cone */
    int threads;
} patch_settings;

/* Arrays from the arena that grow_patches was given. */
typedef struct patch_list {
    normal_cone *cones; /* of each patch; patch of label k is cones[k - 1] */
    size_t count;
} patch_list;

/* Grows patches. labels: triangle_end - triangle_begin entries, 1 .. list->count, or
 * PATCH_ISOLATED for triangles without a cone, or with one wider than max_angle. The cone of a
 * patch holds the normals of all its triangles over the whole step. Patches are numbered in the
 * order of their first triangles; the same for any number of threads. Fails only for want of
 * memory. */
enum { PATCH_ISOLATED = 0 };
tulle_status grow_patches(const patch_surface *surface, const patch_settings *settings,
                          arena *scratch, uint32_t *labels, patch_list *list);

#endif
