/* Woven cloth in a world: the warp lies along the grain or as each triangle says, and what the
 * material says of it counts; the same bits for any number of threads, and through a saved state.
 */
#include "support/pins.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 9, STEPS = 60 };

/* A sheet in the plane z = 0 that hangs by its side y = 0.5, pulled down by gravity along y. */
typedef struct hanging {
    tulle_world_def def;
    tulle_material material;
    double grain[3];
    const double *warps;
} hanging;

static hanging make_hanging(void) {
    hanging sheet = {.def = tulle_world_def_default(), .grain = {1.0, 0.0, 0.0}};
    sheet.def.membrane = TULLE_MEMBRANE_WOVEN;
    sheet.def.gravity[1] = -9.81;
    sheet.def.gravity[2] = 0.0;
    assert_int_equal(tulle_material_preset("cotton", &sheet.material), TULLE_OK);
    sheet.material.area_density = 2.0;
    sheet.material.air_damping = 20.0;
    return sheet;
}

static tulle_world *start_hanging(const hanging *sheet) {
    tulle_mesh mesh = small_sheet(1.0, SIDE, 0.0);
    tulle_cloth_def def = tulle_cloth_def_default();
    uint32_t held[SIDE];
    size_t count = 0;
    for (uint32_t v = 0; v < mesh.vertex_count; v++)
        if (mesh.positions[3 * v + 1] > 0.499) held[count++] = v;
    assert_int_equal(count, SIDE);
    tulle_pin const pin = make_pin(held, SIDE, (double)INFINITY);
    def.mesh = tulle_mesh_get_view(&mesh);
    def.material = sheet->material;
    memcpy(def.grain, sheet->grain, sizeof def.grain);
    def.warps = sheet->warps;
    def.pins = &pin;
    def.pin_count = 1;
    tulle_world *world = NULL;
    tulle_error error;
    assert_int_equal(tulle_world_create(&sheet->def, &world, &error), TULLE_OK);
    tulle_cloth_id id;
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, &error), TULLE_OK);
    assert_int_equal(tulle_world_start(world, &error), TULLE_OK);
    tulle_mesh_destroy(&mesh);
    return world;
}

static void step(tulle_world *world, int count) {
    tulle_error error;
    for (int i = 0; i < count; i++)
        assert_int_equal(tulle_world_step(world, 1.0 / 60.0, NULL, &error), TULLE_OK);
}

/* [m] how far the lowest vertex has sunk. */
static double measure_sag(const hanging *sheet) {
    tulle_world *const world = start_hanging(sheet);
    step(world, STEPS);
    tulle_cloth_id const id = {0, 1};
    const double *const positions = tulle_cloth_get_positions(world, id, NULL);
    double lowest = 0.0;
    for (size_t v = 0; v < SIDE * SIDE; v++) lowest = fmin(lowest, positions[3 * v + 1]);
    tulle_world_destroy(world);
    return -0.5 - lowest;
}

/* Its own weight stretches a hanging sheet by rho g / (2 k). */
static void the_warp_lies_along_the_grain(void **state) {
    (void)state;
    hanging sheet = make_hanging();
    sheet.material.poisson = 0.0;
    sheet.material.warp = (tulle_curve){4000.0, 0.0, 1.0};
    sheet.material.weft = (tulle_curve){1000.0, 0.0, 1.0};
    double const wanted = 2.0 * 9.81 / 2.0;
    double const across = measure_sag(&sheet);
    assert_true(fabs(across - wanted / 1000.0) < 0.02 * wanted / 1000.0);
    sheet.grain[0] = 0.0, sheet.grain[1] = -1e-3;
    double const along = measure_sag(&sheet);
    assert_true(fabs(along - wanted / 4000.0) < 0.02 * wanted / 4000.0);

    double warps[3 * 2 * (SIDE - 1) * (SIDE - 1)] = {0.0};
    for (size_t i = 1; i < sizeof warps / sizeof *warps; i += 3) warps[i] = 7.0;
    sheet.grain[0] = 1.0, sheet.grain[1] = 0.0;
    sheet.warps = warps;
    double const by_triangle = measure_sag(&sheet);
    assert_true(fabs(by_triangle - along) < 1e-9);
}

enum { OVERHANG = 6 }; /* cells */

/* How far the end of an overhanging strip sinks, over what theory says of one that is clamped where
 * its pins end, rho g l^4 / (8 B). Two columns of cells are pinned, until `release_time`; by two
 * pins where there are to be `pins` of them. */
