/* What a step reports of its solves. */
#include "support/paper_options.h"
#include "support/pins.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

/* A hanging sheet after one step, with so many iterations at most. */
static tulle_step_report hang(int limit) {
    tulle_world_def def = tulle_world_def_default();
    change_paper(&def)->cg_max_iterations = limit;
    change_paper(&def)->cg_tolerance = 1e-6;
    def.quality = TULLE_QUALITY_EXACT;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_mesh sheet = small_sheet(0.5, 12, 0.0);
    uint32_t const corner = 0;
    tulle_pin const pin = make_pin(&corner, 1, 1e9);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    tulle_step_report report;
    assert_int_equal(tulle_world_step(world, 1.0 / 60.0, &report, NULL), TULLE_OK);
    tulle_mesh_destroy(&sheet);
    tulle_world_destroy(world);
    return report;
}

static void the_residual_is_what_solves_leave(void **state) {
    (void)state;
    tulle_step_report const cut = hang(2), whole = hang(1000);
    assert_false(cut.cg_converged);
    assert_true(cut.cg_residual > 1e-6 && cut.cg_residual < 1.0);
    assert_true(whole.cg_converged && whole.cg_residual > 0.0 && whole.cg_residual <= 1e-6);
    assert_true(whole.cg_iterations > cut.cg_iterations);
}

/* A free sheet falls by hardly any gravity: products of its forces are below the smallest number.
 */
static void forces_near_the_smallest_number_do_no_harm(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.5, 4, 0.0);
    for (int i = 0; i < 400; i++) {
        tulle_world_def def = tulle_world_def_default();
        def.gravity[2] = -pow(10.0, -150.0 - 0.05 * i);
        def.wind.drag_coefficient = 0.0;
        tulle_world *world = NULL;
        tulle_error error = {0};
        assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
        tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
        for (int k = 0; k < 2; k++)
            if (tulle_world_step(world, 1.0 / 60.0, NULL, &error) != TULLE_OK)
                fail_msg("gravity %g: %s", def.gravity[2], error.message);
        const double *const now = tulle_cloth_get_positions(world, cloth, NULL);
        for (size_t v = 0; v < 3 * sheet.vertex_count; v++)
            assert_true(fabs(now[v] - sheet.positions[v]) < 1e-15);
        tulle_world_destroy(world);
    }
    tulle_mesh_destroy(&sheet);
}

/* Fewest solves of a step of a sheet at rest on the ground, where so many rounds are asked for. */
static uint32_t count_solves_at_rest(int rounds) {
    tulle_world_def def = tulle_world_def_default();
    change_paper(&def)->solve_rounds = rounds;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_mesh sheet = small_sheet(0.5, 6, 0.02);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_PLANE);
    tulle_mesh ground = small_shape(shape, 0.0, 0.0, 0.0);
    small_add_cloth(world, &sheet);
    small_add_obstacle(world, &ground);
    uint32_t fewest = UINT32_MAX;
    for (int step = 0; step < 90; step++) {
        tulle_step_report report;
        assert_int_equal(tulle_world_step(world, 1.0 / 60.0, &report, NULL), TULLE_OK);
        if (step < 60) continue;
        assert_true(report.stick_contacts > 0);
        if (report.solve_count < fewest) fewest = report.solve_count;
    }
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ground);
    tulle_world_destroy(world);
    return fewest;
}

/* A rough first solve makes one round. It is not the last one where more are asked for. */
static void rounds_asked_for_are_made(void **state) {
    (void)state;
    assert_true(count_solves_at_rest(1) < 4); /* else the next two would show nothing */
    assert_true(count_solves_at_rest(3) >= 4);
    assert_true(count_solves_at_rest(6) >= 7);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_residual_is_what_solves_leave),
                                       cmocka_unit_test(forces_near_the_smallest_number_do_no_harm),
                                       cmocka_unit_test(rounds_asked_for_are_made)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
