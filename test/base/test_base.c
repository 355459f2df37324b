/* Arena, arrays, memory limits, parallel_for, hash. */
#include "base/arena.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "base/sort.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void memory_limit_is_kept(void **state) {
    (void)state;
    memory heap = {.allocator = {.byte_limit = 4096}};
    void *const block = memory_allocate(&heap, 3000);
    assert_non_null(block);
    assert_int_equal((uintptr_t)block % 64, 0);
    assert_null(memory_allocate(&heap, 1200));
    memory_release(&heap, block, 3000);
    assert_int_equal(heap.bytes_held, 0);
    void *const again = memory_allocate(&heap, 1200);
    assert_non_null(again);
    memory_release(&heap, again, 1200);
}

static void array_grows_and_keeps_contents(void **state) {
    (void)state;
    memory heap = memory_default();
    ARRAY(uint32_t) numbers = {0};
    for (uint32_t i = 0; i < 10000; i++) {
        assert_true(ARRAY_RESERVE(&heap, &numbers, 1));
        numbers.data[numbers.count++] = i;
    }
    for (uint32_t i = 0; i < 10000; i++) assert_int_equal(numbers.data[i], i);
    assert_true(heap.allocate_count <= 17); /* 16 elements, then half more each time */
    ARRAY_FREE(&heap, &numbers);
    assert_int_equal(heap.bytes_held, 0);
}

static void matched_arrays_have_the_room_of_the_larger(void **state) {
    (void)state;
    memory heap = {.allocator = {.byte_limit = 4096}};
    ARRAY(uint32_t) one = {0}, other = {0};
    assert_true(ARRAY_RESERVE(&heap, &one, 100));
    assert_true(ARRAY_RESERVE(&heap, &other, 120));
    for (uint32_t i = 0; i < 7; i++) one.data[one.count++] = i;
    assert_true(ARRAY_MATCH(&heap, &one, &other));
    assert_int_equal(one.capacity, 120);
    assert_int_equal(other.capacity, 120);
    for (uint32_t i = 0; i < 7; i++) assert_int_equal(one.data[i], i);
    uint64_t const count = heap.allocate_count;
    assert_true(ARRAY_MATCH(&heap, &other, &one));
    assert_true(heap.allocate_count == count);
    assert_true(ARRAY_RESERVE(&heap, &other, 600));
    assert_false(ARRAY_MATCH(&heap, &one, &other)); /* the limit */
    assert_int_equal(one.capacity, 120);
    assert_int_equal(one.count, 7);
    ARRAY_FREE(&heap, &one);
    ARRAY_FREE(&heap, &other);
    assert_int_equal(heap.bytes_held, 0);
}

typedef struct sorted_item {
    uint32_t key, number;
} sorted_item;

static int compare_items(const void *a, const void *b) {
    uint32_t const x = ((const sorted_item *)a)->key, y = ((const sorted_item *)b)->key;
    return (x > y) - (x < y);
}

/* Lists of all lengths up to 100, keys that all differ, some equal, all equal, sorted, reversed. */
static void sorting_keeps_items_and_orders_keys(void **state) {
    (void)state;
    enum { MOST = 100 };
    sorted_item items[MOST];
    for (uint32_t count = 0; count <= MOST; count++)
        for (uint32_t kind = 0; kind < 5; kind++) {
            uint32_t const keys[] = {UINT32_MAX, 7, 1, 0, 0};
            for (uint32_t i = 0; i < count; i++) {
                uint32_t const key = kind == 3   ? i
                                     : kind == 4 ? count - i
                                                 : (uint32_t)hash_mix(i + 1) % keys[kind];
                items[i] = (sorted_item){key, i};
            }
            sorted_item before[MOST];
            memcpy(before, items, sizeof before);
            sort_in_place(items, count, sizeof *items, compare_items);
            bool is_seen[MOST] = {false};
            for (uint32_t i = 0; i < count; i++) {
                assert_true(i == 0 || items[i - 1].key <= items[i].key);
                assert_false(is_seen[items[i].number]);
                is_seen[items[i].number] = true;
                assert_int_equal(items[i].key, before[items[i].number].key);
            }
        }
}

