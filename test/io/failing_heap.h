/* A malloc for one test program that counts, and fails at a chosen call. Sanitizers bring their
 * own, and then HAS_OWN_HEAP is 0 and nothing fails. Include in one file of the program only. */
#ifndef TULLE_TEST_FAILING_HEAP_H
#define TULLE_TEST_FAILING_HEAP_H

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && defined(__GLIBC__)
#define HAS_OWN_HEAP 1
void *__libc_malloc(size_t byte_count);
static bool heap_is_watched;
static size_t heap_largest;        /* [bytes] largest block asked for */
static long heap_calls, heap_fail; /* calls so far; the call that fails, or -1 */

void *malloc(size_t byte_count) {
    if (heap_is_watched) {
        if (byte_count > heap_largest) heap_largest = byte_count;
        if (heap_calls++ == heap_fail) {
            errno = ENOMEM;
            return NULL;
        }
    }
    return __libc_malloc(byte_count);
}
#else
#define HAS_OWN_HEAP 0
static bool heap_is_watched;
static size_t heap_largest;
static long heap_calls, heap_fail;
#endif

static inline void watch_heap(long fail) {
    heap_largest = 0;
    heap_calls = 0;
    heap_fail = fail;
    heap_is_watched = true;
}

/* Whether the chosen call has come and failed. */
static inline bool unwatch_heap(void) {
    heap_is_watched = false;
    return heap_calls > heap_fail;
}

#endif
