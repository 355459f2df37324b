/* contact/pairs/path_test.h - which candidate pairs do not keep their minimum gap along x0 -> x1.
 */
#ifndef TULLE_CONTACT_PAIRS_PATH_TEST_H
#define TULLE_CONTACT_PAIRS_PATH_TEST_H

#include "contact/pairs/contact_paths.h"
#include "contact/pairs/pair_scan.h"

/* Finds those of the source's pairs that are not proven to keep their minimum gap, with a time that
 * is safe. The events stay in the scene's scratch arena until the caller releases its mark.
 * has_changed (vertex_count, may be null): pairs without a marked vertex are skipped. The source's
 * pairs must cover the paths (ensure_pairs_cover). */
tulle_status find_hits(const contact_scene *scene, const pair_source *source, const double *x1,
                       const bool *has_changed, pair_events *hits);

/* The nearest of the pairs that are nearer than `limit` [m] at x1; of equally near ones the first
 * by (kind, first, second). */
typedef struct smallest_gap {
    double distance; /* [m] INFINITY when no pair is nearer than the limit */
    feature_kind kind;
    feature_pair pair;
} smallest_gap;
tulle_status find_smallest_gap(const contact_scene *scene, const pair_source *source,
                               const double *x1, double limit, smallest_gap *result);

#endif
