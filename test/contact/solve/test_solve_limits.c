/* The limit of iterations of a linear solve holds in each of its phases: with the blocks of
 * vertices alone, with aggregates, and in double precision. */
#include "support/contact_world.h"
#include "support/test_support.h"

enum { SIDE = 33 };

/* A step of a sheet that hangs on two corners and is pulled by gravity. */
static tulle_step_report step_sheet(int limit, double tolerance, double stiffness) {
    contact_world world = contact_world_make();
    world.def.cg_max_iterations = limit;
    world.def.cg_tolerance = tolerance;
    world.material.stretch_stiffness = stiffness;
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
        tulle_step_report const report = step_sheet(limits[i], 1e-12, 1500.0);
        print_message("limit %d: %u iterations of %u solves, residual %g\n", limits[i],
                      report.cg_iterations, report.solve_count, report.cg_residual);
        assert_int_equal(report.cg_iterations, (uint32_t)limits[i] * report.solve_count);
        assert_false(report.cg_converged);
    }
}

/* Springs so stiff that single precision gets no nearer; its iterations count towards the limit. */
static void double_precision_goes_on_within_the_limit(void **state) {
    (void)state;
    double const stiffness = 1e12; /* [N/m] */
    tulle_step_report const whole = step_sheet(5000, 1e-12, stiffness);
    print_message("%u iterations of %u solves, residual %g\n", whole.cg_iterations,
                  whole.solve_count, whole.cg_residual);
    assert_true(whole.cg_converged && whole.cg_residual <= 1e-12);
    int const most = (int)(whole.cg_iterations / whole.solve_count);
    for (int limit = most / 2; limit < most; limit += most / 7) {
        tulle_step_report const cut = step_sheet(limit, 1e-12, stiffness);
        print_message("limit %d: residual %g\n", limit, cut.cg_residual);
        assert_int_equal(cut.cg_iterations, (uint32_t)limit * cut.solve_count);
        assert_false(cut.cg_converged);
        assert_true(cut.cg_residual > 1e-12);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(solves_end_at_their_limit),
                                       cmocka_unit_test(double_precision_goes_on_within_the_limit)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
