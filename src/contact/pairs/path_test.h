/* contact/pairs/path_test.h - which candidate pairs do not keep their minimum gap along x0 -> x1.
 */
#ifndef TULLE_CONTACT_PAIRS_PATH_TEST_H
#define TULLE_CONTACT_PAIRS_PATH_TEST_H

#include "contact/pairs/contact_paths.h"
#include "contact/pairs/pair_scan.h"

/* Events of all of the source's pairs that are not proven to keep their minimum gap, with a time
 * that is safe, in the scene's scratch arena until the caller releases its mark. has_changed
 * (vertex_count, may be null): pairs none of whose vertices has a mark are skipped. The source's
 * pairs must cover the paths (ensure_pairs_cover). */
tulle_status find_hits(const contact_scene *scene, const pair_source *source, const double *x1,
                       const bool *has_changed, pair_events *hits);

/* The smallest distance at x1 over all pairs, of which those under `limit` [m] are looked at. */
typedef struct smallest_gap {
    double distance; /* [m] INFINITY when no pair is nearer than the limit */
    feature_kind kind;
    feature_pair pair;
} smallest_gap;
tulle_status find_smallest_gap(const contact_scene *scene, const pair_source *source,
                               const double *x1, double limit, smallest_gap *result);

#endif
