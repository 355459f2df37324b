/* What a world tells of its mesh and its integrator beside the fabric: the bending length, and the
 * damping of each integrator, measured on a triangle that swings. */
#include "support/paper_options.h"
#include "support/pins.h"
#include "support/small_world.h"
#include "tulle/paper.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static double const PI = 3.14159265358979323846;

static void expect_near(double value, double expected, double tolerance) {
    if (fabs(value - expected) <= tolerance) return;
    fail_msg("%.12g where %.12g was expected, within %g", value, expected, tolerance);
}

/* ---- fineness ---- */

static tulle_fineness measure_sheet(tulle_membrane membrane, double gravity) {
    tulle_world_def world_def = tulle_world_def_default();
    world_def.membrane = membrane;
    world_def.gravity[2] = gravity;
    tulle_mesh mesh = small_sheet(1.0, 5, 0.0);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&mesh);
    def.material.area_density = 0.25;
    def.material.bend_warp = 2e-5;
    def.material.bend_weft = 1e-5;
    def.material.springs.bend_stiffness = 8e-5;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&world_def, &world, NULL), TULLE_OK);
    tulle_cloth_id id, second;
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, NULL), TULLE_OK);
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        for (int c = 0; c < 3; c++) mesh.positions[3 * v + (size_t)c] *= 2.0;
        mesh.positions[3 * v + 2] += 1.0;
    }
    assert_int_equal(tulle_world_add_cloth(world, &def, &second, NULL), TULLE_OK);
    assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
    tulle_fineness const first = tulle_cloth_get_fineness(world, id);
    /* A square of cells of 1/4 m: 40 edges along its sides, 16 diagonals. */
    expect_near(first.mean_edge, 0.25 * (40.0 + 16.0 * sqrt(2.0)) / 56.0, 1e-12);
    expect_near(tulle_cloth_get_fineness(world, second).mean_edge, 2.0 * first.mean_edge, 1e-12);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&mesh);
    return first;
}

static void bending_length_is_that_of_the_softer_yarns(void **unused) {
    (void)unused;
    double const woven = measure_sheet(TULLE_MEMBRANE_WOVEN, -10.0).bending_length;
    expect_near(woven, cbrt(1e-5 / 2.5), 1e-12);
    double const springs = measure_sheet(TULLE_MEMBRANE_SPRINGS, 10.0).bending_length;
    expect_near(springs, cbrt(8e-5 / 2.5), 1e-12);
    assert_true(measure_sheet(TULLE_MEMBRANE_WOVEN, 0.0).bending_length == 0.0);
}

/* ---- the fall of fine cloth ---- */

/* A centimetre of cloth with edges of a quarter of a millimetre has a matrix a million times its
 * mass. To fall, it needs next to no iterations all the same. */
static void fine_cloth_falls_at_once(void **unused) {
    (void)unused;
    double const gravity = -9.81, step = 1.0 / 90.0;
    tulle_world_def world_def = tulle_world_def_default();
    world_def.gravity[2] = gravity;
    world_def.wind.drag_coefficient = 0.0;
    tulle_mesh mesh = small_sheet(0.01, 41, 0.0);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&mesh);
    def.material.air_damping = 0.0;
    tulle_world *world = NULL;
    tulle_cloth_id id;
    assert_int_equal(tulle_world_create(&world_def, &world, NULL), TULLE_OK);
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, NULL), TULLE_OK);
    for (int i = 1; i <= 3; i++) {
        tulle_step_report report;
        assert_int_equal(tulle_world_step(world, step, &report, NULL), TULLE_OK);
        assert_true(report.cg_converged);
        assert_in_range(report.cg_iterations, 0, 5);
        for (size_t v = 0; v < mesh.vertex_count; v++)
            expect_near(tulle_cloth_get_velocities(world, id, NULL)[3 * v + 2], gravity * step * i,
                        1e-6);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&mesh);
}

/* ---- damping ---- */

/* A triangle held by two corners, whose third one is moved a little along its middle: it swings by
 * itself to and fro, linear as far as can be seen. */
