/* Hysteresis of woven cloth in a world: what was bent keeps the curvature that theory says, what
 * was folded a fold; sliders are part of the state, and a step that fails leaves them. */
#include "support/pins.h"
#include "support/small_world.h"
#include "world/world_state.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double FRAME = 1.0 / 90.0;           /* [s] */
static const double RIGIDITY = 1e-5, RATIO = 5.0; /* [N m]; of a slider, see hysteresis.c */

enum { ROWS = 5 };

/* A strip along x, centred, whose warp lies along it. Flat at rest. */
typedef struct strip {
    tulle_world_def def;
    tulle_cloth_def cloth;
    tulle_mesh mesh;
    uint32_t columns;
    double cell;
} strip;

static strip make_strip(uint32_t columns, double cell, bool is_irregular) {
    strip made = {.def = tulle_world_def_default(),
                  .cloth = tulle_cloth_def_default(),
                  .columns = columns,
                  .cell = cell};
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    shape.size[0] = (columns - 1) * cell, shape.size[1] = (ROWS - 1) * cell;
    shape.resolution[0] = columns, shape.resolution[1] = ROWS;
    assert_int_equal(tulle_shape_generate(&shape, &made.mesh, NULL), TULLE_OK);
    double const half = 0.499 * shape.size[1];
    for (size_t v = 0; is_irregular && v < made.mesh.vertex_count; v++) {
        double *const x = made.mesh.positions + 3 * v;
        bool const is_middle = v / columns == ROWS / 2; /* where turns are measured */
        if (fabs(x[1]) < half && !is_middle) x[0] += 0.2 * cell * sin(7.0 * (double)v);
    }
    made.def.membrane = TULLE_MEMBRANE_WOVEN;
    made.def.gravity[2] = 0.0;
    made.cloth.material.bend_warp = made.cloth.material.bend_weft = RIGIDITY;
    made.cloth.material.bend_twist = 0.5 * RIGIDITY;
    /* Slowed down from within, cloth has no moment to speak of while it springs back. */
    made.cloth.material.bend_damping = 0.3;
    made.cloth.has_flat_rest = 1;
    return made;
}

