/* Slots within one obstacle: contact keeps the room that there is between its parts, and what is no
 * slot keeps the contact distance that the world chose. And rooms of what comes to a world that
 * runs. */
#include "support/small_world.h"
#include "support/test_support.h"
#include "world/world_state.h"

#include <math.h>
#include <string.h>
#include <time.h>

static const double STEP = 1.0 / 90.0;

static tulle_world *make_world(void) {
    tulle_world_def def = tulle_world_def_default();
    def.wind.drag_coefficient = 0.0;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    return world;
}

static void start(tulle_world *world) {
    tulle_error error = {0};
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s", error.message);
}

/* A card of 0.3 m on its edge in the plane x = 0, its middle at z = 0.5. */
static void add_card(tulle_world *world) {
    tulle_mesh card = small_sheet(0.3, 7, 0.0);
    for (size_t i = 0; i < card.vertex_count; i++) {
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
    tulle_error error = {0};
    if (tulle_world_add_cloth(world, &cloth, NULL, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    tulle_mesh_destroy(&card);
}

/* [m] the lowest vertex of the card after `count` steps */
static double drop_card(tulle_world *world, double step, int count) {
    for (int i = 0; i < count; i++)
        assert_int_equal(tulle_world_step(world, step, NULL, NULL), TULLE_OK);
    size_t vertex_count = 0;
    const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, &vertex_count);
    double lowest = INFINITY;
    for (size_t i = 0; i < vertex_count; i++) lowest = fmin(lowest, x[3 * i + 2]);
    return lowest;
}

/* Both meshes as one. Takes them. */
static tulle_mesh join(tulle_mesh a, tulle_mesh b) {
    tulle_mesh joined = {0};
    assert_int_equal(tulle_mesh_create(a.vertex_count + b.vertex_count,
                                       a.triangle_count + b.triangle_count, &joined, NULL),
                     TULLE_OK);
    memcpy(joined.positions, a.positions, 3 * a.vertex_count * sizeof(double));
    memcpy(joined.positions + 3 * a.vertex_count, b.positions, 3 * b.vertex_count * sizeof(double));
    memcpy(joined.triangles, a.triangles, 3 * a.triangle_count * sizeof(uint32_t));
    for (size_t i = 0; i < 3 * b.triangle_count; i++)
        joined.triangles[3 * a.triangle_count + i] = b.triangles[i] + (uint32_t)a.vertex_count;
    tulle_mesh_destroy(&a);
    tulle_mesh_destroy(&b);
    return joined;
}

static tulle_mesh make_box(double x, double y, double z, double at_x, double at_z) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
    def.size[0] = x;
    def.size[1] = y;
    def.size[2] = z;
    return small_shape(def, at_x, 0.0, at_z);
}

/* Two boards as one mesh, `gap` apart across x = 0. */
static tulle_mesh make_boards(double gap) {
    double const x = 0.05 + 0.5 * gap;
    return join(make_box(0.1, 1.0, 0.02, -x, 0.3), make_box(0.1, 1.0, 0.02, x, 0.3));
}

/* Turns a solid about z into one about y. */
static tulle_mesh lay_down(tulle_mesh mesh, double x, double z) {
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        double *const p = mesh.positions + 3 * v;
        double const y = p[1];
        p[0] += x;
        p[1] = p[2];
        p[2] = z - y;
    }
    return mesh;
}

/* Two bars of 3 mm radius along y as one mesh. */
static tulle_mesh make_bars(double gap) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_CYLINDER);
    def.radius = 3e-3;
    def.height = 1.0;
    def.resolution[0] = 24;
    def.resolution[1] = 2;
    double const x = def.radius + 0.5 * gap;
    return join(lay_down(small_shape(def, 0.0, 0.0, -0.5), -x, 0.3),
                lay_down(small_shape(def, 0.0, 0.0, -0.5), x, 0.3));
}

/* A profile of points (x, z), drawn along y for 1 m: `count` points, whose fronts are on the left
 * of the way along them. */
static tulle_mesh draw_profile(const double *points, size_t count) {
    tulle_mesh mesh = {0};
    assert_int_equal(tulle_mesh_create(2 * count, 2 * (count - 1), &mesh, NULL), TULLE_OK);
    for (size_t i = 0; i < 2 * count; i++) {
        mesh.positions[3 * i] = points[i / 2 * 2];
        mesh.positions[3 * i + 1] = i % 2 ? 0.5 : -0.5;
        mesh.positions[3 * i + 2] = points[i / 2 * 2 + 1];
    }
    for (uint32_t i = 0; i + 1 < count; i++) {
        const uint32_t corners[6] = {2 * i, 2 * i + 2, 2 * i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3};
        memcpy(mesh.triangles + 6 * i, corners, sizeof corners);
    }
    return mesh;
}

