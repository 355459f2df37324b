/* detect/pair_store.c - see pair_store.h. Sorting: least significant digit radix sort. */
#include "detect/pair_store.h"

#include <string.h>

enum {
    DIGIT_BITS_MOST = 11, /* counters of one digit stay in the first cache level */
    DIGIT_COUNT_MOST = 6, /* 62 bits */
    SPARE_BLOCKS = 16     /* blocks that workers leave unfinished differ from run to run */
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
}

void pair_store_clear(pair_store *store) { atomic_store(&store->block_count, 0); }

bool pair_store_is_complete(memory *heap, pair_store *store, tulle_status *status) {
    size_t const needed = atomic_load(&store->block_count);
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

bool pair_store_reserve_spare(memory *heap, pair_store *store) {
    return ARRAY_RESERVE(heap, &store->spare, store->keys.capacity);
}

/* Counts all digits of all keys at once; returns the number of keys that are pairs. */
static size_t count_digits(const uint64_t *keys, size_t key_count, unsigned digit_bits,
                           unsigned digit_count,
                           uint32_t counts[DIGIT_COUNT_MOST][1 << DIGIT_BITS_MOST]) {
    uint64_t const mask = ((uint64_t)1 << digit_bits) - 1;
    memset(counts, 0, digit_count * sizeof counts[0]);
    size_t pair_count = 0;
    for (size_t i = 0; i < key_count; i++) {
        if (keys[i] == KEY_NONE) continue;
        pair_count++;
        for (unsigned d = 0; d < digit_count; d++) counts[d][keys[i] >> (d * digit_bits) & mask]++;
    }
    return pair_count;
}

/* Sorts stably by one digit. */
static void sort_digit(const uint64_t *keys, size_t key_count, unsigned digit_shift,
                       unsigned digit_bits, uint32_t *counts, uint64_t *sorted) {
    uint64_t const mask = ((uint64_t)1 << digit_bits) - 1;
    uint32_t begin = 0;
    for (size_t d = 0; d <= mask; d++) {
        uint32_t const count = counts[d];
        counts[d] = begin;
        begin += count;
    }
    for (size_t i = 0; i < key_count; i++)
        if (keys[i] != KEY_NONE) sorted[counts[keys[i] >> digit_shift & mask]++] = keys[i];
}

size_t pair_store_sort(pair_store *store, feature_pair *pairs) {
    uint32_t counts[DIGIT_COUNT_MOST][1 << DIGIT_BITS_MOST];
    unsigned const digit_count = (store->key_bits + DIGIT_BITS_MOST - 1) / DIGIT_BITS_MOST;
    unsigned const digit_bits = (store->key_bits + digit_count - 1) / digit_count;
    size_t const key_count = atomic_load(&store->block_count) * KEY_BLOCK;
    uint64_t *from = store->keys.data, *to = store->spare.data;
    size_t const pair_count = count_digits(from, key_count, digit_bits, digit_count, counts);
    for (unsigned d = 0; d < digit_count; d++) {
        sort_digit(from, d == 0 ? key_count : pair_count, d * digit_bits, digit_bits, counts[d],
                   to);
        uint64_t *const swapped = from;
        from = to;
        to = swapped;
    }
    uint64_t const mask = ((uint64_t)1 << store->shift) - 1;
    for (size_t i = 0; i < pair_count; i++)
        pairs[i] = (feature_pair){(uint32_t)(from[i] >> store->shift), (uint32_t)(from[i] & mask)};
    return pair_count;
}
