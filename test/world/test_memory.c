/* The world and its heap: every allocation may fail and leaves the state as it was; a step like
 * those before it makes no heap call. */
#include "support/pins.h"
#include "support/small_world.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 90.0; /* [s] */

/* An allocator whose allocation number `fail_at` fails, once. */
typedef struct failing_heap {
    long count, fail_at;
} failing_heap;

static void *failing_allocate(void *context, size_t byte_count) {
    failing_heap *const heap = context;
    return ++heap->count == heap->fail_at ? NULL : malloc(byte_count);
}

static void failing_release(void *context, void *pointer, size_t byte_count) {
    (void)context;
    (void)byte_count;
    free(pointer);
}

static tulle_world_def make_def(failing_heap *heap) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 2;
    def.allocator = (tulle_allocator){failing_allocate, failing_release, heap, 0};
    return def;
}

static void half_an_allocator_is_refused(void **state) {
    (void)state;
    failing_heap heap = {0};
    for (int k = 0; k < 2; k++) {
        tulle_world_def def = make_def(&heap);
        tulle_world *world = NULL;
        if (k == 0) def.allocator.allocate = NULL;
        if (k == 1) def.allocator.release = NULL;
        assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_ERROR_INVALID_ARGUMENT);
        assert_null(world);
    }
}

static tulle_mesh make_sphere(double radius, unsigned resolution) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    def.radius = radius;
    def.resolution[0] = def.resolution[1] = resolution;
    return small_shape(def, 0.0, 0.0, 0.0);
}

static size_t count_contacts(tulle_world *world, tulle_status *status) {
    const tulle_contact *contacts = NULL;
    size_t count = 0;
    *status = tulle_world_get_contacts(world, &contacts, &count, NULL);
    return count;
}

/* What the host drives jumps to and fro. */
static void make_jump(tulle_world *world, const tulle_obstacle_def *obstacle, int i) {
    if (obstacle->drive == TULLE_DRIVE_NONE) return;
    double const place[3] = {i % 2 == 0 ? 1.0 : 0.0, 0.0, -0.1}, turn[4] = {1.0, 0.0, 0.0, 0.0};
    assert_int_equal(tulle_obstacle_set_next_transform(world, (tulle_obstacle_id){0, 1}, place,
                                                       turn, TULLE_TRAVEL_JUMP, NULL),
                     TULLE_OK);
}

/* One world from the first call to the last of `step_count` steps, while allocation number
 * heap->fail_at fails; a step that fails changes nothing, nor the contacts of the one before. */
static tulle_status run_world(const tulle_world_def *def, const tulle_cloth_def *cloth,
                              const tulle_obstacle_def *obstacle, int step_count) {
    tulle_world *world = NULL;
    tulle_status status = tulle_world_create(def, &world, NULL);
    if (status == TULLE_OK) status = tulle_world_add_cloth(world, cloth, NULL, NULL);
    if (status == TULLE_OK) status = tulle_world_add_obstacle(world, obstacle, NULL, NULL);
    if (status == TULLE_OK) {
        tulle_error error = {0};
        status = tulle_world_start(world, &error);
        assert_int_equal(error.status, status);
        assert_true(status == TULLE_OK || strstr(error.message, "no memory"));
    }
    if (status == TULLE_OK) {
        tulle_event_watch const watch = tulle_event_watch_default();
        tulle_error error = {0};
        status = tulle_world_watch_events(world, &watch, &error);
        assert_true(status == TULLE_OK || strstr(error.message, "no memory"));
    }
    for (int i = 0; status == TULLE_OK && i < step_count; i++) {
        uint64_t const hash = tulle_world_get_state_hash(world);
        tulle_error error = {0};
        size_t const contact_count = count_contacts(world, &status);
        if (status != TULLE_OK) break;
        make_jump(world, obstacle, i);
        status = tulle_world_step(world, STEP, NULL, &error);
        if (status == TULLE_OK) continue;
        tulle_status counted = TULLE_OK;
        assert_int_equal(count_contacts(world, &counted), contact_count);
        assert_int_equal(counted, TULLE_OK);
        assert_true(tulle_world_get_state_hash(world) == hash);
        assert_int_equal(error.status, status);
        /* the same step goes well once there is memory */
        make_jump(world, obstacle, i);
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
    }
    tulle_world_destroy(world);
    return status;
}