/* Of an obstacle [m]: the least room of its vertices with a sheet far above; INFINITY: there is
 * none. Takes the mesh. */
static double measure_least_room(tulle_mesh mesh) {
    tulle_world *const world = make_world();
    tulle_mesh sheet = small_sheet(0.3, 7, 10.0);
    small_add_cloth(world, &sheet);
    small_add_obstacle(world, &mesh);
    start(world);
    double least = INFINITY;
    for (size_t v = world->model.cloth_vertex_count;
         world->model.rooms && v < world->model.vertex_count; v++)
        least = fmin(least, world->model.rooms[v]);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&mesh);
    tulle_world_destroy(world);
    return least;
}

/* Where the lowest vertex of the card is after `count` steps over an obstacle. Takes the mesh. */
static void assert_card_is_at(tulle_mesh obstacle, double step, int count, double low,
                              double high) {
    tulle_world *const world = make_world();
    add_card(world);
    small_add_obstacle(world, &obstacle);
    tulle_mesh_destroy(&obstacle);
    start(world);
    double const lowest = drop_card(world, step, count);
    print_message("the card's lowest vertex is at %.4g m\n", lowest);
    assert_true(lowest > low && lowest < high);
    tulle_world_destroy(world);
}

/* Free fall of 0.5 s: 1.24 m from 0.35 m. */
#define FALLS STEP, 45, -0.95, -0.85

static void card_passes_boards_of_one_mesh(void **state) {
    (void)state;
    assert_card_is_at(make_boards(4e-3), FALLS);
}

static void card_passes_bars_of_one_mesh(void **state) {
    (void)state;
    /* Longer steps brake it: they see a bar as a plane. With 5 mm of room it stops at 0.305 m. */
    assert_card_is_at(make_bars(6e-3), 1.0 / 450.0, 120, -1.0, 0.25);
}

/* A groove 6 mm wide and 0.2 m deep in a table: one surface that hangs together. */
static const double groove[] = {-0.3, 0.3, -3e-3, 0.3, -3e-3, 0.1, 3e-3, 0.1, 3e-3, 0.3, 0.3, 0.3};

static void card_falls_into_a_groove(void **state) {
    (void)state;
    assert_card_is_at(draw_profile(groove, 6), STEP, 45, 0.1, 0.11);
}

/* Rooms are 0.4 of the gap. */
static void rooms_are_part_of_the_gap(void **state) {
    (void)state;
    double const boards = measure_least_room(make_boards(4e-3));
    double const bars = measure_least_room(make_bars(6e-3));
    double const in_groove = measure_least_room(draw_profile(groove, 6));
    print_message("boards %g m, bars %g m, groove %g m\n", boards, bars, in_groove);
    assert_float_equal(boards, 1.6e-3, 1e-9);
    assert_float_equal(in_groove, 2.4e-3, 1e-9);
    assert_true(bars > 2.4e-3 - 1e-9 && bars < 2.5e-3);
}

/* Its own inside is no slot, however thin a body is; nor is what is wider than deep. */
static void what_is_no_slot_changes_nothing(void **state) {
    (void)state;
    assert_true(isinf(measure_least_room(make_box(0.3, 0.3, 3e-3, 0.0, 0.0))));
    static const double corner[] = {-0.2, 0.3, 0.0, 0.0, 0.3, 0.0};
    assert_true(isinf(measure_least_room(draw_profile(corner, 3))));
    double bowl[82];
    for (int i = 0; i < 41; i++) { /* half a pipe of 2 cm, in steps of 1.6 mm */
        bowl[2 * i] = -0.02 * cos(acos(-1.0) * i / 40.0);
        bowl[2 * i + 1] = -0.02 * sin(acos(-1.0) * i / 40.0);
    }
    assert_true(isinf(measure_least_room(draw_profile(bowl, 41))));
    static const enum tulle_shape shapes[] = {
        TULLE_SHAPE_PLANE, TULLE_SHAPE_NEEDLE, TULLE_SHAPE_CRESTED_GROUND, TULLE_SHAPE_BUMPY_GROUND,
        TULLE_SHAPE_TORUS, TULLE_SHAPE_NAIL,   TULLE_SHAPE_TILE,           TULLE_SHAPE_CONE};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        double const room =
            measure_least_room(small_shape(tulle_shape_def_default(shapes[i]), 0.0, 0.0, 0.0));
        if (isfinite(room)) fail_msg("%s: a room of %g m", tulle_shape_name(shapes[i]), room);
    }
}

/* The same slot with the fronts of its walls turned away is what a thin shell is. */
static void fronts_decide(void **state) {
    (void)state;
    tulle_mesh mesh = draw_profile(groove, 6);
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        uint32_t const corner = mesh.triangles[3 * t];
        mesh.triangles[3 * t] = mesh.triangles[3 * t + 1];
        mesh.triangles[3 * t + 1] = corner;
    }
    assert_true(isinf(measure_least_room(mesh)));
}

