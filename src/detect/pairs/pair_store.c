/* detect/pairs/pair_store.c - see pair_store.h. Sorting: keys are spread over buckets by their
 * highest bits, in chunks; then each bucket is sorted by a least significant digit radix sort in
 * cache. All keys differ, so the order does not depend on who wrote which block. */
#include "detect/pairs/pair_store.h"

#include "base/parallel.h"

#include <string.h>

enum {
    SPARE_BLOCKS = 16,           /* beyond what is needed */
    SORT_CHUNK = 16 * KEY_BLOCK, /* keys, some 30 microseconds */
    MOST_BUCKETS = 1024,         /* counters stay in the first cache level */
    WANTED_KEYS = 256,           /* in a bucket, so that it stays there too */
    BUCKETS_PER_TASK = 16,
    DIGIT_BITS = 8,
    DIGITS = 1 << DIGIT_BITS,
    INSERTION_MOST = 24 /* keys: fewer than this are faster sorted by insertion */
};

/* Bits that hold all numbers below count, at least 1. */
static unsigned count_bits(size_t count) {
    unsigned bits = 1;
    while (bits < 32 && count > (size_t)1 << bits) bits++;
    return bits;
}

void pair_store_prepare(pair_store *store, size_t first_count, size_t second_count) {
    store->shift = count_bits(second_count);
    store->key_bits = store->shift + count_bits(first_count);
}

void pair_store_free(memory *heap, pair_store *store) {
    ARRAY_FREE(heap, &store->keys);
    ARRAY_FREE(heap, &store->spare);
    ARRAY_FREE(heap, &store->counts);
}

void pair_store_clear(pair_store *store) { atomic_store(&store->block_count, 0); }

bool pair_store_is_complete(memory *heap, pair_store *store, int writer_count,
                            tulle_status *status) {
    /* another time each writer but one may leave a block unfinished that is full now */
    size_t const needed = atomic_load(&store->block_count) + (size_t)writer_count - 1;
    *status = TULLE_OK;
    if (needed * KEY_BLOCK <= store->keys.capacity) return true;
    size_t const room = needed + needed / 4 + SPARE_BLOCKS;
    if (!ARRAY_RESERVE(heap, &store->keys, room * KEY_BLOCK)) *status = TULLE_ERROR_OUT_OF_MEMORY;
    return false;
}

void pair_writer_start(pair_writer *writer, pair_store *store) {
    writer->store = store;
    writer->cursor = writer->end = writer->lost;
    writer->shift = store->shift;
}

void pair_writer_finish(pair_writer *writer) {
    while (writer->cursor != writer->end) *writer->cursor++ = KEY_NONE;
}

void pair_writer_claim(pair_writer *writer) {
    pair_writer_finish(writer);
    pair_store *const store = writer->store;
    size_t const block = atomic_fetch_add_explicit(&store->block_count, 1, memory_order_relaxed);
    bool const fits = (block + 1) * KEY_BLOCK <= store->keys.capacity;
    writer->cursor = fits ? store->keys.data + block * KEY_BLOCK : writer->lost;
    writer->end = writer->cursor + KEY_BLOCK;
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

static size_t count_chunks(size_t key_count) { return parallel_chunk_count(key_count, SORT_CHUNK); }

bool pair_store_reserve_sorting(memory *heap, pair_store *store) {
    size_t const capacity = store->keys.capacity;
    return ARRAY_RESERVE(heap, &store->spare, capacity) &&
           ARRAY_RESERVE(heap, &store->counts, (count_chunks(capacity) + 1) * MOST_BUCKETS + 1);
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

/* Counts become places: buckets in order, in each the chunks in order. Returns the sum. */
static uint32_t place_chunks(sort_context *sort, size_t chunk_count) {
    uint32_t at = 0;
    for (size_t b = 0; b < sort->bucket_count; b++) {
        sort->bucket_begin[b] = at;
        for (size_t chunk = 0; chunk < chunk_count; chunk++) {
            uint32_t *const place = &sort->chunk_counts[chunk * sort->bucket_count + b];
            uint32_t const count = *place;
            *place = at;
            at += count;
        }
    }
    sort->bucket_begin[sort->bucket_count] = at;
    return at;
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

/* Sorts stably by one digit. */
static void sort_digit(const uint64_t *from, uint64_t *to, size_t count, unsigned shift) {
    uint32_t places[DIGITS] = {0};
    for (size_t i = 0; i < count; i++) places[from[i] >> shift & (DIGITS - 1)]++;
    uint32_t begin = 0;
    for (size_t d = 0; d < DIGITS; d++) {
        uint32_t const digit_count = places[d];
        places[d] = begin;
        begin += digit_count;
    }
    for (size_t i = 0; i < count; i++) to[places[from[i] >> shift & (DIGITS - 1)]++] = from[i];
}

static void sort_by_insertion(uint64_t *keys, size_t count) {
    for (size_t i = 1; i < count; i++) {
        uint64_t const key = keys[i];
        size_t at = i;
        for (; at > 0 && keys[at - 1] > key; at--) keys[at] = keys[at - 1];
        keys[at] = key;
    }
}

static void sort_buckets(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const sort_context *const sort = context;
    pair_store *const store = sort->store;
    uint64_t const mask = ((uint64_t)1 << store->shift) - 1;
    for (size_t b = begin; b < end; b++) {
        size_t const first = sort->bucket_begin[b], count = sort->bucket_begin[b + 1] - first;
        uint64_t *from = store->spare.data + first, *to = store->keys.data + first;
        if (count <= INSERTION_MOST) {
            sort_by_insertion(from, count);
        } else {
            for (unsigned done = 0; done < sort->bucket_shift; done += DIGIT_BITS) {
                sort_digit(from, to, count, done);
                uint64_t *const swapped = from;
                from = to;
                to = swapped;
            }
        }
        for (size_t i = 0; i < count; i++)
            sort->pairs[first + i] =
                (feature_pair){(uint32_t)(from[i] >> store->shift), (uint32_t)(from[i] & mask)};
    }
}

size_t pair_store_sort(pair_store *store, int threads, feature_pair *pairs) {
    size_t const key_count = atomic_load(&store->block_count) * KEY_BLOCK;
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
    size_t const pair_count = place_chunks(&sort, count_chunks(key_count));
    parallel_for(key_count, SORT_CHUNK, threads, scatter_chunk, &sort);
    parallel_for(sort.bucket_count, BUCKETS_PER_TASK, threads, sort_buckets, &sort);
    return pair_count;
}
