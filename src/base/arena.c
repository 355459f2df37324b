/* base/arena.c - see arena.h. A list of blocks, each at least twice the last. */
#include "base/arena.h"

#include <string.h>

enum { FIRST_BLOCK_BYTES = 1 << 16, ALIGNMENT = 64 };

struct arena_block {
    arena_block *next;
    size_t capacity, used; /* [bytes] of the payload */
    char *payload;
};

arena arena_make(memory *heap) { return (arena){.heap = heap}; }

void arena_destroy(arena *scratch) {
    for (arena_block *block = scratch->first; block;) {
        arena_block *const next = block->next;
        memory_release(scratch->heap, block->payload, block->capacity);
        memory_release(scratch->heap, block, sizeof *block);
        block = next;
    }
    scratch->first = scratch->current = NULL;
}

static arena_block *append_block(arena *scratch, size_t byte_count) {
    size_t capacity = scratch->current ? 2 * scratch->current->capacity : FIRST_BLOCK_BYTES;
    if (capacity < byte_count) capacity = byte_count;
    arena_block *const block = memory_allocate(scratch->heap, sizeof *block);
    if (!block) return NULL;
    block->payload = memory_allocate(scratch->heap, capacity);
    if (!block->payload) {
        memory_release(scratch->heap, block, sizeof *block);
        return NULL;
    }
    block->capacity = capacity;
    block->used = 0;
    block->next = scratch->current ? scratch->current->next : scratch->first;
    if (scratch->current)
        scratch->current->next = block;
    else
        scratch->first = block;
    return block;
}

void *arena_allocate(arena *scratch, size_t count, size_t size) {
    if (size != 0 && count > (SIZE_MAX / 2 - ALIGNMENT) / size) return NULL;
    size_t const byte_count = (count * size + ALIGNMENT - 1) & ~(size_t)(ALIGNMENT - 1);
    arena_block *block = scratch->current ? scratch->current : scratch->first;
    while (block && block->capacity - block->used < byte_count) {
        block = block->next;
        if (block) block->used = 0;
    }
    if (!block) {
        arena_block *last = scratch->current ? scratch->current : scratch->first;
        while (last && last->next) last = last->next;
        scratch->current = last;
        block = append_block(scratch, byte_count);
        if (!block) return NULL;
    }
    scratch->current = block;
    void *const pointer = block->payload + block->used;
    block->used += byte_count;
    return pointer;
}

void *arena_allocate_zeroed(arena *scratch, size_t count, size_t size) {
    void *const pointer = arena_allocate(scratch, count, size);
    if (pointer) memset(pointer, 0, count * size);
    return pointer;
}

arena_mark arena_get_mark(const arena *scratch) {
    return (arena_mark){scratch->current, scratch->current ? scratch->current->used : 0};
}

void arena_release(arena *scratch, arena_mark mark) {
    if (mark.block) {
        mark.block->used = mark.used;
        scratch->current = mark.block;
    } else {
        if (scratch->first) scratch->first->used = 0;
        scratch->current = NULL;
    }
}