/* Fails allocation 1, 2, ... of run_world until none is left to fail. */
static void fail_every_allocation(tulle_world_def def, failing_heap *heap,
                                  const tulle_cloth_def *cloth, const tulle_obstacle_def *obstacle,
                                  int step_count) {
    bool is_done = false;
    for (long k = 1; !is_done && k < 4000; k++) {
        *heap = (failing_heap){0, k};
        tulle_status const status = run_world(&def, cloth, obstacle, step_count);
        is_done = heap->count < heap->fail_at;
        /* without memory to move to, an array that is too large stays where it is */
        if (is_done || status != TULLE_ERROR_OUT_OF_MEMORY) assert_int_equal(status, TULLE_OK);
    }
    assert_true(is_done);
}

/* Sheets of woven cloth have hysteresis of everything. */
static void check_failed_allocations(unsigned side, int step_count, tulle_membrane membrane) {
    tulle_mesh sheet = small_sheet(0.3, side, 0.2062), sphere = make_sphere(0.2, 4);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&sphere);
    failing_heap heap = {0};
    tulle_world_def def = make_def(&heap);
    def.membrane = membrane;
    if (membrane == TULLE_MEMBRANE_WOVEN) {
        cloth.material.bend_hysteresis_warp = cloth.material.bend_hysteresis_weft = 1e-4;
        cloth.material.shear_hysteresis = 1.0;
    }
    fail_every_allocation(def, &heap, &cloth, &obstacle, step_count);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&sphere);
}

/* The step in which it fails leaves what was to jump where it was. */
static void failed_allocation_undoes_a_jump(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.3, 4, 0.2062), sphere = make_sphere(0.2, 4);
    uint32_t const corner = 0;
    tulle_pin const pin = make_pin(&corner, 1, 1.0);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&sphere);
    obstacle.drive = TULLE_DRIVE_RIGID;
    failing_heap heap = {0};
    fail_every_allocation(make_def(&heap), &heap, &cloth, &obstacle, 3);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&sphere);
}

/* An allocator that counts. */
typedef struct counting_heap {
    size_t held, most; /* [bytes] */
} counting_heap;

static void *counting_allocate(void *context, size_t byte_count) {
    counting_heap *const heap = context;
    heap->held += byte_count;
    if (heap->held > heap->most) heap->most = heap->held;
    return malloc(byte_count);
}

static void counting_release(void *context, void *pointer, size_t byte_count) {
    counting_heap *const heap = context;
    heap->held -= byte_count;
    free(pointer);
}

/* Large cloth that falls, from its start on: what a particle takes at most. Written down so that it
 * does not creep back: a million particles are to fit into 3 GB, of woven cloth into 4. The drag of
 * the air takes some 40 bytes of it. */
static void measure_particles(tulle_membrane membrane, size_t most) {
    enum { SIDE = 200, STEPS = 3 };
    counting_heap heap = {0};
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.membrane = membrane;
    def.allocator = (tulle_allocator){counting_allocate, counting_release, &heap, 0};
    tulle_mesh sheet = small_sheet(2.0, SIDE, 1.0);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    for (int i = 0; i < STEPS; i++)
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
    size_t const each = heap.most / sheet.vertex_count;
    if (each > most) fail_msg("%zu bytes a particle, more than %zu", each, most);
    tulle_world_destroy(world);
    assert_int_equal(heap.held, 0);
    tulle_mesh_destroy(&sheet);
}

static void a_particle_takes_little_memory(void **state) {
    (void)state;
    measure_particles(TULLE_MEMBRANE_WOVEN, 3780);
    measure_particles(TULLE_MEMBRANE_SPRINGS, 3000);
}

static void failed_allocation_leaves_the_world_as_it_was(void **state) {
    (void)state;
    check_failed_allocations(4, 3, TULLE_MEMBRANE_SPRINGS);
    check_failed_allocations(4, 3, TULLE_MEMBRANE_WOVEN);
    check_failed_allocations(33, 2, TULLE_MEMBRANE_SPRINGS); /* solves in single precision */
}

/* A rigid body that lands on the sheet. */
static void failed_allocation_leaves_bodies_as_they_were(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.3, 4, 0.0), sphere = make_sphere(0.1, 3);
    for (size_t i = 0; i < sphere.vertex_count; i++) sphere.positions[3 * i + 2] += 0.12;
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&sphere);
    obstacle.body = (tulle_body){.is_dynamic = 1, .mass = 0.1, .velocity = {0.0, 0.0, -3.0}};
    failing_heap heap = {0};
    fail_every_allocation(make_def(&heap), &heap, &cloth, &obstacle, 3);
    obstacle.body.sleep_speed = 100.0; /* asleep after a step */
    obstacle.body.sleep_time = 0.001;
    heap = (failing_heap){0};
    fail_every_allocation(make_def(&heap), &heap, &cloth, &obstacle, 3);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&sphere);
}

