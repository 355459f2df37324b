/* detect/pairs/pair_store.h - a set of pairs that many workers write and that comes out sorted.
 *
 * Pairs are packed into keys, first << shift | second. Each writer fills blocks of its own in one
 * shared array. When the array is full, writers write to `lost` and continue counting blocks, so
 * that the caller can make room and repeat. Blocks are filled to their ends, so their number
 * depends on the number of pairs. Who writes what changes it by at most one a writer. */
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
    uint64_t *cursor, *end;   /* of the block that is being filled */
    unsigned shift;           /* of the store */
    uint64_t lost[KEY_BLOCK]; /* written to once the store is full */
} pair_writer;

/* Keys of pairs (first < first_count, second < second_count). */
void pair_store_prepare(pair_store *store, size_t first_count, size_t second_count);

/* Copies the pairs into `pairs`, which has room for all blocks, in an order that depends on who
 * wrote what; returns their number. */
size_t pair_store_copy(const pair_store *store, feature_pair *pairs);
/* Sorts by (first, second) into `pairs`, which has room for all blocks. *count: their number. */
tulle_status pair_store_sort(pair_store *store, memory *heap, int threads, feature_pair *pairs,
                             size_t *count);

#endif
