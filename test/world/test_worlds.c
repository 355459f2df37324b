/* Many worlds on threads (tulle/threads.h): each comes to the bits that it has alone, whoever runs
 * its loops, whatever other worlds do meanwhile, and also where some of them fail. */
#include "tulle/threads.h"

#include "support/body_world.h"
#include "support/test_support.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WORLDS = 12, STEPS = 12 };
static const double STEP = 1.0 / 60.0; /* [s] */

static void expect_ok(tulle_status status, const tulle_error *error) {
    if (status != TULLE_OK) fail_msg("%s", error->message);
}

/* Cloth falls over a ball and a box on a floor. `size` is that of the cloth; worlds of other
 * numbers start otherwise. */
static tulle_world *make_world(int number, unsigned size, int threads) {
    tulle_world_def world_def = tulle_world_def_default();
    world_def.threads = threads;
    world_def.wind.velocity[0] = 0.3 * number;
    tulle_world *world = NULL;
    tulle_error error = {0};
    expect_ok(tulle_world_create(&world_def, &world, &error), &error);
    tulle_mesh sheet = small_sheet(0.3, size, 0.12 + 0.003 * number);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.velocity[2] = -2.0;
    expect_ok(tulle_world_add_cloth(world, &cloth, NULL, &error), &error);
    tulle_mesh ball = bodies_make_ball(0.1, 5, (double[]){0.0, 0.0, 0.0});
    tulle_mesh floor = bodies_make_box(2.0, 2.0, 0.1, (double[]){0.0, 0.0, -0.2});
    tulle_mesh box = bodies_make_box(0.1, 0.1, 0.1, (double[]){0.3, 0.0, -0.09});
    small_add_obstacle(world, &ball);
    small_add_obstacle(world, &floor);
    tulle_body const body = {.is_dynamic = 1, .density = 300.0};
    bodies_add_obstacle(world, &box, 0.5, &body);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
    tulle_mesh_destroy(&floor);
    tulle_mesh_destroy(&box);
    return world;
}

/* Hashes of world `number` after each step, made alone. */
static void step_alone(int number, uint64_t hashes[STEPS]) {
    tulle_world *const world = make_world(number, 8, 1);
    tulle_error error = {0};
    for (int step = 0; step < STEPS; step++) {
        expect_ok(tulle_world_step(world, STEP, NULL, &error), &error);
        hashes[step] = tulle_world_get_state_hash(world);
    }
    tulle_world_destroy(world);
}

static void worlds_of_a_batch_are_as_alone(void **state) {
    (void)state;
    static uint64_t hashes[WORLDS][STEPS];
    for (int i = 0; i < WORLDS; i++) step_alone(i, hashes[i]);
    int const threads[] = {1, 2, 5, 0};
    for (int t = 0; t < 4; t++) {
        tulle_world *worlds[WORLDS];
        tulle_step_report reports[WORLDS];
        tulle_error error = {0};
        tulle_world_batch const batch = {worlds, WORLDS, threads[t], reports, NULL};
        for (int i = 0; i < WORLDS; i++) worlds[i] = make_world(i, 8, 1 + i % 3);
        for (int step = 0; step < STEPS; step++) {
            expect_ok(tulle_worlds_step(&batch, STEP, &error), &error);
            for (int i = 0; i < WORLDS; i++) {
                if (tulle_world_get_state_hash(worlds[i]) != hashes[i][step])
                    fail_msg("%d threads: other bits of world %d in step %d", threads[t], i, step);
                assert_int_equal(reports[i].step, step);
            }
        }
        for (int i = 0; i < WORLDS; i++) tulle_world_destroy(worlds[i]);
    }
}

static int stop_now(void *context) {
    (void)context;
    return 1;
}

/* The worlds that cannot step are as before and keep no other from its step; the error is that of
 * the first. */
static void some_may_fail(void **state) {
    (void)state;
    tulle_world *worlds[WORLDS];
    tulle_status statuses[WORLDS];
    tulle_error error = {0};
    tulle_world_batch batch = {worlds, WORLDS, 2, NULL, statuses};
    for (int i = 0; i < WORLDS; i++) worlds[i] = make_world(i, 5, 1);
    expect_ok(tulle_worlds_step(&batch, STEP, &error), &error);
    static const int stopped[] = {4, 5, 9};
    for (int threads = 1; threads <= 4; threads++) {
        uint64_t before[WORLDS];
        batch.threads = threads;
        for (int i = 0; i < WORLDS; i++) before[i] = tulle_world_get_state_hash(worlds[i]);
        for (int k = 0; k < 3; k++)
            tulle_world_set_stop_request(worlds[stopped[k]], stop_now, NULL);
        assert_int_equal(tulle_worlds_step(&batch, STEP, &error), TULLE_ERROR_INTERRUPTED);
        assert_int_equal(error.status, TULLE_ERROR_INTERRUPTED);
        assert_non_null(strstr(error.message, "world 4: interrupted"));
        for (int i = 0; i < WORLDS; i++) {
            bool const fails = i == 4 || i == 5 || i == 9;
            assert_int_equal(statuses[i], fails ? TULLE_ERROR_INTERRUPTED : TULLE_OK);
            assert_true((tulle_world_get_state_hash(worlds[i]) == before[i]) == fails);
        }
        for (int k = 0; k < 3; k++) tulle_world_set_stop_request(worlds[stopped[k]], NULL, NULL);
    }
    for (int i = 0; i < WORLDS; i++) tulle_world_destroy(worlds[i]);
}

