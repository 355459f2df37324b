/* Errors and their texts; the arena and heap when memory is short. */
#define _DEFAULT_SOURCE /* madvise */
#include "base/arena.h"
#include "base/error.h"
#include "base/timer.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/mman.h>
#endif
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/asan_interface.h>
#endif

#include <cmocka.h>

static void every_status_has_its_own_text(void **state) {
    (void)state;
    for (int i = 0; i < TULLE_STATUS_COUNT; i++) {
        const char *const text = tulle_status_text((tulle_status)i);
        assert_string_not_equal(text, "unknown status");
        for (int j = 0; j < i; j++)
            assert_string_not_equal(text, tulle_status_text((tulle_status)j));
    }
    assert_string_equal(tulle_status_text(TULLE_STATUS_COUNT), "unknown status");
    assert_string_equal(tulle_status_text((tulle_status)999), "unknown status");
}

static void errors_are_filled_and_cut_to_size(void **state) {
    (void)state;
    tulle_error error;
    assert_int_equal(
        error_set_at(&error, TULLE_ERROR_PARSE, "a.obj", 3, 7, "vertex %d is %s", 5, "odd"),
        TULLE_ERROR_PARSE);
    assert_int_equal(error.status, TULLE_ERROR_PARSE);
    assert_string_equal(error.file, "a.obj");
    assert_int_equal(error.line, 3);
    assert_int_equal(error.column, 7);
    assert_string_equal(error.message, "vertex 5 is odd");
    assert_int_equal(error_set(&error, TULLE_ERROR_LIMIT, "too many"), TULLE_ERROR_LIMIT);
    assert_string_equal(error.file, "");
    assert_int_equal(error.line, 0);
    assert_int_equal(error.column, 0);
    static char long_text[8192];
    memset(long_text, 'x', sizeof long_text - 1);
    error_set_at(&error, TULLE_ERROR_IO, long_text, 1, 1, "%s", long_text);
    assert_int_equal(strlen(error.file), sizeof error.file - 1);
    assert_int_equal(strlen(error.message), sizeof error.message - 1);
    assert_int_equal(error_set(NULL, TULLE_ERROR_IO, "nobody listens"), TULLE_ERROR_IO);
}

/* An allocator that fails from its calls_left-th call on. */
typedef struct failing_allocator {
    int calls_left;
    size_t held;
} failing_allocator;

static void *allocate_or_fail(void *context, size_t byte_count) {
    failing_allocator *const allocator = context;
    if (allocator->calls_left-- <= 0) return NULL;
    allocator->held += byte_count;
    return malloc(byte_count);
}

static void release(void *context, void *pointer, size_t byte_count) {
    failing_allocator *const allocator = context;
    allocator->held -= byte_count;
    free(pointer);
}

static void an_arena_outlives_failed_allocations(void **state) {
    (void)state;
    for (int calls = 0; calls < 6; calls++) {
        failing_allocator failing = {.calls_left = calls};
        memory heap = {
            .allocator = {.allocate = allocate_or_fail, .release = release, .context = &failing}};
        arena scratch = arena_make(&heap);
        int served = 0;
        for (int i = 0; i < 3; i++) {
            char *const block = ARENA_NEW_ZEROED(&scratch, char, (size_t)100000 << (2 * i));
            if (!block) continue;
            served++;
            assert_int_equal(block[99999], 0);
            memset(block, 1, 100000);
        }
        assert_int_equal(served, calls / 2);
        assert_null(arena_allocate(&scratch, SIZE_MAX / 4, 8));
        arena_destroy(&scratch);
        assert_int_equal(heap.bytes_held, 0);
        assert_int_equal(failing.held, 0);
    }
}

