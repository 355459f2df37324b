/* app/bench/input.c - inputs of `tulle bench`: the state of a scene while contact is in full swing,
 * made by simulating from the start and kept in a file, so that the work is done once.
 *
 * The file holds what tulle_world_save_state gives, with checks of its own. Its name says scene,
 * size, step, and a key of everything in the scene's description and of the physics. */
#define _POSIX_C_SOURCE 200809L
#include "app/bench/bench.h"
#include "app/cli/interrupt.h"
#include "app/commands.h"
#include "base/hash.h"
#include "base/timer.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { INPUT_PATH_SIZE = 2 * BENCH_PATH_SIZE };
static const double LINE_INTERVAL = 10.0; /* [s] between lines of progress without a terminal */

int bench_load_scene(const bench_session *self, const bench_case *which, tulle_scene **loaded) {
    char path[INPUT_PATH_SIZE];
    snprintf(path, sizeof path, "%s/%s.yaml", self->scenes, which->scene->file);
    const char *const *const overrides = which->scene->overrides[which->size];
    size_t count = 0;
    while (count < BENCH_OVERRIDE_MAX && overrides[count]) count++;
    tulle_scene_problems *const problems = calloc(1, sizeof *problems);
    if (!problems) return APP_EXIT_OUT_OF_MEMORY;
    tulle_status const status = tulle_scene_load(path, overrides, count, loaded, problems);
    if (status != TULLE_OK) scene_print_problems(problems, stderr);
    free(problems);
    return app_exit_for_input(status);
}

static void name_input(const bench_session *self, const bench_case *which,
                       const tulle_scene *loaded, char path[INPUT_PATH_SIZE]) {
    uint64_t const key = hash_mix(self->fingerprint ^ hash_mix(tulle_scene_get_hash(loaded)));
    snprintf(path, INPUT_PATH_SIZE, "%s/%s-%s-%u-%016llx.state", self->inputs, which->scene->name,
             bench_sizes[which->size].name, which->scene->capture_step, (unsigned long long)key);
}

/* ---- making ---- */

static int is_stopped(void *context) {
    (void)context;
    return interrupt_is_pending();
}

typedef struct capture_progress {
    double begin, shown; /* [s] of the clock */
} capture_progress;

static void show_step(bench_session *self, const bench_case *which, capture_progress *progress,
                      uint32_t done) {
    const char *const name = which->scene->name, *const size = bench_sizes[which->size].name;
    uint32_t const count = which->scene->capture_step;
    progress_bar_show(&self->bar, done, count, "%s %s: makes its input, step %u of %u", name, size,
                      done, count);
    double const now = timer_now();
    if (self->bar.is_terminal || now - progress->shown < LINE_INTERVAL) return;
    fprintf(stderr, "%s %s: makes its input, step %u of %u after %.0f s\n", name, size, done, count,
            now - progress->begin);
    progress->shown = now;
}

/* Simulates up to the captured step. */
static tulle_status simulate(bench_session *self, const bench_case *which,
                             const tulle_scene *loaded, tulle_world *world, tulle_error *error) {
    capture_progress progress = {timer_now(), timer_now()};
    tulle_world_set_stop_request(world, is_stopped, NULL);
    tulle_status status = tulle_world_start(world, error);
    for (uint32_t i = 0; i < which->scene->capture_step && status == TULLE_OK; i++) {
        status = tulle_world_step(world, tulle_scene_get_time_step(loaded), NULL, error);
        if (status == TULLE_OK) show_step(self, which, &progress, i + 1);
    }
    progress_bar_clear(&self->bar);
    if (status == TULLE_OK && timer_now() - progress.begin > 1.0)
        fprintf(stderr, "%s %s: made its input in %.0f s\n", which->scene->name,
                bench_sizes[which->size].name, timer_now() - progress.begin);
    return status;
}

/* Writes beside the path and moves there; 0 or an errno. */
static int write_whole(const char *path, const void *bytes, size_t byte_count) {
    char beside[INPUT_PATH_SIZE + 32];
    snprintf(beside, sizeof beside, "%s.%ld.tmp", path, (long)getpid());
    FILE *const file = fopen(beside, "wb");
    if (!file) return errno;
    int code = fwrite(bytes, 1, byte_count, file) == byte_count && fflush(file) == 0 ? 0 : errno;
    if (fclose(file) != 0 && !code) code = errno;
    if (!code && rename(beside, path) != 0) code = errno;
    if (code) unlink(beside);
    return code;
}

static int keep_state(const tulle_world *world, const char *path, tulle_error *error) {
    void *bytes = NULL;
    size_t byte_count = 0;
    tulle_status const status = tulle_world_save_state(world, &bytes, &byte_count, error);
    if (status != TULLE_OK) return app_exit_for_run(status);
    int const fault = write_whole(path, bytes, byte_count);
    tulle_world_free_state(world, bytes, byte_count);
    if (!fault) return APP_EXIT_FINE;
    app_print_message("bench", "%s: cannot be written: %s", path, strerror(fault));
    return APP_EXIT_CANNOT_GO_ON;
}

static int make_input(bench_session *self, const bench_case *which, tulle_scene *loaded,
                      const char *path) {
    tulle_error error = {0};
    tulle_scene_world built = {0};
    int code = APP_EXIT_FINE;
    tulle_status status = tulle_scene_build_world(loaded, 0, NULL, &built, &error);
    if (status == TULLE_OK) status = simulate(self, which, loaded, built.world, &error);
    if (status == TULLE_OK) code = keep_state(built.world, path, &error);
    tulle_scene_destroy_world(&built);
    if (error.status != TULLE_OK && status != TULLE_ERROR_INTERRUPTED)
        app_print_error("bench", &error);
    return status != TULLE_OK ? app_exit_for_run(status) : code;
}

int bench_get_input(bench_session *self, const bench_case *which, tulle_scene *loaded,
                    bench_input *input) {
    name_input(self, which, loaded, input->path);
    if (self->renews_inputs || access(input->path, F_OK) != 0) {
        int const code = make_input(self, which, loaded, input->path);
        if (code != APP_EXIT_FINE) return code;
    }
    return APP_EXIT_FINE;
}
