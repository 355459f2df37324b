/* The world as a whole, small: free fall, drape, determinism, saved states, obstacles
 * that come and go, pins, pinches. */
#include "support/paper_options.h"
#include "support/pins.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void assert_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance)) fail_msg("%.17g is not %.17g", value, expected);
}

static const double STEP = 1.0 / 90.0; /* [s] */

static tulle_world *make_world(tulle_world_def def) {
    tulle_world *world = NULL;
    tulle_error error = {0};
    if (tulle_world_create(&def, &world, &error) != TULLE_OK) fail_msg("%s", error.message);
    return world;
}

static tulle_mesh make_sphere(double radius, unsigned resolution) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    def.radius = radius;
    def.resolution[0] = def.resolution[1] = resolution;
    return small_shape(def, 0.0, 0.0, 0.0);
}

static void step_or_fail(tulle_world *world, tulle_step_report *report) {
    tulle_error error = {0};
    tulle_status const status = tulle_world_step(world, STEP, report, &error);
    if (status != TULLE_OK) fail_msg("step: %s: %s", tulle_status_text(status), error.message);
}

static void sheet_falls_freely(void **state) {
    (void)state;
    tulle_mesh mesh = small_sheet(1.0, 6, 3.0);
    tulle_world_def def = tulle_world_def_default();
    change_paper(&def)->cg_tolerance = 1e-12;
    def.wind.drag_coefficient = 0.0;
    tulle_world *const world = make_world(def);
    tulle_cloth_id const cloth = small_add_cloth(world, &mesh);
    int const count = 30;
    for (int i = 0; i < count; i++) step_or_fail(world, NULL);
    /* implicit Euler: v = -g t, drop = g h^2 n (n + 1) / 2; cotton's air damping is part of it */
    const double *const x = tulle_cloth_get_positions(world, cloth, NULL);
    const double *const v = tulle_cloth_get_velocities(world, cloth, NULL);
    tulle_material material;
    assert_int_equal(tulle_material_preset("cotton", &material), TULLE_OK);
    double speed = 0.0, height = 3.0;
    for (int i = 0; i < count; i++) {
        speed = (speed - 9.81 * STEP) / (1.0 + material.air_damping * STEP);
        height += STEP * speed;
    }
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        assert_near(v[3 * i + 2], speed, 1e-9);
        assert_near(x[3 * i + 2], height, 1e-9);
        assert_near(x[3 * i], mesh.positions[3 * i], 1e-9);
    }
    assert_near(tulle_world_get_time(world), count * STEP, 1e-12);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&mesh);
}

/* The edge that is named has the stretch of the report. */
static void assert_stretch_is_found(const tulle_world *world, const tulle_mesh *rest,
                                    double stretch) {
    tulle_stretch const found = tulle_world_find_largest_stretch(world);
    assert_near(found.stretch, stretch, 1e-12);
    assert_int_equal(found.cloth, 0);
    const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL);
    double now = 0.0, before = 0.0;
    for (size_t c = 0; c < 3; c++) {
        size_t const a = 3 * (size_t)found.vertices[0] + c, b = 3 * (size_t)found.vertices[1] + c;
        now += (x[a] - x[b]) * (x[a] - x[b]);
        before +=
            (rest->positions[a] - rest->positions[b]) * (rest->positions[a] - rest->positions[b]);
        assert_near(found.position[c], 0.5 * (x[a] + x[b]), 1e-12);
    }
    assert_near(sqrt(now / before), stretch, 1e-12);
}

/* A sheet on a sphere for `count` steps; returns the final hash. */
static uint64_t drape(tulle_world_def def, int count, unsigned n, bool is_judged) {
    tulle_mesh sheet = small_sheet(1.0, n, 0.32), sphere = make_sphere(0.3, 6);
    tulle_world *const world = make_world(def);
    small_add_cloth(world, &sheet);
    small_add_obstacle(world, &sphere);
    double minimum_gap = 0.0;
    double max_stretch = 1.0;
    uint64_t contacts = 0;
    for (int i = 0; i < count; i++) {
        tulle_step_report report;
        step_or_fail(world, &report);
        tulle_world_get_distances(world, NULL, NULL, &minimum_gap);
        contacts += report.contacts;
        if (!is_judged) continue;
        assert_int_equal(small_judge(world, &sheet, 1, &sphere, 1), 0);
        assert_true(report.smallest_gap >= minimum_gap);
        max_stretch = report.max_stretch;
        assert_stretch_is_found(world, &sheet, max_stretch);
    }
    if (is_judged) assert_true(max_stretch < 1.1);
    assert_true(contacts > 0);
    uint64_t const hash = tulle_world_get_state_hash(world);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&sphere);
    return hash;
}