static void arena_blocks_never_overlap(void **state) {
    (void)state;
    enum { COUNT = 300 };
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    for (int round = 0; round < 3; round++) {
        arena_mark const start = arena_get_mark(&scratch);
        unsigned char *blocks[COUNT];
        size_t sizes[COUNT];
        for (size_t i = 0; i < COUNT; i++) {
            sizes[i] = (i * 7919) % 5000 + (i % 50 == 0 ? 300000 : 0);
            blocks[i] = arena_allocate(&scratch, 1, sizes[i]);
            assert_non_null(blocks[i]);
            assert_int_equal((uintptr_t)blocks[i] % 64, 0);
            memset(blocks[i], (int)(i % 251), sizes[i]);
            arena_mark const inner = arena_get_mark(&scratch);
            unsigned char *const passing = arena_allocate(&scratch, 1, 10000);
            assert_non_null(passing);
            memset(passing, 255, 10000);
            arena_release(&scratch, inner);
        }
        for (size_t i = 0; i < COUNT; i++) {
            for (size_t k = 0; k < sizes[i]; k++) assert_true(blocks[i][k] == i % 251);
        }
        arena_release(&scratch, start);
    }
    arena_destroy(&scratch);
    assert_int_equal(heap.bytes_held, 0);
}

#ifdef __SANITIZE_ADDRESS__
static void what_an_arena_does_not_hand_out_is_guarded(void **state) {
    (void)state;
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    arena_mark const mark = arena_get_mark(&scratch);
    for (size_t count = 1; count < 100000; count += count < 200 ? 1 : 9973) {
        char *const place = ARENA_NEW(&scratch, char, count);
        assert_non_null(place);
        assert_null(__asan_region_is_poisoned(place, count));
        assert_true(__asan_address_is_poisoned(place + count));
        arena_mark const between = arena_get_mark(&scratch);
        char *const next = ARENA_NEW(&scratch, char, 64);
        assert_true(__asan_address_is_poisoned(place + count));
        arena_release(&scratch, between);
        assert_true(__asan_address_is_poisoned(next));
        assert_null(__asan_region_is_poisoned(place, count));
        if (count == 100) arena_release(&scratch, mark);
    }
    arena_destroy(&scratch);
    assert_int_equal(heap.bytes_held, 0);
}
#endif

#ifdef MADV_HUGEPAGE
/* Whether Linux has been asked for large pages there. */
static bool wants_large_pages(const void *place) {
    FILE *const file = fopen("/proc/self/smaps", "r");
    char line[512];
    bool is_there = false, wants = false;
    while (file && fgets(line, sizeof line, file)) {
        unsigned long long begin, end;
        if (sscanf(line, "%llx-%llx ", &begin, &end) == 2)
            is_there = (uintptr_t)place >= begin && (uintptr_t)place < end;
        else if (is_there && strncmp(line, "VmFlags:", 8) == 0)
            wants = strstr(line, " hg") != NULL;
    }
    if (file) fclose(file);
    return wants;
}

static void large_blocks_want_large_pages(void **state) {
    (void)state;
    size_t const size = 8 << 20;
    char *const mapped =
        mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(mapped != MAP_FAILED);
    bool const is_told =
        madvise(mapped, size, MADV_HUGEPAGE) == 0 && wants_large_pages(mapped + size / 2);
    munmap(mapped, size);
    if (!is_told) {
        print_message("this system has no large pages, or does not tell\n");
        skip();
    }
    memory heap = memory_default();
    char *const large = memory_allocate(&heap, size);
    assert_non_null(large);
    assert_true(wants_large_pages(large + size / 2));
    memset(large, 1, size);
    memory_release(&heap, large, size);
    assert_int_equal(heap.bytes_held, 0);
}
#endif

static void the_clock_never_goes_back(void **state) {
    (void)state;
    double last = timer_now();
    for (int i = 0; i < 1000; i++) {
        double const now = timer_now();
        assert_true(now >= last);
        last = now;
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_status_has_its_own_text),
        cmocka_unit_test(errors_are_filled_and_cut_to_size),
        cmocka_unit_test(an_arena_outlives_failed_allocations),
        cmocka_unit_test(arena_blocks_never_overlap),
        cmocka_unit_test(the_clock_never_goes_back),
#ifdef __SANITIZE_ADDRESS__
        cmocka_unit_test(what_an_arena_does_not_hand_out_is_guarded),
#endif
#ifdef MADV_HUGEPAGE
        cmocka_unit_test(large_blocks_want_large_pages),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
