/* Starts that intersect are untangled: clean by the exact judge, minimum gaps kept, nothing else
 * touched; or refused by name with the world unchanged. One start of each family;
 * TULLE_TEST_LONG=1: ten of each, larger, a hundred in all. */
#include "support/pins.h"
#include "support/small_world.h"
#include "support/tangled.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 90.0; /* [s] */
enum { SEEDS_LONG = 10, SIDE_SHORT = 13 };
static unsigned const SIDES_LONG[] = {15, 21, 27, 33};

static tulle_world_def make_def(void) {
    tulle_world_def def = tulle_world_def_default();
    def.start_intersections = TULLE_START_UNTANGLE;
    def.threads = 1;
    return def;
}

/* Whether the start becomes clean and two steps keep it so. */
static int is_cleaned(const tangled_start *start, tulle_untangle_report *report) {
    tulle_world_def const def = make_def();
    tulle_world *const world = tangled_make_world(start, &def);
    tulle_error error = {0};
    tulle_status status = tulle_world_start(world, &error);
    *report = tulle_world_get_untangle_report(world);
    int is_clean =
        status == TULLE_OK && tangled_judge(start, world) == 0 && report->keeps_minimum_gap;
    for (int i = 0; i < 2 && is_clean; i++) {
        tulle_step_report step = {0};
        status = tulle_world_step(world, STEP, &step, &error);
        is_clean =
            status == TULLE_OK && tangled_judge(start, world) == 0 && step.ignored_pairs == 0;
    }
    if (!is_clean) print_message("%s: %.200s\n", tangled_family_name(start->family), error.message);
    tulle_world_destroy(world);
    return is_clean;
}

static void tangled_starts_become_clean(void **state) {
    (void)state;
    int const is_long = getenv("TULLE_TEST_LONG") != NULL;
    int start_count = 0, clean_count = 0;
    for (int family = 0; family < TANGLED_FAMILY_COUNT; family++) {
        int const seed_count = is_long ? SEEDS_LONG : 1;
        int clean_here = 0;
        double most_seconds = 0.0, farthest = 0.0;
        for (int seed = 1; seed <= seed_count; seed++) {
            unsigned const side = is_long ? SIDES_LONG[seed % 4] : SIDE_SHORT;
            tangled_start start = tangled_make((tangled_family)family, (uint64_t)seed, side);
            tulle_untangle_report report;
            clean_here += is_cleaned(&start, &report);
            assert_int_equal(report.intersections, start.pair_count);
            assert_int_equal(report.left, 0);
            most_seconds = fmax(most_seconds, report.seconds);
            farthest = fmax(farthest, report.largest_displacement);
            tangled_destroy(&start);
        }
        print_message("%-12s %d of %d clean, at most %.2f s, %.3f m\n",
                      tangled_family_name((tangled_family)family), clean_here, seed_count,
                      most_seconds, farthest);
        start_count += seed_count;
        clean_count += clean_here;
    }
    assert_int_equal(clean_count, start_count);
}

/* A sheet that crosses another one along its whole border: the other one has to leave over that
 * border, and crossings that only pull their contour short crumple both instead. */
static void a_border_leaves_along_its_length(void **state) {
    (void)state;
    if (!getenv("TULLE_TEST_LONG")) skip();
    tangled_start start = tangled_make(TANGLED_THRUST, 102, 27);
    tulle_untangle_report report;
    assert_true(is_cleaned(&start, &report));
    tangled_destroy(&start);
}

/* Two sheets in one plane: pairs that touch everywhere and cross nowhere part to the sides that
 * their corners say. */
static void sheets_in_one_plane_part(void **state) {
    (void)state;
    tulle_world_def const def = make_def();
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_mesh sheets[2] = {small_sheet(0.3, 7, 0.0), small_sheet(0.3, 7, 0.0)};
    for (size_t v = 0; v < sheets[1].vertex_count; v++) {
        sheets[1].positions[3 * v] += 0.013;
        sheets[1].positions[3 * v + 1] += 0.007;
    }
    (void)small_add_cloth(world, &sheets[0]);
    (void)small_add_cloth(world, &sheets[1]);
    assert_true(small_judge(world, sheets, 2, NULL, 0) > 100);
    assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
    tulle_untangle_report const report = tulle_world_get_untangle_report(world);
    print_message("%d pairs, %d rounds, %.4f m\n", (int)report.intersections, (int)report.rounds,
                  report.largest_displacement);
    assert_int_equal(small_judge(world, sheets, 2, NULL, 0), 0);
    assert_true(report.keeps_minimum_gap);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheets[0]);
    tulle_mesh_destroy(&sheets[1]);
}

