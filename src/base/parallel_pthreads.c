/* base/parallel_pthreads.c - the chunks of parallel_for on POSIX threads.
 *
 * Each thread that runs loops keeps helper threads of its own, made on demand and ended with it.
 * Between loops a helper looks out for work for some microseconds, then sleeps, so that loops which
 * follow each other closely start fast and helpers do not take the processor from others that need
 * it. The thread sanitizer follows every step of this.
 *
 * Where no more threads can be had, the calling thread does their share. A child of fork() has no
 * helpers and makes new ones. */
#define _GNU_SOURCE /* sched_getaffinity */
#include "base/memory.h"
#include "base/parallel_backend.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdint.h>
#include <unistd.h>

enum {
    MAX_HELPERS = 255,
    LIMIT_BITS = 16,  /* of a ticket: how many helpers take part */
    SPIN_COUNT = 500, /* looks before sleeping, 5 to 25 microseconds */
    STOP_LIMIT = (1 << LIMIT_BITS) - 1
};

typedef struct helper_team helper_team;
typedef struct helper {
    pthread_t thread;
    helper_team *team;
    int worker; /* 1 .. MAX_HELPERS */
} helper;

struct helper_team {
    pthread_mutex_t mutex;
    pthread_cond_t has_ticket, is_done;
    /* Number of the loop and, in the low bits, of the helpers that take part in it. */
    _Atomic uint64_t ticket;
    const parallel_loop *loop; /* of the ticket; read by the helpers that take part */
    atomic_size_t next_chunk;
    atomic_int pending;    /* helpers that still work on the loop */
    atomic_int spin_count; /* 0 where there are more threads than processors */
    int processor_count;
    pid_t process;
    int helper_count;
    helper helpers[MAX_HELPERS];
};

static pthread_once_t team_key_once = PTHREAD_ONCE_INIT;
static pthread_key_t team_key;
static bool has_team_key;

static void look_again(void) {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

/* Each worker begins with the chunk of its own number, so every thread runs something. */
static void take_chunks(helper_team *team, const parallel_loop *loop, int worker) {
    size_t chunk = (size_t)worker;
    while (chunk < loop->chunk_count) {
        parallel_run_chunk(loop, chunk, worker);
        chunk = atomic_fetch_add(&team->next_chunk, 1);
    }
}

/* The first ticket that is not `seen`. */
static uint64_t await_ticket(helper_team *team, uint64_t seen) {
    int const spin_count = atomic_load(&team->spin_count);
    for (int i = 0; i < spin_count; i++) {
        uint64_t const ticket = atomic_load(&team->ticket);
        if (ticket != seen) return ticket;
        look_again();
    }
    pthread_mutex_lock(&team->mutex);
    while (atomic_load(&team->ticket) == seen) pthread_cond_wait(&team->has_ticket, &team->mutex);
    uint64_t const ticket = atomic_load(&team->ticket);
    pthread_mutex_unlock(&team->mutex);
    return ticket;
}

static void publish_ticket(helper_team *team, uint64_t limit) {
    pthread_mutex_lock(&team->mutex);
    uint64_t const number = (atomic_load(&team->ticket) >> LIMIT_BITS) + 1;
    atomic_store(&team->ticket, number << LIMIT_BITS | limit);
    pthread_cond_broadcast(&team->has_ticket);
    pthread_mutex_unlock(&team->mutex);
}

static void *run_helper(void *argument) {
    const helper *const self = argument;
    helper_team *const team = self->team;
    uint64_t seen = 0;
    for (;;) {
        seen = await_ticket(team, seen);
        uint64_t const limit = seen & STOP_LIMIT;
        if (limit == STOP_LIMIT) return NULL;
        if ((uint64_t)self->worker > limit) continue;
        take_chunks(team, team->loop, self->worker);
        if (atomic_fetch_sub(&team->pending, 1) != 1) continue;
        pthread_mutex_lock(&team->mutex);
        pthread_cond_signal(&team->is_done);
        pthread_mutex_unlock(&team->mutex);
    }
}

static void await_helpers(helper_team *team) {
    int const spin_count = atomic_load(&team->spin_count);
    for (int i = 0; i < spin_count; i++) {
        if (atomic_load(&team->pending) == 0) return;
        look_again();
    }
    pthread_mutex_lock(&team->mutex);
    while (atomic_load(&team->pending) != 0) pthread_cond_wait(&team->is_done, &team->mutex);
    pthread_mutex_unlock(&team->mutex);
}

static void release_team(helper_team *team) {
    memory heap = memory_default();
    heap.bytes_held = sizeof *team;
    memory_release(&heap, team, sizeof *team);
}

/* Ends the helpers of a thread that ends. */
static void destroy_team(void *argument) {
    helper_team *const team = argument;
    if (team->process == getpid()) {
        publish_ticket(team, STOP_LIMIT);
        for (int i = 0; i < team->helper_count; i++) pthread_join(team->helpers[i].thread, NULL);
        pthread_cond_destroy(&team->has_ticket);
        pthread_cond_destroy(&team->is_done);
        pthread_mutex_destroy(&team->mutex);
    }
    release_team(team);
}

static void make_team_key(void) { has_team_key = pthread_key_create(&team_key, destroy_team) == 0; }

/* The team of the calling thread, made when it has none; null when it cannot be made. */
static helper_team *get_team(void) {
    pthread_once(&team_key_once, make_team_key);
    if (!has_team_key) return NULL;
    helper_team *team = pthread_getspecific(team_key);
    if (team && team->process == getpid()) return team;
    if (team) release_team(team);
    memory heap = memory_default();
    team = memory_allocate_zeroed(&heap, 1, sizeof *team);
    if (team) {
        team->process = getpid();
        team->processor_count = parallel_backend_processor_count();
        pthread_mutex_init(&team->mutex, NULL);
        pthread_cond_init(&team->has_ticket, NULL);
        pthread_cond_init(&team->is_done, NULL);
    }
    if (pthread_setspecific(team_key, team) == 0 || !team) return team;
    release_team(team);
    return NULL;
}

/* Starts helpers until there are `wanted`, as far as it goes; returns how many take part. */
static int start_helpers(helper_team *team, int wanted) {
    while (team->helper_count < wanted && team->helper_count < MAX_HELPERS) {
        helper *const next = &team->helpers[team->helper_count];
        *next = (helper){.team = team, .worker = team->helper_count + 1};
        if (pthread_create(&next->thread, NULL, run_helper, next) != 0) break;
        team->helper_count++;
    }
    return team->helper_count < wanted ? team->helper_count : wanted;
}

int parallel_backend_processor_count(void) {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0) return 1;
    int const count = CPU_COUNT(&set);
    return count < 1 ? 1 : count;
}

void parallel_backend_run(const parallel_loop *loop, int threads) {
    helper_team *const team = get_team();
    if (!team) {
        for (size_t chunk = 0; chunk < loop->chunk_count; chunk++)
            parallel_run_chunk(loop, chunk, 0);
        return;
    }
    int const helper_count = start_helpers(team, threads - 1);
    team->loop = loop;
    atomic_store(&team->spin_count, threads <= team->processor_count ? SPIN_COUNT : 0);
    atomic_store(&team->next_chunk, (size_t)threads);
    atomic_store(&team->pending, helper_count);
    publish_ticket(team, (uint64_t)helper_count);
    for (int worker = helper_count + 1; worker < threads; worker++)
        parallel_run_chunk(loop, (size_t)worker, 0);
    take_chunks(team, loop, 0);
    await_helpers(team);
}
