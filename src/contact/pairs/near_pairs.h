/* contact/pairs/near_pairs.h - pairs that start near each other. Along short paths no other pair
 * can come together, so the tests of paths look at these alone. */
#ifndef TULLE_CONTACT_PAIRS_NEAR_PAIRS_H
#define TULLE_CONTACT_PAIRS_NEAR_PAIRS_H

#include "contact/pairs/contact_paths.h"
#include "contact/pairs/pair_scan.h"

/* Replaces the contents of `list` by the near pairs of a scan. Its array lives on scene->heap. */
tulle_status note_near_pairs(const contact_scene *scene, const pair_events *found,
                             near_pair_list *list);

/* Picks the source's pairs that may come nearer than `limit` [m] along x0 -> x1. It may pick others
 * too: where some vertices go far, all pairs of these; where most do, all pairs. *picked lies in
 * the scene's scratch arena, or is the source's own list; it must not be changed. */
tulle_status pick_pairs(const contact_scene *scene, const pair_source *source, const double *x1,
                        double limit, pair_list *picked);

#endif
