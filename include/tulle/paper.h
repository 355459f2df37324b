/* tulle/paper.h - for studies of the method, as in Wong & Baciu 2005: how fine a mesh
 * is, what an integrator damps, the patches of the detector. Simulations need none of it. */
#ifndef TULLE_PAPER_H
#define TULLE_PAPER_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How fine the mesh of a cloth is compared with the folds of its fabric. Edges should be at most
 * half the bending length; where cloth curves in two directions at once, as a table cloth does, a
 * third. Coarser cells hold cloth up. */
typedef struct tulle_fineness {
    double mean_edge; /* [m] mean length of the edges between rest positions; 0: not known */
    /* [m] (B / (area density * gravity))^(1/3), B: the smaller bending rigidity of warp and weft;
     * 0: B or gravity is 0. Source: Peirce 1930. */
    double bending_length;
} tulle_fineness;
/* Gives the fineness of a cloth. All zero before the start, for null and for a stale id. */
TULLE_API tulle_fineness tulle_cloth_get_fineness(const tulle_world *world, tulle_cloth_id id);

/* Gives the numerical damping of the world's integrator, without the damping of materials: the
 * damping ratio (1: critical) of a free motion with this `period` [s], solved in steps of
 * `time_step` [s]. For implicit Euler it is about pi time_step / period. 0 if `world` is null or
 * one of the two is not finite and > 0. */
TULLE_API double tulle_world_get_numerical_damping(const tulle_world *world, double time_step,
                                                   double period);

/* Which patches to give. A zeroed struct asks for patches of the present shape. */
typedef struct tulle_patch_options {
    double time_step; /* [s] length of the coming step, 0 .. 1; 0: patches of the present shape */
    double max_angle; /* [rad] alpha_max, > 0 and < pi/2; 0: pi/3 */
    /* 1: the patches that the last step used, whatever the other options say; none before the first
     * step and for methods without patches */
    int is_in_use;
} tulle_patch_options;
/* Finds the patches of a cloth: triangles connected over edges whose normals all stay within
 * max_angle of one axis, while each vertex moves for time_step with its present velocity. Detection
 * skips the pairs within one patch if it also finds a certificate for it (is_in_use); only cones
 * are tested here.
 *
 * `labels` gets a number for each triangle: 1 .. `*patch_count`, or 0 for an isolated triangle,
 * whose own normal turns too far. The world must have started; it does not change. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, not started, options),
 * TULLE_ERROR_OUT_OF_MEMORY.
 *
 * Based on: Wong & Baciu 2005, 3.1 to 3.3, the (zeta, alpha, I)-surfaces.   */
TULLE_API tulle_status tulle_cloth_get_patches(tulle_world *world, tulle_cloth_id id,
                                               const tulle_patch_options *options, uint32_t *labels,
                                               size_t *patch_count, tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
