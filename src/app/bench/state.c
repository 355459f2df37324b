/* app/bench/state.c - the state of a scene that steps are timed from: made by simulating from the
 * start, and kept in a file if one is named, so that the work is done once. */
#include "app/bench/bench.h"
#include "app/cli/interrupt.h"
#include "app/commands.h"
#include "base/error.h"
#include "base/timer.h"

#include "tulle_io/mesh_files.h"

#include <string.h>
#include <unistd.h>

static const double LINE_INTERVAL = 10.0; /* [s] between lines of progress without a terminal */

static int is_stopped(void *context) {
    (void)context;
    return interrupt_is_pending();
}

/* Simulates the skipped steps. */
static tulle_status simulate(bench_session *self, const tulle_scene *loaded, tulle_world *world,
                             tulle_error *error) {
    double const begin = timer_now();
    double shown = begin; /* [s] of the clock */
    uint32_t const count = self->skip_count;
    tulle_world_set_stop_request(world, is_stopped, NULL);
    tulle_status status = app_start_world(world, self->scene_path, error);
    for (uint32_t done = 1; done <= count && status == TULLE_OK; done++) {
        status = tulle_world_step(world, tulle_scene_get_time_step(loaded), NULL, error);
        if (status != TULLE_OK) break;
        progress_bar_show(&self->bar, done, count, "%s %s: to where it is timed, step %u of %u",
                          self->name, self->size, done, count);
        double const now = timer_now();
        if (self->bar.is_terminal || now - shown < LINE_INTERVAL) continue;
        fprintf(stderr, "%s %s: to where it is timed, step %u of %u after %.0f s\n", self->name,
                self->size, done, count, now - begin);
        shown = now;
    }
    progress_bar_clear(&self->bar);
    if (status == TULLE_OK && timer_now() - begin > 1.0)
        fprintf(stderr, "%s %s: %u steps to where it is timed took %.0f s\n", self->name,
                self->size, count, timer_now() - begin);
    return status;
}

static tulle_status make_state(bench_session *self, tulle_scene *loaded, memory *heap,
                               file_data *state, tulle_error *error) {
    tulle_scene_world built = {0};
    void *saved = NULL;
    size_t size = 0;
    tulle_status status = tulle_scene_build_world(loaded, 0, NULL, &built, error);
    if (status == TULLE_OK) status = simulate(self, loaded, built.world, error);
    if (status == TULLE_OK) status = tulle_world_save_state(built.world, &saved, &size, error);
    if (status == TULLE_OK) {
        *state = (file_data){memory_allocate(heap, size + 1), size};
        if (state->bytes)
            memcpy(state->bytes, saved, size);
        else
            status =
                error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for %zu bytes", size);
        tulle_world_free_state(built.world, saved, size);
    }
    tulle_scene_destroy_world(&built);
    return status;
}

int bench_get_state(bench_session *self, tulle_scene *loaded, memory *heap, file_data *state) {
    tulle_error error = {0};
    tulle_status status = TULLE_OK;
    const char *const path = self->state_path;
    if (path && access(path, F_OK) == 0) {
        status = file_load(heap, path, 0, state, &error);
        if (status != TULLE_OK) app_print_error("bench", &error);
        return app_exit_for_input(status);
    }
    status = make_state(self, loaded, heap, state, &error);
    if (status == TULLE_OK && path)
        status = tulle_file_write(path, state->bytes, state->byte_count, &error);
    if (status == TULLE_OK) return APP_EXIT_FINE;
    if (status != TULLE_ERROR_INTERRUPTED) app_print_error("bench", &error);
    file_release(heap, state);
    return app_exit_for_run(status);
}
