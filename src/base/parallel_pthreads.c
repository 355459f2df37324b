/* base/parallel_pthreads.c - the chunks of parallel_for on POSIX threads that live for one loop.
 * The thread sanitizer follows these, while it does not see how OpenMP's threads wait for each
 * other; and a loop may start in any thread of the caller. */
#define _GNU_SOURCE /* sched_getaffinity */
#include "base/parallel_backend.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>

enum { MAX_HELPERS = 255 };

typedef struct shared_loop {
    const parallel_loop *loop;
    atomic_size_t next_chunk;
} shared_loop;

typedef struct helper {
    pthread_t thread;
    shared_loop *shared;
    int worker;
} helper;

/* Each worker begins with the chunk of its own number, so every thread runs something. */
static void take_chunks(shared_loop *shared, int worker) {
    size_t chunk = (size_t)worker;
    while (chunk < shared->loop->chunk_count) {
        parallel_run_chunk(shared->loop, chunk, worker);
        chunk = atomic_fetch_add(&shared->next_chunk, 1);
    }
}

static void *run_helper(void *argument) {
    const helper *const self = argument;
    take_chunks(self->shared, self->worker);
    return NULL;
}

int parallel_backend_processor_count(void) {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0) return 1;
    int const count = CPU_COUNT(&set);
    return count < 1 ? 1 : count;
}

void parallel_backend_run(const parallel_loop *loop, int threads) {
    helper helpers[MAX_HELPERS];
    shared_loop shared = {.loop = loop};
    atomic_init(&shared.next_chunk, (size_t)threads);
    int started = 0;
    while (started < threads - 1 && started < MAX_HELPERS) {
        helper *const next = &helpers[started];
        *next = (helper){.shared = &shared, .worker = started + 1};
        if (pthread_create(&next->thread, NULL, run_helper, next) != 0) break;
        started++;
    }
    /* Where no more threads can be had, this one does their share. */
    for (int worker = started + 1; worker < threads; worker++)
        parallel_run_chunk(loop, (size_t)worker, 0);
    take_chunks(&shared, 0);
    for (int i = 0; i < started; i++) pthread_join(helpers[i].thread, NULL);
}
