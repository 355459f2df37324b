/* Starts that intersect: refused by name, or ignored until the pairs have come apart. */
#include "support/pins.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 1.0 / 90.0; /* [s] */

static tulle_world *make_world(tulle_world_def def) {
    tulle_world *world = NULL;
    tulle_error error = {0};
    if (tulle_world_create(&def, &world, &error) != TULLE_OK) fail_msg("%s", error.message);
    return world;
}

static void step_or_fail(tulle_world *world, tulle_step_report *report) {
    tulle_error error = {0};
    tulle_status const status = tulle_world_step(world, STEP, report, &error);
    if (status != TULLE_OK) fail_msg("step: %s: %s", tulle_status_text(status), error.message);
}

static tulle_mesh make_sphere(double radius, unsigned resolution) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    def.radius = radius;
    def.resolution[0] = def.resolution[1] = resolution;
    return small_shape(def, 0.0, 0.0, 0.0);
}

/* A cube of 0.2 m with a corner of another in it, 0.03 m deep: all that crosses is told, the
 * deepest first, and where. */
static void refused_start_tells_how_deep_and_where(void **state) {
    (void)state;
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
    def.size[0] = def.size[1] = def.size[2] = 0.2;
    def.resolution[0] = 2;
    tulle_mesh lower = small_shape(def, 5.0, 0.0, 0.0), upper = small_shape(def, 5.05, 0.04, 0.17);
    tulle_world *const world = make_world(tulle_world_def_default());
    small_add_cloth(world, &upper);
    small_add_obstacle(world, &lower);
    size_t count = 1;
    assert_null(tulle_world_get_overlaps(world, &count));
    assert_int_equal(count, 0);
    tulle_error error = {0};
    assert_int_equal(tulle_world_start(world, &error), TULLE_ERROR_INTERSECTING_START);
    const tulle_overlap *const overlaps = tulle_world_get_overlaps(world, &count);
    size_t pair_count = 0;
    (void)tulle_world_get_intersections(world, &pair_count);
    assert_true(pair_count > 0);
    assert_int_equal(count, pair_count);
    assert_true(overlaps[0].depth > 0.0);
    double const low[3] = {4.95, -0.06, 0.07}, high[3] = {5.1, 0.1, 0.1};
    for (size_t i = 0; i < count; i++) {
        assert_true(overlaps[i].depth >= 0.0);
        assert_true(i == 0 || overlaps[i].depth <= overlaps[i - 1].depth);
        for (int c = 0; c < 3; c++) {
            assert_true(overlaps[i].position[c] > low[c] - 1e-9);
            assert_true(overlaps[i].position[c] < high[c] + 1e-9);
        }
    }
    char deepest[96];
    snprintf(deepest, sizeof deepest, ":\n  %.3g m deep at (%.6g, %.6g, %.6g), ", overlaps[0].depth,
             overlaps[0].position[0], overlaps[0].position[1], overlaps[0].position[2]);
    if (!strstr(error.message, deepest)) fail_msg("%s: %s", deepest, error.message);
    tulle_world_destroy(world);
    tulle_mesh_destroy(&lower);
    tulle_mesh_destroy(&upper);
}

/* Corners of two cubes in a third one, 0.01 and 0.03 m deep: what is deeper comes first. */
static void the_deepest_overlaps_come_first(void **state) {
    (void)state;
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
    def.size[0] = def.size[1] = def.size[2] = 0.2;
    def.resolution[0] = 2;
    tulle_mesh lower = small_shape(def, 5.0, 0.0, 0.0);
    tulle_mesh uppers[2] = {small_shape(def, 4.85, 0.04, 0.19), small_shape(def, 5.06, 0.05, 0.17)};
    for (int i = 0; i < 2; i++) {
        tulle_world *const world = make_world(tulle_world_def_default());
        for (int k = 0; k < 2; k++) small_add_cloth(world, &uppers[k == i]);
        small_add_obstacle(world, &lower);
        assert_int_equal(tulle_world_start(world, NULL), TULLE_ERROR_INTERSECTING_START);
        size_t count = 0;
        const tulle_overlap *const overlaps = tulle_world_get_overlaps(world, &count);
        assert_true(count > 4 && fabs(overlaps[0].depth - 0.03) < 1e-9);
        assert_true(overlaps[count - 1].depth < 0.0101);
        for (size_t k = 1; k < count; k++) assert_true(overlaps[k].depth <= overlaps[k - 1].depth);
        tulle_world_destroy(world);
    }
    for (int i = 0; i < 2; i++) tulle_mesh_destroy(&uppers[i]);
    tulle_mesh_destroy(&lower);
}

