/* base/memory.h - the heap of one world: the user's allocator with a byte limit, 64-byte alignment
 * and a count of calls. Not thread-safe: only the thread that owns the world allocates; workers use
 * arrays prepared before the parallel region. */
#ifndef TULLE_BASE_MEMORY_H
#define TULLE_BASE_MEMORY_H

#include "tulle/base.h"

#include <stdbool.h>

typedef struct memory {
    tulle_allocator allocator; /* of both functions or none: malloc and free */
    size_t bytes_held;         /* [bytes] now */
    uint64_t allocate_count;   /* heap calls so far; a steady step makes none */
} memory;

/* Whether an allocator has both functions, or none. */
static inline bool allocator_is_whole(const tulle_allocator *allocator) {
    return !allocator->allocate == !allocator->release;
}
/* A memory over malloc and free without a limit: all zero. */
memory memory_default(void);
/* As malloc; to be released with free. Asks Linux for large pages for blocks of 2 MiB and more: a
 * product with a large matrix reads from more places at a time than a processor keeps small pages
 * at hand. */
void *memory_allocate_default(size_t byte_count);

/* 64-byte aligned, uninitialised; null when the allocator fails or the limit would be passed.
 * byte_count 0 is fine. */
void *memory_allocate(memory *heap, size_t byte_count);
/* count * size with overflow check, zeroed. */
void *memory_allocate_zeroed(memory *heap, size_t count, size_t size);
/* Releases what memory_allocate gave, of the same size; null is fine. */
void memory_release(memory *heap, void *pointer, size_t byte_count);

/* Grows *data, an array of *capacity elements of element_size bytes of which `count` are in use, to
 * hold `needed`. Grows by half at least. False when memory is short: the array is then as before.
 */
bool array_reserve(memory *heap, void **data, size_t *capacity, size_t count, size_t needed,
                   size_t element_size);
/* Moves an array to memory of its own size if it has much more room than its `count` elements
 * need, and if there is memory for the copy. */
void array_trim(memory *heap, void **data, size_t *capacity, size_t count, size_t element_size);
/* Gives an array room for `wanted` elements and no more; false when memory is short. */
bool array_match(memory *heap, void **data, size_t *capacity, size_t count, size_t wanted,
                 size_t element_size);

/* A typed growable array; zeroed is empty. */
#define ARRAY(type)                                                                                \
    struct {                                                                                       \
        type *data;                                                                                \
        size_t count, capacity;                                                                    \
    }
/* Makes room for `extra` more elements; false when memory is short. */
#define ARRAY_RESERVE(heap, array, extra)                                                          \
    array_reserve((heap), (void **)&(array)->data, &(array)->capacity, (array)->count,             \
                  (array)->count + (extra), sizeof *(array)->data)
/* Gives two arrays that are swapped with each other the room of the larger one. False when
 * memory is short. */
#define ARRAY_MATCH(heap, one, other)                                                              \
    (array_match((heap), (void **)&(one)->data, &(one)->capacity, (one)->count, (other)->capacity, \
                 sizeof *(one)->data) &&                                                           \
     array_match((heap), (void **)&(other)->data, &(other)->capacity, (other)->count,              \
                 (one)->capacity, sizeof *(other)->data))
#define ARRAY_TRIM(heap, array)                                                                    \
    array_trim((heap), (void **)&(array)->data, &(array)->capacity, (array)->count,                \
               sizeof *(array)->data)
#define ARRAY_FREE(heap, array)                                                                    \
    (memory_release((heap), (array)->data, (array)->capacity * sizeof *(array)->data),             \
     (array)->data = NULL, (array)->count = (array)->capacity = 0)

#endif
