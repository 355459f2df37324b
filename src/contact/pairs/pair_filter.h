/* contact/pairs/pair_filter.h - the cheapest test of candidate pairs, eight at a time.
 *
 * Let d be a fixed direction towards the first feature. Let the gap g(t) be the smallest extent of
 * the first feature along d less the largest of the second. No two points of the features are
 * nearer than g(t) / |d|. If g(0) > s0 |d|, the pair starts farther apart than s0. If also g(1) >
 * s1 |d| and s1 <= s0, it stays farther apart than s1 for all t, because gaps between corners along
 * a fixed direction are linear in t. Both distances include the rounding slack
 * (compute_rounding_slack), which covers the error of g.
 *
 * Two directions at the start of the step are tried: from the middle of the second feature to that
 * of the first, and the common normal of both. The middle of a large triangle says little about
 * small features on it; there its normal is decisive. */
#ifndef TULLE_CONTACT_PAIRS_PAIR_FILTER_H
#define TULLE_CONTACT_PAIRS_PAIR_FILTER_H

#include "contact/contact_types.h"
#include "detect/impact/pair_batch.h"
#include "math/kernel_target.h"

typedef struct pair_filter {
    const topology *topo;
    const vertex_record *records; /* of all vertices, see make_records */
    double at_start, at_end;      /* [m] s0 and s1, with rounding slack */
} pair_filter;

/* Copies the pairs that this does not prove apart, in their order; returns how many. `kept` has
 * room for `count`. */
TULLE_DECLARE_KERNEL(size_t, filter_pairs,
                     (const pair_filter *filter, feature_kind kind, const feature_pair *pairs,
                      size_t count, feature_pair *kept))

/* Measures of pairs, an entry each. */
typedef struct pair_measures {
    double *distances; /* [m] the same bits as by closest_of_pair */
    bool *is_at_end;   /* of two edges: a closest point is an end of an edge; a weight of
                          closest_of_pair is under RIM_WEIGHT */
} pair_measures;

/* Measures pairs at the start of the records, where positions are finite. */
TULLE_DECLARE_KERNEL(void, measure_distances,
                     (const topology *topo, const vertex_record *records, feature_kind kind,
                      const feature_pair *pairs, size_t count, const pair_measures *measures))

/* The paths start -> end of all vertices of the scene in its scratch arena; null when memory is
 * short. */
const vertex_record *make_records(const contact_scene *scene, const double *start,
                                  const double *end);

#endif
