/* parallel_for under many loops and many callers: every chunk runs once, on a worker
 * of its range, and the results do not depend on the number of threads. */
#define _DEFAULT_SOURCE /* usleep */
#include "base/parallel.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

enum { CHUNK_MAX = 1000 };

typedef struct record {
    size_t count, chunk_size;
    int threads;
    int runs[CHUNK_MAX];     /* of each chunk */
    int is_wrong[CHUNK_MAX]; /* range or worker of a chunk */
} record;

static void note_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    record *const r = context;
    size_t const expected_end = (chunk + 1) * r->chunk_size;
    r->runs[chunk]++;
    if (begin != chunk * r->chunk_size || worker < 0 || worker >= r->threads ||
        end != (expected_end < r->count ? expected_end : r->count))
        r->is_wrong[chunk] = 1;
}

/* Whether one loop runs each of its chunks once and as it should. */
static int is_loop_right(size_t count, size_t chunk_size, int threads) {
    record r = {.count = count, .chunk_size = chunk_size, .threads = threads};
    parallel_for(count, chunk_size, threads, note_chunk, &r);
    size_t const chunk_count = parallel_chunk_count(count, chunk_size);
    for (size_t i = 0; i < CHUNK_MAX; i++)
        if (r.runs[i] != (i < chunk_count) || r.is_wrong[i]) return 0;
    return 1;
}

static void every_chunk_runs_once(void **state) {
    (void)state;
    for (size_t count = 0; count < 40; count++) {
        for (size_t chunk_size = 1; chunk_size < 6; chunk_size += 2)
            for (int threads = 1; threads <= 9; threads += 2)
                assert_true(is_loop_right(count, chunk_size, threads));
    }
    assert_true(is_loop_right(100000, 101, 4));
    assert_true(is_loop_right(CHUNK_MAX, 1, 64));
}

/* Helpers that sleep between loops wake up again. */
static void loops_may_be_far_apart(void **state) {
    (void)state;
    for (int i = 0; i < 10; i++) {
        usleep(2000);
        assert_true(is_loop_right(500, 1, 2 + i % 3));
    }
}

static void *run_loops(void *argument) {
    int *const faults = argument;
    for (int i = 0; i < 100; i++) *faults += !is_loop_right(300, 7, 1 + i % 4);
    return NULL;
}

/* Several threads of the caller run loops at once, then end. */
static void callers_do_not_disturb_each_other(void **state) {
    (void)state;
    pthread_t threads[4];
    int faults[4] = {0};
    for (int i = 0; i < 4; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, run_loops, &faults[i]), 0);
    for (int i = 0; i < 4; i++) pthread_join(threads[i], NULL);
    for (int i = 0; i < 4; i++) assert_int_equal(faults[i], 0);
}

static void threads_are_resolved(void **state) {
    (void)state;
    assert_true(parallel_resolve_threads(0) >= 1);
    assert_true(parallel_resolve_threads(-5) >= 1);
    assert_int_equal(parallel_resolve_threads(1), 1);
    assert_true(parallel_resolve_threads(100000) <= 256);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_chunk_runs_once),
        cmocka_unit_test(loops_may_be_far_apart),
        cmocka_unit_test(callers_do_not_disturb_each_other),
        cmocka_unit_test(threads_are_resolved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