/* ---- tasks of a host ---- */

enum { TASKS_MOST = 8 };
typedef struct host {
    atomic_size_t calls, tasks;
    tulle_world *other; /* steps while the first world waits */
    int is_inside;
} host;
typedef struct host_task {
    tulle_task task;
    void *work;
    size_t index;
} host_task;

static void *run_task(void *argument) {
    const host_task *const self = argument;
    self->task(self->work, self->index);
    return NULL;
}

/* Threads for the tasks; now and then the thread that waits steps another world. */
static void run_on_threads(void *context, tulle_task task, void *work, size_t count) {
    host *const self = context;
    pthread_t threads[TASKS_MOST];
    host_task tasks[TASKS_MOST];
    assert_true(count >= 2 && count <= TASKS_MOST);
    bool const is_outer = !self->is_inside;
    for (size_t i = 0; i < count; i++) {
        tasks[i] = (host_task){task, work, i};
        if (i > 0) assert_int_equal(pthread_create(&threads[i], NULL, run_task, &tasks[i]), 0);
    }
    if (is_outer && atomic_load(&self->calls) % 400 == 7) {
        self->is_inside = 1;
        assert_int_equal(tulle_world_step(self->other, STEP, NULL, NULL), TULLE_OK);
        self->is_inside = 0;
    }
    (void)run_task(&tasks[0]);
    for (size_t i = 1; i < count; i++) pthread_join(threads[i], NULL);
    atomic_fetch_add(&self->calls, 1);
    atomic_fetch_add(&self->tasks, count);
}

static void a_host_may_run_the_loops_of_a_world(void **state) {
    (void)state;
    enum { FINE_SIDE = 30, FEW = 3 };
    tulle_world *const own = make_world(0, FINE_SIDE, 1), *const given =
                                                              make_world(0, FINE_SIDE, 4);
    tulle_world *const twin = make_world(1, 8, 1);
    host of = {.other = make_world(1, 8, 2)};
    tulle_tasks tasks = {run_on_threads, &of};
    tulle_error error = {0};
    expect_ok(tulle_world_set_tasks(given, &tasks, &error), &error);
    expect_ok(tulle_world_set_tasks(of.other, &tasks, &error), &error);
    tasks = (tulle_tasks){0}; /* they were copied */
    for (int step = 0; step < FEW; step++) {
        expect_ok(tulle_world_step(own, STEP, NULL, &error), &error);
        expect_ok(tulle_world_step(given, STEP, NULL, &error), &error);
        assert_true(tulle_world_get_state_hash(own) == tulle_world_get_state_hash(given));
    }
    size_t const calls = atomic_load(&of.calls);
    print_message("%d calls, %d tasks\n", (int)calls, (int)atomic_load(&of.tasks));
    assert_true(calls > 100);
    while (tulle_world_get_step_count(twin) < tulle_world_get_step_count(of.other))
        expect_ok(tulle_world_step(twin, STEP, NULL, &error), &error);
    assert_true(tulle_world_get_step_count(twin) > 0);
    assert_true(tulle_world_get_state_hash(twin) == tulle_world_get_state_hash(of.other));
    expect_ok(tulle_world_set_tasks(given, NULL, &error), &error);
    expect_ok(tulle_world_step(own, STEP, NULL, &error), &error);
    expect_ok(tulle_world_step(given, STEP, NULL, &error), &error);
    assert_true(tulle_world_get_state_hash(own) == tulle_world_get_state_hash(given));
    assert_int_equal(atomic_load(&of.calls), calls);
    /* a batch asks no host */
    tulle_world_batch const batch = {&of.other, 1, 2, NULL, NULL};
    expect_ok(tulle_worlds_step(&batch, STEP, &error), &error);
    assert_int_equal(atomic_load(&of.calls), calls);
    tulle_world_destroy(own);
    tulle_world_destroy(given);
    tulle_world_destroy(twin);
    tulle_world_destroy(of.other);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(worlds_of_a_batch_are_as_alone),
        cmocka_unit_test(some_may_fail),
        cmocka_unit_test(a_host_may_run_the_loops_of_a_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
