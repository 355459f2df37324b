/* world/worlds.c - worlds on threads of a host, and many worlds at once (tulle/threads.h). */
#include "tulle/threads.h"

#include "base/error.h"
#include "base/parallel.h"
#include "world/world_state.h"

#include <stdio.h>
#include <string.h>

tulle_status tulle_world_set_tasks(tulle_world *world, const tulle_tasks *tasks,
                                   tulle_error *error) {
    if (!world) return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the world is null");
    if (tasks && !tasks->run)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the tasks have no function");
    if (tasks) world->host_tasks = *tasks;
    world->work.tasks = tasks ? &world->host_tasks : NULL;
    return TULLE_OK;
}

/* The first world that failed among those that one worker stepped. */
typedef struct first_failure {
    tulle_error error;
    size_t world; /* SIZE_MAX: none */
} first_failure;

typedef struct batch_run {
    const tulle_world_batch *batch;
    double time_step;
    first_failure *failures; /* by worker */
} batch_run;

static void step_worlds(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    const batch_run *const self = context;
    const tulle_world_batch *const batch = self->batch;
    first_failure *const failure = &self->failures[worker];
    parallel_set_alone(true);
    for (size_t i = begin; i < end; i++) {
        tulle_step_report *const report = batch->reports ? &batch->reports[i] : NULL;
        bool const is_earlier = i < failure->world;
        tulle_status const status = tulle_world_step(batch->worlds[i], self->time_step, report,
                                                     is_earlier ? &failure->error : NULL);
        if (batch->statuses) batch->statuses[i] = status;
        if (status == TULLE_OK || !is_earlier) continue;
        failure->error.status = status;
        failure->world = i;
    }
    parallel_set_alone(false);
}

/* Whether every world is there, and once. */
static tulle_status check_worlds(tulle_world *const *worlds, size_t count, tulle_error *error) {
    size_t marked = 0;
    while (marked < count && worlds[marked] && !worlds[marked]->is_in_batch)
        worlds[marked++]->is_in_batch = true;
    bool const is_null = marked < count && !worlds[marked];
    for (size_t i = 0; i < marked; i++) worlds[i]->is_in_batch = false;
    if (marked == count) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "world %zu is %s", marked,
                     is_null ? "null" : "there twice");
}

tulle_status tulle_worlds_step(const tulle_world_batch *batch, double time_step,
                               tulle_error *error) {
    if (!batch || (!batch->worlds && batch->count > 0))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "the worlds are null");
    if (batch->threads < 0 || batch->threads > 256)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "there are %d threads; there must be 0 to 256", batch->threads);
    size_t const count = batch->count;
    tulle_status status = check_worlds(batch->worlds, count, error);
    if (status != TULLE_OK || count == 0) return status;
    int const workers = parallel_resolve_threads(batch->threads);
    memory heap = memory_default();
    first_failure *const failures =
        memory_allocate_zeroed(&heap, (size_t)workers, sizeof *failures);
    if (!failures)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory left to step %zu worlds",
                         count);
    for (int i = 0; i < workers; i++) failures[i].world = SIZE_MAX;
    batch_run run = {batch, time_step, failures};
    parallel_for(count, 1, workers, step_worlds, &run);
    const first_failure *first = &failures[0];
    for (int i = 1; i < workers; i++)
        if (failures[i].world < first->world) first = &failures[i];
    if (first->world != SIZE_MAX) {
        status = error_set(error, first->error.status, "world %zu: %.*s", first->world,
                           (int)(sizeof first->error.message - 32), first->error.message);
    }
    memory_release(&heap, failures, (size_t)workers * sizeof *failures);
    return status;
}