static void intersecting_start_is_refused_or_ignored(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(1.0, 11, 0.01), sphere = make_sphere(0.2, 10);
    tulle_world_def def = tulle_world_def_default();
    tulle_world *world = make_world(def);
    small_add_cloth(world, &sheet);
    small_add_obstacle(world, &sphere);
    tulle_error error = {0};
    assert_int_equal(tulle_world_start(world, &error), TULLE_ERROR_INTERSECTING_START);
    assert_non_null(strstr(error.message, "triangle"));
    assert_non_null(strstr(error.message, "cloth 0"));
    assert_non_null(strstr(error.message, "obstacle 0"));
    size_t count = 0;
    assert_non_null(tulle_world_get_intersections(world, &count));
    assert_true(count > 3);
    tulle_world_destroy(world);

    def.start_intersections = TULLE_START_IGNORE;
    world = make_world(def);
    small_add_cloth(world, &sheet);
    small_add_obstacle(world, &sphere);
    for (int i = 0; i < 20; i++) {
        tulle_step_report report;
        step_or_fail(world, &report);
        assert_true(report.ignored_pairs <= count);
        /* nothing new begins to intersect */
        assert_true(small_judge(world, &sheet, 1, &sphere, 1) <= report.ignored_pairs);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&sphere);
}

/* One cloth of two triangles: one pinned flat, the other upright through it. It falls out below;
 * the pair is ignored exactly as long as it intersects. */
static void pairs_of_one_cloth_count_once_apart(void **state) {
    (void)state;
    double positions[] = {-0.3, -0.3, 0.0,  0.3, -0.3, 0.0,  0.0, 0.4, 0.0,
                          -0.1, 0.0,  -0.1, 0.1, 0.0,  -0.1, 0.0, 0.0, 0.05};
    uint32_t triangles[] = {0, 1, 2, 3, 4, 5};
    uint32_t const held[] = {0, 1, 2};
    tulle_pin const pin = make_pin(held, 3, (double)INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = (tulle_mesh_view){positions, 6, triangles, 2};
    cloth.pins = &pin;
    cloth.pin_count = 1;
    tulle_world_def def = tulle_world_def_default();
    def.start_intersections = TULLE_START_IGNORE;
    tulle_world *const world = make_world(def);
    tulle_cloth_id id;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, &id, NULL), TULLE_OK);
    tulle_mesh const view = {positions, 6, triangles, 2};
    tulle_step_report report = {0};
    step_or_fail(world, &report);
    assert_int_equal(report.ignored_pairs, 1);
    assert_int_equal(small_judge(world, &view, 1, NULL, 0), 1);
    for (int i = 0; i < 20; i++) {
        step_or_fail(world, &report);
        assert_int_equal(report.ignored_pairs, small_judge(world, &view, 1, NULL, 0));
    }
    assert_int_equal(report.ignored_pairs, 0);
    assert_true(tulle_cloth_get_positions(world, id, NULL)[3 * 5 + 2] < 0.0);
    tulle_world_destroy(world);
}

/* Cloth that crosses nothing but lies in a solid is a bad start; in a room it is not. */
static void cloth_inside_a_solid_is_refused(void **state) {
    (void)state;
    static const tulle_start_intersections choices[] = {TULLE_START_REFUSE, TULLE_START_UNTANGLE,
                                                        TULLE_START_IGNORE};
    tulle_mesh sheet = small_sheet(0.1, 5, 0.01), sphere = make_sphere(0.2, 10);
    for (int is_room = 0; is_room < 2; is_room++) {
        for (size_t t = 0; is_room && t < sphere.triangle_count; t++) {
            uint32_t const corner = sphere.triangles[3 * t];
            sphere.triangles[3 * t] = sphere.triangles[3 * t + 1];
            sphere.triangles[3 * t + 1] = corner;
        }
        for (int i = 0; i < 3; i++) {
            tulle_world_def def = tulle_world_def_default();
            def.start_intersections = choices[i];
            tulle_world *const world = make_world(def);
            small_add_cloth(world, &sheet);
            small_add_obstacle(world, &sphere);
            tulle_error error = {0};
            int const is_refused = !is_room && choices[i] != TULLE_START_IGNORE;
            assert_int_equal(tulle_world_start(world, &error),
                             is_refused ? TULLE_ERROR_INTERSECTING_START : TULLE_OK);
            if (is_refused) {
                assert_non_null(strstr(error.message, "'cloth 0' lies inside 'obstacle 0'"));
                /* a corner of the sheet, (-0.05, -0.05, 0.01), below the ball's radius of 0.2 */
                const char *const told = strstr(error.message, " is ");
                double depth = 0.0;
                assert_non_null(told);
                assert_int_equal(sscanf(told, " is %lf m deep", &depth), 1);
                assert_true(depth > 0.12 && depth < 0.2 - sqrt(0.0051) + 0.001);
            }
            tulle_world_destroy(world);
        }
    }
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&sphere);
}