/* Walls of many small triangles, some 0.5 mm long: found by a tree, not by pairs. */
static void fine_walls_have_the_same_room(void **state) {
    (void)state;
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
    def.size[0] = def.size[1] = 0.1;
    def.size[2] = 0.01;
    def.resolution[0] = 201;
    tulle_mesh const mesh = join(small_shape(def, 0, 0, 0), small_shape(def, 0, 0, 0.016));
    clock_t const begin = clock();
    double const room = measure_least_room(mesh);
    print_message("room %g m of %zu triangles, world and all, in %.3g s\n", room,
                  mesh.triangle_count, (double)(clock() - begin) / CLOCKS_PER_SEC);
    assert_float_equal(room, 2.4e-3, 1e-9);
}

/* ---- worlds that run ---- */

static double find_highest_of_first(const tulle_world *world) {
    size_t count = 0;
    const double *const x = tulle_cloth_get_positions(world, (tulle_cloth_id){0, 1}, &count);
    double highest = -INFINITY;
    for (size_t i = 0; i < count; i++) highest = fmax(highest, x[3 * i + 2]);
    return highest;
}

/* A sheet lies 1 mm over a table, and stays there when other things come and go. */
static void rooms_stay_when_objects_come_and_go(void **state) {
    (void)state;
    tulle_world *const world = make_world();
    tulle_mesh sheet = small_sheet(1.0, 11, 1e-3);
    tulle_shape_def plane = tulle_shape_def_default(TULLE_SHAPE_PLANE);
    plane.size[0] = plane.size[1] = 2.0;
    tulle_mesh table = small_shape(plane, 0.0, 0.0, 0.0);
    tulle_mesh far = make_box(0.1, 0.1, 0.1, 3.0, 0.0);
    small_add_cloth(world, &sheet);
    small_add_obstacle(world, &table);
    start(world);
    double highest = 0.0;
    for (int i = 0; i < 30; i++) {
        if (i == 10) small_add_obstacle(world, &far);
        if (i == 20)
            assert_int_equal(tulle_world_remove_obstacle(world, (tulle_obstacle_id){1, 1}, NULL),
                             TULLE_OK);
        assert_int_equal(tulle_world_step(world, STEP, NULL, NULL), TULLE_OK);
        highest = fmax(highest, find_highest_of_first(world));
    }
    print_message("highest %.4g mm\n", 1e3 * highest);
    assert_true(highest < 1.01e-3);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&table);
    tulle_mesh_destroy(&far);
    tulle_world_destroy(world);
}

/* What comes finds its rooms when it comes: a sheet 1 mm over a table, and boards for a card. */
static void what_comes_has_rooms(void **state) {
    (void)state;
    tulle_world *const world = make_world();
    add_card(world);
    start(world);
    tulle_mesh boards = make_boards(4e-3);
    small_add_obstacle(world, &boards);
    tulle_mesh_destroy(&boards);
    double const lowest = drop_card(world, STEP, 45);
    print_message("the card's lowest vertex is at %.4g m\n", lowest);
    assert_true(lowest < -0.85);
    tulle_world_destroy(world);
}

static void cloth_that_comes_too_near_is_told(void **state) {
    (void)state;
    tulle_world *const world = make_world();
    tulle_shape_def plane = tulle_shape_def_default(TULLE_SHAPE_PLANE);
    plane.size[0] = plane.size[1] = 2.0;
    tulle_mesh table = small_shape(plane, 0.0, 0.0, 0.0);
    tulle_mesh high = small_sheet(1.0, 11, 1.0), low = small_sheet(1.0, 11, 2e-4);
    small_add_cloth(world, &high);
    small_add_obstacle(world, &table);
    start(world);
    assert_string_equal(tulle_world_last_message(world), "");
    small_add_cloth(world, &low);
    print_message("%s\n", tulle_world_last_message(world));
    assert_non_null(strstr(tulle_world_last_message(world), "a thickness of 0.2 mm"));
    tulle_mesh_destroy(&high);
    tulle_mesh_destroy(&low);
    tulle_mesh_destroy(&table);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(card_passes_boards_of_one_mesh),
        cmocka_unit_test(card_passes_bars_of_one_mesh),
        cmocka_unit_test(card_falls_into_a_groove),
        cmocka_unit_test(rooms_are_part_of_the_gap),
        cmocka_unit_test(what_is_no_slot_changes_nothing),
        cmocka_unit_test(fronts_decide),
        cmocka_unit_test(fine_walls_have_the_same_room),
        cmocka_unit_test(rooms_stay_when_objects_come_and_go),
        cmocka_unit_test(what_comes_has_rooms),
        cmocka_unit_test(cloth_that_comes_too_near_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
