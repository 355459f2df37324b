/* The limit of iterations of a linear solve holds in each of its phases: with the blocks of
 * vertices alone, and with aggregates. */
#include "support/contact_world.h"
#include "support/test_support.h"

enum { SIDE = 33 };

/* A step of a sheet that hangs on two corners and is pulled by gravity. */
static tulle_step_report step_sheet(int limit, double tolerance) {
    contact_world world = contact_world_make();
    world.def.cg_max_iterations = limit;
    world.def.cg_tolerance = tolerance;
    contact_grid sheet = make_contact_grid(SIDE, SIDE, vec3_make(0.0, 0.0, 0.0),
                                           vec3_make(0.5, 0.0, 0.0), vec3_make(0.0, 0.5, 0.0));
    add_contact_surface(&world, sheet.mesh, false);
    world.pinned[world.pin_count++] = 0;
    world.pinned[world.pin_count++] = SIDE - 1;
    start_contact_world(&world);
    assert_non_null(world.world->aggregates); /* else there is one phase */
    for (int i = 0; i < 2; i++) assert_int_equal(step_contact_world(&world, 1.0 / 30.0), TULLE_OK);
    tulle_step_report const report = world.report;
    contact_world_destroy(&world);
    free_contact_grid(&sheet);
    return report;
}

static void solves_end_at_their_limit(void **state) {
    (void)state;
    static const int limits[] = {1, 3, 8, 9, 11, 20};
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        tulle_step_report const report = step_sheet(limits[i], 1e-12);
        print_message("limit %d: %u iterations of %u solves, residual %g\n", limits[i],
                      report.cg_iterations, report.solve_count, report.cg_residual);
        assert_int_equal(report.cg_iterations, (uint32_t)limits[i] * report.solve_count);
        assert_false(report.cg_converged);
    }
}

/* A tolerance far below what single precision resolves. */
static void exact_solves_keep_the_limit_too(void **state) {
    (void)state;
    tulle_step_report const whole = step_sheet(5000, 1e-12);
    print_message("%u iterations of %u solves, residual %g\n", whole.cg_iterations,
                  whole.solve_count, whole.cg_residual);
    assert_true(whole.cg_converged && whole.cg_residual <= 1e-12);
    tulle_step_report const rough = step_sheet(5000, 1e-5);
    assert_true(rough.cg_converged && rough.cg_residual <= 1e-5);
    assert_true(rough.cg_iterations < whole.cg_iterations / 2);
    int const limit = (int)(whole.cg_iterations / whole.solve_count) - 5;
    tulle_step_report const cut = step_sheet(limit, 1e-12);
    assert_int_equal(cut.cg_iterations, (uint32_t)limit * cut.solve_count);
    assert_false(cut.cg_converged);
    assert_true(cut.cg_residual > 1e-12 && cut.cg_residual < 1e-5);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(solves_end_at_their_limit),
                                       cmocka_unit_test(exact_solves_keep_the_limit_too)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
