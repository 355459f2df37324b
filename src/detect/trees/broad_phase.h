/* detect/trees/broad_phase.h - trees over the boxes that moving triangles sweep, and the feature
 * pairs whose boxes meet (stages build_trees and find_pairs).
 *
 * In: surfaces, and the straight paths of their vertices over a step. Out: candidates. A candidate
 * is a vertex and a triangle, or two edges, that share no vertex, belong to surfaces that may meet,
 * and whose boxes meet. The box of a feature holds its paths, widened by half the margin, and
 * outward against rounding.
 *
 * All methods give the same candidates, with two exceptions: pairs within a patch may be left out,
 * and so may pairs that straight paths keep apart. */
#ifndef TULLE_DETECT_TREES_BROAD_PHASE_H
#define TULLE_DETECT_TREES_BROAD_PHASE_H

#include "base/arena.h"
#include "base/stop.h"
#include "detect/impact/pair_batch.h"
#include "detect/patches/patch_labels.h"
#include "detect/surface_set.h"

typedef enum broad_phase_method {
    BROAD_PHASE_REFIT, /* static trees, refitted; skips pairs within one patch if it has labels
                        */
    BROAD_PHASE_BVOX,  /* backward-voxel trees, built each time; takes no labels */
    BROAD_PHASE_PAPER  /* one backward-voxel tree a patch and one of the isolated triangles of each
                          surface, under a root; takes labels */
} broad_phase_method;

typedef struct broad_phase broad_phase; /* trees, kept between steps */

/* rest: 3 * vertex_count positions from which static trees are shaped. */
tulle_status broad_phase_create(memory *heap, const surface_set *set, const double *rest,
                                broad_phase_method method, broad_phase **result);
void broad_phase_destroy(broad_phase *broad);

/* Fits boxes of all triangles to the paths x0 -> x1 (3 * vertex_count each), widened by
 * margin / 2 [m], and builds their trees. TULLE_ERROR_INVALID_ARGUMENT when a position or the
 * margin is not finite. */
tulle_status build_trees(broad_phase *broad, const surface_set *set, const double *x0,
                         const double *x1, double margin, int threads);
/* Patches whose inner pairs the next searches may leave out. They do so where that is cheap (whole
 * nodes), not everywhere. Call this before build_trees, which reads the patches; zeroed: no
 * patches. Borrowed until the next call. */
void broad_phase_set_patches(broad_phase *broad, patch_labels patches);
/* Gives back the memory of the boxes of features, which the next build_trees makes again if it
 * needs them. */
void broad_phase_release_blocks(broad_phase *broad);
/* Searches may leave out pairs whose boxes meet but whose straight paths x0 -> x1 stay farther
 * apart than the margin along one axis or diagonal. They do so where that is cheap: always, or only
 * where paths are long and neighbours move together. Only refitted trees leave out such pairs. */
typedef enum path_following { PATHS_IN_BOXES, PATHS_WHERE_LONG, PATHS_ALWAYS } path_following;

typedef struct broad_phase_options {
    path_following following;
    stop_poll *stop; /* Searches ask it, and end with TULLE_ERROR_INTERRUPTED when a stop is wanted.
                        Null: they ask nothing. */
    uint64_t most_candidates; /* find_pairs ends with TULLE_ERROR_LIMIT where there are more,
                                 whoever counts them; 0: any number */
    arena *scratch; /* For callers of find_pairs alone. Records and points in pair_tables are then
                       null, and each build_trees puts the boxes of vertices into the arena, which
                       must not be released before find_pairs. Null: they stay where they are. */
} broad_phase_options;
/* The options hold from the next build_trees on. Before the first call all of them are zero. */
void broad_phase_configure(broad_phase *broad, broad_phase_options options);

/* Whether pairs that straight paths keep apart are left out. The candidates then hold for the
 * straight paths alone, not for other paths within the boxes. */
bool broad_phase_is_straight(const broad_phase *broad);

typedef struct search_counts {
    uint64_t leaf_pair_count, candidate_count;
    uint64_t near_pair_count; /* pairs of leaves that any search without patches visits: of surfaces
                                 that meet themselves, a leaf with itself or with a neighbour */
} search_counts;
/* Hands every candidate to `consume` once, in batches. `threads` workers of one parallel loop call
 * it; at the end the calling thread hands over the rest of their batches. counts may be null.
 * TULLE_ERROR_OUT_OF_MEMORY comes before the first batch only; TULLE_ERROR_INVALID_ARGUMENT where
 * the last build_trees failed. */
tulle_status search_pairs(broad_phase *broad, const surface_set *set, int threads,
                          pair_consumer consume, void *context, search_counts *counts);
/* The triangles of all surfaces in the order of tree_shape.h; null for methods that have another.
 */
const uint32_t *broad_phase_get_order(const broad_phase *broad);
/* The tables of the last build_trees. */
const pair_tables *broad_phase_get_tables(const broad_phase *broad);

/* Unsorted lists take less time; their order may depend on the threads. */
typedef enum pair_order { PAIRS_SORTED, PAIRS_UNSORTED } pair_order;
/* Lists all candidates by the boxes of the last build_trees. Replaces the contents of `pairs`,
 * whose arrays live on the heap of the broad phase. counts may be null. Out of memory leaves the
 * list empty and returns the error, as do more candidates than the options allow,
 * TULLE_ERROR_LIMIT, which take no memory; TULLE_ERROR_INVALID_ARGUMENT where the last build_trees
 * failed. */
tulle_status find_pairs(broad_phase *broad, const surface_set *set, int threads, pair_order order,
                        pair_list *pairs, search_counts *counts);

#endif