static void pins_and_velocities_stay(void **state) {
    (void)state;
    tangled_start start = tangled_make(TANGLED_SPHERE_RIM, 3, SIDE_SHORT);
    tulle_world_def const def = make_def();
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    /* the corner of the sheet that is farthest from the obstacle */
    size_t const count = start.cloths[0].vertex_count;
    uint32_t farthest = 0;
    for (uint32_t v = 0; v < count; v++)
        if (start.cloths[0].positions[3 * v] > start.cloths[0].positions[3 * farthest])
            farthest = v;
    tulle_pin const pin = make_pin(&farthest, 1, (double)INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&start.cloths[0]);
    cloth.rest_positions = start.rest[0];
    cloth.pins = &pin;
    cloth.pin_count = 1;
    cloth.velocity[1] = 0.25;
    tulle_cloth_id id;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, &id, NULL), TULLE_OK);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&start.obstacle);
    assert_int_equal(tulle_world_add_obstacle(world, &obstacle, NULL, NULL), TULLE_OK);
    assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
    const double *const x = tulle_cloth_get_positions(world, id, NULL);
    assert_memory_equal(x + 3 * farthest, start.cloths[0].positions + 3 * farthest,
                        3 * sizeof(double));
    const double *const v = tulle_cloth_get_velocities(world, id, NULL);
    for (size_t i = 0; i < 3 * count; i++) assert_true(v[i] == cloth.velocity[i % 3]);
    assert_int_equal(tangled_judge(&start, world), 0);
    size_t left = 1;
    (void)tulle_world_get_intersections(world, &left);
    assert_int_equal(left, 0);
    tulle_world_destroy(world);
    tangled_destroy(&start);
}

/* One round is not enough: the error names what is left, the world can be started otherwise. */
static void limit_names_what_is_left(void **state) {
    (void)state;
    tangled_start start = tangled_make(TANGLED_THRUST, 1, SIDE_SHORT);
    tulle_world_def def = make_def();
    def.untangle_limit = 1;
    tulle_world *const world = tangled_make_world(&start, &def);
    tulle_error error = {0};
    assert_int_equal(tulle_world_start(world, &error), TULLE_ERROR_INTERSECTING_START);
    assert_non_null(strstr(error.message, "after 1 rounds of untangling"));
    assert_non_null(strstr(error.message, " of 'cloth 0' with 'cloth 1'"));
    assert_non_null(strstr(error.message, " lines: "));
    assert_non_null(strstr(error.message, "triangle"));
    assert_non_null(strstr(error.message, "vertices"));
    size_t left = 0;
    assert_non_null(tulle_world_get_intersections(world, &left));
    assert_true(left > 0);
    assert_int_equal(tulle_world_get_untangle_report(world).left, left);
    const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL);
    assert_memory_equal(x, start.cloths[0].positions,
                        3 * start.cloths[0].vertex_count * sizeof(double));
    tulle_world_destroy(world);
    tangled_destroy(&start);
}

static int stop_after(void *context) {
    int *const rounds_left = context;
    return (*rounds_left)-- == 0;
}

/* A stop request ends the start between rounds; nothing has changed, and it can be tried again. */
static void request_stops_the_start(void **state) {
    (void)state;
    tangled_start start = tangled_make(TANGLED_THRUST, 1, SIDE_SHORT);
    tulle_world_def const def = make_def();
    tulle_world *const world = tangled_make_world(&start, &def);
    tulle_error error = {0};
    for (int rounds = 0; rounds < 4; rounds += 3) {
        int left = rounds;
        tulle_world_set_stop_request(world, stop_after, &left);
        assert_int_equal(tulle_world_start(world, &error), TULLE_ERROR_INTERRUPTED);
        assert_non_null(strstr(error.message, "rounds of untangling"));
        assert_int_equal(tulle_world_get_untangle_report(world).rounds, rounds);
        const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL);
        assert_memory_equal(x, start.cloths[0].positions,
                            3 * start.cloths[0].vertex_count * sizeof(double));
    }
    tulle_world_set_stop_request(world, NULL, NULL);
    assert_int_equal(tulle_world_start(world, &error), TULLE_OK);
    assert_int_equal(tangled_judge(&start, world), 0);
    tulle_world_destroy(world);
    tangled_destroy(&start);
}

static void result_does_not_depend_on_threads(void **state) {
    (void)state;
    tangled_start start = tangled_make(TANGLED_CORNERS, 2, SIDE_SHORT);
    tulle_world *worlds[2];
    for (int i = 0; i < 2; i++) {
        tulle_world_def def = make_def();
        def.threads = 1 + 2 * i;
        worlds[i] = tangled_make_world(&start, &def);
        assert_int_equal(tulle_world_start(worlds[i], NULL), TULLE_OK);
    }
    assert_int_equal(tulle_world_get_state_hash(worlds[0]), tulle_world_get_state_hash(worlds[1]));
    for (int i = 0; i < 2; i++) tulle_world_destroy(worlds[i]);
    tangled_destroy(&start);
}

