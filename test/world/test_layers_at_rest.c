/* Contacts live from step to step: three sheets of different cloth that lie on one another come to
 * rest, and then their rows neither come nor go. */
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>

#include <cmocka.h>

enum { STEPS = 45, MEASURED_STEPS = 15 };

/* A sheet of n x n vertices, turned about the vertical. */
static tulle_mesh make_turned_sheet(double side, unsigned n, double angle, double z) {
    tulle_mesh mesh = small_sheet(side, n, z);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        double *const p = mesh.positions + 3 * i;
        double const x = p[0], y = p[1];
        p[0] = 0.03 * angle + cos(angle) * x - sin(angle) * y;
        p[1] = 0.015 * angle + sin(angle) * x + cos(angle) * y;
    }
    return mesh;
}

static void add_sheet(tulle_world *world, const tulle_mesh *mesh, const char *preset) {
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    assert_int_equal(tulle_material_preset(preset, &def.material), TULLE_OK);
    def.material.friction = 0.1;
    assert_int_equal(tulle_world_add_cloth(world, &def, NULL, NULL), TULLE_OK);
}

static void stacked_sheets_keep_their_contacts(void **state) {
    (void)state;
    tulle_mesh sheets[3] = {make_turned_sheet(0.4, 21, 0.0, 0.01),
                            make_turned_sheet(0.4, 21, 0.349, 0.02),
                            make_turned_sheet(0.35, 15, 0.785, 0.03)};
    const char *const presets[3] = {"cotton", "silk", "denim"};
    tulle_shape_def plane = tulle_shape_def_default(TULLE_SHAPE_PLANE);
    tulle_mesh ground = small_shape(plane, 0.0, 0.0, 0.0);
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    for (int k = 0; k < 3; k++) add_sheet(world, &sheets[k], presets[k]);
    small_add_obstacle(world, &ground);
    uint64_t contacts = 0, new_contacts = 0;
    uint32_t impact_rounds = 0;
    tulle_step_report report;
    for (int i = 0; i < STEPS; i++) {
        tulle_error error = {0};
        if (tulle_world_step(world, 1.0 / 90.0, &report, &error) != TULLE_OK)
            fail_msg("step %d: %s", i, error.message);
        if (i < STEPS - MEASURED_STEPS) continue;
        contacts += report.contacts;
        new_contacts += report.new_contacts;
        impact_rounds += report.impact_rounds;
    }
    print_message("%.0f contacts a step, %.2f of them new, kinetic energy %.3g J, gap %.3g mm\n",
                  (double)contacts / MEASURED_STEPS, (double)new_contacts / MEASURED_STEPS,
                  report.kinetic_energy, 1e3 * report.smallest_gap);
    assert_int_equal(small_judge(world, sheets, 3, &ground, 1), 0);
    assert_true(contacts > MEASURED_STEPS * 600);
    assert_true(new_contacts < contacts / 1000);
    assert_int_equal(impact_rounds, 0);
    assert_true(report.kinetic_energy < 1e-7);
    tulle_world_destroy(world);
    for (int k = 0; k < 3; k++) tulle_mesh_destroy(&sheets[k]);
    tulle_mesh_destroy(&ground);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(stacked_sheets_keep_their_contacts)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
