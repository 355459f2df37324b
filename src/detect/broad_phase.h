/* detect/broad_phase.h - stages 6 and 7: trees over swept triangle boxes and the feature pairs
 * whose swept boxes meet.
 *
 * Candidates are all pairs (vertex, triangle) with the vertex not a corner of it, and (edge, edge)
 * without a shared vertex, whose boxes over the whole step, each widened by half the margin and
 * outward against rounding, meet; among surfaces that may collide. Both methods give the same list.
 */
#ifndef TULLE_DETECT_BROAD_PHASE_H
#define TULLE_DETECT_BROAD_PHASE_H

#include "detect/surface_set.h"

typedef enum broad_phase_method { BROAD_PHASE_REFIT, BROAD_PHASE_BVOX } broad_phase_method;

typedef struct broad_phase broad_phase; /* trees, kept between steps */

/* rest: 3 * vertex_count positions from which static trees are shaped. */
tulle_status broad_phase_create(memory *heap, const surface_set *set, const double *rest,
                                broad_phase_method method, broad_phase **result);
void broad_phase_destroy(broad_phase *broad);

/* Stage 6. Boxes of all triangles over the paths x0 -> x1 (3 * vertex_count each), widened by
 * margin / 2 [m], and their trees. TULLE_ERROR_INVALID_ARGUMENT when a position or the margin is
 * not finite. */
tulle_status build_trees(broad_phase *broad, const surface_set *set, const double *x0,
                         const double *x1, double margin, int threads);
/* Stage 7, over the boxes of the last build_trees. Replaces the contents of `pairs` (whose arrays
 * live on `heap` of the broad phase). box_pair_count: triangle pairs whose boxes met; may be null,
 * which saves the counting. Out of memory leaves the list empty and returns the error;
 * TULLE_ERROR_INVALID_ARGUMENT where the last build_trees failed. */
tulle_status find_pairs(broad_phase *broad, const surface_set *set, int threads, pair_list *pairs,
                        uint64_t *box_pair_count);

#endif