/* A sphere that the sheet goes through at the start. */
static void failed_allocation_of_untangling_is_told(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.3, 6, 0.09), sphere = make_sphere(0.1, 4);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&sphere);
    failing_heap heap = {0};
    tulle_world_def def = make_def(&heap);
    def.start_intersections = TULLE_START_UNTANGLE;
    fail_every_allocation(def, &heap, &cloth, &obstacle, 0);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&sphere);
}

/* The appearance changes which obstacles are there and which pairs are ignored. */
static void failed_allocation_undoes_an_appearance(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.3, 4, 0.01), sphere = make_sphere(0.1, 4);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&sphere);
    obstacle.appear_time = 1.5 * STEP;
    failing_heap heap = {0};
    tulle_world_def def = make_def(&heap);
    def.start_intersections = TULLE_START_IGNORE;
    fail_every_allocation(def, &heap, &cloth, &obstacle, 4);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&sphere);
}

static void check_steady_steps(unsigned side, tulle_membrane membrane) {
    tulle_mesh sheet = small_sheet(0.3, side, 0.01);
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[1] = 0.5;
    box.size[2] = 0.1;
    tulle_mesh table = small_shape(box, 0.0, 0.0, -0.055);
    failing_heap heap = {0, -1};
    tulle_world_def def = make_def(&heap);
    def.membrane = membrane;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.material.bend_hysteresis_warp = 1e-4; /* of woven cloth */
    cloth.material.shear_hysteresis = 1.0;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    small_add_obstacle(world, &table);
    for (int i = 0; i < 40; i++) {
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
    }
    long const before = heap.count;
    assert_true(before > 0);
    tulle_step_report report = {0};
    for (int i = 0; i < 20; i++) {
        assert_int_equal(tulle_world_step(world, STEP, &report, NULL), TULLE_OK);
    }
    assert_true(report.contacts > 0);
    assert_int_equal(heap.count, before);
    tulle_status status = TULLE_OK;
    assert_int_equal(count_contacts(world, &status), report.contacts);
    assert_true(heap.count > before); /* only who asks pays */
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&table);
}

static void steady_step_makes_no_heap_call(void **state) {
    (void)state;
    check_steady_steps(9, TULLE_MEMBRANE_SPRINGS);
    check_steady_steps(9, TULLE_MEMBRANE_WOVEN);
    check_steady_steps(36, TULLE_MEMBRANE_SPRINGS); /* solves in single precision */
}

static void stage_times_add_up(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.3, 9, 0.2062), sphere = make_sphere(0.2, 6);
    failing_heap heap = {0, -1};
    tulle_world_def const def = make_def(&heap);
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    small_add_cloth(world, &sheet);
    small_add_obstacle(world, &sphere);
    double seconds[TULLE_STAGE_COUNT] = {0};
    for (int i = 0; i < 10; i++) {
        tulle_step_report report;
        assert_int_equal(tulle_world_step(world, STEP, &report, NULL), TULLE_OK);
        double sum = 0.0;
        for (int k = 0; k < TULLE_STAGE_COUNT; k++) {
            assert_true(report.stage_seconds[k] > -1e-9);
            seconds[k] += report.stage_seconds[k];
            sum += report.stage_seconds[k];
        }
        assert_true(sum <= report.total_seconds + 1e-9);
    }
    for (int k = 0; k < TULLE_STAGE_COUNT; k++) assert_true(seconds[k] > 0.0);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&sphere);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_particle_takes_little_memory),
        cmocka_unit_test(failed_allocation_leaves_the_world_as_it_was),
        cmocka_unit_test(failed_allocation_leaves_bodies_as_they_were),
        cmocka_unit_test(failed_allocation_of_untangling_is_told),
        cmocka_unit_test(failed_allocation_undoes_an_appearance),
        cmocka_unit_test(failed_allocation_undoes_a_jump),
        cmocka_unit_test(steady_step_makes_no_heap_call),
        cmocka_unit_test(stage_times_add_up),
        cmocka_unit_test(half_an_allocator_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
