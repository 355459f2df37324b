/* app/fit/drape_test.h - simulated drape tests: a material in, its drape coefficient out. */
#ifndef TULLE_APP_FIT_DRAPE_TEST_H
#define TULLE_APP_FIT_DRAPE_TEST_H

#include "app/fit/drape_sample.h"

typedef struct drape_test {
    tulle_material material;
    drape_pattern pattern;
    double cell; /* [m] length of the mesh's edges */
    uint32_t seed;
    /* What came of it. */
    double coefficient; /* [%] */
    int folds;
    bool is_at_rest; /* false: it still moved after 6 s */
} drape_test;

/* Runs the tests, some at once, each on one thread; what comes of each does not depend on the
 * number of threads. A pending interrupt ends them with TULLE_ERROR_INTERRUPTED. The error is that
 * of the first test that has one. */
tulle_status drape_test_run(drape_test *tests, size_t count, int threads, tulle_error *error);

#endif