static tulle_world *start_swing(tulle_integrator integrator, tulle_cloth_id *id) {
    double rest[9] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 1.0, 0.0};
    double moved[9] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 1.0 + 1e-7, 0.0};
    uint32_t corners[3] = {0, 1, 2}, held[2] = {0, 1};
    tulle_world_def world_def = tulle_world_def_default();
    world_def.gravity[2] = 0.0;
    world_def.integrator = integrator;
    change_paper(&world_def)->cg_tolerance = 1e-12;
    tulle_pin const pin = make_pin(held, 2, (double)INFINITY);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = (tulle_mesh_view){
        .positions = moved, .triangles = corners, .vertex_count = 3, .triangle_count = 1};
    def.rest_positions = rest;
    def.material.stretch_damping = def.material.bend_damping = def.material.air_damping = 0.0;
    def.material.springs.stretch_stiffness = 1.0;
    def.pins = &pin;
    def.pin_count = 1;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&world_def, &world, NULL), TULLE_OK);
    assert_int_equal(tulle_world_add_cloth(world, &def, id, NULL), TULLE_OK);
    assert_int_equal(tulle_world_start(world, NULL), TULLE_OK);
    return world;
}

static double get_place(const tulle_world *world, tulle_cloth_id id) {
    return tulle_cloth_get_positions(world, id, NULL)[7] - 1.0;
}

static double get_speed(const tulle_world *world, tulle_cloth_id id) {
    return tulle_cloth_get_velocities(world, id, NULL)[7];
}

/* [1/s] from the first moment of the motion. */
static double measure_omega(void) {
    tulle_cloth_id id;
    tulle_world *const world = start_swing(TULLE_INTEGRATOR_IMPLICIT_EULER, &id);
    double const step = 1e-5, start = get_place(world, id);
    assert_int_equal(tulle_world_step(world, step, NULL, NULL), TULLE_OK);
    double const omega = sqrt(-get_speed(world, id) / (step * start));
    tulle_world_destroy(world);
    return omega;
}

/* Steps until what came before the swing is gone, then measures what 60 steps take of it. */
static void expect_damping(tulle_integrator integrator, double omega, double step) {
    tulle_cloth_id id;
    tulle_world *const world = start_swing(integrator, &id);
    double sizes[2] = {0.0, 0.0}, turned = 0.0, last = 0.0;
    for (int i = 0; i <= 80; i++) {
        double const place = get_place(world, id), speed = get_speed(world, id) / omega;
        double const angle = atan2(speed, place);
        if (i == 20) sizes[0] = hypot(place, speed);
        if (i == 80) sizes[1] = hypot(place, speed);
        if (i > 20) turned += fabs(remainder(angle - last, 2.0 * PI));
        last = angle;
        assert_int_equal(tulle_world_step(world, step, NULL, NULL), TULLE_OK);
    }
    double const loss = log(sizes[0] / sizes[1]), measured = loss / hypot(loss, turned);
    double const told = tulle_world_get_numerical_damping(world, step, 2.0 * PI / omega);
    assert_true(told > 1e-5);
    expect_near(told, measured, 0.02 * measured);
    tulle_world_destroy(world);
}

static void damping_is_what_a_swing_loses(void **unused) {
    (void)unused;
    double const omega = measure_omega();
    for (int i = 0; i < 3; i++) {
        expect_damping((tulle_integrator)i, omega, 0.3 / omega);
        expect_damping((tulle_integrator)i, omega, 0.1 / omega);
    }
}

static void damping_of_euler_is_half_the_turn(void **unused) {
    (void)unused;
    tulle_cloth_id id;
    tulle_world *const world = start_swing(TULLE_INTEGRATOR_IMPLICIT_EULER, &id);
    expect_near(tulle_world_get_numerical_damping(world, 1e-4, 1.0), PI * 1e-4, 1e-9);
    assert_true(tulle_world_get_numerical_damping(world, 1.0, 1e-3) > 0.9);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fine_cloth_falls_at_once),
        cmocka_unit_test(bending_length_is_that_of_the_softer_yarns),
        cmocka_unit_test(damping_is_what_a_swing_loses),
        cmocka_unit_test(damping_of_euler_is_half_the_turn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