static tulle_world *start(strip *of) {
    tulle_world *world = NULL;
    tulle_error error = {0};
    of->cloth.mesh = tulle_mesh_get_view(&of->mesh);
    assert_int_equal(tulle_world_create(&of->def, &world, &error), TULLE_OK);
    if (tulle_world_add_cloth(world, &of->cloth, NULL, &error) != TULLE_OK ||
        tulle_world_start(world, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    return world;
}

static void take_steps(tulle_world *world, int count, double time_step) {
    tulle_error error = {0};
    for (int i = 0; i < count; i++)
        if (tulle_world_step(world, time_step, NULL, &error) != TULLE_OK)
            fail_msg("%s", error.message);
}

/* [rad] by which the strip turns from column `from` to column `to`, of both cells after them, at
 * the row in the middle. */
static double measure_turn(const strip *of, const tulle_world *world, uint32_t from, uint32_t to) {
    const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL);
    uint32_t const ends[2] = {from, to};
    double angles[2];
    for (int k = 0; k < 2; k++) {
        const double *const a = x + 3 * (size_t)(ROWS / 2 * of->columns + ends[k]);
        angles[k] = atan2(a[5] - a[2], a[3] - a[0]);
    }
    return angles[1] - angles[0];
}

/* Rolls the mesh; what is given beyond `reach` [m] from the middle goes on straight. */
static void roll(strip *of, double curvature, double reach) {
    for (size_t v = 0; v < of->mesh.vertex_count; v++) {
        double *const x = of->mesh.positions + 3 * v;
        double const along = fmin(fmax(x[0], -reach), reach), turn = curvature * along;
        double const rest = x[0] - along;
        x[0] = sin(turn) / curvature + rest * cos(turn);
        x[2] = (1.0 - cos(turn)) / curvature + rest * sin(turn);
    }
}

/* Released from a curvature, a long strip goes back to where the elastic moment and that of the
 * slider cancel: to 2HB / (2 B) if it was bent far enough, else to where the slider sticks. */
static void what_was_bent_keeps_a_curvature(void **state) {
    (void)state;
    double const width = 2e-4, most = 0.5 * width, stiffness = RATIO * RIGIDITY;
    static const double starts[] = {30.0, 8.0};
    for (int is_irregular = 0; is_irregular < 2; is_irregular++)
        for (int k = 0; k < 2; k++) {
            strip of = make_strip(25, 0.006, is_irregular);
            of.cloth.material.bend_hysteresis_warp = width;
            roll(&of, starts[k], 1.0);
            tulle_world *const world = start(&of);
            take_steps(world, 200, FRAME);
            double const found = measure_turn(&of, world, 7, 16) / (9 * of.cell);
            double const sticks = (stiffness * starts[k] - most) / (RIGIDITY + stiffness);
            double const wanted = fmin(most / RIGIDITY, sticks);
            if (!(fabs(found - wanted) < 0.01 * wanted))
                fail_msg("irregular %d from %g: %g, not %g", is_irregular, starts[k], found,
                         wanted);
            tulle_world_destroy(world);
            tulle_mesh_destroy(&of.mesh);
        }
}

/* A strip of cotton folded over keeps part of the fold, and without hysteresis nothing of it. */
static void what_was_folded_keeps_a_fold(void **state) {
    (void)state;
    double folds[2];
    double const radius = 0.012, angle = 2.5, width = 4.9e-4; /* 0.05 gf cm/cm */
    for (int has_any = 0; has_any < 2; has_any++) {
        strip of = make_strip(31, 0.0025, false);
        of.cloth.material.bend_damping = 0.1;
        of.cloth.material.bend_hysteresis_warp = has_any ? width : 0.0;
        roll(&of, 1.0 / radius, 0.5 * radius * angle);
        tulle_world *const world = start(&of);
        take_steps(world, 400, 1.0 / 360.0);
        folds[has_any] = measure_turn(&of, world, 1, 28);
        tulle_world_destroy(world);
        tulle_mesh_destroy(&of.mesh);
    }
    /* Of the kinks at both ends half counts in the cell beyond. */
    double const wanted = 0.5 * width / RIGIDITY * (radius * angle + 0.0025);
    if (!(fabs(folds[0]) < 1e-3) || !(fabs(folds[1] - wanted) < 0.02 * wanted))
        fail_msg("folds %g and %g, not %g", folds[0], folds[1], wanted);
}

/* A strip that swings from one end, bent and sheared. */
static tulle_world *start_swinging(strip *of, int threads) {
    static uint32_t held[2 * ROWS];
    static tulle_pin pin;
    *of = make_strip(25, 0.01, true);
    for (uint32_t row = 0; row < ROWS; row++) {
        held[2 * row] = row * 25;
        held[2 * row + 1] = row * 25 + 1;
    }
    pin = make_pin(held, 2, (double)INFINITY);
    of->cloth.pins = &pin;
    of->cloth.pin_count = 1;
    of->cloth.material.air_damping = 0.1;
    of->cloth.material.bend_hysteresis_warp = 5e-4;
    of->cloth.material.bend_hysteresis_weft = 3e-4;
    of->cloth.material.shear_hysteresis = 2.0;
    of->def.gravity[2] = -9.81;
    of->def.threads = threads;
    return start(of);
}

static bool has_slid(const tulle_world *world, size_t slider) {
    for (size_t k = slider; k < world->model.plastic_count; k += 3)
        if (world->now.plastic[k] != 0.0) return true;
    return false;
}

static void sliders_are_part_of_the_state(void **state) {
    (void)state;
    strip of, same;
    tulle_world *const world = start_swinging(&of, 1), *const other = start_swinging(&same, 3);
    take_steps(world, 25, FRAME);
    take_steps(other, 25, FRAME);
    for (size_t slider = 0; slider < 3; slider++) assert_true(has_slid(world, slider));
    assert_true(tulle_world_get_state_hash(world) == tulle_world_get_state_hash(other));
    void *saved = NULL;
    size_t size = 0;
    tulle_error error;
    assert_int_equal(tulle_world_save_state(world, &saved, &size, &error), TULLE_OK);
    take_steps(world, 15, FRAME);
    take_steps(other, 5, FRAME);
    assert_int_equal(tulle_world_load_state(other, saved, size, &error), TULLE_OK);
    take_steps(other, 15, FRAME);
    assert_true(tulle_world_get_state_hash(world) == tulle_world_get_state_hash(other));

    /* The hash knows each plastic part. */
    uint64_t const hash = tulle_world_get_state_hash(other);
    other->now.plastic[5] += 1.0;
    assert_true(tulle_world_get_state_hash(other) != hash);

    /* A world without hysteresis does not take such a state, nor the other way round. */
    of.cloth.material.bend_hysteresis_warp = of.cloth.material.bend_hysteresis_weft = 0.0;
    of.cloth.material.shear_hysteresis = 0.0;
    tulle_world *const elastic = start(&of);
    assert_int_equal(elastic->model.plastic_count, 0);
    assert_int_equal(tulle_world_load_state(elastic, saved, size, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    tulle_world_free_state(world, saved, size);
    assert_int_equal(tulle_world_save_state(elastic, &saved, &size, &error), TULLE_OK);
    assert_int_equal(tulle_world_load_state(world, saved, size, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    tulle_world_free_state(elastic, saved, size);

    /* What no cloth has is refused. */
    static const double wrong[] = {(double)NAN, (double)INFINITY, -1e13};
    for (int i = 0; i < 3; i++) {
        world->now.plastic[7] = wrong[i];
        assert_int_equal(tulle_world_save_state(world, &saved, &size, &error), TULLE_OK);
        assert_int_equal(tulle_world_load_state(other, saved, size, &error), TULLE_ERROR_PARSE);
        assert_non_null(strstr(error.message, "hysteresis"));
        tulle_world_free_state(world, saved, size);
    }
    tulle_world_destroy(elastic);
    tulle_world_destroy(world);
    tulle_world_destroy(other);
    tulle_mesh_destroy(&of.mesh);
    tulle_mesh_destroy(&same.mesh);
}

static int count_down(void *context) { return --*(int *)context <= 0; }

/* Stopped at any moment, a step leaves sliders as they were; a step that does not slide does, too.
 */
static void steps_that_fail_leave_them(void **state) {
    (void)state;
    strip of;
    tulle_world *const world = start_swinging(&of, 1);
    tulle_error error;
    take_steps(world, 20, FRAME);
    uint64_t const hash = tulle_world_get_state_hash(world);
    tulle_status status = TULLE_ERROR_INTERRUPTED;
    int stops = 0;
    for (int asks = 1; status != TULLE_OK; asks++) {
        int left = asks;
        tulle_world_set_stop_request(world, count_down, &left);
        status = tulle_world_step(world, FRAME, NULL, &error);
        if (status == TULLE_OK) break;
        assert_int_equal(status, TULLE_ERROR_INTERRUPTED);
        assert_true(tulle_world_get_state_hash(world) == hash);
        stops++;
    }
    assert_true(stops > 0);
    assert_true(tulle_world_get_state_hash(world) != hash);
    tulle_world_destroy(world);

    /* what the fabric does not hold fails at the end of the step, when sliders have followed */
    tulle_mesh_destroy(&of.mesh);
    tulle_world_destroy(start_swinging(&of, 1));
    of.def.on_overstretch = TULLE_ON_OVERSTRETCH_STOP;
    of.cloth.material.warp.limit = of.cloth.material.weft.limit = 1e-3;
    of.cloth.material.air_damping = 0.0;
    of.def.gravity[2] = -50.0;
    tulle_world *const weak = start(&of);
    uint64_t before = 0;
    status = TULLE_OK;
    for (int i = 0; status == TULLE_OK && i < 100; i++) {
        before = tulle_world_get_state_hash(weak);
        status = tulle_world_step(weak, FRAME, NULL, &error);
    }
    assert_int_equal(status, TULLE_ERROR_STEP_FAILED);
    assert_true(tulle_world_get_state_hash(weak) == before);
    tulle_world_destroy(weak);
    tulle_mesh_destroy(&of.mesh);
}

/* A swing comes to rest by it: energy that nothing else takes. */
static void swings_lose_energy(void **state) {
    (void)state;
    double energies[2];
    for (int has_any = 0; has_any < 2; has_any++) {
        strip of = make_strip(25, 0.01, false);
        of.cloth.material.air_damping = of.cloth.material.bend_damping = 0.0;
        of.cloth.material.stretch_damping = 0.0;
        if (has_any) of.cloth.material.bend_hysteresis_warp = 1e-4;
        of.def.integrator = TULLE_INTEGRATOR_BDF2;
        roll(&of, 12.0, 1.0);
        tulle_world *const world = start(&of);
        tulle_step_report report;
        tulle_error error;
        double previous = (double)INFINITY;
        for (int i = 0; i < 300; i++) {
            assert_int_equal(tulle_world_step(world, 1.0 / 240.0, &report, &error), TULLE_OK);
            energies[has_any] = report.kinetic_energy + report.elastic_energy;
            assert_true(energies[has_any] < previous * 1.02);
            previous = energies[has_any];
        }
        tulle_world_destroy(world);
        tulle_mesh_destroy(&of.mesh);
    }
    assert_true(energies[1] < 0.3 * energies[0]);
}

static void bad_values_are_refused(void **state) {
    (void)state;
    strip of = make_strip(4, 0.01, false);
    of.cloth.mesh = tulle_mesh_get_view(&of.mesh);
    double *const values[] = {&of.cloth.material.bend_hysteresis_warp,
                              &of.cloth.material.bend_hysteresis_weft,
                              &of.cloth.material.shear_hysteresis};
    static const char *const names[] = {"bend_hysteresis_warp", "bend_hysteresis_weft",
                                        "shear_hysteresis"};
    double const beyond[] = {1.01e6 * RIGIDITY, 1.01e6 * RIGIDITY,
                             2.01 * of.cloth.material.shear.stiffness};
    tulle_world *world = NULL;
    tulle_error error;
    assert_int_equal(tulle_world_create(&of.def, &world, &error), TULLE_OK);
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++) {
            *values[k] = i == 0 ? -1e-9 : i == 1 ? (double)NAN : beyond[k];
            assert_int_equal(tulle_world_add_cloth(world, &of.cloth, NULL, &error),
                             TULLE_ERROR_INVALID_ARGUMENT);
            assert_non_null(strstr(error.message, names[k]));
            *values[k] = 0.0;
        }
    of.cloth.material.bend_warp = 0.0;
    of.cloth.material.bend_hysteresis_warp = 1e-4;
    assert_int_equal(tulle_world_add_cloth(world, &of.cloth, NULL, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&of.mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_bent_keeps_a_curvature),
        cmocka_unit_test(what_was_folded_keeps_a_fold),
        cmocka_unit_test(sliders_are_part_of_the_state),
        cmocka_unit_test(steps_that_fail_leave_them),
        cmocka_unit_test(swings_lose_energy),
        cmocka_unit_test(bad_values_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
