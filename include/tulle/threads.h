/* tulle/threads.h - worlds and threads: what may run beside what, loops on the threads of a host,
 * many worlds at once.
 *
 * What may run at the same time:
 *
 *   - Calls for different worlds, on any threads. Worlds share nothing, so each comes to the bits
 *     that it has alone. A world may go from thread to thread, as long as what one thread did is
 *     seen by the next.
 *   - Calls for one world that only read it, those with a `const tulle_world *`. What they give
 *     is borrowed until a call that changes the world.
 *   - Functions that take no world: shapes, meshes, materials, the judge, a detector of one's own.
 *
 * What may not: two calls for one world of which one changes it; and a call for a world from a
 * task, a stop request or a frame reader of that world, but for what tulle_stop_request allows.
 *
 * What the host shares must bear it: an allocator, tasks, a frame reader or a stop request that
 * several worlds have is called from several threads at once. A thread that calls the library with
 * more than one thread to a world keeps helpers, which end with that thread. */
#ifndef TULLE_THREADS_H
#define TULLE_THREADS_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Lets tulle_world_start, tulle_world_step, tulle_world_load_state and tulle_cloth_get_patches run
 * their loops by `tasks`, copied, in place of threads of the library: at most def.threads tasks at
 * a time, some thousand times a step. The bits are the same. `run` is called by the thread that
 * called the world; while it waits it may do other work, also for other worlds. Null `tasks`:
 * threads of the library again. May be called before the start and between any calls. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null world, null `run`); all stays as it was then. */
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
/* Makes one step of `time_step` [s] of each world, as tulle_world_step does. Each steps on one of
 * the threads alone, whatever its def.threads and tasks are, and comes to the same bits. For many
 * small worlds; a large one is better stepped by itself, on threads of its own.
 *
 * A world whose step fails is as it was and keeps no other from its step. The call then returns the
 * status of the first of them, and `error` says which that is. Errors before any step:
 * TULLE_ERROR_INVALID_ARGUMENT (null, a null world or one that is there twice, threads out of
 * range), TULLE_ERROR_OUT_OF_MEMORY; `reports` and `statuses` are not filled then. */
TULLE_API tulle_status tulle_worlds_step(const tulle_world_batch *batch, double time_step,
                                         tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