static double measure_overhang(double release_time, size_t pins) {
    double const cell = 0.01, load = 0.02; /* the strip sinks by a fortieth of its length */
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    uint32_t const columns = OVERHANG + 3, rows = 4;
    shape.size[0] = (columns - 1) * cell, shape.size[1] = (rows - 1) * cell;
    shape.resolution[0] = columns, shape.resolution[1] = rows;
    tulle_mesh mesh = {0};
    assert_int_equal(tulle_shape_generate(&shape, &mesh, NULL), TULLE_OK);
    uint32_t held[2][12];
    size_t counts[2] = {0};
    for (uint32_t v = 0; v < mesh.vertex_count; v++) {
        double const column = mesh.positions[3 * v] / cell + 0.5 * (columns - 1);
        size_t const pin = pins == 2 && column > 1.5;
        if (column < 2.5) held[pin][counts[pin]++] = v;
    }
    assert_int_equal(counts[0] + counts[1], 12);
    tulle_pin both[2];
    for (size_t i = 0; i < 2; i++) both[i] = make_pin(held[i], counts[i], release_time);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&mesh);
    def.material.air_damping = 10.0;
    def.pins = both;
    def.pin_count = pins;
    double const length = OVERHANG * cell;
    double const gravity = load * 8.0 * def.material.bend_warp /
                           (def.material.area_density * length * length * length);
    tulle_world_def world_def = tulle_world_def_default();
    world_def.membrane = TULLE_MEMBRANE_WOVEN;
    world_def.gravity[2] = -gravity;
    tulle_world *world = NULL;
    tulle_error error;
    assert_int_equal(tulle_world_create(&world_def, &world, &error), TULLE_OK);
    tulle_cloth_id id;
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, &error), TULLE_OK);
    assert_int_equal(tulle_world_start(world, &error), TULLE_OK);
    step(world, 600);
    const double *const x = tulle_cloth_get_positions(world, id, NULL);
    double sum = 0.0;
    for (size_t v = 0; v < mesh.vertex_count; v++)
        if (mesh.positions[3 * v] > 0.499 * shape.size[0]) sum -= x[3 * v + 2];
    tulle_world_destroy(world);
    tulle_mesh_destroy(&mesh);
    return sum / rows / (load * length);
}

/* What one pin holds for ever does not bend, so cloth bends from the pin's edge on; beside it half
 * a cell more bends, (1 + 1 / 12)^4. */
static void cloth_bends_from_the_edge_of_a_clamp(void **state) {
    (void)state;
    double const clamped = measure_overhang((double)INFINITY, 1);
    if (!(fabs(clamped - 1.0) < 0.03)) fail_msg("clamped: %g", clamped);
    double const released_later = measure_overhang(1e3, 1);
    if (!(fabs(released_later - 1.38) < 0.06)) fail_msg("held for a while: %g", released_later);
    /* Nothing says that two pins move alike: neither holds the cells between them. */
    double const by_two = measure_overhang((double)INFINITY, 2);
    if (!(fabs(by_two - 1.38) < 0.06)) fail_msg("held by two: %g", by_two);
}

/* Its weight pulls the uppermost row beyond what the fabric holds: the step tells of it or, if it
 * is to stop there, fails and leaves the state as it was. */
