/* Cloth that flies so fast that all of its paths meet: a step takes little memory, by shorter
 * substeps. Cloth that is crowded at rest, by a contact distance of its own size, fails its step.
 * Cloth that lands too hard for a whole step costs few solves more than shorter steps do. */
#include "support/small_world.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 90.0;       /* [s] */
static const size_t MEMORY_MOST = 64u << 20; /* [bytes]; all candidates would take 3 GB */
static const double SPEED = 1000.0;          /* [m/s] along each axis */
enum { SIDE = 61 };
static const double LANDING_SPEED = 80.0; /* [m/s] */
/* Solves that go on with a landing too hard for the step take ten times as many. */
enum { LANDING_ITERATIONS = 100 };

/* Counts what is held. */
typedef struct counted_heap {
    size_t held, most;
} counted_heap;

static void *counted_allocate(void *context, size_t byte_count) {
    counted_heap *const heap = context;
    heap->held += byte_count;
    if (heap->held > heap->most) heap->most = heap->held;
    return malloc(byte_count);
}

static void counted_release(void *context, void *pointer, size_t byte_count) {
    ((counted_heap *)context)->held -= byte_count;
    free(pointer);
}

static tulle_world *make_world(counted_heap *heap, int threads, double contact_distance,
                               const tulle_mesh *sheet, double speed) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = threads;
    def.allocator = (tulle_allocator){counted_allocate, counted_release, heap, 0};
    def.contact_distance = contact_distance;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(sheet);
    for (int k = 0; k < 3; k++) cloth.velocity[k] = speed;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    return world;
}

static uint64_t fly(int threads) {
    tulle_mesh sheet = small_sheet(1.0, SIDE, 0.0);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.4;
    tulle_mesh ball = small_shape(shape, 10.0, 10.0, 10.0);
    counted_heap heap = {0};
    tulle_world *const world = make_world(&heap, threads, 0.0, &sheet, SPEED);
    small_add_obstacle(world, &ball);
    for (int i = 0; i < 2; i++) {
        tulle_step_report report;
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, &report, &error) != TULLE_OK)
            fail_msg("%s", error.message);
        assert_int_equal(small_judge(world, &sheet, 1, &ball, 1), 0);
        if (i == 0) assert_true(report.substeps > 1);
    }
    uint64_t const hash = tulle_world_get_state_hash(world);
    print_message("%d threads: %.1f MB at most\n", threads, (double)heap.most / (1 << 20));
    assert_true(heap.most < MEMORY_MOST);
    tulle_world_destroy(world);
    assert_int_equal(heap.held, 0);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
    return hash;
}

static void fast_cloth_takes_little_memory(void **state) {
    (void)state;
    uint64_t const hash = fly(1);
    assert_true(fly(2) == hash);
}

static void cloth_that_is_crowded_at_rest_fails_its_step(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(1.0, SIDE, 0.0);
    counted_heap heap = {0};
    tulle_world *const world = make_world(&heap, 1, 1.0, &sheet, 0.0);
    tulle_error error = {0};
    assert_int_equal(tulle_world_start(world, &error), TULLE_OK);
    uint64_t const hash = tulle_world_get_state_hash(world);
    assert_int_equal(tulle_world_step(world, STEP, NULL, &error), TULLE_ERROR_LIMIT);
    print_message("%s, %.1f MB\n", error.message, (double)heap.most / (1 << 20));
    assert_non_null(strstr(error.message, "step 0 has too many candidate pairs"));
    assert_true(tulle_world_get_state_hash(world) == hash);
    assert_true(tulle_world_get_time(world) == 0.0);
    assert_true(heap.most < MEMORY_MOST);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
}

static void a_landing_too_hard_for_the_step_is_cut_at_once(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(1.0, 41, 0.5);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.1;
    tulle_mesh ball = small_shape(shape, 0.013, 0.021, 0.0);
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.velocity[2] = -LANDING_SPEED;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    small_add_obstacle(world, &ball);
    for (int i = 0; i < 3; i++) {
        tulle_step_report report;
        tulle_error error = {0};
        if (tulle_world_step(world, STEP, &report, &error) != TULLE_OK)
            fail_msg("%s", error.message);
        print_message("%u substeps, %u solves, %u iterations\n", report.substeps,
                      report.solve_count, report.cg_iterations);
        assert_int_equal(small_judge(world, &sheet, 1, &ball, 1), 0);
        assert_true(report.substeps > 1);
        assert_int_equal(report.cg_converged, 1);
        if (i == 0) assert_true(report.cg_iterations < LANDING_ITERATIONS);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fast_cloth_takes_little_memory),
        cmocka_unit_test(cloth_that_is_crowded_at_rest_fails_its_step),
        cmocka_unit_test(a_landing_too_hard_for_the_step_is_cut_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
