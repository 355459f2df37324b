/* support/exact_approach.h - whether and when a moving pair comes within a separation, proven in
 * rational arithmetic. */
#ifndef TULLE_TEST_EXACT_APPROACH_H
#define TULLE_TEST_EXACT_APPROACH_H

#include "detect/impact/time_of_impact.h"

typedef enum approach_verdict {
    APPROACH_APART, /* the distance exceeds the separation at all times */
    APPROACH_OPEN,  /* it comes so near to it that the search did not decide; never without one */
    APPROACH_NEAR   /* it is at most the separation at some time */
} approach_verdict;

typedef struct approach {
    approach_verdict verdict;
    double from; /* the distance exceeds the separation at all times before this one */
    double by;   /* NEAR: at this time, or for separation 0 at the latest then, it does not */
} approach;

/* Searches until times differ by 2^-depth; 0 for the verdict alone where there is no separation. */
approach find_approach(feature_kind kind, const moving_pair *pair, double separation, int depth);

#endif