static void sheet_drapes_without_intersection(void **state) {
    (void)state;
    drape(tulle_world_def_default(), 70, 19, true);
}

static void result_does_not_depend_on_threads(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    uint64_t const one = drape(def, 22, 13, false);
    for (int threads = 2; threads <= 5; threads += 3) {
        def.threads = threads;
        assert_true(drape(def, 22, 13, false) == one);
    }
}

static void every_integrator_drapes(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.integrator = TULLE_INTEGRATOR_BDF2;
    drape(def, 45, 13, true);
    def.integrator = TULLE_INTEGRATOR_CRANK_NICOLSON;
    drape(def, 45, 13, true);
}

static void every_quality_drapes(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    def.quality = TULLE_QUALITY_DRAFT;
    uint64_t const draft = drape(def, 70, 19, true);
    def.quality = TULLE_QUALITY_EXACT;
    assert_true(drape(def, 70, 19, true) != draft);
}

/* The paper's response is exact whatever the quality. */
static void quality_means_nothing_to_the_paper(void **state) {
    (void)state;
    tulle_world_def def = tulle_world_def_default();
    change_paper(&def)->response = TULLE_RESPONSE_PAPER;
    uint64_t const normal = drape(def, 22, 19, false);
    def.quality = TULLE_QUALITY_DRAFT;
    assert_true(drape(def, 22, 19, false) == normal);
}

static void saved_state_goes_on_with_the_same_bits(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(1.0, 13, 0.32), sphere = make_sphere(0.3, 6);
    tulle_world *worlds[2];
    for (int k = 0; k < 2; k++) {
        worlds[k] = make_world(tulle_world_def_default());
        small_add_cloth(worlds[k], &sheet);
        small_add_obstacle(worlds[k], &sphere);
    }
    for (int i = 0; i < 18; i++) step_or_fail(worlds[0], NULL);
    void *bytes = NULL;
    size_t byte_count = 0;
    tulle_error error = {0};
    assert_int_equal(tulle_world_save_state(worlds[0], &bytes, &byte_count, &error), TULLE_OK);
    assert_int_equal(tulle_world_load_state(worlds[1], bytes, byte_count, &error), TULLE_OK);
    assert_true(tulle_world_get_state_hash(worlds[0]) == tulle_world_get_state_hash(worlds[1]));
    for (int i = 0; i < 8; i++) {
        step_or_fail(worlds[0], NULL);
        step_or_fail(worlds[1], NULL);
        assert_true(tulle_world_get_state_hash(worlds[0]) == tulle_world_get_state_hash(worlds[1]));
    }

    /* damaged bytes are refused and change nothing */
    uint64_t const hash = tulle_world_get_state_hash(worlds[1]);
    for (size_t i = 0; i < byte_count; i += byte_count / 97 + 1) {
        unsigned char *const damaged = malloc(byte_count);
        memcpy(damaged, bytes, byte_count);
        damaged[i] ^= 0x10;
        assert_int_not_equal(tulle_world_load_state(worlds[1], damaged, byte_count, NULL),
                             TULLE_OK);
        assert_int_not_equal(tulle_world_load_state(worlds[1], bytes, i, NULL), TULLE_OK);
        free(damaged);
    }
    ((unsigned char *)bytes)[7] = '2'; /* the format of the first contact stores */
    assert_int_equal(tulle_world_load_state(worlds[1], bytes, byte_count, &error),
                     TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "another version"));
    assert_true(tulle_world_get_state_hash(worlds[1]) == hash);
    tulle_world_free_state(worlds[0], bytes, byte_count);
    for (int k = 0; k < 2; k++) tulle_world_destroy(worlds[k]);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&sphere);
}

static void obstacles_come_and_go(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.6, 13, 0.0);
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[1] = 2.0;
    box.size[2] = 0.1;
    tulle_mesh floor = small_shape(box, 0.0, 0.0, -0.1);
    tulle_world *const world = make_world(tulle_world_def_default());
    tulle_cloth_id const cloth = small_add_cloth(world, &sheet);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&floor);
    def.disappear_time = 30.5 * STEP;
    tulle_obstacle_id id;
    assert_int_equal(tulle_world_add_obstacle(world, &def, &id, NULL), TULLE_OK);
    for (int i = 0; i < 30; i++) step_or_fail(world, NULL);
    double const resting = tulle_cloth_get_positions(world, cloth, NULL)[2];
    assert_true(resting > -0.05);
    for (int i = 0; i < 40; i++) step_or_fail(world, NULL);
    assert_false(tulle_obstacle_is_present(world, id));
    assert_true(tulle_cloth_get_positions(world, cloth, NULL)[2] < -0.2);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&floor);
}

