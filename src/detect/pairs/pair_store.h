/* detect/pairs/pair_store.h - a set of pairs that many workers write and that comes out sorted.
 * Pairs are packed into keys, first << shift | second. Each worker fills blocks of its own in one
 * shared array; when the array is full it goes on counting, so that the caller can make room and
 * repeat.
 */
#ifndef TULLE_DETECT_PAIRS_PAIR_STORE_H
#define TULLE_DETECT_PAIRS_PAIR_STORE_H

#include "detect/surface_set.h"

#include <stdatomic.h>

#define KEY_NONE UINT64_MAX /* fills the ends of blocks */

enum { KEY_BLOCK = 1024 }; /* keys */

typedef struct pair_store {
    ARRAY(uint64_t) keys;       /* count is unused; capacity a multiple of KEY_BLOCK */
    ARRAY(uint64_t) spare;      /* for sorting */
    ARRAY(uint32_t) counts;     /* for sorting */
    _Atomic size_t block_count; /* claimed, also beyond the capacity */
    unsigned shift, key_bits;
} pair_store;

typedef struct pair_writer {
    pair_store *store;
    uint64_t *cursor, *end;
    unsigned shift;           /* of the store */
    uint64_t lost[KEY_BLOCK]; /* written to once the store is full */
} pair_writer;

/* Keys of pairs (first < first_count, second < second_count). */
void pair_store_prepare(pair_store *store, size_t first_count, size_t second_count);
void pair_store_free(memory *heap, pair_store *store);
/* Empties the store. */
void pair_store_clear(pair_store *store);
/* True when all that `writer_count` writers wrote is there, and would be whichever of them writes
 * what; else makes room for it, and more, for a repeat. *status tells whether that worked. */
bool pair_store_is_complete(memory *heap, pair_store *store, int writer_count,
                            tulle_status *status);

void pair_writer_start(pair_writer *writer, pair_store *store);
/* Ends this block and begins another. */
void pair_writer_claim(pair_writer *writer);
void pair_writer_finish(pair_writer *writer);
/* How many pairs can be written in a row, at least 1. Blocks are filled to their ends, so the
 * number of them depends on the number of pairs, and by at most one a writer on who writes what. */
static inline size_t pair_writer_make_room(pair_writer *writer) {
    if (writer->cursor == writer->end) pair_writer_claim(writer);
    return (size_t)(writer->end - writer->cursor);
}
/* There must be room. */
static inline void pair_writer_add(pair_writer *writer, uint32_t first, uint32_t second) {
    *writer->cursor++ = (uint64_t)first << writer->shift | second;
}

/* Copies the pairs into `pairs`, which has room for all blocks, in an order that depends on who
 * wrote what; returns their number. */
size_t pair_store_copy(const pair_store *store, feature_pair *pairs);
/* Makes room for sorting; false when memory is short. */
bool pair_store_reserve_sorting(memory *heap, pair_store *store);
/* Sorts by (first, second) into `pairs`, which has room for all blocks; returns their number. */
size_t pair_store_sort(pair_store *store, int threads, feature_pair *pairs);

#endif
