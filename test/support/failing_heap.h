/* test/support/failing_heap.h - a heap whose allocations fail from a given one on. */
#ifndef TULLE_TEST_SUPPORT_FAILING_HEAP_H
#define TULLE_TEST_SUPPORT_FAILING_HEAP_H

#include "base/memory.h"

#include <stdlib.h>

static inline void *failing_heap_allocate(void *context, size_t byte_count) {
    int *const left = context;
    return (*left)-- > 0 ? malloc(byte_count) : NULL;
}

static inline void failing_heap_release(void *context, void *pointer, size_t byte_count) {
    (void)context, (void)byte_count;
    free(pointer);
}

/* The first *left allocations succeed. */
static inline memory failing_heap_make(int *left) {
    return (memory){.allocator = {failing_heap_allocate, failing_heap_release, left, 0}};
}

#endif
