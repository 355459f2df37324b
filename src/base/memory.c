/* base/memory.c - see memory.h. Each block carries a 64-byte header in front that keeps what the
 * allocator gave. */
#define _DEFAULT_SOURCE /* madvise */
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

enum {
    BLOCK_ALIGNMENT = 64,     /* [bytes] a cache line, and the widest vector */
    FEWEST_ELEMENTS = 16,     /* of an array that grows, */
    FEWEST_BYTES_MOST = 4096, /* [bytes] unless they take more than this */
    TRIM_SHARE = 16,      /* room for less than this share of the elements is not worth a copy */
    LARGE_BLOCK = 2 << 20 /* [bytes] a large page */
};

memory memory_default(void) { return (memory){0}; }

void *memory_allocate_default(size_t byte_count) {
    void *const raw = malloc(byte_count);
#ifdef MADV_HUGEPAGE
    if (!raw || byte_count < LARGE_BLOCK) return raw;
    uintptr_t const mask = ~((uintptr_t)sysconf(_SC_PAGESIZE) - 1);
    uintptr_t const begin = (uintptr_t)raw & mask, end = ((uintptr_t)raw + byte_count) & mask;
    (void)madvise((void *)begin, end - begin, MADV_HUGEPAGE); /* without them all goes on */
#endif
    return raw;
}

void *memory_allocate(memory *heap, size_t byte_count) {
    if (byte_count > SIZE_MAX / 2) return NULL;
    size_t const total = byte_count + 2 * BLOCK_ALIGNMENT;
    size_t const limit = heap->allocator.byte_limit;
    if (limit != 0 && (total > limit || heap->bytes_held > limit - total)) return NULL;
    void *const raw = heap->allocator.allocate
                          ? heap->allocator.allocate(heap->allocator.context, total)
                          : memory_allocate_default(total);
    if (!raw) return NULL;
    uintptr_t const aligned =
        ((uintptr_t)raw + 2 * BLOCK_ALIGNMENT - 1) & ~(uintptr_t)(BLOCK_ALIGNMENT - 1);
    uintptr_t const start =
        aligned - (uintptr_t)raw >= sizeof(void *) ? aligned : aligned + BLOCK_ALIGNMENT;
    memcpy((char *)start - sizeof(void *), &raw, sizeof(void *));
    heap->bytes_held += total;
    heap->allocate_count++;
    return (void *)start;
}

void *memory_allocate_zeroed(memory *heap, size_t count, size_t size) {
    if (size != 0 && count > SIZE_MAX / 2 / size) return NULL;
    void *const pointer = memory_allocate(heap, count * size);
    if (pointer) memset(pointer, 0, count * size);
    return pointer;
}

void memory_release(memory *heap, void *pointer, size_t byte_count) {
    if (!pointer) return;
    void *raw;
    memcpy(&raw, (char *)pointer - sizeof(void *), sizeof(void *));
    size_t const total = byte_count + 2 * BLOCK_ALIGNMENT;
    heap->bytes_held -= total;
    if (heap->allocator.release)
        heap->allocator.release(heap->allocator.context, raw, total);
    else
        free(raw);
}

/* Moves an array to new memory for `wanted` elements. False when memory is short. */
static bool move_array(memory *heap, void **data, size_t *capacity, size_t count, size_t wanted,
                       size_t element_size) {
    if (wanted > SIZE_MAX / 2 / element_size) return false;
    void *moved = NULL;
    if (wanted > 0) {
        moved = memory_allocate(heap, wanted * element_size);
        if (!moved) return false;
    }
    if (count > 0) memcpy(moved, *data, count * element_size);
    memory_release(heap, *data, *capacity * element_size);
    *data = moved;
    *capacity = wanted;
    return true;
}

bool array_reserve(memory *heap, void **data, size_t *capacity, size_t count, size_t needed,
                   size_t element_size) {
    if (needed <= *capacity && *data) return true;
    size_t wanted = *capacity + *capacity / 2;
    if (wanted < needed) wanted = needed;
    if (wanted < FEWEST_ELEMENTS && element_size <= FEWEST_BYTES_MOST / FEWEST_ELEMENTS)
        wanted = FEWEST_ELEMENTS;
    return move_array(heap, data, capacity, count, wanted, element_size);
}

void array_trim(memory *heap, void **data, size_t *capacity, size_t count, size_t element_size) {
    if (*capacity - count <= count / TRIM_SHARE) return;
    (void)move_array(heap, data, capacity, count, count, element_size);
}

bool array_match(memory *heap, void **data, size_t *capacity, size_t count, size_t wanted,
                 size_t element_size) {
    return *capacity >= wanted || move_array(heap, data, capacity, count, wanted, element_size);
}
