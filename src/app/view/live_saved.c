/* app/view/live_saved.c - states of a live scene to which one can rewind. They are spread over the
 * whole time: when there is no more room, every second one goes, and from then on they are saved
 * half as often. The first stays. */
#include "app/view/live_thread.h"

#include "base/error.h"

#include <math.h>
#include <string.h>

enum { SAVED_BYTES_MAX = 256 << 20 /* [bytes] of all states */ };
static const double SAVE_SECONDS = 0.25; /* [s] of the scene between two states, at first */

static void drop(view_live *live, size_t index) {
    live_saved *const saved = &live->saved[index];
    live->saved_bytes -= saved->byte_count;
    memory_release(&live->heap, saved->bytes, saved->byte_count);
    live->saved_count--;
    memmove(saved, saved + 1, (live->saved_count - index) * sizeof *saved);
}

static void thin_out(view_live *live) {
    for (size_t i = 1; i < live->saved_count; i++) drop(live, i);
    live->save_interval *= 2;
}

void live_save_if_due(view_live *live) {
    tulle_world *const world = live->built.world;
    uint64_t const step = tulle_world_get_step_count(world);
    if (live->saved_count == 0)
        live->save_interval =
            (uint64_t)fmax(1.0, SAVE_SECONDS / tulle_scene_get_time_step(live->options.scene));
    if (live->saved_count > 0 &&
        step - live->saved[live->saved_count - 1].step < live->save_interval)
        return;
    size_t const size = tulle_world_get_state_size(world);
    if (live->saved_count > 0 && size > SAVED_BYTES_MAX / 4) return; /* two and a few: of no use */
    while (live->saved_count > 1 &&
           (live->saved_count == LIVE_SAVED_MAX || live->saved_bytes + size > SAVED_BYTES_MAX))
        thin_out(live);
    live_saved *const saved = &live->saved[live->saved_count];
    *saved = (live_saved){.step = step,
                          .bytes = memory_allocate(&live->heap, size),
                          .byte_count = size,
                          .script_bytes = atomic_load(&live->script.byte_count),
                          .hold = live->hold};
    size_t written = 0;
    if (!saved->bytes ||
        tulle_world_save_state_into(world, saved->bytes, size, &written, NULL) != TULLE_OK) {
        memory_release(&live->heap, saved->bytes, size);
        return;
    }
    live->saved_count++;
    live->saved_bytes += size;
}

void live_forget_saved(view_live *live) {
    while (live->saved_count > 0) drop(live, live->saved_count - 1);
}

/* A world in which the same obstacles are driven as when the state was saved. The states that were
 * saved stay. */
static tulle_status build_as_then(view_live *live, const live_hold *then, tulle_error *error) {
    size_t const count = live->saved_count, bytes = live->saved_bytes;
    live_saved *const kept = memory_allocate(&live->heap, count * sizeof *kept);
    if (!kept) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for a rewind");
    memcpy(kept, live->saved, count * sizeof *kept);
    live->saved_count = live->saved_bytes = 0;
    tulle_status status = live_build(live, error);
    memcpy(live->saved, kept, count * sizeof *kept);
    memory_release(&live->heap, kept, count * sizeof *kept);
    live->saved_count = count;
    live->saved_bytes = bytes;
    for (size_t i = 0; i < then->driven_count && status == TULLE_OK; i++)
        if (!then->driven[i].is_body)
            status = scene_drive_obstacle(live->options.scene, &live->built,
                                          then->driven[i].object - live->built.cloth_count, error);
    return status;
}

static size_t count_obstacles(const live_hold *hold) {
    size_t count = 0;
    for (size_t i = 0; i < hold->driven_count; i++) count += !hold->driven[i].is_body;
    return count;
}

tulle_status live_rewind(view_live *live, uint64_t step, tulle_error *error) {
    size_t index = live->saved_count;
    for (size_t i = 0; i < live->saved_count; i++)
        if (live->saved[i].step <= step) index = i;
    if (index == live->saved_count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "no state is kept of step %llu",
                         (unsigned long long)step);
    const live_saved *const saved = &live->saved[index];
    tulle_status status = TULLE_OK;
    if (count_obstacles(&saved->hold) != count_obstacles(&live->hold))
        status = build_as_then(live, &saved->hold, error);
    if (status == TULLE_OK)
        status = tulle_world_load_state(live->built.world, saved->bytes, saved->byte_count, error);
    if (status != TULLE_OK) return status;
    live->hold = saved->hold;
    record_cut(&live->script, saved->script_bytes);
    while (live->saved_count > index + 1) drop(live, live->saved_count - 1);
    live->has_failed = false;
    live->report = (tulle_step_report){.step = saved->step};
    return TULLE_OK;
}