static void what_a_fabric_does_not_hold_is_told(void **state) {
    (void)state;
    hanging sheet = make_hanging();
    sheet.material.poisson = 0.0;
    sheet.material.warp = (tulle_curve){4000.0, 0.0, 1e-3};
    sheet.material.weft = (tulle_curve){1000.0, 0.0, 0.015};
    tulle_error error;
    tulle_step_report report;
    tulle_world *world = start_hanging(&sheet);
    step(world, STEPS);
    assert_int_equal(tulle_world_step(world, 1.0 / 60.0, &report, &error), TULLE_OK);
    /* the weight of what hangs below the middle of a row of triangles */
    double const row = 1.0 / (SIDE - 1);
    int rows = 0;
    while (2.0 * 9.81 * (1.0 - (rows + 0.5) * row) / 1000.0 > 0.015) rows++;
    assert_true(rows > 0 && rows < SIDE - 1);
    assert_in_range(report.overstretched, 2 * (SIDE - 1) * (size_t)rows - (SIDE - 1),
                    2 * (SIDE - 1) * (size_t)rows + (SIDE - 1));
    tulle_stretch const largest = tulle_world_find_largest_stretch(world);
    assert_true(largest.stretch == report.max_stretch);
    assert_true(largest.stretch > 1.015 && largest.stretch < 1.021);
    assert_int_equal(largest.cloth, 0);
    assert_true(largest.position[1] > 0.5 - row); /* in the uppermost row, along the weft */
    const double *const positions = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL);
    const double *const ends[2] = {positions + 3 * (size_t)largest.vertices[0],
                                   positions + 3 * (size_t)largest.vertices[1]};
    assert_true(fabs(ends[0][1] - ends[1][1]) > 10.0 * fabs(ends[0][0] - ends[1][0]));
    tulle_world_destroy(world);

    sheet.def.on_overstretch = TULLE_ON_OVERSTRETCH_STOP;
    world = start_hanging(&sheet);
    uint64_t hash = 0;
    tulle_status status = TULLE_OK;
    int steps = 0;
    for (; status == TULLE_OK && steps < STEPS; steps++) {
        hash = tulle_world_get_state_hash(world);
        status = tulle_world_step(world, 1.0 / 60.0, &report, &error);
    }
    assert_in_range(steps, 2, STEPS - 1);
    assert_int_equal(status, TULLE_ERROR_STEP_FAILED);
    assert_true(tulle_world_get_state_hash(world) == hash);
    assert_non_null(strstr(error.message, "is overstretched in step"));
    assert_non_null(strstr(error.message, "its weft is stretched by 1."));
    assert_non_null(strstr(error.message, "the material holds 1.5 %"));
    assert_int_equal(tulle_world_step(world, 1.0 / 60.0, &report, &error), status); /* again */
    assert_true(tulle_world_get_state_hash(world) == hash);
    tulle_world_destroy(world);
}

static void springs_do_not_look_at_it(void **state) {
    (void)state;
    hanging sheet = make_hanging();
    sheet.def.membrane = TULLE_MEMBRANE_SPRINGS;
    double const one = measure_sag(&sheet);
    sheet.grain[0] = 0.0, sheet.grain[1] = 1.0;
    sheet.material.warp.stiffness = sheet.material.weft.stiffness = -1.0; /* nor check it */
    assert_true(measure_sag(&sheet) == one);
}

static void a_saved_state_goes_on_to_the_same_bits(void **state) {
    (void)state;
    hanging sheet = make_hanging();
    tulle_world *const world = start_hanging(&sheet);
    sheet.def.threads = 3;
    tulle_world *const other = start_hanging(&sheet);
    step(world, 10);
    step(other, 10);
    assert_int_equal(tulle_world_get_state_hash(world), tulle_world_get_state_hash(other));
    void *saved = NULL;
    size_t size = 0;
    tulle_error error;
    assert_int_equal(tulle_world_save_state(world, &saved, &size, &error), TULLE_OK);
    step(world, 10);
    assert_int_equal(tulle_world_load_state(other, saved, size, &error), TULLE_OK);
    step(other, 10);
    assert_int_equal(tulle_world_get_state_hash(world), tulle_world_get_state_hash(other));
    /* The same cloth of springs is another world. */
    sheet.def.membrane = TULLE_MEMBRANE_SPRINGS;
    tulle_world *const springs = start_hanging(&sheet);
    assert_int_not_equal(tulle_world_load_state(springs, saved, size, &error), TULLE_OK);
    tulle_world_free_state(world, saved, size);
    tulle_world_destroy(springs);
    tulle_world_destroy(world);
    tulle_world_destroy(other);
}

/* [m] the corners of all triangles of a mesh, times `scale`. */
static double *list_corners(const tulle_mesh *mesh, double scale) {
    double *const corners = malloc(9 * mesh->triangle_count * sizeof *corners);
    assert_non_null(corners);
    for (size_t k = 0; k < 3 * mesh->triangle_count; k++)
        for (size_t axis = 0; axis < 3; axis++)
            corners[3 * k + axis] = scale * mesh->positions[3 * (size_t)mesh->triangles[k] + axis];
    return corners;
}

