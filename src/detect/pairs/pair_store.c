/* detect/pairs/pair_store.c - see pair_store.h.
 *
 * Sorting: chunks of keys are spread over buckets by their highest bits. Then each bucket is sorted
 * in cache. All keys differ, so the order does not depend on who wrote which block. */
#include "detect/pairs/pair_store.h"

#include "base/parallel.h"
#include "base/sort.h"

#include <string.h>

enum {
    SORT_CHUNK = 16 * KEY_BLOCK, /* keys, some 30 microseconds */
    MOST_BUCKETS = 1024,         /* counters stay in the first cache level */
    WANTED_KEYS = 256,           /* in a bucket, so that it stays there too */
    BUCKETS_PER_TASK = 16
};

void pair_store_prepare(pair_store *store, size_t first_count, size_t second_count) {
    size_t const counts[2] = {first_count, second_count};
    unsigned bits[2] = {1, 1}; /* that hold all numbers below each count */
    for (int k = 0; k < 2; k++)
        while (bits[k] < 32 && counts[k] > (size_t)1 << bits[k]) bits[k]++;
    store->shift = bits[1];
    store->key_bits = bits[0] + bits[1];
}

size_t pair_store_copy(const pair_store *store, feature_pair *pairs) {
    size_t const key_count = atomic_load(&store->block_count) * KEY_BLOCK;
    uint64_t const mask = ((uint64_t)1 << store->shift) - 1;
    size_t count = 0;
    for (size_t i = 0; i < key_count; i++) {
        uint64_t const key = store->keys.data[i];
        pairs[count] = (feature_pair){(uint32_t)(key >> store->shift), (uint32_t)(key & mask)};
        count += key != KEY_NONE;
    }
    return count;
}

typedef struct sort_context {
    pair_store *store;
    feature_pair *pairs;
    unsigned bucket_shift; /* bits below those that choose the bucket */
    size_t bucket_count;
    uint32_t *bucket_begin; /* bucket_count + 1: places in `spare` */
    uint32_t *chunk_counts; /* bucket_count for each chunk: keys, then places in `spare` */
} sort_context;

static void count_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    const sort_context *const sort = context;
    const uint64_t *const keys = sort->store->keys.data;
    uint32_t *const counts = sort->chunk_counts + chunk * sort->bucket_count;
    memset(counts, 0, sort->bucket_count * sizeof *counts);
    for (size_t i = begin; i < end; i++)
        if (keys[i] != KEY_NONE) counts[keys[i] >> sort->bucket_shift]++;
}

static void scatter_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    const sort_context *const sort = context;
    const uint64_t *const keys = sort->store->keys.data;
    uint32_t *const places = sort->chunk_counts + chunk * sort->bucket_count;
    for (size_t i = begin; i < end; i++)
        if (keys[i] != KEY_NONE)
            sort->store->spare.data[places[keys[i] >> sort->bucket_shift]++] = keys[i];
}

static void sort_buckets(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const sort_context *const sort = context;
    pair_store *const store = sort->store;
    uint64_t const mask = ((uint64_t)1 << store->shift) - 1;
    for (size_t b = begin; b < end; b++) {
        size_t const first = sort->bucket_begin[b], count = sort->bucket_begin[b + 1] - first;
        const uint64_t *const keys =
            sort_keys(store->spare.data + first, store->keys.data + first, count);
        for (size_t i = 0; i < count; i++)
            sort->pairs[first + i] =
                (feature_pair){(uint32_t)(keys[i] >> store->shift), (uint32_t)(keys[i] & mask)};
    }
}

tulle_status pair_store_sort(pair_store *store, memory *heap, int threads, feature_pair *pairs,
                             size_t *count) {
    size_t const capacity = store->keys.capacity;
    size_t const most_chunks = parallel_chunk_count(capacity, SORT_CHUNK);
    if (!ARRAY_RESERVE(heap, &store->spare, capacity) ||
        !ARRAY_RESERVE(heap, &store->counts, (most_chunks + 1) * MOST_BUCKETS + 1))
        return TULLE_ERROR_OUT_OF_MEMORY;

    /* Count the keys of each bucket in each chunk. */
    size_t const key_count = atomic_load(&store->block_count) * KEY_BLOCK;
    size_t const chunk_count = parallel_chunk_count(key_count, SORT_CHUNK);
    unsigned bits = 0;
    while (bits < store->key_bits && (size_t)1 << bits < MOST_BUCKETS &&
           key_count >> bits > WANTED_KEYS)
        bits++;
    sort_context sort = {.store = store,
                         .pairs = pairs,
                         .bucket_shift = store->key_bits - bits,
                         .bucket_count = (size_t)1 << bits,
                         .bucket_begin = store->counts.data,
                         .chunk_counts = store->counts.data + MOST_BUCKETS + 1};
    parallel_for(key_count, SORT_CHUNK, threads, count_chunk, &sort);

    /* Counts become places: buckets in order, in each the chunks in order. */
    uint32_t at = 0;
    for (size_t b = 0; b < sort.bucket_count; b++) {
        sort.bucket_begin[b] = at;
        for (size_t chunk = 0; chunk < chunk_count; chunk++) {
            uint32_t *const place = &sort.chunk_counts[chunk * sort.bucket_count + b];
            uint32_t const chunk_keys = *place;
            *place = at;
            at += chunk_keys;
        }
    }
    sort.bucket_begin[sort.bucket_count] = at;
    *count = at;
    if (at == 0) return TULLE_OK; /* without a key there may be no buffer of keys */

    parallel_for(key_count, SORT_CHUNK, threads, scatter_chunk, &sort);
    parallel_for(sort.bucket_count, BUCKETS_PER_TASK, threads, sort_buckets, &sort);
    return TULLE_OK;
}
