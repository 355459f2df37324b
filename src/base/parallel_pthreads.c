/* base/parallel_pthreads.c - the chunks of parallel_for on POSIX threads.
 *
 * Each thread has a range of chunks. It takes those of its own range first, then what is left of
 * the ranges of the others. So in several loops over the same data a thread mostly works on what is
 * still in its own cache.
 *
 * Each thread that runs loops keeps helper threads of its own. It makes them on demand and ends
 * them when it ends. Between loops a helper looks for work for a moment, then sleeps: loops that
 * follow each other closely start fast, and helpers do not take the processor from others. The
 * thread sanitizer follows every step of this.
 *
 * The caller takes chunks like its helpers. When no chunk is left it waits only for helpers that
 * are inside one. A loop has a gate for that: helpers enter while it is open, and the caller
 * closes it. A helper that gets a processor only then finds the gate closed. So on a busy machine a
 * loop takes at most as long as the caller alone would need, and the rest of one chunk.
 *
 * There are no mutexes and no condition variables: with them, a thread that has been woken and gets
 * no processor holds up the one that woke it. Posting a semaphore never waits.
 *
 * Where no more threads can be had, the calling thread does their share. A child of fork() has
 * no helpers and makes new ones. */
#define _GNU_SOURCE /* sched_getaffinity */
#include "base/memory.h"
#include "base/parallel_backend.h"
#include "base/timer.h"

#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    MAX_HELPERS = 255,
    LIMIT_BITS = 16, /* of a ticket: how many helpers take part */
    GATE_BITS = 17,  /* of a gate, below the number of its loop: helpers inside, and whether open */
    GATE_OPEN = 1 << 16,
    LOOKS = 64, /* between two readings of the clock, a microsecond or a few */
    STOP_LIMIT = (1 << LIMIT_BITS) - 1
};

/* [s] How long a thread looks for work before it sleeps. Between two loops of a solve a caller
 * works alone for some 10 microseconds. */
static const double SPIN_TIME = 50e-6;

typedef struct helper_team helper_team;
typedef struct helper {
    pthread_t thread;
    helper_team *team;
    int worker;           /* 1 .. MAX_HELPERS */
    atomic_int is_asleep; /* whoever sets it back to 0 posts `wake`, except the helper itself */
    sem_t wake;
} helper;

/* The next chunk of one range; alone on its cache line. */
typedef struct chunk_range {
    _Alignas(64) atomic_size_t next;
} chunk_range;

struct helper_team {
    sem_t is_done; /* posted by the last helper to leave a closed gate */
    /* Number of the loop and, in the low bits, of the helpers that take part in it. */
    _Atomic uint64_t ticket;
    /* Number of the loop, GATE_OPEN while helpers may enter, and in the low bits how many are
     * inside. The next three belong to those inside and to the caller. */
    _Atomic uint64_t gate;
    const parallel_loop *loop;
    int range_count;
    chunk_range ranges[MAX_HELPERS + 1]; /* by worker */
    atomic_bool has_room; /* no more threads than processors: a thread may look for work */
    int processor_count;
    unsigned fork_count; /* of the process that made it */
    int helper_count;
    helper helpers[MAX_HELPERS];
};

static pthread_once_t team_key_once = PTHREAD_ONCE_INIT;
static pthread_key_t team_key;
static bool has_team_key;
static atomic_uint fork_count; /* forks from the first process to this one */

typedef bool (*look)(void *context);

/* Looks until `sees` is true, for SPIN_TIME at most. Returns whether it was. */
static bool look_for(const helper_team *team, look sees, void *context) {
    if (!atomic_load(&team->has_room)) return false;
    double const end = timer_now() + SPIN_TIME;
    do {
        for (int i = 0; i < LOOKS; i++) {
            if (sees(context)) return true;
#if defined(__x86_64__) || defined(__i386__)
            __builtin_ia32_pause();
#endif
        }
    } while (timer_now() < end);
    return false;
}

/* The first chunk of a range. */
static size_t compute_range_begin(const helper_team *team, const parallel_loop *loop, int range) {
    size_t const count = (size_t)team->range_count, share = loop->chunk_count / count;
    size_t const rest = loop->chunk_count % count, number = (size_t)range;
    return share * number + (number < rest ? number : rest);
}

static void take_chunks(helper_team *team, const parallel_loop *loop, int worker) {
    for (int i = 0; i < team->range_count; i++) {
        int const range = (worker + i) % team->range_count;
        size_t const end = compute_range_begin(team, loop, range + 1);
        for (;;) {
            size_t const chunk = atomic_fetch_add(&team->ranges[range].next, 1);
            if (chunk >= end) break;
            parallel_run_chunk(loop, chunk, worker);
        }
    }
}

static void await_post(sem_t *semaphore) {
    while (sem_wait(semaphore) != 0) continue; /* a signal interrupts it */
}

static bool sees_post(void *semaphore) { return sem_trywait(semaphore) == 0; }

/* A ticket, and the one that was there before. */
typedef struct ticket_watch {
    helper_team *team;
    uint64_t seen, ticket;
} ticket_watch;