/* An elastic band: it draws together to the size that it has at rest. */
static void what_is_smaller_at_rest_shrinks(void **state) {
    (void)state;
    tulle_mesh mesh = small_sheet(1.0, SIDE, 0.0);
    double *const corners = list_corners(&mesh, 0.9);
    tulle_world_def world_def = tulle_world_def_default();
    world_def.membrane = TULLE_MEMBRANE_WOVEN;
    world_def.gravity[2] = 0.0;
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&mesh);
    def.rest_corners = corners;
    def.material.air_damping = 10.0;
    tulle_world *world = NULL;
    tulle_error error;
    tulle_cloth_id id;
    assert_int_equal(tulle_world_create(&world_def, &world, &error), TULLE_OK);
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, &error), TULLE_OK);
    corners[0] = 5.0; /* it was copied */
    step(world, STEPS);
    const double *const positions = tulle_cloth_get_positions(world, id, NULL);
    double low = 0.0, high = 0.0;
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        low = fmin(low, positions[3 * v]);
        high = fmax(high, positions[3 * v]);
    }
    assert_true(fabs(high - low - 0.9) < 1e-3);
    tulle_world_destroy(world);
    free(corners);
    tulle_mesh_destroy(&mesh);
}

static void a_bad_triangle_at_rest_is_named(void **state) {
    (void)state;
    tulle_mesh mesh = small_sheet(1.0, 3, 0.0);
    double *const corners = list_corners(&mesh, 1.0);
    tulle_world_def const world_def = tulle_world_def_default();
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&mesh);
    def.rest_corners = corners;
    tulle_world *world = NULL;
    tulle_error error;
    tulle_cloth_id id;
    assert_int_equal(tulle_world_create(&world_def, &world, &error), TULLE_OK);
    memcpy(corners + 9 * 5, corners + 9 * 5 + 3, 3 * sizeof *corners);
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "triangle 5 at rest is too thin"));
    corners[9 * 2 + 4] = 1e7;
    assert_int_equal(tulle_world_add_cloth(world, &def, &id, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "rest_corners of triangle 2"));
    tulle_world_destroy(world);
    free(corners);
    tulle_mesh_destroy(&mesh);
}

/* A sheet that starts bent and is flat at rest springs open; one that is bent at rest stays. */
static void folds_may_be_left_out_of_the_rest_shape(void **state) {
    (void)state;
    double heights[2];
    for (int is_flat = 0; is_flat < 2; is_flat++) {
        tulle_mesh mesh = small_sheet(1.0, SIDE, 0.0);
        for (size_t v = 0; v < mesh.vertex_count; v++) {
            double const angle = mesh.positions[3 * v] / 0.6;
            mesh.positions[3 * v] = 0.6 * sin(angle);
            mesh.positions[3 * v + 2] = 0.6 * (1.0 - cos(angle));
        }
        tulle_world_def world_def = tulle_world_def_default();
        world_def.membrane = TULLE_MEMBRANE_WOVEN;
        world_def.gravity[2] = 0.0;
        tulle_cloth_def def = tulle_cloth_def_default();
        def.mesh = tulle_mesh_get_view(&mesh);
        def.has_flat_rest = is_flat;
        def.material.bend_warp = def.material.bend_weft = def.material.bend_twist = 1e-2;
        def.material.bend_damping = 0.05;
        tulle_world *world = NULL;
        tulle_error error;
        tulle_cloth_id id;
        assert_int_equal(tulle_world_create(&world_def, &world, &error), TULLE_OK);
        assert_int_equal(tulle_world_add_cloth(world, &def, &id, &error), TULLE_OK);
        step(world, 4 * STEPS);
        const double *const positions = tulle_cloth_get_positions(world, id, NULL);
        double low = (double)INFINITY, high = -(double)INFINITY;
        for (size_t v = 0; v < mesh.vertex_count; v++) {
            low = fmin(low, positions[3 * v + 2]);
            high = fmax(high, positions[3 * v + 2]);
        }
        heights[is_flat] = high - low;
        tulle_world_destroy(world);
        tulle_mesh_destroy(&mesh);
    }
    assert_true(fabs(heights[0] - 0.6 * (1.0 - cos(0.5 / 0.6))) < 1e-4);
    assert_true(heights[1] < 0.1 * heights[0]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_smaller_at_rest_shrinks),
        cmocka_unit_test(a_bad_triangle_at_rest_is_named),
        cmocka_unit_test(folds_may_be_left_out_of_the_rest_shape),
        cmocka_unit_test(the_warp_lies_along_the_grain),
        cmocka_unit_test(cloth_bends_from_the_edge_of_a_clamp),
        cmocka_unit_test(what_a_fabric_does_not_hold_is_told),
        cmocka_unit_test(springs_do_not_look_at_it),
        cmocka_unit_test(a_saved_state_goes_on_to_the_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
