/* Pairs come out sorted, each once, for numbers of any size, few pairs or many, and any number of
 * threads. */
#include "detect/pairs/pair_store.h"

#include "base/hash.h"
#include "support/test_support.h"

#include <stdlib.h>

enum { MOST_BLOCKS = 20 };

static int compare_pairs(const void *a, const void *b) {
    const feature_pair *const x = a, *const y = b;
    if (x->first != y->first) return x->first < y->first ? -1 : 1;
    return (x->second > y->second) - (x->second < y->second);
}

/* So many blocks, the last of which is filled by half; all pairs differ, or nearly all. */
static void check_sort(size_t first_count, size_t second_count, size_t block_count, int threads) {
    memory heap = memory_default();
    pair_store store = {0};
    size_t const room = block_count * KEY_BLOCK, count = room - KEY_BLOCK / 2;
    feature_pair *const expected = calloc(room, sizeof *expected);
    feature_pair *const sorted = calloc(room, sizeof *sorted);
    assert_true(expected && sorted && ARRAY_RESERVE(&heap, &store.keys, room));
    pair_store_prepare(&store, first_count, second_count);
    uint64_t seed = first_count + second_count;
    for (size_t i = 0; i < count; i++) {
        /* numbers from both ends of what there is */
        uint64_t const first = random_next(&seed) % first_count;
        uint64_t const second = random_next(&seed) % second_count;
        expected[i] = (feature_pair){(uint32_t)first, (uint32_t)second};
        store.keys.data[i] = first << store.shift | second;
    }
    for (size_t i = count; i < room; i++) store.keys.data[i] = KEY_NONE;
    for (size_t i = room; i < store.keys.capacity; i++) store.keys.data[i] = 0; /* of no block */
    atomic_store(&store.block_count, block_count);
    qsort(expected, count, sizeof *expected, compare_pairs);
    size_t found = 0;
    assert_int_equal(pair_store_copy(&store, sorted), count);
    assert_int_equal(pair_store_sort(&store, &heap, threads, sorted, &found), TULLE_OK);
    assert_int_equal(found, count);
    assert_memory_equal(sorted, expected, count * sizeof *expected);
    ARRAY_FREE(&heap, &store.keys);
    ARRAY_FREE(&heap, &store.spare);
    ARRAY_FREE(&heap, &store.counts);
    assert_int_equal(heap.bytes_held, 0);
    free(expected);
    free(sorted);
}

static void pairs_come_out_sorted(void **state) {
    (void)state;
    static const size_t counts[][2] = {{1000, 900},       {1, 50000},
                                       {50000, 1},        {UINT32_MAX, 70000},
                                       {300, UINT32_MAX}, {UINT32_MAX, UINT32_MAX}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        for (size_t blocks = 1; blocks <= MOST_BLOCKS; blocks += i % 2 ? 3 : 19)
            for (int threads = 1; threads < 4; threads++)
                check_sort(counts[i][0], counts[i][1], blocks, threads);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(pairs_come_out_sorted)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