static void pins_hold_move_and_let_go(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.5, 7, 0.0);
    tulle_world *const world = make_world(tulle_world_def_default());
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&sheet);
    uint32_t const held[] = {0, 6}, moved[] = {42};
    tulle_keyframe const keys[] = {{0.0, {0, 0, 0}, {0, 0, 0}}, {0.5, {0, 0, 0.1}, {0, 0, 0}}};
    tulle_pin pins[] = {make_pin(held, 2, (double)INFINITY), make_pin(moved, 1, 0.6)};
    pins[1].motion = (tulle_motion){.keys = keys, .key_count = 2};
    def.pins = pins;
    def.pin_count = 2;
    tulle_cloth_id id;
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, NULL), TULLE_OK);
    for (int i = 0; i < 45; i++) step_or_fail(world, NULL);
    const double *x = tulle_cloth_get_positions(world, id, NULL);
    for (int k = 0; k < 2; k++) {
        for (int c = 0; c < 3; c++) {
            assert_true(x[3 * held[k] + (uint32_t)c] == sheet.positions[3 * held[k] + (uint32_t)c]);
        }
    }
    assert_near(x[3 * 42 + 2], 0.1, 1e-12);
    for (int i = 0; i < 30; i++) step_or_fail(world, NULL);
    x = tulle_cloth_get_positions(world, id, NULL);
    assert_true(x[3 * 42 + 2] < 0.05);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
}

/* Bend damping far beyond any preset, and that of presets with small steps, on a sheet held by a
 * corner: energy never grows. */
static void bend_damping_gives_no_energy(void **state) {
    (void)state;
    /* [N m], [s], [s] step */
    double const choices[][3] = {{0.1, 0.1, STEP},
                                 {1e-3, 1.0, STEP},
                                 {1.0, 0.02, STEP},
                                 {0.5, 2e-3, STEP / 4.0},
                                 {1e-3, 5e-3, STEP / 16.0}};
    for (size_t k = 0; k < sizeof choices / sizeof choices[0]; k++) {
        tulle_mesh sheet = small_sheet(1.0, 20, 0.0);
        tulle_world *const world = make_world(tulle_world_def_default());
        tulle_cloth_def def = tulle_cloth_def_default();
        def.mesh = tulle_mesh_get_view(&sheet);
        def.material.springs.stretch_stiffness =
            5e3; /* so that its weight alone stretches it little */
        def.material.springs.bend_stiffness = choices[k][0];
        def.material.bend_damping = choices[k][1];
        uint32_t const corner = 0;
        tulle_pin const pin = make_pin(&corner, 1, (double)INFINITY);
        def.pins = &pin;
        def.pin_count = 1;
        assert_int_equal(tulle_world_add_cloth(world, &def, NULL, NULL), TULLE_OK);
        double last = (double)INFINITY;
        for (int i = 0; i < 100; i++) {
            tulle_step_report report;
            assert_int_equal(tulle_world_step(world, choices[k][2], &report, NULL), TULLE_OK);
            double const energy =
                report.kinetic_energy + report.gravity_energy + report.elastic_energy;
            if (!(energy <= last + 1e-9)) {
                fail_msg("choice %zu, step %d: %g J more, stretch %g", k, i, energy - last,
                         report.max_stretch);
            }
            last = energy;
        }
        tulle_world_destroy(world);
        tulle_mesh_destroy(&sheet);
    }
}

