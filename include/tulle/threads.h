/* tulle/threads.h - worlds and threads: calls that may run at the same time, loops on the threads
 * of a host, many worlds at once.
 *
 * These may run at the same time:
 *
 *   - Calls for different worlds, on any threads. Worlds share nothing, so the results of each are
 *     the same as alone. A world may go from thread to thread if the next thread sees the writes of
 *     the one before.
 *   - Calls for one world that only read it: all that take a `const tulle_world *`. Their results
 *     are borrowed until a call that changes the world.
 *   - Functions that take no world: shapes, meshes, materials, the judge, your own detector.
 *
 * These may not run at the same time: two calls for one world if one of them changes it. A task, a
 * stop request or a frame reader of a world must not call that world; tulle_stop_request lists the
 * exceptions.
 *
 * An allocator, tasks, a frame reader or a stop request that several worlds share is called from
 * several threads at once and must allow this. A thread that calls the library for a world with
 * more than one thread keeps helper threads; they end with that thread. */
#ifndef TULLE_THREADS_H
#define TULLE_THREADS_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Runs the loops of tulle_world_start, tulle_world_step, tulle_world_load_state and
 * tulle_cloth_get_patches as `tasks`, which is copied, instead of on threads of the library: at
 * most def.threads tasks at a time, some thousand times a step. Results do not change. The thread
 * that called the world calls `run`; while it waits it may do other work, also for other worlds.
 * Null `tasks`: threads of the library again. May be called before the start and between any calls.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (null world, null `run`); nothing then changes. */
TULLE_API tulle_status tulle_world_set_tasks(tulle_world *world, const tulle_tasks *tasks,
                                             tulle_error *error);

/* Worlds that step together. */
typedef struct tulle_world_batch {
    tulle_world *const *worlds; /* `count` worlds, each once */
    size_t count;               /* length of `worlds` */
    int threads;                /* 0 .. 256; 0: one per processor */
    tulle_step_report *reports; /* gets `count` reports, in the order of the worlds; or null */
    tulle_status *statuses;     /* gets what tulle_world_step returned for each; or null */
} tulle_world_batch;
/* Makes one step of `time_step` [s] of each world, as tulle_world_step does. Each world steps on
 * one thread, whatever its def.threads and tasks are, with the same results. This is for many small
 * worlds; step a large world by itself, on several threads.
 *
 * A world whose step fails is as it was, and the other worlds still step. The call then returns the
 * status of the first world that failed, and `error` says which world it is. Errors before any
 * step: TULLE_ERROR_INVALID_ARGUMENT (null, a null world, a world given twice, threads out of
 * range), TULLE_ERROR_OUT_OF_MEMORY; `reports` and `statuses` are then not filled. */
TULLE_API tulle_status tulle_worlds_step(const tulle_world_batch *batch, double time_step,
                                         tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
