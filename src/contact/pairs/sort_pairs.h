/* contact/pairs/sort_pairs.h - puts pairs into the order of lists. */
#ifndef TULLE_CONTACT_PAIRS_SORT_PAIRS_H
#define TULLE_CONTACT_PAIRS_SORT_PAIRS_H

#include "base/arena.h"
#include "detect/surface_set.h"

/* Sorts pairs, of which no two are equal, by (first, second); first < first_count. Fails only for
 * want of room in scratch. */
tulle_status sort_pairs(arena *scratch, int threads, feature_pair *pairs, size_t count,
                        size_t first_count);

#endif
