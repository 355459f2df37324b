/* support/alarm_count.h - what a detector reports of one motion beside what truly touches: every
 * pair of features whose boxes meet, judged in rational arithmetic. */
#ifndef TULLE_TEST_ALARM_COUNT_H
#define TULLE_TEST_ALARM_COUNT_H

#include "tulle/detect.h"

/* Pairs of features; in this order most are among those before. */
typedef struct alarm_counts {
    uint64_t candidates;   /* boxes over the motion meet */
    uint64_t coplanar;     /* of these not shown apart by the coplanarity filter */
    uint64_t filtered;     /* of these not shown apart by an axis or the direction at the start */
    uint64_t tested;       /* of these not shown apart by the direction at the end: all that pass
                              the filters */
    uint64_t events;       /* reported, in any state */
    uint64_t touching;     /* candidates that truly touch at some time, ends included */
    uint64_t false_alarms; /* events of pairs that do not touch */
    uint64_t missed;       /* candidates that touch and are not reported */
} alarm_counts;

/* Adds the counts of the motion from start to end, of the surfaces of `def`; its method does not
 * matter. Truth knows no separation: where `def` has one, what comes near without touching counts
 * as a false alarm. On an error *counts is as it was. */
tulle_status alarm_count_add(const tulle_detect_def *def, const double *start, const double *end,
                             alarm_counts *counts, tulle_error *error);

/* False alarms among the pairs that pass the filters, in percent; 0 without any. */
double alarm_count_share(const alarm_counts *counts);

#endif
