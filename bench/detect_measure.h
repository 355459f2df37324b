/* bench/detect_measure.h - times passes of several detectors over one input, turn by turn, so that
 * their ratios do not depend on what else the machine does. */
#ifndef TULLE_BENCH_DETECT_MEASURE_H
#define TULLE_BENCH_DETECT_MEASURE_H

#include "detect_input.h"

enum { RUNS_MAX = 16, ROUNDS_MAX = 201 };

typedef enum stage {
    STAGE_PATCHES,
    STAGE_TREES,
    STAGE_TRAVERSAL, /* parts of the joint search, as the detector shares it out */
    STAGE_FILTERS,
    STAGE_IMPACT,
    STAGE_SEARCH,
    STAGE_EVENTS,
    STAGE_TOTAL,
    STAGE_PROCESSOR, /* processor time of all threads; the others are wall clock */
    STAGE_COUNT
} stage;
extern const char *const stage_names[STAGE_COUNT];

/* [s] */
typedef struct spread {
    double median, least, ninth_decile;
} spread;

/* One detector; `name`, `def`'s method, cone, max_angle, has_certificate, threads are given. */
typedef struct measured_run {
    const char *name;
    tulle_detect_def def;
    int keeps_all; /* patches are kept however little they save */
    /* what comes out */
    tulle_status status;            /* UNSUPPORTED: the method is not there */
    tulle_detect_statistics counts; /* of the last pass */
    size_t event_count;
    double first_seconds; /* the first pass, which shapes trees and grows patches */
    size_t bytes_held;    /* by the detector, after the last pass */
    spread times[STAGE_COUNT];
    /* Where passes are of different steps, means of a pass: of all of it, and of its patches and
     * its search without trees and events; else 0. */
    double mean_seconds, mean_part_seconds;
} measured_run;

/* A detector of the run's def for the input, and a pass of it over step 0 or 1; where either fails
 * the program ends with a message. */
tulle_detector *make_detector(const detect_input *input, measured_run *run);
tulle_detect_result find_step(const detect_input *input, tulle_detector *detector, int step);

/* rounds measured passes of each, each after a pass over the step before. */
void measure_runs(const detect_input *input, measured_run *runs, size_t count, int rounds);

/* Sorts. */
spread spread_of(double *values, size_t count);
const char *method_name(tulle_detect_method method);

#endif