/* The same where the solid appears in mid-run: the time is named, and the world stays as it was.
 * One that is there already and holds nothing may stay. */
static void cloth_that_a_solid_appears_around_is_refused(void **state) {
    (void)state;
    tulle_mesh sheet = small_sheet(0.1, 5, 0.01), sphere = make_sphere(0.2, 10);
    for (int is_ignored = 0; is_ignored < 2; is_ignored++) {
        tulle_world_def def = tulle_world_def_default();
        if (is_ignored) def.start_intersections = TULLE_START_IGNORE;
        tulle_world *const world = make_world(def);
        small_add_cloth(world, &sheet);
        tulle_obstacle_def obstacle = tulle_obstacle_def_default();
        obstacle.mesh = tulle_mesh_get_view(&sphere);
        obstacle.appear_time = 1.5 * STEP;
        assert_int_equal(tulle_world_add_obstacle(world, &obstacle, NULL, NULL), TULLE_OK);
        tulle_step_report report;
        for (int i = 0; i < 2; i++) step_or_fail(world, &report);
        uint64_t const hash = tulle_world_get_state_hash(world);
        for (int i = 0; i < 2; i++) {
            tulle_error error = {0};
            tulle_status const status = tulle_world_step(world, STEP, NULL, &error);
            assert_int_equal(status, is_ignored ? TULLE_OK : TULLE_ERROR_INTERSECTING_START);
            if (is_ignored) continue;
            assert_non_null(strstr(error.message, "'cloth 0' lies inside 'obstacle 0' when"));
            char when[64];
            snprintf(when, sizeof when, " appears or comes free at %.6g s ", 2.0 * STEP);
            assert_non_null(strstr(error.message, when));
            assert_int_equal(hash, tulle_world_get_state_hash(world));
        }
        tulle_world_destroy(world);
    }
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&sphere);
}

/* Distances that do not go together with those of the meshes and thicknesses are errors that say
 * which of them to change: a minimum gap of the caller is not one of a scene that is too large. */
static void distances_that_do_not_fit_are_refused(void **state) {
    (void)state;
    tulle_mesh sheets[3] = {small_sheet(0.4, 9, 0.0), small_sheet(0.4, 9, 0.1),
                            small_sheet(0.4, 9, 0.2)};
    struct {
        double thickness, separation, gap, far;
        const char *message;
    } const cases[] = {
        {0.0, 0.0, 0.0, 0.0, NULL},
        {0.004, 0.005, 0.002, 0.0, NULL}, /* the bounds themselves */
        {0.004, 0.0, 0.0021, 0.0, "the minimum gap (xi) of 0.0021 m is more than half"},
        {0.0, 0.0, 0.0026, 0.0, "give at most 0.0025 m"},
        {0.004, 0.0049, 0.0, 0.0, "the separation distance (delta_s) of 0.0049 m is under"},
        {0.006, 0.0055, 0.0, 0.0, "of 0.006 m between 'cloth 1' and 'cloth 1'"},
        {0.0, 0.0, 0.0, 1e4, "reaches 10000.2 m from the origin"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        tulle_world_def def = tulle_world_def_default();
        def.separation_distance = cases[i].separation;
        def.minimum_gap = cases[i].gap;
        tulle_world *const world = make_world(def);
        for (int k = 0; k < 3; k++) {
            tulle_mesh moved = sheets[k];
            tulle_cloth_def cloth = tulle_cloth_def_default();
            cloth.mesh = tulle_mesh_get_view(&moved);
            cloth.thickness = k == 1 ? cases[i].thickness : 0.0; /* 5 mm from the mesh */
            for (size_t v = 0; k == 2 && v < moved.vertex_count; v++)
                moved.positions[3 * v + 2] = 0.2 + cases[i].far;
            assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
        }
        tulle_error error = {0};
        tulle_status const status = tulle_world_start(world, &error);
        assert_int_equal(status, cases[i].message ? TULLE_ERROR_INVALID_ARGUMENT : TULLE_OK);
        if (cases[i].message && !strstr(error.message, cases[i].message))
            fail_msg("no \"%s\" in \"%s\"", cases[i].message, error.message);
        tulle_world_destroy(world);
    }
    for (int k = 0; k < 3; k++) tulle_mesh_destroy(&sheets[k]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(refused_start_tells_how_deep_and_where),
        cmocka_unit_test(the_deepest_overlaps_come_first),
        cmocka_unit_test(intersecting_start_is_refused_or_ignored),
        cmocka_unit_test(cloth_inside_a_solid_is_refused),
        cmocka_unit_test(cloth_that_a_solid_appears_around_is_refused),
        cmocka_unit_test(pairs_of_one_cloth_count_once_apart),
        cmocka_unit_test(distances_that_do_not_fit_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
