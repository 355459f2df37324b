/* Pinned cloth that is large enough for solves in single precision: it swings down from one side,
 * and is let go midway, so what is held changes between steps. Solves stay few, exact and whole,
 * pinned vertices stay where they are, and the bits are the same for any number of threads. */
#include "support/pins.h"
#include "support/small_world.h"
#include "support/test_support.h"
#include "tulle/paper.h"

#include <stdbool.h>
#include <string.h>

#define STEP (1.0 / 90.0)
enum { SIDE = 36, HELD_STEPS = 20, STEPS = 30 };

typedef struct swing {
    uint64_t hash;
    uint32_t most_solves, most_iterations;
} swing;

static tulle_world *make_world(int threads, const tulle_mesh *sheet) {
    uint32_t side[SIDE];
    for (uint32_t i = 0; i < SIDE; i++) side[i] = i;
    tulle_pin const pin = make_pin(side, SIDE, (HELD_STEPS - 0.5) * STEP);
    tulle_world_def def = tulle_world_def_default();
    def.threads = threads;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(sheet);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    return world;
}

static void check_place(const tulle_world *world, const tulle_mesh *sheet, bool is_held) {
    size_t const bytes = 3 * SIDE * sizeof(double);
    const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL);
    assert_true((memcmp(x, sheet->positions, bytes) == 0) == is_held);
}

static swing run(int threads) {
    swing result = {0};
    tulle_mesh sheet = small_sheet(0.5, SIDE, 1.0);
    tulle_world *const world = make_world(threads, &sheet);
    double const tolerance = tulle_paper_options_default().cg_tolerance;
    for (int i = 0; i < STEPS; i++) {
        tulle_step_report report;
        assert_int_equal(tulle_world_step(world, STEP, &report, NULL), TULLE_OK);
        /* a solve that outlasts its patience, of 32 iterations, ends at a hundred times the
         * tolerance */
        double const most = (report.cg_iterations >= 32 ? 100.0 : 1.0) * tolerance;
        assert_true(report.cg_converged && report.cg_residual <= most);
        if (report.solve_count > result.most_solves) result.most_solves = report.solve_count;
        if (report.cg_iterations > result.most_iterations)
            result.most_iterations = report.cg_iterations;
        /* the time of release lies within one step, which may end either way */
        if (i + 1 != HELD_STEPS) check_place(world, &sheet, i < HELD_STEPS);
    }
    result.hash = tulle_world_get_state_hash(world);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    return result;
}

static void pinned_cloth_swings_and_falls(void **state) {
    (void)state;
    swing const one = run(1), four = run(4);
    print_message("solves of a step at most %u, iterations %u\n", one.most_solves,
                  one.most_iterations);
    assert_true(one.most_solves <= 8 && one.most_iterations < 400);
    assert_true(one.hash == four.hash);
}

/* A pin of zeros would let go at once: it is refused. Pins hold unless they are told otherwise, and
 * may be told to let go at 0 s. */
static void pins_hold_unless_told(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.5, 4, 1.0);
    uint32_t const side[4] = {0, 1, 2, 3};
    tulle_pin pins[3] = {{.vertices = side, .vertex_count = 4}, tulle_pin_default()};
    pins[1].vertices = side;
    pins[1].vertex_count = 4;
    pins[2] = make_pin(side, 4, 0.0);
    for (int i = 0; i < 3; i++) {
        tulle_world_def const def = tulle_world_def_default();
        tulle_world *world = NULL;
        tulle_error error = {0};
        assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
        tulle_cloth_def cloth = tulle_cloth_def_default();
        tulle_cloth_id id;
        cloth.name = "flag";
        cloth.mesh = tulle_mesh_get_view(&sheet);
        cloth.pins = &pins[i];
        cloth.pin_count = 1;
        tulle_status const status = tulle_world_add_cloth(world, &cloth, &id, &error);
        assert_int_equal(status, i == 0 ? TULLE_ERROR_INVALID_ARGUMENT : TULLE_OK);
        if (i == 0)
            assert_non_null(strstr(error.message, "flag: pin 0 was not made by tulle_pin_default"));
        for (int k = 0; k < 9 && i > 0; k++)
            assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
        if (i > 0) {
            double const z = tulle_cloth_get_positions(world, id, NULL)[2];
            assert_true(i == 1 ? z == 1.0 : z < 0.97);
        }
        tulle_world_destroy(world);
    }
    tulle_mesh_destroy(&sheet);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(pinned_cloth_swings_and_falls),
                                       cmocka_unit_test(pins_hold_unless_told)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
