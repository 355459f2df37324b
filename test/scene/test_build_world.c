/* Worlds made from scenes: the table's defaults are the world's, values arrive, failures of the
 * world carry a place in the scene file, mesh sequences and copies move. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_data.h"
#include "scene_text.h"
#include "tulle/paper.h"

#include <math.h>

#define TIME "time: {frames: 3, step: 10 ms}\n"
#define SHEET "cloth:\n  - mesh: {shape: rectangle, size: [1, 1], resolution: [5, 5]}\n"

static void test_defaults_are_those_of_the_world(void **state) {
    (void)state;
    tulle_scene *loaded =
        load_good(TIME SHEET "obstacles:\n  - {mesh: {shape: box}, translate: [0, 0, -3]}\n");
    tulle_world_def def = tulle_world_def_default();
    const scene_keys *keys = &loaded->keys;
    for (int k = 0; k < 3; k++) assert_true(keys->gravity.value[k] == def.gravity[k]);
    assert_true(keys->wind.gust_length == def.wind.gust_length);
    assert_true(keys->wind.gust_time == def.wind.gust_time);
    assert_true(keys->wind.gust_strength == def.wind.gust_strength);
    assert_true(keys->wind.drag == def.wind.drag_coefficient);
    assert_true(keys->contact.delta_c == def.contact_distance);
    assert_true(keys->contact.delta_s == def.separation_distance);
    assert_true(keys->contact.xi == def.minimum_gap);
    assert_true(keys->contact.friction == def.friction_cloth_cloth);
    assert_true(keys->contact.dynamic_friction == def.dynamic_friction_cloth_cloth);
    tulle_paper_options const paper = tulle_paper_options_default();
    assert_int_equal(keys->contact.method, paper.detection.method);
    assert_int_equal(keys->contact.cone, paper.detection.cone);
    assert_true(keys->contact.alpha_max == paper.detection.max_angle);
    assert_int_equal(keys->contact.certificate, paper.detection.has_certificate);
    assert_int_equal(keys->contact.patches, paper.detection.grows_patches_anew);
    assert_int_equal(keys->contact.response, paper.response);
    assert_int_equal(keys->contact.motion_space, paper.motion_space);
    assert_int_equal(keys->contact.impact_rounds, paper.impact_rounds);
    assert_int_equal(keys->contact.start_intersections, def.start_intersections);
    assert_int_equal(keys->contact.on_pinch, def.on_pinch);
    assert_int_equal(keys->solver.integrator, def.integrator);
    assert_int_equal(keys->solver.quality, def.quality);
    assert_true(keys->solver.cg_tolerance == paper.cg_tolerance);
    assert_int_equal(keys->solver.cg_iterations, paper.cg_max_iterations);
    assert_int_equal(keys->solver.rounds, paper.solve_rounds);
    assert_int_equal(keys->solver.sweeps, paper.impulse_sweeps);
    const cloth_keys *cloth = keys->cloth.items;
    const obstacle_keys *obstacle = keys->obstacles.items;
    tulle_cloth_def cloth_def = tulle_cloth_def_default();
    tulle_obstacle_def obstacle_def = tulle_obstacle_def_default();
    assert_true(cloth->thickness == cloth_def.thickness);
    for (int k = 0; k < 3; k++) assert_true(cloth->grain.value[k] == cloth_def.grain[k]);
    assert_true(obstacle->friction == obstacle_def.friction);
    assert_true(obstacle->dynamic_friction == obstacle_def.dynamic_friction);
    assert_true(obstacle->restitution == obstacle_def.restitution);
    for (int k = 0; k < 3; k++) assert_true(loaded->obstacles[0].grain[k] == obstacle_def.grain[k]);
    assert_true(obstacle->appears == obstacle_def.appear_time);
    assert_true(obstacle->disappears == obstacle_def.disappear_time);
    tulle_scene_destroy(loaded);
}

/* Steps a world for a while. */
static void run_steps(tulle_scene *loaded, tulle_scene_world *built, int count) {
    tulle_error error = {0};
    tulle_status status = tulle_scene_build_world(loaded, 1, NULL, built, &error);
    for (int i = 0; status == TULLE_OK && i < count; i++)
        status = tulle_world_step(built->world, tulle_scene_get_time_step(loaded), NULL, &error);
    if (status != TULLE_OK) fail_msg("%s:%d: %s", error.file, error.line, error.message);
}