/* An allocator whose allocation number `fail_at` fails, once. */
typedef struct failing_heap {
    long count, fail_at, held;
} failing_heap;

static void *failing_allocate(void *context, size_t byte_count) {
    failing_heap *const heap = context;
    if (++heap->count == heap->fail_at) return NULL;
    heap->held++;
    return malloc(byte_count);
}

static void failing_release(void *context, void *pointer, size_t byte_count) {
    (void)byte_count;
    ((failing_heap *)context)->held--;
    free(pointer);
}

/* Every allocation of the start fails once: an error that says so, nothing lost, and the start
 * works afterwards. A few only save memory, and are done without. */
static void failed_allocations_are_reported(void **state) {
    (void)state;
    tangled_start start = tangled_make(TANGLED_SLAB, 1, 9);
    int is_done = 0, survived = 0;
    for (long k = 1; !is_done; k++) {
        failing_heap heap = {0};
        tulle_world_def def = make_def();
        def.allocator = (tulle_allocator){failing_allocate, failing_release, &heap, 0};
        tulle_world *const world = tangled_make_world(&start, &def);
        heap.fail_at = heap.count + k;
        tulle_error error = {0};
        tulle_status status = tulle_world_start(world, &error);
        is_done = heap.count < heap.fail_at;
        if (is_done || status != TULLE_ERROR_OUT_OF_MEMORY) assert_int_equal(status, TULLE_OK);
        survived += !is_done && status == TULLE_OK;
        if (status != TULLE_OK) {
            assert_true(strlen(error.message) > 0);
            status = tulle_world_start(world, &error);
        }
        assert_int_equal(status, TULLE_OK);
        assert_int_equal(tangled_judge(&start, world), 0);
        tulle_world_destroy(world);
        assert_int_equal(heap.held, 0);
    }
    assert_true(survived <= 4); /* arrays that were only to be made smaller */
    tangled_destroy(&start);
}

/* A saved state takes the place of the first one: nothing is judged or untangled for it. One that
 * cannot be loaded leaves the world as it was, to be started in the usual way. */
static void a_loaded_state_is_not_untangled_again(void **state) {
    (void)state;
    tangled_start start = tangled_make((tangled_family)0, 1, SIDE_SHORT);
    tulle_world_def const def = make_def();
    tulle_world *const first = tangled_make_world(&start, &def);
    tulle_world *const second = tangled_make_world(&start, &def);
    tulle_error error = {0};
    tulle_step_report report;
    void *bytes = NULL;
    size_t byte_count = 0;
    assert_int_equal(tulle_world_step(first, STEP, &report, &error), TULLE_OK);
    assert_int_equal(tulle_world_save_state(first, &bytes, &byte_count, &error), TULLE_OK);
    assert_int_equal(tulle_world_load_state(second, bytes, byte_count - 1, &error),
                     TULLE_ERROR_PARSE);
    assert_int_equal(tulle_world_load_state(second, bytes, byte_count, &error), TULLE_OK);
    assert_int_equal(tulle_world_get_untangle_report(second).rounds, 0);
    assert_true(tulle_world_get_state_hash(first) == tulle_world_get_state_hash(second));
    assert_int_equal(tulle_world_step(first, STEP, &report, &error), TULLE_OK);
    assert_int_equal(tulle_world_step(second, STEP, &report, &error), TULLE_OK);
    assert_true(tulle_world_get_state_hash(first) == tulle_world_get_state_hash(second));
    tulle_world *const third = tangled_make_world(&start, &def);
    assert_int_not_equal(tulle_world_load_state(third, bytes, byte_count - 1, &error), TULLE_OK);
    assert_int_equal(tulle_world_start(third, &error), TULLE_OK);
    assert_true(tulle_world_get_untangle_report(third).rounds > 0);
    tulle_world_free_state(first, bytes, byte_count);
    tulle_world_destroy(first);
    tulle_world_destroy(second);
    tulle_world_destroy(third);
    tangled_destroy(&start);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tangled_starts_become_clean),
        cmocka_unit_test(a_loaded_state_is_not_untangled_again),
        cmocka_unit_test(a_border_leaves_along_its_length),
        cmocka_unit_test(sheets_in_one_plane_part),
        cmocka_unit_test(pins_and_velocities_stay),
        cmocka_unit_test(limit_names_what_is_left),
        cmocka_unit_test(request_stops_the_start),
        cmocka_unit_test(failed_allocations_are_reported),
        cmocka_unit_test(result_does_not_depend_on_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