static void numbers_are_sorted_upwards(void **state) {
    (void)state;
    double values[] = {0.5, -1e300, 3.0, -0.25, 3.0, 1e-300, 0.0};
    double const sorted[] = {-1e300, -0.25, 0.0, 1e-300, 0.5, 3.0, 3.0};
    sort_in_place(values, 7, sizeof *values, compare_doubles);
    assert_memory_equal(values, sorted, sizeof values);
    uint64_t keys[] = {UINT64_MAX, 1, 0, UINT64_MAX - 1, UINT64_C(1) << 63};
    uint64_t const ordered[] = {0, 1, UINT64_C(1) << 63, UINT64_MAX - 1, UINT64_MAX};
    sort_in_place(keys, 5, sizeof *keys, compare_u64);
    assert_memory_equal(keys, ordered, sizeof keys);
}

/* The result of sort_keys is what qsort makes of the same keys: counts around the limit of
 * insertion and large ones, keys that differ in no digit, in any one of them, in some and in all.
 */
static void keys_are_sorted_by_digits(void **state) {
    (void)state;
    enum { MOST = 3000 };
    static uint64_t keys[MOST], spare[MOST], expected[MOST];
    size_t const counts[] = {0, 1, 2, 23, 24, 25, 26, 100, MOST};
    uint64_t masks[13] = {0, 1, UINT64_MAX, UINT64_C(0xff00ff), UINT64_C(0xffffffff00000000)};
    for (unsigned digit = 0; digit < 8; digit++) masks[5 + digit] = UINT64_C(0xff) << 8 * digit;
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
        for (size_t m = 0; m < sizeof masks / sizeof *masks; m++)
            for (int order = 0; order < 3; order++) { /* as drawn, sorted, reversed */
                size_t const count = counts[c];
                uint64_t const common = hash_mix(m + 1) & ~masks[m]; /* what all keys have alike */
                for (size_t i = 0; i < count; i++)
                    expected[i] = common | (hash_mix(i + 100 * c + 1) & masks[m]);
                memcpy(keys, expected, sizeof keys);
                if (count > 0) qsort(expected, count, sizeof *expected, compare_u64);
                for (size_t i = 0; i < count && order > 0; i++)
                    keys[i] = expected[order == 1 ? i : count - 1 - i];
                const uint64_t *const sorted = sort_keys(keys, spare, count);
                assert_true(sorted == keys || sorted == spare);
                assert_memory_equal(sorted, expected, count * sizeof *expected);
            }
}

/* What does not fit into the end of a block leaves it unused, but not for good. */
static void an_empty_arena_is_one_block(void **state) {
    (void)state;
    enum { COUNT = 40, BYTES = 70000 };
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    for (int round = 0; round < 3; round++) {
        arena_mark const mark = arena_get_mark(&scratch);
        for (int i = 0; i < COUNT; i++) assert_non_null(arena_allocate(&scratch, 1, BYTES));
        arena_release(&scratch, mark);
        assert_true(heap.bytes_held < COUNT * BYTES * 11 / 10);
    }
    arena_destroy(&scratch);
    assert_int_equal(heap.bytes_held, 0);
}

static void a_reserved_arena_is_one_block(void **state) {
    (void)state;
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    arena_reserve(&scratch, 1000000);
    uint64_t const before = heap.allocate_count;
    for (int i = 0; i < 10; i++) assert_non_null(arena_allocate(&scratch, 1, 99000));
    arena_reserve(&scratch, 5000000); /* it is in use: stays as it is */
    assert_int_equal(heap.allocate_count, before);
    assert_true(heap.bytes_held < 1001000);
    arena_destroy(&scratch);
    assert_int_equal(heap.bytes_held, 0);
}

static void arena_reuses_its_blocks(void **state) {
    (void)state;
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    uint64_t steady_count = 0;
    for (int round = 0; round < 4; round++) {
        arena_mark const mark = arena_get_mark(&scratch);
        char *const a = arena_allocate(&scratch, 1, 50000);
        char *const b = arena_allocate(&scratch, 100, 5000);
        assert_true(a && b);
        memset(a, 1, 50000);
        memset(b, 2, 500000);
        assert_int_equal(a[49999], 1);
        arena_release(&scratch, mark);
        if (round == 0)
            steady_count = heap.allocate_count;
        else
            assert_int_equal(heap.allocate_count, steady_count);
    }
    uint64_t const before = heap.allocate_count;
    for (int i = 0; i < 10000; i++) assert_non_null(arena_allocate(&scratch, 1, 10000));
    assert_true(heap.allocate_count - before <= 2 * 100); /* a sixteenth more each; two calls */
    arena_destroy(&scratch);
    assert_int_equal(heap.bytes_held, 0);
}

