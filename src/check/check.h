/* check/check.h - the judge over a given heap. */
#ifndef TULLE_CHECK_CHECK_H
#define TULLE_CHECK_CHECK_H

#include "base/memory.h"
#include "tulle/check.h"

typedef struct check_settings {
    memory *heap;      /* all memory, also that of result->pairs */
    int threads;       /* as in tulle_check_intersections */
    size_t pair_limit; /* more intersecting pairs are refused with TULLE_ERROR_LIMIT */
    size_t test_limit; /* more pairs whose boxes overlap are refused with TULLE_ERROR_LIMIT */
} check_settings;

/* tulle_check_intersections with settings. result->pairs is released to the same heap, as
 * pair_count * sizeof(tulle_check_pair) bytes. */
tulle_status check_intersections(const check_settings *settings, const tulle_check_body *bodies,
                                 size_t body_count, tulle_check_result *result, tulle_error *error);

#endif
