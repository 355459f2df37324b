/* parallel_for under many loops and many callers: every chunk runs once, on a worker
 * of its range, and the results do not depend on the number of threads. Threads that come late or
 * not at all hold nobody up. */
#define _GNU_SOURCE /* usleep, SIGUSR1 */
#include "base/parallel.h"

#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
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

/* Chunks that write `value` into their item, some of them slow on one worker. */
typedef struct written_items {
    int value, slow_worker;
    int items[64];
    int worker_of[64];
} written_items;

static void write_item(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    written_items *const w = context;
    (void)end;
    if (worker == w->slow_worker && chunk % 16 == 5) usleep(50);
    w->items[begin] = w->value;
    w->worker_of[begin] = worker;
}

/* What helpers of one loop wrote is whole when it returns, also when a helper of the loop before
 * comes late, or is slow, and the number of threads changes from loop to loop. */
static void tiny_loops_in_a_row_are_whole(void **state) {
    (void)state;
    written_items w = {0};
    for (int i = 1; i <= 20000; i++) {
        size_t const count = 2 + (size_t)i % 63;
        int const threads = 2 + i % 5;
        w.value = i;
        w.slow_worker = i % 50 == 0 ? i % 3 : -1;
        parallel_for(count, 1, threads, write_item, &w);
        for (size_t k = 0; k < count; k++) {
            assert_int_equal(w.items[k], i);
            assert_in_range(w.worker_of[k], 0, threads - 1);
        }
    }
}

/* The same while other threads keep every processor busy. */
static atomic_int is_idle_over;

static void *keep_busy(void *argument) {
    while (!atomic_load(&is_idle_over)) continue;
    return argument;
}

static void loops_on_a_busy_machine_are_whole(void **state) {
    pthread_t busy[4];
    atomic_store(&is_idle_over, 0);
    for (int i = 0; i < 4; i++)
        assert_int_equal(pthread_create(&busy[i], NULL, keep_busy, NULL), 0);
    written_items w = {.slow_worker = -1};
    for (int i = 1; i <= 300; i++) {
        w.value = i;
        parallel_for(64, 1, 2 + i % 3, write_item, &w);
        for (size_t k = 0; k < 64; k++) assert_int_equal(w.items[k], i);
    }
    atomic_store(&is_idle_over, 1);
    for (int i = 0; i < 4; i++) pthread_join(busy[i], NULL);
    (void)state;
}

/* Ways in which a host may run tasks. */
typedef enum host_way { IN_ORDER, BACKWARDS, ON_THREADS, NONE_AT_ALL, HOST_WAYS } host_way;
typedef struct host {
    host_way way;
    size_t calls, most; /* of `run`; tasks of one call */
} host;
typedef struct host_task {
    tulle_task task;
    void *work;
    size_t index;
} host_task;

static void *run_host_task(void *argument) {
    const host_task *const self = argument;
    self->task(self->work, self->index);
    return NULL;
}

static void run_host_tasks(void *context, tulle_task task, void *work, size_t count) {
    host *const self = context;
    pthread_t threads[16];
    host_task tasks[16];
    assert_true(count <= 16);
    self->calls++;
    if (count > self->most) self->most = count;
    for (size_t i = 0; i < count; i++)
        tasks[i] = (host_task){task, work, self->way == BACKWARDS ? count - 1 - i : i};
    for (size_t i = 0; i < count && self->way != NONE_AT_ALL; i++) {
        if (self->way != ON_THREADS)
            (void)run_host_task(&tasks[i]);
        else
            assert_int_equal(pthread_create(&threads[i], NULL, run_host_task, &tasks[i]), 0);
    }
    for (size_t i = 0; i < count && self->way == ON_THREADS; i++) pthread_join(threads[i], NULL);
}

/* Tasks of a host take all chunks, as workers of their own; whoever runs alone asks for none. */
static void a_host_may_run_the_loops(void **state) {
    (void)state;
    for (int way = 0; way < HOST_WAYS; way++) {
        host of = {.way = (host_way)way};
        tulle_tasks const tasks = {run_host_tasks, &of};
        assert_null(parallel_use(&tasks));
        for (size_t count = 0; count < 40; count += 3)
            for (int threads = 1; threads <= 9; threads += 2)
                assert_true(is_loop_right(count, 2, threads));
        assert_true(is_loop_right(CHUNK_MAX, 1, 16));
        assert_true(of.calls > 20 && of.most == 16);
        size_t const calls = of.calls;
        parallel_set_alone(true);
        assert_true(is_loop_right(CHUNK_MAX, 1, 16));
        parallel_set_alone(false);
        assert_int_equal(of.calls, calls);
        assert_true(is_loop_right(2, 1, 2));
        assert_int_equal(of.calls, calls + 1);
        assert_ptr_equal(parallel_use(NULL), &tasks);
        assert_true(is_loop_right(2, 1, 2));
        assert_int_equal(of.calls, calls + 1);
    }
}

