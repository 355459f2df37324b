/* support/struck_calls.h - calls for memory and to the system that fail, one at each place of the
 * code.
 *
 * A failing heap reaches few of the places that must survive it: arrays grow by half, and an arena
 * hands out of blocks of 64 kB, so a small world seldom asks the heap. Here the requests to
 * base/memory.h and base/arena.h fail themselves, whether there is room or not. So do calls to the
 * system that read and write files. A place is a call and the depth of the stack at it; so a call
 * that is reached on two ways mostly counts twice. A program of these is linked with --wrap:
 * `tests_of_struck_calls` in test/CMakeLists.txt. */
#ifndef TULLE_TEST_STRUCK_CALLS_H
#define TULLE_TEST_STRUCK_CALLS_H

#include "tulle/base.h"

#include <stdbool.h>
#include <stddef.h>

typedef enum strike {
    STRIKE_MEMORY,    /* a request for memory is refused */
    STRIKE_SYSTEM,    /* a call to the system fails with EIO */
    STRIKE_INTERRUPT, /* a call that reads or writes is interrupted: EINTR */
    STRIKE_SHORTEN,   /* a call that reads or writes does so for one byte */
    STRIKE_COUNT,
    STRIKE_NOTHING = STRIKE_COUNT
} strike;

/* A call of the library; it fills *error. What it gives beside that is the test's to judge. */
typedef tulle_status (*struck_call)(void *context, tulle_error *error);

/* Calls once. Meanwhile the first call of this kind is struck at whose place none has been before;
 * *is_struck tells whether there was one. Gives the status, where it is as it must be, else the
 * test fails:
 * - Memory: the status and the message say that memory is short.
 * - System: an input-output error with the system's own words for it; or all went well, but not
 *   after calls that write, flush, rename or make folders.
 * - Calls that are interrupted or short change nothing. */
tulle_status call_struck(const char *name, strike kind, struck_call call, void *context,
                         bool *is_struck);
/* Places that have been struck so far. */
size_t count_struck_places(void);

#endif
