/* The same bits everywhere: the hash of a small world's state after some steps, for 1, 2 and 5
 * threads, against a constant that holds for every build (with and without optimisation, with
 * sanitizers, on any vector width). A hash that moves means that results changed: that is what
 * CHANGELOG.md calls "results changed". When the change is meant, put the hash that the failure
 * prints into its constant, after a run of this test in the dev preset and in the release preset
 * printed the same one. */
#include "support/paper_options.h"
#include "support/small_world.h"

#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>

#include <cmocka.h>

static const uint64_t GOLDEN = UINT64_C(0x147f059a50cea26c);
static const uint64_t OF_SPRINGS = UINT64_C(0xa0220e9b1f3e75dc);
/* Of finer sheets, whose solves are in single precision. */
static const uint64_t OF_FINE = UINT64_C(0xd3ed245bb5bcec47);
/* Of two of the same width, whose vertices make one grid. */
static const uint64_t OF_GRID = UINT64_C(0xa79eb185ee1810d5);
static const uint64_t OF_FINE_SPRINGS = UINT64_C(0x49b93c98a512c35b);

typedef struct golden_case {
    tulle_membrane membrane;
    uint32_t sides[2]; /* vertices of a sheet along a side */
    int steps;
    uint64_t hash;
} golden_case;

/* Two sheets fall on a box with its edges up and are pushed by one that moves: forces, contacts
 * with friction, impacts, all of them without functions of the system's mathematics library, whose
 * last bits differ between versions. */
static uint64_t run_small_world(const golden_case *given, int threads) {
    tulle_membrane const membrane = given->membrane;
    tulle_mesh sheets[2] = {small_sheet(0.5, given->sides[0], 0.002),
                            small_sheet(0.4, given->sides[1], 0.012)};
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[1] = 0.2;
    box.size[2] = 0.1;
    tulle_mesh obstacles[2] = {small_shape(box, 0.0, 0.0, -0.055),
                               small_shape(box, 0.36, 0.0, -0.055)};
    tulle_world_def def = tulle_world_def_default();
    def.membrane = membrane;
    if (membrane == TULLE_MEMBRANE_SPRINGS) def.wind.drag_coefficient = 0.0;
    def.threads = threads;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    for (int k = 0; k < 2; k++) small_add_cloth(world, &sheets[k]);
    small_add_obstacle(world, &obstacles[0]);
    tulle_obstacle_def pusher = tulle_obstacle_def_default();
    pusher.mesh = tulle_mesh_get_view(&obstacles[1]);
    tulle_keyframe const keys[] = {{0.0, {0, 0, 0}, {0, 0, 0}}, {0.3, {-0.1, 0, 0.05}, {0, 0, 0}}};
    pusher.motion = (tulle_motion){keys, 2, {0, 0, 0}, 0};
    assert_int_equal(tulle_world_add_obstacle(world, &pusher, NULL, NULL), TULLE_OK);
    uint64_t contacts = 0;
    for (int i = 0; i < given->steps; i++) {
        tulle_step_report report;
        tulle_error error = {0};
        if (tulle_world_step(world, 1.0 / 90.0, &report, &error) != TULLE_OK) {
            fail_msg("step %d: %s", i, error.message);
        }
        /* a solve that takes long ends at thirty times the tolerance */
        double const most =
            (report.cg_iterations >= 32 ? 30.0 : 1.0) * get_paper(&def).cg_tolerance;
        assert_true(report.cg_converged && report.cg_residual <= most);
        contacts += report.contacts;
    }
    assert_true(contacts > 100);
    uint64_t const hash = tulle_world_get_state_hash(world);
    tulle_world_destroy(world);
    for (int k = 0; k < 2; k++) {
        tulle_mesh_destroy(&sheets[k]);
        tulle_mesh_destroy(&obstacles[k]);
    }
    return hash;
}

static void check_hash(golden_case given) {
    int const threads[] = {1, 2, 5};
    for (int k = 0; k < 3; k++) {
        uint64_t const hash = run_small_world(&given, threads[k]);
        if (hash != given.hash) {
            fail_msg("membrane %d, %d threads: the hash is UINT64_C(0x%016" PRIx64 ")",
                     (int)given.membrane, threads[k], hash);
        }
    }
}

static void woven_hash_is_the_golden_one(void **state) {
    (void)state;
    check_hash((golden_case){TULLE_MEMBRANE_WOVEN, {11, 9}, 24, GOLDEN});
}

static void fine_woven_hash_is_the_golden_one(void **state) {
    (void)state;
    check_hash((golden_case){TULLE_MEMBRANE_WOVEN, {33, 27}, 12, OF_FINE});
}

static void hash_of_a_woven_grid_is_the_golden_one(void **state) {
    (void)state;
    check_hash((golden_case){TULLE_MEMBRANE_WOVEN, {30, 30}, 12, OF_GRID});
}

static void hash_of_springs_is_the_golden_one(void **state) {
    (void)state;
    check_hash((golden_case){TULLE_MEMBRANE_SPRINGS, {11, 9}, 24, OF_SPRINGS});
}

static void fine_hash_of_springs_is_the_golden_one(void **state) {
    (void)state;
    check_hash((golden_case){TULLE_MEMBRANE_SPRINGS, {33, 27}, 12, OF_FINE_SPRINGS});
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(woven_hash_is_the_golden_one),
                                       cmocka_unit_test(fine_woven_hash_is_the_golden_one),
                                       cmocka_unit_test(hash_of_a_woven_grid_is_the_golden_one),
                                       cmocka_unit_test(hash_of_springs_is_the_golden_one),
                                       cmocka_unit_test(fine_hash_of_springs_is_the_golden_one)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
