/* base/arena.c - see arena.h.
 *
 * The arena is a list of blocks. What does not fit into the rest of a block goes into the next one,
 * and that rest stays unused. So once all is released, one block takes the place of several, with
 * room for the most that was in use at once. */
#include "base/arena.h"

#include <string.h>

/* The address sanitizer by itself sees a block as one allocation. So it is told what is not handed
 * out, and there are bytes between what is. */
#ifdef __has_feature
#if __has_feature(address_sanitizer)
#define TULLE_HAS_ADDRESS_SANITIZER
#endif
#endif
#ifdef __SANITIZE_ADDRESS__
#define TULLE_HAS_ADDRESS_SANITIZER
#endif
#ifdef TULLE_HAS_ADDRESS_SANITIZER
#include <sanitizer/asan_interface.h>
enum { GAP = 64 };
#else
#define ASAN_POISON_MEMORY_REGION(place, size) ((void)(place), (void)(size))
#define ASAN_UNPOISON_MEMORY_REGION(place, size) ((void)(place), (void)(size))
enum { GAP = 0 };
#endif

enum {
    FIRST_BLOCK_BYTES = 1 << 16,
    GROWTH_SHARE = 16, /* a block has at least this share of the bytes of those before it */
    SPARE_SHARE = 16,  /* room beyond the most that was in use */
    ALIGNMENT = 64
};

struct arena_block {
    arena_block *next;
    size_t capacity, used; /* [bytes] of the payload */
    char *payload;
};

arena arena_make(memory *heap) { return (arena){.heap = heap}; }

/* Releases the blocks after the current one, which hold nothing. */
static void release_rest(arena *scratch) {
    arena_block **const link = scratch->current ? &scratch->current->next : &scratch->first;
    for (arena_block *block = *link; block;) {
        arena_block *const next = block->next;
        scratch->capacity -= block->capacity;
        ASAN_UNPOISON_MEMORY_REGION(block->payload, block->capacity);
        memory_release(scratch->heap, block->payload, block->capacity);
        memory_release(scratch->heap, block, sizeof *block);
        block = next;
    }
    *link = NULL;
}

void arena_destroy(arena *scratch) {
    scratch->current = NULL;
    release_rest(scratch);
    scratch->used = scratch->most_used = 0;
}

/* Adds a block after the current one, which is the last. */
static arena_block *append_block(arena *scratch, size_t capacity) {
    arena_block *const block = memory_allocate(scratch->heap, sizeof *block);
    if (!block) return NULL;
    block->payload = memory_allocate(scratch->heap, capacity);
    if (!block->payload) {
        memory_release(scratch->heap, block, sizeof *block);
        return NULL;
    }
    block->capacity = capacity;
    block->used = 0;
    block->next = NULL;
    if (scratch->current)
        scratch->current->next = block;
    else
        scratch->first = block;
    scratch->capacity += capacity;
    ASAN_POISON_MEMORY_REGION(block->payload, capacity);
    return block;
}

void arena_reserve(arena *scratch, size_t byte_count) {
    if (scratch->used > 0 || (scratch->first && scratch->first->capacity >= byte_count)) return;
    scratch->current = NULL;
    release_rest(scratch);
    (void)append_block(scratch, byte_count);
}

void *arena_allocate(arena *scratch, size_t count, size_t size) {
    if (size != 0 && count > (SIZE_MAX / 2 - ALIGNMENT - GAP) / size) return NULL;
    size_t const byte_count = ((count * size + ALIGNMENT - 1) & ~(size_t)(ALIGNMENT - 1)) + GAP;
    arena_block *block = scratch->current ? scratch->current : scratch->first;
    while (block && block->capacity - block->used < byte_count) {
        block = block->next;
        if (block) block->used = 0;
    }
    if (!block) {
        release_rest(scratch); /* all too short */
        size_t capacity = scratch->capacity / GROWTH_SHARE;
        if (capacity < FIRST_BLOCK_BYTES) capacity = FIRST_BLOCK_BYTES;
        block = append_block(scratch, capacity < byte_count ? byte_count : capacity);
        if (!block) return NULL;
    }
    scratch->current = block;
    void *const pointer = block->payload + block->used;
    ASAN_UNPOISON_MEMORY_REGION(pointer, count * size);
    block->used += byte_count;
    scratch->used += byte_count;
    if (scratch->used > scratch->most_used) scratch->most_used = scratch->used;
    return pointer;
}

void *arena_allocate_zeroed(arena *scratch, size_t count, size_t size) {
    void *const pointer = arena_allocate(scratch, count, size);
    if (pointer) memset(pointer, 0, count * size);
    return pointer;
}

size_t arena_get_room(const arena *scratch) {
    const arena_block *const block = scratch->current ? scratch->current : scratch->first;
    return block ? block->capacity - block->used : 0;
}

arena_mark arena_get_mark(const arena *scratch) {
    return (arena_mark){scratch->current, scratch->current ? scratch->current->used : 0,
                        scratch->used};
}

void arena_release(arena *scratch, arena_mark mark) {
    scratch->used = mark.all_used;
    scratch->current = mark.block;
    for (arena_block *block = mark.block ? mark.block : scratch->first; block;
         block = block->next) {
        size_t const kept = block == mark.block ? mark.used : 0;
        ASAN_POISON_MEMORY_REGION(block->payload + kept, block->capacity - kept);
    }
    if (mark.block) {
        mark.block->used = mark.used;
        return;
    }
    if (!scratch->first) return;
    scratch->first->used = 0;
    if (!scratch->first->next) return;
    /* One block takes the place of several. Where memory is short there is none; the next call
     * makes some. */
    release_rest(scratch);
    (void)append_block(scratch, scratch->most_used + scratch->most_used / SPARE_SHARE);
}
