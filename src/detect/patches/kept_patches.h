/* detect/patches/kept_patches.h - patches that are proven not to touch themselves over a step, kept
 * from step to step (stage update_patches).
 *
 * In: surfaces, and the paths of their vertices over a step. Out: a label for each triangle.
 *
 * A patch is an edge-connected set of triangles. During the step in which it grew, the normals of
 * its triangles stayed within one cone of at most max_angle about its axis zeta; patches that were
 * merged into it later may lean farther. With has_certificate a patch is a topological disc, and it
 * is *certified* for each step in which it is used: all its normals stay within a right angle of
 * the axis, and the projection of its boundary along the axis stays simple. Then no two of its
 * features touch; certificate.h has the theorem. A certificate with a reach r > 0 holds for all
 * motions whose vertices differ from the given ones by at most r at any time, so all pairs within a
 * patch that share no vertex keep more than 2 r.
 *
 * Patches never span surfaces. Labels are 1 .. label_count, PATCH_ISOLATED (0) for triangles
 * outside patches; a label may be unused. */
#ifndef TULLE_DETECT_PATCHES_KEPT_PATCHES_H
#define TULLE_DETECT_PATCHES_KEPT_PATCHES_H

#include "detect/patches/normal_cone.h"
#include "detect/patches/patch_labels.h"
#include "detect/patches/patches.h"
#include "detect/surface_set.h"

typedef struct patch_rules {
    cone_rule cone;
    double max_angle;     /* [rad] > 0, < pi/2 */
    bool has_certificate; /* false: every patch is used, by its cone alone, checked at each step; it
                             need not be a disc */
    bool grows_anew;      /* true: nothing is kept. Then, and without certificate, patches of any
                             size are used, and they are never switched off */
    double reach;         /* [m] >= 0 */
    bool keeps_all;       /* true: patches of any size are kept and never switched off, however
                             little they save; for tests on small meshes */
} patch_rules;

typedef struct patch_counts {
    uint64_t patch_count, triangle_count; /* in use after the call, and the triangles in them */
    uint64_t star_count, contour_count;   /* certified by which test */
    uint64_t kept_count;                  /* held again */
    uint64_t split_count, dissolved_count;
    uint64_t grown_triangle_count; /* triangles that growth looked at in this call */
} patch_counts;

/* What moves how: the paths x0 -> x1 [m] of all vertices of the set. */
typedef struct patch_step {
    const surface_set *set;
    const double *x0, *x1;
    int threads;
} patch_step;

typedef struct kept_patches kept_patches;

/* The topology of the set is kept by its address; it must not change or move. scratch is for
 * callers whose steady steps must make no heap call; it outlives the patches, or is null. With it
 * what growth alone needs comes from there, and patches keep the memory that they took. Without it
 * growth gives back all that the patches do not need. */
tulle_status kept_patches_create(memory *heap, const surface_set *set, arena *scratch,
                                 kept_patches **result);
void kept_patches_destroy(kept_patches *patches);

/* Checks kept patches again for a step, and splits or dissolves those that fail. From time to time
 * it grows patches where much is isolated; counts alone decide when. The first call grows. Surfaces
 * that cannot meet themselves, and absent ones, get no patches. Out of memory leaves no patches at
 * all, which is safe. */
tulle_status update_patches(kept_patches *patches, const patch_step *step, const patch_rules *rules,
                            patch_counts *counts);

/* Tells the next update what the search with the present patches cost: the pairs of leaves that it
 * visited, and how many of them any search without patches visits. The next update lets patches go
 * that save less than they cost; what they save pays for growth. */
void kept_patches_tell_search(kept_patches *patches, uint64_t pair_count, uint64_t near_count);

/* Whether all patches in use are certified for this step too; nothing that later calls depend on
 * changes. With has_certificate false only the cones are checked. */
bool patches_hold(const kept_patches *patches, const patch_step *step, const patch_rules *rules);

/* The array is that of the patches and changes with them. */
patch_labels kept_patches_get_labels(const kept_patches *patches);

/* Writes all that the next call depends on, as plain bytes, for checkpoints. Returns their number,
 * 0 when there is nothing. Where `bytes` is null it only counts them. */
size_t kept_patches_save(const kept_patches *patches, void *bytes);
/* Bytes that do not fit the topology leave no patches: TULLE_ERROR_INVALID_ARGUMENT. */
tulle_status kept_patches_load(kept_patches *patches, const void *bytes, size_t size);

#endif