static void test_motion_arrives(void **state) {
    (void)state;
    write_text_file("m_1.obj", "v 0 0 -1\nv 1 0 -1\nv 1 1 -1\nf 1 2 3\n");
    write_text_file("m_2.obj", "v 0 0 -2\nv 1 0 -2\nv 1 1 -2\nf 1 2 3\n");
    tulle_scene *loaded = load_good(
        TIME "contact: {delta_c: 3 mm}\n" SHEET "    velocity: [1, 0, 0]\n"
             "    pins: [{nearest: [-0.5, -0.5, 0], keyframes: [{time: 0}, {time: 0.1, translate: "
             "[0, 0, 0.2]}]}]\n"
             "obstacles:\n"
             "  - {name: fins, mesh: {shape: plane, size: [1, 1]}, translate: [0, 0, -3],\n"
             "     copies: {row: {count: 2, offset: [2, 0, 0]}, stagger: 0.1 s},\n"
             "     motion: {keyframes: [{time: 0}, {time: 0.1, translate: [0, 1, 0]}]}}\n"
             "  - motion: {sequence: {files: m_%d.obj, first: 1, last: 2, interval: 0.2 s}}\n"
             "  - {mesh: {shape: plane}, translate: [0, 0, -9], disappears: 50 ms}\n");
    tulle_scene_world built;
    run_steps(loaded, &built, 10);
    assert_int_equal(built.cloth_count, 1);
    assert_int_equal(built.obstacle_count, 4);
    double contact, separation, gap;
    tulle_world_get_distances(built.world, &contact, &separation, &gap);
    assert_true(contact == 0.003);
    size_t count;
    const double *first = tulle_obstacle_get_positions(built.world, built.obstacles[0], &count);
    const double *start = tulle_scene_get_obstacle_mesh(loaded, 0).positions;
    assert_true(fabs(first[1] - start[1] - 1) < 1e-9);
    const double *second = tulle_obstacle_get_positions(built.world, built.obstacles[1], &count);
    start = tulle_scene_get_obstacle_mesh(loaded, 1).positions;
    assert_true(fabs(second[1] - start[1]) < 1e-9);
    const double *deformed = tulle_obstacle_get_positions(built.world, built.obstacles[2], &count);
    assert_true(count == 3 && fabs(deformed[2] + 1.5) < 1e-9);
    assert_true(tulle_obstacle_is_present(built.world, built.obstacles[0]));
    assert_false(tulle_obstacle_is_present(built.world, built.obstacles[3]));
    uint32_t pinned = loaded->cloths[0].pins[0].vertices[0];
    const double *cloth = tulle_cloth_get_positions(built.world, built.cloths[0], &count);
    assert_true(fabs(cloth[3 * pinned + 2] - 0.2) < 1e-9);
    tulle_scene_destroy_world(&built);
    assert_null(built.world);
    tulle_scene_destroy(loaded);
}

