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
 * Loops take a few microseconds, and a cache line that goes from one processor to another takes a
 * twentieth of one. So the gate is also what helpers look at between loops, its loop lies beside it
 * in the same line, and nobody writes into a line that others look at without need.
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
    LOOKS = 64 /* between two readings of the clock, a microsecond or a few */
};

/* A gate: in the low bits the helpers inside, then flags, then how many helpers may enter, then the
 * number of its loop. */
static const uint64_t GATE_INSIDE = 0x1ff;
static const uint64_t GATE_OPEN = 1 << 9;     /* helpers may enter */
static const uint64_t GATE_AWAITED = 1 << 10; /* the last to leave posts `is_done` */
static const uint64_t GATE_ENDED = 1 << 11;   /* helpers end */
enum { GATE_LIMIT = 12, GATE_LIMIT_MASK = 0xff, GATE_NUMBER = 20 }; /* bits below them */

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

/* A loop and the gate to it, on one cache line. Only those inside and the caller may look at the
 * loop. */
typedef struct gated_loop {
    _Alignas(64) _Atomic uint64_t gate;
    parallel_loop loop;
    int range_count; /* one more than helpers may enter */
} gated_loop;

struct helper_team {
    gated_loop shared;
    chunk_range ranges[MAX_HELPERS + 1]; /* by worker */
    _Alignas(64) sem_t is_done;
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
static size_t compute_range_begin(const parallel_loop *loop, int range_count, int range) {
    size_t const count = (size_t)range_count, share = loop->chunk_count / count;
    size_t const rest = loop->chunk_count % count, number = (size_t)range;
    return share * number + (number < rest ? number : rest);
}

static void take_chunks(helper_team *team, int worker) {
    parallel_loop const loop = team->shared.loop;
    int const range_count = team->shared.range_count;
    for (int i = 0; i < range_count; i++) {
        int const range = (worker + i) % range_count;
        size_t const end = compute_range_begin(&loop, range_count, range + 1);
        atomic_size_t *const next = &team->ranges[range].next;
        while (atomic_load(next) < end) {
            size_t const chunk = atomic_fetch_add(next, 1);
            if (chunk < end) parallel_run_chunk(&loop, chunk, worker);
        }
    }
}

static void await_post(sem_t *semaphore) {
    while (sem_wait(semaphore) != 0) continue; /* a signal interrupts it */
}

/* The gate of a team, who looks at it, and the number of the loop that it has seen last. */
typedef struct gate_watch {
    _Atomic uint64_t *gate;
    int worker;
    uint64_t seen;
} gate_watch;

/* Whether the helper may enter. */
static bool is_open_to(uint64_t gate, int worker) {
    return (gate & GATE_OPEN) && (uint64_t)worker <= (gate >> GATE_LIMIT & GATE_LIMIT_MASK);
}

/* Whether there is a loop to enter, or an end. */
static bool sees_call(void *context) {
    const gate_watch *const watch = context;
    uint64_t const gate = atomic_load(watch->gate);
    return (gate & GATE_ENDED) ||
           (gate >> GATE_NUMBER != watch->seen && is_open_to(gate, watch->worker));
}

static bool sees_nobody(void *context) {
    return (atomic_load(&((helper_team *)context)->shared.gate) & GATE_INSIDE) == 0;
}

/* Calls the first `count` helpers. All that they find in the team is ready. */
static void publish_gate(helper_team *team, uint64_t gate, int count) {
    atomic_exchange(&team->shared.gate, gate); /* a store that no load overtakes */
    for (int i = 0; i < count; i++) {
        helper *const called = &team->helpers[i];
        if (atomic_load(&called->is_asleep) && atomic_exchange(&called->is_asleep, 0))
            sem_post(&called->wake);
    }
}

/* Looks until it is called, then sleeps until it is. */
static void await_call(helper *self, gate_watch *watch) {
    while (!look_for(self->team, sees_call, watch)) {
        atomic_store(&self->is_asleep, 1);
        if (sees_call(watch) && atomic_exchange(&self->is_asleep, 0)) return;
        await_post(&self->wake);
    }
}

static void *run_helper(void *argument) {
    helper *const self = argument;
    helper_team *const team = self->team;
    gate_watch watch = {.gate = &team->shared.gate, .worker = self->worker};
    for (;;) {
        await_call(self, &watch);
        /* Enters the gate, unless its loop is over or another one has begun. */
        uint64_t gate = atomic_load(watch.gate);
        if (gate & GATE_ENDED) return NULL;
        if (!is_open_to(gate, self->worker)) continue;
        watch.seen = gate >> GATE_NUMBER;
        bool is_inside = false;
        while (!is_inside && gate >> GATE_NUMBER == watch.seen && (gate & GATE_OPEN))
            is_inside = atomic_compare_exchange_weak(watch.gate, &gate, gate + 1);
        if (!is_inside) continue;
        take_chunks(team, self->worker);
        gate = atomic_fetch_sub(watch.gate, 1);
        if ((gate & GATE_AWAITED) && (gate & GATE_INSIDE) == 1) sem_post(&team->is_done);
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
        publish_gate(team, GATE_ENDED, team->helper_count);
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
    bool const has_room = threads <= team->processor_count;
    if (atomic_load(&team->has_room) != has_room) atomic_store(&team->has_room, has_room);
    /* The gate is closed and nobody is inside. */
    team->shared.loop = *loop;
    team->shared.range_count = helper_count + 1;
    for (int i = 0; i <= helper_count; i++)
        atomic_store_explicit(&team->ranges[i].next, compute_range_begin(loop, helper_count + 1, i),
                              memory_order_relaxed);
    uint64_t const number = (atomic_load(&team->shared.gate) >> GATE_NUMBER) + 1;
    uint64_t const limit = (uint64_t)helper_count << GATE_LIMIT;
    publish_gate(team, number << GATE_NUMBER | limit | GATE_OPEN, helper_count);
    take_chunks(team, 0);
    /* No chunk is left: no more helpers enter, then those inside leave. */
    if ((atomic_fetch_sub(&team->shared.gate, GATE_OPEN) & GATE_INSIDE) == 0) return;
    if (look_for(team, sees_nobody, team)) return;
    if (atomic_fetch_or(&team->shared.gate, GATE_AWAITED) & GATE_INSIDE) await_post(&team->is_done);
}
