/* app/fit/search.h - which value of one unknown gives a measure that was found on a real fabric,
 * where the measure can be simulated, takes long and is somewhat noisy. */
#ifndef TULLE_APP_FIT_SEARCH_H
#define TULLE_APP_FIT_SEARCH_H

#include "tulle/base.h"

#include <stdbool.h>
#include <stddef.h>

/* The measure at a value of the unknown: mean of several samples, how far they lie apart. */
typedef struct search_point {
    double unknown;         /* > 0 */
    double mean, deviation; /* the standard deviation of one sample; 0 of a single one */
    double least, most;
} search_point;

/* Measures at `count` values of the unknown, which are set. */
typedef tulle_status (*search_measure)(void *context, search_point *points, size_t count,
                                       tulle_error *error);

enum { SEARCH_FIRST_MAX = 5, SEARCH_POINTS_MAX = 16 };

typedef struct search_goal {
    double measure, error;          /* what was found, and what it may be off */
    double least, most;             /* range of the unknown */
    double first[SEARCH_FIRST_MAX]; /* values to begin with, ascending, within the range */
    size_t first_count;             /* at least 2 */
    size_t samples;                 /* that a point is the mean of */
} search_goal;

typedef enum search_verdict {
    SEARCH_FOUND,
    SEARCH_VAGUE,    /* values within the error differ tenfold or reach the end of the range */
    SEARCH_TOO_LOW,  /* the measure of the goal is below all */
    SEARCH_TOO_HIGH, /* and above all */
} search_verdict;

typedef struct search_result {
    search_verdict verdict;
    double unknown; /* where the measure is that of the goal, or nearest to it */
    /* Values whose measure lies within the error. An open end is one of the range. */
    double low, high;
    bool is_low_open, is_high_open;
    double error;                           /* that of the goal with that of a point's mean */
    double slope;                           /* of the measure by the unknown's logarithm, there */
    search_point points[SEARCH_POINTS_MAX]; /* ascending */
    size_t point_count;
} search_result;

/* Begins with the first values, goes on beyond them until the goal lies between two points or the
 * range ends, then divides that gap up to twice. At most SEARCH_POINTS_MAX points are measured. The
 * curve between points is straight over the logarithm of the unknown. Errors: those of measure. */
tulle_status search_find(const search_goal *goal, search_measure measure, void *context,
                         search_result *result, tulle_error *error);

#endif
