/* support/exact_ccd.h - rational oracles for moving feature pairs (GMP): every double is taken as
 * the number that it is. Not thread-safe. */
#ifndef TULLE_TEST_EXACT_CCD_H
#define TULLE_TEST_EXACT_CCD_H

#include "detect/impact/time_of_impact.h"

/* Do the closed features share a point at some t in [0, t_end], t_end <= 1? */
bool exact_pair_touches(feature_kind kind, const moving_pair *pair, double t_end);

/* Is their distance at time t more than `separation` >= 0? */
bool exact_pair_is_farther(feature_kind kind, const moving_pair *pair, double t, double separation);

#endif