#ifdef TULLE_HAS_OWN_THREADS
enum { HELPER_RUNS, HELPER_IS_CALLED, HELPER_IS_STOPPED };
static atomic_int helper_state;

/* Runs on the helper: keeps it from coming to any loop. */
static void stop_helper(int signal) {
    (void)signal;
    atomic_store(&helper_state, HELPER_IS_STOPPED);
    while (atomic_load(&helper_state) == HELPER_IS_STOPPED) usleep(200);
}

typedef struct helper_watch {
    pthread_t thread;
    atomic_int is_known;
} helper_watch;

static void watch_helper(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    helper_watch *const watch = context;
    (void)begin, (void)end, (void)chunk;
    usleep(100);
    if (worker != 1) return;
    watch->thread = pthread_self();
    atomic_store(&watch->is_known, 1);
}

static int is_helper_at_work(helper_watch *watch) {
    atomic_store(&watch->is_known, 0);
    for (int i = 0; i < 1000 && !atomic_load(&watch->is_known); i++)
        parallel_for(20, 1, 2, watch_helper, watch);
    return atomic_load(&watch->is_known);
}

/* A helper that gets no processor at all: the caller does the loops alone and does not wait. Then
 * the helper, late for all of them, takes part again. */
static void a_stopped_helper_holds_nobody_up(void **state) {
    (void)state;
    helper_watch watch;
    assert_true(is_helper_at_work(&watch));
    struct sigaction action = {.sa_handler = stop_helper}, former;
    assert_int_equal(sigaction(SIGUSR1, &action, &former), 0);
    usleep(20000); /* it sleeps by now */
    atomic_store(&helper_state, HELPER_IS_CALLED);
    assert_int_equal(pthread_kill(watch.thread, SIGUSR1), 0);
    while (atomic_load(&helper_state) != HELPER_IS_STOPPED) usleep(200);
    alarm(60);
    written_items w = {.slow_worker = -1};
    for (int i = 1; i <= 2000; i++) {
        w.value = i;
        parallel_for(64, 1, 2, write_item, &w);
        for (size_t k = 0; k < 64; k++) {
            assert_int_equal(w.items[k], i);
            assert_int_equal(w.worker_of[k], 0);
        }
    }
    alarm(0);
    atomic_store(&helper_state, HELPER_RUNS);
    assert_true(is_helper_at_work(&watch));
    assert_int_equal(sigaction(SIGUSR1, &former, NULL), 0);
}

/* A child of fork() has none of its parent's helpers and makes its own. The parent keeps its. */
static void children_have_helpers_of_their_own(void **state) {
    (void)state;
#ifdef __SANITIZE_THREAD__ /* which ends a child that makes threads */
    skip();
#endif
    if (getenv("TULLE_TEST_EMULATED")) skip(); /* qemu's user mode ends when threads fork */
    helper_watch watch;
    assert_true(is_helper_at_work(&watch));
    pid_t const child = fork();
    if (child == 0) _exit(is_helper_at_work(&watch) && is_loop_right(CHUNK_MAX, 1, 4) ? 0 : 1);
    assert_true(child > 0);
    int status = -1;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    assert_true(is_helper_at_work(&watch));
}
#endif

static void threads_are_resolved(void **state) {
    (void)state;
    assert_true(parallel_resolve_threads(0) >= 1);
    assert_true(parallel_resolve_threads(-5) >= 1);
    assert_int_equal(parallel_resolve_threads(1), 1);
    assert_true(parallel_resolve_threads(100000) <= 256);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_host_may_run_the_loops),
        cmocka_unit_test(every_chunk_runs_once),
        cmocka_unit_test(loops_may_be_far_apart),
        cmocka_unit_test(callers_do_not_disturb_each_other),
        cmocka_unit_test(tiny_loops_in_a_row_are_whole),
        cmocka_unit_test(loops_on_a_busy_machine_are_whole),
#ifdef TULLE_HAS_OWN_THREADS
        cmocka_unit_test(a_stopped_helper_holds_nobody_up),
        cmocka_unit_test(children_have_helpers_of_their_own),
#endif
        cmocka_unit_test(threads_are_resolved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
