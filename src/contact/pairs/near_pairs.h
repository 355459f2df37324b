/* contact/pairs/near_pairs.h - pairs that start near each other: along short paths no other pair
 * can come together, so the tests look at these alone. */
#ifndef TULLE_CONTACT_PAIRS_NEAR_PAIRS_H
#define TULLE_CONTACT_PAIRS_NEAR_PAIRS_H

#include "contact/pairs/contact_paths.h"
#include "contact/pairs/pair_scan.h"

/* Replaces `list` (its array lives on scene->heap) by the near pairs of a scan. */
tulle_status note_near_pairs(const contact_scene *scene, const pair_events *found,
                             near_pair_list *list);

/* Those of the source's pairs that may come nearer than `limit` [m] along x0 -> x1, and others: all
 * of vertices that go far, and where most do, all. In the scene's scratch arena, or the source's
 * own; not to be changed. */
tulle_status pick_pairs(const contact_scene *scene, const pair_source *source, const double *x1,
                        double limit, pair_list *picked);

/* Those that may be the nearest pair at x1. *limit [m] becomes a smaller one where a pair among
 * them, which is not ignored, is known to be under it. */
tulle_status pick_pairs_for_nearest(const contact_scene *scene, const pair_source *source,
                                    const double *x1, double *limit, pair_list *picked);

#endif
