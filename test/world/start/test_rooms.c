/* Where the start leaves less room than the contact distance that the world chooses: contact keeps
 * that room, and what is narrower is told. */
#include "support/small_world.h"
#include "support/test_support.h"
#include "world/world_state.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define STEP (1.0 / 90.0)

/* A sheet of 1 m over a plane; `thickness` 0: the world chooses 5 mm. */
static tulle_world *make_sheet(double height, double thickness, tulle_mesh *sheet) {
    tulle_world_def const def = tulle_world_def_default();
    tulle_world *world = NULL;
    tulle_error error = {0};
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    *sheet = small_sheet(1.0, 11, height);
    tulle_shape_def plane = tulle_shape_def_default(TULLE_SHAPE_PLANE);
    plane.size[0] = plane.size[1] = 2.0;
    tulle_mesh table = small_shape(plane, 0.0, 0.0, 0.0);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.name = "sheet";
    cloth.mesh = tulle_mesh_get_view(sheet);
    cloth.thickness = thickness;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    small_add_obstacle(world, &table);
    tulle_mesh_destroy(&table);
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s", error.message);
    return world;
}

static double find_highest(const tulle_world *world, size_t count) {
    const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, NULL);
    double highest = -INFINITY;
    for (size_t i = 0; i < count; i++) highest = fmax(highest, x[3 * i + 2]);
    return highest;
}

/* [m] the highest that a vertex of the sheet is in 20 steps */
static double rise(double height, double thickness) {
    tulle_mesh sheet;
    tulle_world *const world = make_sheet(height, thickness, &sheet);
    double highest = height;
    for (int i = 0; i < 20; i++) {
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
        highest = fmax(highest, find_highest(world, sheet.vertex_count));
    }
    tulle_mesh_destroy(&sheet);
    tulle_world_destroy(world);
    return highest;
}

static void sheet_near_a_table_lies_still(void **state) {
    (void)state;
    double const near = rise(1e-3, 0.0), given = rise(1e-3, 5e-3);
    print_message("1 mm over a table a sheet rises to %.4g mm; with a thickness of 5 mm to %.4g\n",
                  1e3 * near, 1e3 * given);
    assert_true(near < 1.01e-3);
    assert_true(given > 4e-3); /* what is given holds */
}

static void enough_room_changes_nothing(void **state) {
    (void)state;
    tulle_mesh sheet;
    tulle_world *const world = make_sheet(6e-3, 0.0, &sheet);
    assert_null(world->model.rooms);
    assert_string_equal(tulle_world_last_message(world), "");
    tulle_mesh_destroy(&sheet);
    tulle_world_destroy(world);
}

static void what_is_narrower_is_told(void **state) {
    (void)state;
    tulle_mesh sheet;
    tulle_world *world = make_sheet(2e-4, 0.0, &sheet);
    const char *const message = tulle_world_last_message(world);
    print_message("%s\n", message);
    assert_non_null(strstr(message, "'sheet' lies 0.2 mm from"));
    assert_non_null(strstr(message, "0.5 mm"));
    assert_non_null(strstr(message, "a thickness of 0.2 mm"));
    tulle_mesh_destroy(&sheet);
    tulle_world_destroy(world);
    world = make_sheet(2e-4, 2e-4, &sheet);
    assert_string_equal(tulle_world_last_message(world), "");
    tulle_mesh_destroy(&sheet);
    tulle_world_destroy(world);
}

/* A card over a slot between two boxes of some width [m] falls for 45 steps: where its top is. */
static double drop_card(double width, double thickness, char message[WORLD_MESSAGE_BYTES]) {
    tulle_world_def def = tulle_world_def_default();
    def.wind.drag_coefficient = 0.0;
    tulle_world *world = NULL;
    tulle_error error = {0};
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_mesh card = small_sheet(0.3, 7, 0.0);
    for (size_t i = 0; i < card.vertex_count; i++) { /* on its edge, in the plane x = 0 */
        double *const p = card.positions + 3 * i;
        p[2] = 0.5 + p[0];
        p[0] = 0.0;
    }
    tulle_cloth_def cloth = tulle_cloth_def_default();
    assert_int_equal(tulle_material_preset("felt", &cloth.material), TULLE_OK);
    cloth.material.friction = 0.0;
    cloth.material.dynamic_friction = -1.0;
    cloth.material.air_damping = 0.0;
    cloth.mesh = tulle_mesh_get_view(&card);
    cloth.thickness = thickness;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    tulle_shape_def box = tulle_shape_def_default(TULLE_SHAPE_BOX);
    box.size[0] = 0.1;
    box.size[1] = 1.0;
    box.size[2] = 0.02;
    for (int side = -1; side <= 1; side += 2) {
        tulle_mesh wall = small_shape(box, (0.05 + 0.5 * width) * side, 0.0, 0.3);
        small_add_obstacle(world, &wall);
        tulle_mesh_destroy(&wall);
    }
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s", error.message);
    snprintf(message, WORLD_MESSAGE_BYTES, "%s", tulle_world_last_message(world));
    for (int i = 0; i < 45; i++)
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
    double const top = find_highest(world, card.vertex_count);
    print_message("a slot of %g mm: the card's top is at %.4g m; %s\n", 1e3 * width, top, message);
    tulle_mesh_destroy(&card);
    tulle_world_destroy(world);
    return top;
}

static void card_passes_a_slot(void **state) {
    (void)state;
    char message[WORLD_MESSAGE_BYTES];
    double const fallen = -0.5;                          /* it fell freely: 1.24 m */
    assert_true(drop_card(4e-3, 0.0, message) < fallen); /* 2 mm to spare on each side */
    assert_string_equal(message, "");
    /* a slot that is narrower than the least is told, and what it takes: so it is */
    assert_true(drop_card(2e-4, 0.0, message) > 0.0);
    assert_non_null(strstr(message, "are 0.2 mm apart"));
    assert_non_null(strstr(message, "a thickness of at most 0.08 mm"));
    assert_true(drop_card(2e-4, 8e-5, message) < fallen);
    assert_string_equal(message, "");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sheet_near_a_table_lies_still),
        cmocka_unit_test(enough_room_changes_nothing),
        cmocka_unit_test(what_is_narrower_is_told),
        cmocka_unit_test(card_passes_a_slot),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
