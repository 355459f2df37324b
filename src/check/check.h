/* check/check.h - the judge over a given heap. */
#ifndef TULLE_CHECK_CHECK_H
#define TULLE_CHECK_CHECK_H

#include "base/memory.h"
#include "tulle/check.h"

/* tulle_check_intersections with memory from `heap`; result->pairs is released there too, as
 * pair_count * sizeof(tulle_check_pair) bytes. More than pair_limit intersecting pairs are refused
 * with TULLE_ERROR_LIMIT. */
tulle_status check_intersections(memory *heap, const tulle_check_body *bodies, size_t body_count,
                                 int threads, size_t pair_limit, tulle_check_result *result,
                                 tulle_error *error);

#endif
