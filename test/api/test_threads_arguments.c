/* Arguments of the public functions of tulle/threads.h. */
#include "api/arguments.h"
#include "support/small_world.h"

static const double STEP = 1.0 / 64.0;
enum { WORLD_COUNT = 3 };
static tulle_world *worlds[WORLD_COUNT];
static tulle_step_report reports[WORLD_COUNT];
static tulle_status statuses[WORLD_COUNT];

static tulle_world *make_world(void) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *world = NULL;
    FINE(tulle_world_create(&def, &world, &error));
    tulle_mesh sheet = small_sheet(0.3, 4, 0.1);
    (void)small_add_cloth(world, &sheet);
    tulle_mesh_destroy(&sheet);
    return world;
}

static int set_up(void **unused) {
    (void)unused;
    for (int i = 0; i < WORLD_COUNT; i++) worlds[i] = make_world();
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    for (int i = 0; i < WORLD_COUNT; i++) tulle_world_destroy(worlds[i]);
    return 0;
}

static int run_count;
static void run_in_order(void *context, tulle_task task, void *work, size_t count) {
    (void)context;
    run_count++;
    for (size_t i = 0; i < count; i++) task(work, i);
}

ARGUMENTS_OF(tulle_world_set_tasks) {
    tulle_tasks const good = {run_in_order, NULL}, bad = {NULL, worlds};
    REFUSED(tulle_world_set_tasks(NULL, &good, &error));
    REFUSED(tulle_world_set_tasks(NULL, NULL, &error));
    REFUSED(tulle_world_set_tasks(worlds[0], &bad, &error));
    assert_int_equal(tulle_world_set_tasks(NULL, NULL, NULL), TULLE_ERROR_INVALID_ARGUMENT);
    FINE(tulle_world_set_tasks(worlds[0], &good, NULL));
    FINE(tulle_world_set_tasks(worlds[0], NULL, &error));
}

/* No world has stepped after a call that was refused. */
static void expect_steps(uint64_t count) {
    for (int i = 0; i < WORLD_COUNT; i++)
        assert_int_equal(tulle_world_get_step_count(worlds[i]), count);
}

static tulle_status step_worlds(tulle_world *const *list, size_t count, double time_step,
                                int threads) {
    tulle_world_batch const batch = {list, count, threads, reports, statuses};
    return tulle_worlds_step(&batch, time_step, &error);
}

ARGUMENTS_OF(tulle_worlds_step) {
    for (int i = 0; i < WORLD_COUNT; i++) statuses[i] = TULLE_ERROR_IO;
    REFUSED(tulle_worlds_step(NULL, STEP, &error));
    assert_int_equal(tulle_worlds_step(NULL, STEP, NULL), TULLE_ERROR_INVALID_ARGUMENT);
    REFUSED(step_worlds(NULL, 1, STEP, 1));
    REFUSED(step_worlds(NULL, SIZE_MAX, STEP, 1));
    FINE(step_worlds(NULL, 0, STEP, 1));
    FINE(step_worlds(worlds, 0, (double)NAN, 0));
    int const no_threads[] = {-1, 257, INT_MIN, INT_MAX};
    for (int i = 0; i < 4; i++) REFUSED(step_worlds(worlds, WORLD_COUNT, STEP, no_threads[i]));
    tulle_world *const with_null[] = {worlds[0], worlds[1], NULL};
    tulle_world *const twice[] = {worlds[0], worlds[1], worlds[0]};
    for (int threads = 0; threads < 3; threads++) {
        REFUSED(step_worlds(with_null, 3, STEP, threads));
        REFUSED(step_worlds(twice, 3, STEP, threads));
    }
    for (int i = 0; i < WORLD_COUNT; i++) assert_int_equal(statuses[i], TULLE_ERROR_IO);
    expect_steps(0);
    static const double no_steps[] = {(double)NAN, (double)INFINITY, 0.0, -STEP, 1.5};
    for (int i = 0; i < 5; i++) {
        REFUSED(step_worlds(worlds, WORLD_COUNT, no_steps[i], 2));
        for (int k = 0; k < WORLD_COUNT; k++)
            assert_int_equal(statuses[k], TULLE_ERROR_INVALID_ARGUMENT);
    }
    expect_steps(0);
    tulle_world_batch const plain = {.worlds = worlds, .count = WORLD_COUNT};
    FINE(tulle_worlds_step(&plain, STEP, NULL));
    FINE(step_worlds(worlds, WORLD_COUNT, STEP, 0));
    for (int i = 0; i < WORLD_COUNT; i++) assert_int_equal(statuses[i], TULLE_OK);
    expect_steps(2);
}

int main(void) { return run_arguments(HEADERS("tulle/threads.h"), set_up, tear_down); }
