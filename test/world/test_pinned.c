/* Pinned cloth that is large enough for solves in single precision: it swings down from one side,
 * and is let go midway, so what is held changes between steps. Solves stay few, exact and whole,
 * pinned vertices stay where they are, and the bits are the same for any number of threads. */
#include "support/small_world.h"
#include "support/test_support.h"

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
    tulle_pin const pin = {
        .vertices = side, .vertex_count = SIDE, .release_time = (HELD_STEPS - 0.5) * STEP};
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
    double const tolerance = tulle_world_def_default().cg_tolerance;
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

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(pinned_cloth_swings_and_falls)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
