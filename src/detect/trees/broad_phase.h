/* detect/trees/broad_phase.h - stages 6 and 7: trees over swept triangle boxes and the feature
 * pairs whose swept boxes meet.
 *
 * Candidates are all pairs (vertex, triangle) with the vertex not a corner of it, and (edge, edge)
 * without a shared vertex, whose boxes over the whole step, each widened by half the margin and
 * outward against rounding, meet; among surfaces that may collide. All methods give the same list,
 * but for pairs within patches and, where straight paths are followed, pairs that these keep apart.
 */
#ifndef TULLE_DETECT_TREES_BROAD_PHASE_H
#define TULLE_DETECT_TREES_BROAD_PHASE_H

#include "base/arena.h"
#include "base/stop.h"
#include "detect/impact/pair_batch.h"
#include "detect/patches/patch_labels.h"
#include "detect/surface_set.h"

typedef enum broad_phase_method {
    BROAD_PHASE_REFIT, /* static trees, refitted; skips what lies within one patch when given labels
                        */
    BROAD_PHASE_BVOX,  /* backward-voxel trees, built anew; takes no labels */
    BROAD_PHASE_PAPER  /* one backward-voxel tree a patch and one of the isolated triangles of each
                          surface, under a root; takes labels */
} broad_phase_method;

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
/* Patches whose inner pairs may be left out in the next searches. Pairs within a patch are left out
 * where that is cheap (whole nodes), not everywhere. Call before build_trees, which reads them;
 * zeroed: no patches. Borrowed until the next call. */
void broad_phase_set_patches(broad_phase *broad, patch_labels patches);
/* Asked during searches, which then end with TULLE_ERROR_INTERRUPTED; null, as at first: never. */
void broad_phase_set_stop(broad_phase *broad, stop_poll *stop);

/* From the next build_trees on, pairs that the straight paths x0 -> x1 keep farther apart than the
 * margin, along one axis or diagonal, may be left out of searches where that is cheap, though their
 * boxes meet: always, or only where paths are long and neighbours go together. For refitted trees;
 * others leave out none. */
typedef enum path_following { PATHS_IN_BOXES, PATHS_WHERE_LONG, PATHS_ALWAYS } path_following;
void broad_phase_follow_paths(broad_phase *broad, path_following how);
/* Whether such pairs are left out, which all paths may meet that end elsewhere in their boxes. */
bool broad_phase_is_straight(const broad_phase *broad);
/* For users of find_pairs alone: without the positions in pair_tables, which are null from then on.
 * Boxes of vertices are in the arena from each build_trees on; find_pairs is to be called before
 * that is released. */
void broad_phase_use_scratch(broad_phase *broad, arena *scratch);

typedef struct search_counts {
    uint64_t leaf_pair_count, candidate_count;
    uint64_t near_pair_count; /* pairs of leaves that a search without patches visits at least: of
                                 surfaces that meet themselves, a leaf with itself or a neighbour */
} search_counts;
/* Stage 7, streaming: every candidate goes to `consume` once, in batches, from `threads` workers in
 * one parallel loop; what remains in their batches at the end comes from the calling thread. counts
 * may be null. Out of memory comes before the first batch only; TULLE_ERROR_INVALID_ARGUMENT where
 * the last build_trees failed. */
tulle_status search_pairs(broad_phase *broad, const surface_set *set, int threads,
                          pair_consumer consume, void *context, search_counts *counts);
/* The tables of the last build_trees. */
const pair_tables *broad_phase_get_tables(const broad_phase *broad);

/* Stage 7 as a list, over the boxes of the last build_trees. Replaces the contents of `pairs`
 * (whose arrays live on `heap` of the broad phase). counts may be null. Out of memory leaves the
 * list empty and returns the error; TULLE_ERROR_INVALID_ARGUMENT where the last build_trees failed.
 */
tulle_status find_pairs(broad_phase *broad, const surface_set *set, int threads, pair_list *pairs,
                        search_counts *counts);
/* The same in an order that may depend on the threads, which takes less time. */
tulle_status find_unsorted_pairs(broad_phase *broad, const surface_set *set, int threads,
                                 pair_list *pairs, search_counts *counts);

#endif
