/* base/parallel.c - cuts a loop into chunks and hands them to the threading library. */
#include "base/parallel.h"

#include "base/parallel_backend.h"

#include <stdatomic.h>

enum { MAX_THREADS = 256 };

/* What this thread was last told. */
static _Thread_local const tulle_tasks *current;
static _Thread_local bool runs_alone;

const tulle_tasks *parallel_use(const tulle_tasks *tasks) {
    const tulle_tasks *const before = current;
    current = tasks;
    return before;
}

void parallel_set_alone(bool is_alone) { runs_alone = is_alone; }

size_t parallel_chunk_count(size_t count, size_t chunk_size) {
    return (count + chunk_size - 1) / chunk_size;
}

int parallel_resolve_threads(int threads) {
    if (threads <= 0) threads = parallel_backend_processor_count();
    return threads < 1 ? 1 : threads > MAX_THREADS ? MAX_THREADS : threads;
}

void parallel_run_chunk(const parallel_loop *loop, size_t chunk, int worker) {
    size_t const begin = chunk * loop->chunk_size;
    size_t const end =
        begin + loop->chunk_size < loop->count ? begin + loop->chunk_size : loop->count;
    loop->body(loop->context, begin, end, chunk, worker);
}

/* A loop whose chunks the tasks of a host take. */
typedef struct task_loop {
    const parallel_loop *loop;
    atomic_size_t next; /* chunk */
} task_loop;

/* A task of the host, which is one worker of the loop. */
static void take_chunks_as_task(void *work, size_t index) {
    task_loop *const self = work;
    for (;;) {
        size_t const chunk = atomic_fetch_add(&self->next, 1);
        if (chunk >= self->loop->chunk_count) return;
        parallel_run_chunk(self->loop, chunk, (int)index);
    }
}

void parallel_for(size_t count, size_t chunk_size, int threads, parallel_body body, void *context) {
    parallel_loop const loop = {.count = count,
                                .chunk_size = chunk_size,
                                .chunk_count = parallel_chunk_count(count, chunk_size),
                                .body = body,
                                .context = context};
    if (threads > 1 && loop.chunk_count > 1 && !runs_alone) {
        size_t const useful =
            (size_t)threads < loop.chunk_count ? (size_t)threads : loop.chunk_count;
        if (!current) {
            parallel_backend_run(&loop, (int)useful);
            return;
        }
        const tulle_tasks *const tasks = current;
        task_loop shared = {.loop = &loop};
        tasks->run(tasks->context, take_chunks_as_task, &shared, useful);
        /* what a host left that ran no task at all */
        take_chunks_as_task(&shared, 0);
        return;
    }
    for (size_t chunk = 0; chunk < loop.chunk_count; chunk++) parallel_run_chunk(&loop, chunk, 0);
}

/* A loop that leaves out chunks. */
typedef struct busy_loop {
    const uint8_t *is_idle;
    parallel_body body;
    void *context;
} busy_loop;

static void run_busy(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    const busy_loop *const loop = context;
    if (!are_idle(loop->is_idle, begin, end)) loop->body(loop->context, begin, end, chunk, worker);
}

void parallel_for_busy(const uint8_t *is_idle, size_t count, size_t chunk_size, int threads,
                       parallel_body body, void *context) {
    busy_loop loop = {is_idle, body, context};
    if (is_idle)
        parallel_for(count, chunk_size, threads, run_busy, &loop);
    else
        parallel_for(count, chunk_size, threads, body, context);
}