static void add_squares(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    double *const sums = context;
    sums[chunk] = 0.0;
    for (size_t i = begin; i < end; i++) sums[chunk] += 1.0 / (double)(i + 1);
}

static void chunks_do_not_depend_on_threads(void **state) {
    (void)state;
    double one[64], many[64];
    parallel_for(1000, 17, 1, add_squares, one);
    for (int threads = 2; threads <= 8; threads++) {
        parallel_for(1000, 17, threads, add_squares, many);
        assert_memory_equal(one, many, parallel_chunk_count(1000, 17) * sizeof(double));
    }
}

static void hash_is_fixed_and_sensitive(void **state) {
    (void)state;
    static const char text[] = "the same bytes";
    uint64_t const a = hash_bytes(HASH_SEED, text, 14);
    assert_true(a == hash_bytes(HASH_SEED, "the same bytes", 14));
    assert_true(a != hash_bytes(HASH_SEED, "the same bytet", 14));
    /* in pieces of any lengths */
    for (size_t first = 0; first <= 14; first++) {
        for (size_t second = 0; first + second <= 14; second++) {
            hash_stream stream = hash_stream_make(HASH_SEED);
            hash_stream_add(&stream, text, first);
            hash_stream_add(&stream, text + first, second);
            hash_stream_add(&stream, text + first + second, 14 - first - second);
            assert_true(a == hash_stream_get(&stream));
        }
    }
    uint64_t seed = 1;
    assert_true(random_next(&seed) ==
                UINT64_C(0x910a2dec89025cc1)); /* SplitMix64's published first value for seed 1 */
}

/* As told in hash.c, one word after the other. */
static uint64_t hash_block_slowly(const unsigned char *bytes, size_t count) {
    uint64_t lanes[4];
    for (uint64_t i = 0; i < 4; i++) lanes[i] = hash_mix(HASH_SEED + i);
    for (size_t place = 0; place < 4 * (count / 32 + 1); place++) {
        uint64_t word = 0;
        for (size_t k = 0; k < 8 && 8 * place + k < count; k++)
            word |= (uint64_t)bytes[8 * place + k] << 8 * k;
        uint64_t *const lane = &lanes[place % 4];
        *lane = (*lane ^ word) * UINT64_C(0x9e3779b97f4a7c15);
        *lane ^= *lane >> 32;
    }
    uint64_t hash = hash_mix(count);
    for (int i = 0; i < 4; i++) hash = hash_mix(hash ^ lanes[i]);
    return hash;
}

static void hash_of_a_block_sees_each_bit_and_the_length(void **state) {
    (void)state;
    unsigned char bytes[131]; /* four rows of the lanes, and a word with a rest */
    uint64_t random = 3, seen[sizeof bytes + 1];
    for (size_t i = 0; i < sizeof bytes; i++) bytes[i] = (unsigned char)random_next(&random);
    for (size_t count = 0; count <= sizeof bytes; count++) {
        uint64_t const hash = hash_block(bytes, count);
        assert_true(hash == hash_block_slowly(bytes, count));
        for (size_t bit = 0; bit < 8 * count; bit++) {
            bytes[bit / 8] ^= (unsigned char)(1u << bit % 8);
            assert_true(hash_block(bytes, count) != hash);
            bytes[bit / 8] ^= (unsigned char)(1u << bit % 8);
        }
    }
    memset(bytes, 0, sizeof bytes);
    for (size_t count = 0; count <= sizeof bytes; count++) {
        seen[count] = hash_block(bytes, count);
        for (size_t i = 0; i < count; i++) assert_true(seen[i] != seen[count]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_limit_is_kept),
        cmocka_unit_test(array_grows_and_keeps_contents),
        cmocka_unit_test(matched_arrays_have_the_room_of_the_larger),
        cmocka_unit_test(sorting_keeps_items_and_orders_keys),
        cmocka_unit_test(numbers_are_sorted_upwards),
        cmocka_unit_test(keys_are_sorted_by_digits),
        cmocka_unit_test(arena_reuses_its_blocks),
        cmocka_unit_test(an_empty_arena_is_one_block),
        cmocka_unit_test(a_reserved_arena_is_one_block),
        cmocka_unit_test(chunks_do_not_depend_on_threads),
        cmocka_unit_test(hash_is_fixed_and_sensitive),
        cmocka_unit_test(hash_of_a_block_sees_each_bit_and_the_length),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