static bool sees_ticket(void *context) {
    ticket_watch *const watch = context;
    watch->ticket = atomic_load(&watch->team->ticket);
    return watch->ticket != watch->seen;
}

/* Calls the first `count` helpers to a loop, or to end. All that they find in the team is ready. */
static void publish_ticket(helper_team *team, uint64_t ticket, int count) {
    atomic_store(&team->ticket, ticket);
    for (int i = 0; i < count; i++) {
        helper *const called = &team->helpers[i];
        if (atomic_exchange(&called->is_asleep, 0)) sem_post(&called->wake);
    }
}

static void *run_helper(void *argument) {
    helper *const self = argument;
    helper_team *const team = self->team;
    ticket_watch watch = {.team = team};
    for (;;) {
        /* Looks for another ticket, then sleeps until someone wakes it. */
        while (!look_for(team, sees_ticket, &watch)) {
            atomic_store(&self->is_asleep, 1);
            if (sees_ticket(&watch) && atomic_exchange(&self->is_asleep, 0)) break;
            await_post(&self->wake);
        }
        uint64_t const seen = watch.seen = watch.ticket;
        uint64_t const limit = seen & STOP_LIMIT;
        if (limit == STOP_LIMIT) return NULL;
        if ((uint64_t)self->worker > limit) continue;
        /* Enters the gate, unless its loop is over or another one has begun. */
        uint64_t gate = atomic_load(&team->gate);
        bool is_inside = false;
        while (!is_inside && gate >> GATE_BITS == seen >> LIMIT_BITS && (gate & GATE_OPEN) != 0)
            is_inside = atomic_compare_exchange_weak(&team->gate, &gate, gate + 1);
        if (!is_inside) continue;
        take_chunks(team, team->loop, self->worker);
        /* The last to leave a closed gate tells the caller. */
        gate = atomic_fetch_sub(&team->gate, 1);
        if ((gate & (2 * GATE_OPEN - 1)) == 1) sem_post(&team->is_done);
    }
}

static void release_team(helper_team *team) {
    memory heap = memory_default();
    heap.bytes_held = sizeof *team;
    memory_release(&heap, team, sizeof *team);
}

/* Ends the helpers of a thread that ends. */
static void destroy_team(void *argument) {
    helper_team *const team = argument;
    if (team->fork_count == atomic_load(&fork_count)) {
        publish_ticket(team, atomic_load(&team->ticket) | STOP_LIMIT, team->helper_count);
        for (int i = 0; i < team->helper_count; i++) {
            pthread_join(team->helpers[i].thread, NULL);
            sem_destroy(&team->helpers[i].wake);
        }
        sem_destroy(&team->is_done);
    }
    release_team(team);
}

static void count_fork(void) { atomic_fetch_add(&fork_count, 1); }

static void make_team_key(void) {
    has_team_key = pthread_atfork(NULL, NULL, count_fork) == 0 &&
                   pthread_key_create(&team_key, destroy_team) == 0;
}

/* The team of the calling thread, made when it has none; null when it cannot be made. */
static helper_team *get_team(void) {
    pthread_once(&team_key_once, make_team_key);
    if (!has_team_key) return NULL;
    helper_team *team = pthread_getspecific(team_key);
    unsigned const forks = atomic_load(&fork_count);
    if (team && team->fork_count == forks) return team;
    if (team) release_team(team);
    memory heap = memory_default();
    team = memory_allocate_zeroed(&heap, 1, sizeof *team);
    if (team) {
        team->fork_count = forks;
        team->processor_count = parallel_backend_processor_count();
        sem_init(&team->is_done, 0, 0);
    }
    if (pthread_setspecific(team_key, team) == 0 || !team) return team;
    release_team(team);
    return NULL;
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
    /* Starts helpers until there are as many as wanted, or no more can be had. */
    int const wanted = threads - 1;
    while (team->helper_count < wanted && team->helper_count < MAX_HELPERS) {
        helper *const next = &team->helpers[team->helper_count];
        *next = (helper){.team = team, .worker = team->helper_count + 1};
        sem_init(&next->wake, 0, 0);
        if (pthread_create(&next->thread, NULL, run_helper, next) != 0) break;
        team->helper_count++;
    }
    int const helper_count = team->helper_count < wanted ? team->helper_count : wanted;
    uint64_t const number = (atomic_load(&team->ticket) >> LIMIT_BITS) + 1;
    atomic_store(&team->has_room, threads <= team->processor_count);
    /* The gate opens to this loop; nobody is inside. */
    team->loop = loop;
    team->range_count = helper_count + 1;
    for (int i = 0; i < team->range_count; i++)
        atomic_store(&team->ranges[i].next, compute_range_begin(team, loop, i));
    atomic_store(&team->gate, number << GATE_BITS | GATE_OPEN);
    publish_ticket(team, number << LIMIT_BITS | (uint64_t)helper_count, helper_count);
    take_chunks(team, loop, 0);
    /* No chunk is left: no more helpers enter, then those inside leave. */
    uint64_t const gate = atomic_fetch_sub(&team->gate, GATE_OPEN);
    if ((gate & (GATE_OPEN - 1)) == 0) return;
    if (!look_for(team, sees_post, &team->is_done)) await_post(&team->is_done);
}