static void test_failures_carry_a_place(void **state) {
    (void)state;
    tulle_scene_world built;
    tulle_error error = {0};
    tulle_scene *loaded = load_good(TIME SHEET "contact:\n  delta_c: 4 mm\n  delta_s: 1 mm\n");
    assert_int_equal(tulle_scene_build_world(loaded, 1, NULL, &built, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(error.line, 4);
    assert_memory_equal(error.message, "contact: ", 9);
    assert_non_null(strstr(error.file, "s.yaml"));
    tulle_scene_destroy(loaded);
}

/* Allocation k fails, for every k until none does: an error, no leak, no crash. */
typedef struct failing_heap {
    size_t until_failure, held;
} failing_heap;
static void *failing_allocate(void *context, size_t byte_count) {
    failing_heap *heap = context;
    if (heap->until_failure-- == 0) {
        heap->until_failure = 0;
        return NULL;
    }
    heap->held++;
    return malloc(byte_count);
}
static void failing_release(void *context, void *pointer, size_t byte_count) {
    (void)byte_count;
    ((failing_heap *)context)->held--;
    free(pointer);
}

static void test_failing_allocations(void **state) {
    (void)state;
    tulle_scene *loaded =
        load_good(TIME SHEET "obstacles:\n  - {mesh: {shape: box}, translate: [0, 0, -3]}\n");
    tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
    size_t k = 0;
    for (; status != TULLE_OK; k++) {
        failing_heap heap = {k, 0};
        tulle_allocator allocator = {failing_allocate, failing_release, &heap, 0};
        tulle_scene_world built;
        tulle_error error = {0};
        status = tulle_scene_build_world(loaded, 1, &allocator, &built, &error);
        assert_true(status == TULLE_OK || status == TULLE_ERROR_OUT_OF_MEMORY);
        if (status == TULLE_OK) tulle_scene_destroy_world(&built);
        assert_int_equal(heap.held, 0);
        assert_true(k < 10000);
    }
    assert_true(k > 3);
    tulle_scene_destroy(loaded);
}

/* A law for a cloth and all copies of an obstacle reaches the world: it can be set only once it is
 * known, and the run depends on it. */
static void test_laws_of_pairs_arrive(void **state) {
    (void)state;
    const char *const laws[] = {"friction: 0.3", "friction: 0.3, restitution: 1"};
    double speed[2];
    for (int i = 0; i < 2; i++) {
        char text[600];
        snprintf(text, sizeof text,
                 TIME "gravity: [0, 0, 0]\n" SHEET
                      "    name: sheet\n    velocity: [0, 0, -1]\n    translate: [0, 0, 0.52]\n"
                      "obstacles:\n  - {mesh: {shape: box, size: [1, 1, 1]}, name: block, copies: "
                      "{row: {count: 2, offset: [1.1, 0, 0]}}}\n"
                      "contact: {pairs: [{between: [sheet, block], %s}]}\n",
                 laws[i]);
        tulle_scene *loaded = load_good(text);
        tulle_scene_world built;
        run_steps(loaded, &built, 4);
        size_t count;
        speed[i] = tulle_cloth_get_velocities(built.world, built.cloths[0], &count)[2];
        tulle_scene_destroy_world(&built);
        tulle_scene_destroy(loaded);
    }
    assert_true(fabs(speed[0]) < 1e-6 && speed[1] > 0.5);
}

/* The same of laws of materials: a cloth's is its preset or its own name. */
static void test_laws_of_materials_arrive(void **state) {
    (void)state;
    const struct {
        const char *material, *laws;
        bool rebounds;
    } cases[] = {{"preset: silk", "{between: [wood, silk], friction: 0.3, restitution: 1}", true},
                 {"name: felt", "{between: [felt, wood], friction: 0.3, restitution: 1}", true},
                 {"name: felt", "{between: [cotton, wood], friction: 0.3, restitution: 1}", false},
                 {"preset: silk", "{between: [silk, silk], friction: 0.3, restitution: 1}", false}};
    for (int i = 0; i < 4; i++) {
        char text[700];
        snprintf(text, sizeof text,
                 TIME
                 "gravity: [0, 0, 0]\n" SHEET
                 "    material: {%s}\n    velocity: [0, 0, -1]\n    translate: [0, 0, 0.52]\n"
                 "obstacles:\n  - {mesh: {shape: box, size: [1, 1, 1]}, material: wood, copies: "
                 "{row: {count: 2, offset: [1.1, 0, 0]}}}\n"
                 "contact: {materials: [%s]}\n",
                 cases[i].material, cases[i].laws);
        tulle_scene *loaded = load_good(text);
        tulle_scene_world built;
        run_steps(loaded, &built, 4);
        size_t count;
        double const speed = tulle_cloth_get_velocities(built.world, built.cloths[0], &count)[2];
        assert_true(cases[i].rebounds ? speed > 0.5 : fabs(speed) < 1e-6);
        tulle_scene_destroy_world(&built);
        tulle_scene_destroy(loaded);
    }
}

/* A cloth pushed along x slides on a box without friction across its grain, which is along y. */
static void test_grain_of_an_obstacle_arrives(void **state) {
    (void)state;
    const char *const keys[] = {"friction_across: 0", "friction_across: 1, grain: [0, 1, 0]",
                                "friction_across: 0, grain: [0, 2, 0]"};
    for (int i = 0; i < 3; i++) {
        char text[600];
        snprintf(text, sizeof text,
                 TIME "gravity: [1, 0, -9.81]\n" SHEET
                      "    translate: [0, 0, 0.505]\ncontact: {delta_c: 5 mm}\n"
                      "obstacles:\n  - {mesh: {shape: box, size: [3, 3, 1]}, %s}\n",
                 keys[i]);
        tulle_scene *loaded = load_good(text);
        tulle_scene_world built;
        run_steps(loaded, &built, 20);
        size_t count;
        double const speed = tulle_cloth_get_velocities(built.world, built.cloths[0], &count)[0];
        assert_true(i == 2 ? fabs(speed - 0.2) < 0.01 : fabs(speed) < 1e-6);
        tulle_scene_destroy_world(&built);
        tulle_scene_destroy(loaded);
    }
}

static void test_grain_turns_with_copies(void **state) {
    (void)state;
    tulle_scene *loaded =
        load_good(TIME SHEET "obstacles:\n  - {mesh: {shape: box}, friction_across: 1, grain: [0, "
                             "3, 4], rotate: [0, 0, 30 deg], "
                             "translate: [0, 0, -9], copies: {ring: {count: 4, radius: 5}}}\n");
    for (size_t i = 0; i < 4; i++) {
        const double *grain = loaded->obstacles[i].grain;
        double const turned[4][2] = {{0, 3}, {-3, 0}, {0, -3}, {3, 0}};
        assert_true(fabs(grain[0] - turned[i][0]) < 1e-12);
        assert_true(fabs(grain[1] - turned[i][1]) < 1e-12);
        assert_true(grain[2] == 4);
    }
    tulle_scene_destroy(loaded);
}

/* `dynamic: true` is a body of 1000 kg/m^3, false is none; copies bounce off one another by their
 * law. */
static void test_bare_bodies_arrive(void **state) {
    (void)state;
    tulle_scene *loaded = load_good(
        TIME "gravity: [0, 0, 0]\n" SHEET "    translate: [0, 0, -3]\n"
             "obstacles:\n  - {mesh: {shape: box, size: [0.1, 0.2, 0.3]}, name: left, translate: "
             "[-3, 0, 0], dynamic: false}\n  - {mesh: {shape: box, size: [0.1, 0.2, 0.3]}, name: "
             "brick, dynamic: true, copies: {row: {count: 2, offset: [0.14, 0, 0]}}}\n"
             "contact: {pairs: [{between: [brick, brick], friction: 0, restitution: 1}, {between: "
             "[left, brick], friction: 0.1}]}\n");
    tulle_scene_world built;
    run_steps(loaded, &built, 1);
    tulle_transform transform = {.mass = 0.0};
    assert_int_equal(
        tulle_obstacle_get_transform(built.world, built.obstacles[0], &transform, NULL),
        TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(
        tulle_obstacle_get_transform(built.world, built.obstacles[1], &transform, NULL), TULLE_OK);
    assert_true(fabs(transform.mass - 6.0) < 1e-9);
    double const push[3] = {6.0, 0.0, 0.0}; /* 1 m/s towards the other */
    tulle_obstacle_add_impulse(built.world, built.obstacles[1], transform.position, push, NULL);
    tulle_error error = {0};
    for (int i = 0; i < 8; i++)
        if (tulle_world_step(built.world, 0.01, NULL, &error) != TULLE_OK)
            fail_msg("%s", error.message);
    for (int i = 1; i < 3; i++) {
        tulle_obstacle_get_transform(built.world, built.obstacles[i], &transform, NULL);
        assert_true(fabs(transform.velocity[0] - (i == 2)) < 1e-6); /* they have swapped speeds */
    }
    tulle_scene_destroy_world(&built);
    tulle_scene_destroy(loaded);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_defaults_are_those_of_the_world),
        cmocka_unit_test(test_motion_arrives),
        cmocka_unit_test(test_failures_carry_a_place),
        cmocka_unit_test(test_laws_of_pairs_arrive),
        cmocka_unit_test(test_laws_of_materials_arrive),
        cmocka_unit_test(test_grain_of_an_obstacle_arrives),
        cmocka_unit_test(test_grain_turns_with_copies),
        cmocka_unit_test(test_bare_bodies_arrive),
        cmocka_unit_test(test_failing_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
