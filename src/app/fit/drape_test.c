/* app/fit/drape_test.c - see drape_test.h. */
#include "app/fit/drape_test.h"

#include "app/cli/interrupt.h"
#include "app/cli/progress_bar.h"
#include "base/error.h"
#include "base/parallel.h"

#include <stdatomic.h>
#include <stdlib.h>

static const double TIME_STEP = 1.0 / 90.0; /* [s] */
enum {
    STEPS_BETWEEN_LOOKS = 45,
    LOOKS_LEAST = 3, /* 1.5 s: before that cloth that starts level may seem to be at rest */
    LOOKS_MOST = 12
};

static int is_stopped(void *context) {
    (void)context;
    return interrupt_is_pending();
}

static tulle_status simulate(drape_test *test, drape_sample *sample, tulle_world *world,
                             tulle_error *error) {
    tulle_cloth_def const def = drape_sample_get_cloth(sample, &test->material);
    tulle_cloth_id id = {0};
    tulle_status status = tulle_world_add_cloth(world, &def, &id, error);
    tulle_world_set_stop_request(world, is_stopped, NULL);
    for (int look = 0; look < LOOKS_MOST && !(look >= LOOKS_LEAST && test->is_at_rest); look++) {
        for (int i = 0; i < STEPS_BETWEEN_LOOKS && status == TULLE_OK; i++)
            status = tulle_world_step(world, TIME_STEP, NULL, error);
        if (status != TULLE_OK) return status;
        size_t count = 0;
        const double *const velocities = tulle_cloth_get_velocities(world, id, &count);
        test->is_at_rest = drape_is_at_rest(velocities, count);
    }
    const double *const x = tulle_cloth_get_positions(world, id, NULL);
    test->coefficient = drape_measure_coefficient(sample, x);
    test->folds = drape_count_folds(sample, x);
    return TULLE_OK;
}

static tulle_status run_test(drape_test *test, tulle_error *error) {
    drape_sample sample;
    tulle_world *world = NULL;
    tulle_world_def def = tulle_world_def_default();
    def.quality = TULLE_QUALITY_EXACT; /* as for all that is measured */
    def.threads = 1;
    def.wind.drag_coefficient = 0.0; /* air would only delay the rest */
    test->is_at_rest = false;
    if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
    tulle_status status = drape_sample_make(test->pattern, test->cell, test->seed, &sample, error);
    if (status == TULLE_OK) status = tulle_world_create(&def, &world, error);
    if (status == TULLE_OK) status = simulate(test, &sample, world, error);
    tulle_world_destroy(world);
    drape_sample_destroy(&sample);
    return status;
}

typedef struct test_batch {
    drape_test *tests;
    tulle_error *errors;
    size_t count;
    atomic_size_t done;
    progress_bar bar; /* drawn by the first worker alone */
} test_batch;

static void run_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    test_batch *const batch = context;
    (void)chunk;
    for (size_t i = begin; i < end; i++) {
        tulle_status const status = run_test(&batch->tests[i], &batch->errors[i]);
        batch->errors[i].status = status;
        size_t const done = atomic_fetch_add(&batch->done, 1) + 1;
        if (worker == 0)
            progress_bar_show(&batch->bar, done, batch->count, "drape tests at once: %zu of %zu",
                              done, batch->count);
    }
}

tulle_status drape_test_run(drape_test *tests, size_t count, int threads, tulle_error *error) {
    test_batch batch = {.tests = tests,
                        .errors = calloc(count, sizeof *batch.errors),
                        .count = count,
                        .bar = progress_bar_begin()};
    if (!batch.errors)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for drape tests");
    parallel_for(count, 1, threads, run_chunk, &batch);
    progress_bar_clear(&batch.bar);
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < count && status == TULLE_OK; i++) {
        status = batch.errors[i].status;
        if (status != TULLE_OK) *error = batch.errors[i];
    }
    free(batch.errors);
    return status;
}
