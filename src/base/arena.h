/* base/arena.h - scratch memory of one step: allocate forward, release back to a mark.
 *
 * When all is released one block stays for the next step, so a steady step makes no heap call.
 * An arena is not thread-safe: each worker has its own, or arrays are allocated before the
 * parallel region. */
#ifndef TULLE_BASE_ARENA_H
#define TULLE_BASE_ARENA_H

#include "base/memory.h"

typedef struct arena_block arena_block;
typedef struct arena {
    memory *heap;
    arena_block *first, *current;
    size_t capacity;        /* [bytes] of all blocks */
    size_t used, most_used; /* [bytes] handed out now, and at most so far */
} arena;
typedef struct arena_mark {
    arena_block *block;
    size_t used, all_used; /* [bytes] of the block, of the arena */
} arena_mark;

arena arena_make(memory *heap);
void arena_destroy(arena *scratch);
/* 64-byte aligned, uninitialised, null when memory is short. */
void *arena_allocate(arena *scratch, size_t count, size_t size);
void *arena_allocate_zeroed(arena *scratch, size_t count, size_t size);
/* Gives an empty arena one block of at least so many bytes, if there is memory for it, so that
 * later allocations need not be spread over smaller blocks. */
void arena_reserve(arena *scratch, size_t byte_count);
/* [bytes] that the current block can still hand out. */
size_t arena_get_room(const arena *scratch);
arena_mark arena_get_mark(const arena *scratch);
void arena_release(arena *scratch, arena_mark mark);
/* Typed: ARENA_NEW(scratch, double, n). */
#define ARENA_NEW(scratch, type, count) ((type *)arena_allocate((scratch), (count), sizeof(type)))
#define ARENA_NEW_ZEROED(scratch, type, count)                                                     \
    ((type *)arena_allocate_zeroed((scratch), (count), sizeof(type)))

#endif
