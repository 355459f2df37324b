/* support/failing_requests.h - requests for memory that fail, one at each place of the code.
 *
 * A failing heap reaches few of the places that must survive it: arrays grow by half, and an arena
 * hands out of blocks of 64 kB, so a small world seldom asks the heap. Here the requests to
 * base/memory.h and base/arena.h fail themselves, whether there is room or not. A place is a call
 * and the depth of the stack at it; so a call that is reached on two ways mostly counts twice. A
 * program of these is linked with --wrap: `tests_of_failing_requests` in test/CMakeLists.txt. */
#ifndef TULLE_TEST_FAILING_REQUESTS_H
#define TULLE_TEST_FAILING_REQUESTS_H

#include "tulle/base.h"

#include <stdbool.h>
#include <stddef.h>

/* A call of the library; it fills *error. What it fills in beside that is the test's. */
typedef tulle_status (*refused_call)(void *context, tulle_error *error);

/* Calls once, while the first request of a place that has not been refused before is refused. True
 * where the call went well. Else it must say that memory is short, and a request must have been
 * refused; the test fails otherwise. */
bool survives_refusal(const char *name, refused_call call, void *context);
/* Places that have been refused so far. */
size_t count_refused_places(void);

#endif