/* A sheet between a fixed and a descending box that would meet; `choice` decides. */
static void pinch(tulle_on_pinch choice) {
    tulle_mesh sheet = small_sheet(0.3, 9, 0.0);
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = box.size[1] = 0.5;
    box.size[2] = 0.1;
    tulle_mesh plates[2] = {small_shape(box, 0, 0, -0.06), small_shape(box, 0, 0, 0.06)};
    tulle_world_def def = tulle_world_def_default();
    def.membrane = TULLE_MEMBRANE_SPRINGS;
    def.on_pinch = choice;
    tulle_world *const world = make_world(def);
    small_add_cloth(world, &sheet);
    small_add_obstacle(world, &plates[0]);
    tulle_obstacle_def upper = tulle_obstacle_def_default();
    upper.mesh = tulle_mesh_get_view(&plates[1]);
    upper.name = "upper plate";
    tulle_keyframe const keys[] = {{0.0, {0, 0, 0}, {0, 0, 0}},
                                   {0.2, {0, 0, -0.021}, {0, 0, 0}}, /* 1 mm into the other */
                                   {0.4, {0, 0, 0}, {0, 0, 0}}};
    upper.motion = (tulle_motion){keys, 3, {0, 0, 0}, 0};
    assert_int_equal(tulle_world_add_obstacle(world, &upper, NULL, NULL), TULLE_OK);
    bool was_pinched = false;
    for (int i = 0; i < 45; i++) {
        uint64_t const hash = tulle_world_get_state_hash(world);
        tulle_step_report report;
        tulle_error error = {0};
        tulle_status const status = tulle_world_step(world, STEP, &report, &error);
        was_pinched = was_pinched || report.pinched;
        if (status != TULLE_OK) {
            assert_int_equal(choice, TULLE_ON_PINCH_STOP);
            assert_int_equal(status, TULLE_ERROR_PINCHED);
            assert_non_null(strstr(error.message, "upper plate"));
            assert_non_null(strstr(error.message, "cloth 0"));
            assert_true(tulle_world_get_state_hash(world) == hash);
            break;
        }
        assert_int_equal(small_judge(world, &sheet, 1, plates, 2), 0);
    }
    assert_true(was_pinched);
    if (choice == TULLE_ON_PINCH_SLOW) { /* it follows its script again */
        const double *const x =
            tulle_obstacle_get_positions(world, (tulle_obstacle_id){1, 1}, NULL);
        assert_near(x[2], plates[1].positions[2], 1e-12);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    for (int k = 0; k < 2; k++) tulle_mesh_destroy(&plates[k]);
}

static void pinch_stops(void **state) {
    (void)state;
    pinch(TULLE_ON_PINCH_STOP);
}

static void pinch_slows(void **state) {
    (void)state;
    pinch(TULLE_ON_PINCH_SLOW);
}

static void numbers_out_of_range_fail_the_step(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.5, 4, 0.0);
    tulle_world *const world = make_world(tulle_world_def_default());
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    double velocities[3 * 16];
    for (int i = 0; i < 3 * 16; i++) velocities[i] = i % 2 == 0 ? 1.7e308 : -1.7e308;
    cloth.velocities = velocities;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    tulle_error error = {0};
    assert_int_equal(tulle_world_start(world, &error), TULLE_OK);
    uint64_t const hash = tulle_world_get_state_hash(world);
    assert_int_equal(tulle_world_step(world, STEP, NULL, &error), TULLE_ERROR_STEP_FAILED);
    assert_non_null(strstr(error.message, "not finite"));
    assert_true(tulle_world_get_state_hash(world) == hash);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
}

static void bad_definitions_are_named(void **state) {
    (void)state;
    tulle_error error = {0};
    tulle_world *world = NULL;
    tulle_world_def bad = {0};
    assert_int_equal(tulle_world_create(&bad, &world, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_null(world);
    bad = tulle_world_def_default();
    change_paper(&bad)->cg_tolerance = (double)NAN;
    assert_int_equal(tulle_world_create(&bad, &world, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "cg_tolerance"));

    world = make_world(tulle_world_def_default());
    tulle_mesh sheet = small_sheet(0.5, 4, 0.0);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.material.area_density = -1.0;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "area_density"));
    uint32_t const outside = 99;
    tulle_pin const pin = make_pin(&outside, 1, 1.0);
    cloth.material.area_density = 0.2;
    cloth.pins = &pin;
    cloth.pin_count = 1;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "vertex 99"));
    small_add_cloth(world, &sheet);
    assert_int_equal(tulle_world_step(world, 0.0, NULL, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_world_step(world, (double)NAN, NULL, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    step_or_fail(world, NULL);
    assert_null(tulle_cloth_get_positions(world, (tulle_cloth_id){0, 2}, NULL));
    assert_null(tulle_cloth_get_positions(world, (tulle_cloth_id){7, 1}, NULL));
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sheet_falls_freely),
        cmocka_unit_test(sheet_drapes_without_intersection),
        cmocka_unit_test(result_does_not_depend_on_threads),
        cmocka_unit_test(every_integrator_drapes),
        cmocka_unit_test(every_quality_drapes),
        cmocka_unit_test(quality_means_nothing_to_the_paper),
        cmocka_unit_test(saved_state_goes_on_with_the_same_bits),
        cmocka_unit_test(obstacles_come_and_go),
        cmocka_unit_test(pins_hold_move_and_let_go),
        cmocka_unit_test(bend_damping_gives_no_energy),
        cmocka_unit_test(pinch_stops),
        cmocka_unit_test(pinch_slows),
        cmocka_unit_test(numbers_out_of_range_fail_the_step),
        cmocka_unit_test(bad_definitions_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
