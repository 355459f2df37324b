/* contact/pairs/sort_pairs.c - see sort_pairs.h. Keys are spread over about as many buckets as
 * there are keys, by ranges of their first features, then each bucket is sorted. All keys differ,
 * so the order depends on nothing else. */
#include "contact/pairs/sort_pairs.h"

#include "base/parallel.h"
#include "base/sort.h"

enum { BUCKET_CHUNK = 4096 /* buckets; some 40 microseconds */ };

typedef struct pair_buckets {
    feature_pair *pairs; /* sorted: the keys of all buckets */
    uint64_t *keys;      /* first << 32 | second */
    uint64_t *spare;     /* as many */
    uint32_t *ends;      /* of each bucket, in `keys` */
} pair_buckets;

static uint64_t make_key(feature_pair pair) { return (uint64_t)pair.first << 32 | pair.second; }

static void sort_buckets(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const pair_buckets *const buckets = context;
    size_t const first = begin > 0 ? buckets->ends[begin - 1] : 0;
    for (size_t b = begin, from = first; b < end; from = buckets->ends[b++]) {
        size_t const count = buckets->ends[b] - from;
        const uint64_t *const sorted =
            sort_keys(buckets->keys + from, buckets->spare + from, count);
        for (size_t i = 0; i < count; i++)
            buckets->pairs[from + i] =
                (feature_pair){(uint32_t)(sorted[i] >> 32), (uint32_t)sorted[i]};
    }
}

tulle_status sort_pairs(arena *scratch, int threads, feature_pair *pairs, size_t count,
                        size_t first_count) {
    bool is_sorted = true;
    for (size_t i = 1; i < count && is_sorted; i++)
        is_sorted = make_key(pairs[i - 1]) <= make_key(pairs[i]);
    if (is_sorted) return TULLE_OK;
    arena_mark const mark = arena_get_mark(scratch);
    unsigned shift = 0; /* a bucket is of 2^shift first features */
    while (first_count >> shift > count) shift++;
    size_t const bucket_count = (first_count >> shift) + 1;
    pair_buckets buckets = {.pairs = pairs,
                            .keys = ARENA_NEW(scratch, uint64_t, count),
                            .spare = ARENA_NEW(scratch, uint64_t, count),
                            .ends = ARENA_NEW_ZEROED(scratch, uint32_t, bucket_count)};
    bool const has_room = buckets.keys && buckets.spare && buckets.ends;
    if (has_room) {
        /* keys go to their buckets: `ends` counts, then says where the next key goes */
        uint32_t *const places = buckets.ends;
        for (size_t i = 0; i < count; i++) places[pairs[i].first >> shift]++;
        uint32_t begin = 0;
        for (size_t b = 0; b < bucket_count; b++) {
            uint32_t const bucket_size = places[b];
            places[b] = begin;
            begin += bucket_size;
        }
        for (size_t i = 0; i < count; i++)
            buckets.keys[places[pairs[i].first >> shift]++] = make_key(pairs[i]);
        parallel_for(bucket_count, BUCKET_CHUNK, threads, sort_buckets, &buckets);
    }
    arena_release(scratch, mark);
    return has_room ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
