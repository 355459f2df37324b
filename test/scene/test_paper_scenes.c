/* Every scene of the folder scenes/paper/ loads, has the sizes and the step that it promises, and
 * starts free of intersection; example one has the numbers of the paper to the last triangle. */
#define _POSIX_C_SOURCE 200809L
#include "scene_start.h"

#include "tulle/mesh.h"

#include <math.h>

typedef struct expectation {
    const char *name;
    size_t particle_count, cloth_count, obstacle_count;
    double time_step; /* [s] */
} expectation;

static const expectation expectations[] = {
    {"paper/example_one", 9801, 1, 6, 1.0 / 90},  {"paper/animation_1", 4420, 1, 4, 0.033},
    {"paper/animation_2", 9700, 1, 6, 0.02},      {"paper/animation_3", 101 * 68, 1, 3, 0.02},
    {"paper/animation_4", 267 * 17, 1, 25, 0.02}, {"paper/animation_5", 101 * 68, 1, 3, 0.02},
    {"paper/animation_6", 81 * 81, 1, 82, 0.02},  {"paper/rings", 2088, 1, 11, 0.02},
    {"paper/ribbons", 9 * 174 * 6, 9, 9, 0.02},
};

typedef struct mesh_sums {
    size_t vertices, triangles;
} mesh_sums;

static mesh_sums sum_cloth(const tulle_scene *loaded) {
    mesh_sums sums = {0, 0};
    for (size_t i = 0; i < tulle_scene_get_cloth_count(loaded); i++) {
        sums.vertices += tulle_scene_get_cloth_mesh(loaded, i).vertex_count;
        sums.triangles += tulle_scene_get_cloth_mesh(loaded, i).triangle_count;
    }
    return sums;
}

static mesh_sums sum_obstacles(const tulle_scene *loaded) {
    mesh_sums sums = {0, 0};
    for (size_t i = 0; i < tulle_scene_get_obstacle_count(loaded); i++) {
        sums.vertices += tulle_scene_get_obstacle_mesh(loaded, i).vertex_count;
        sums.triangles += tulle_scene_get_obstacle_mesh(loaded, i).triangle_count;
    }
    return sums;
}

static void test_scenes_load_and_start_free(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof expectations / sizeof expectations[0]; i++) {
        const expectation *wanted = &expectations[i];
        tulle_scene *loaded = load_scene_file(wanted->name);
        if (!loaded) fail_msg("%s does not load", wanted->name);
        mesh_sums const cloth = sum_cloth(loaded), bodies = sum_obstacles(loaded);
        print_message("%s: %zu particles, %zu triangles; obstacles %zu, %zu\n", wanted->name,
                      cloth.vertices, cloth.triangles, bodies.vertices, bodies.triangles);
        assert_int_equal(cloth.vertices, wanted->particle_count);
        assert_int_equal(tulle_scene_get_cloth_count(loaded), wanted->cloth_count);
        assert_int_equal(tulle_scene_get_obstacle_count(loaded), wanted->obstacle_count);
        assert_true(tulle_scene_get_time_step(loaded) == wanted->time_step);
        size_t const pair_count = count_start_intersections(loaded);
        if (pair_count > 0) fail_msg("%s: %zu intersections", wanted->name, pair_count);
        tulle_scene_destroy(loaded);
    }
}

static void test_example_one_has_published_sizes(void **state) {
    (void)state;
    tulle_scene *loaded = load_scene_file("paper/example_one");
    assert_non_null(loaded);
    mesh_sums const cloth = sum_cloth(loaded), bodies = sum_obstacles(loaded);
    assert_int_equal(cloth.vertices, 9801);
    assert_int_equal(cloth.triangles, 19200);
    assert_int_equal(bodies.vertices, 2827);
    assert_int_equal(bodies.triangles, 5472);
    assert_int_equal(tulle_scene_get_frame_count(loaded) * tulle_scene_get_steps_per_frame(loaded),
                     2400);
    tulle_scene_destroy(loaded);
}

/* The holes of both nets are real. */
static void test_nets_have_holes(void **state) {
    (void)state;
    const char *const names[] = {"paper/animation_1", "paper/animation_2"};
    const long cells[] = {16, 24};
    for (int i = 0; i < 2; i++) {
        tulle_scene *loaded = load_scene_file(names[i]);
        assert_non_null(loaded);
        tulle_mesh_info info;
        tulle_mesh_view const net = tulle_scene_get_cloth_mesh(loaded, 0);
        assert_int_equal(tulle_mesh_get_info(net, &info, NULL), TULLE_OK);
        assert_int_equal(info.component_count, 1);
        assert_int_equal(info.boundary_loop_count, 1 + cells[i] * cells[i]);
        tulle_scene_destroy(loaded);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scenes_load_and_start_free),
        cmocka_unit_test(test_example_one_has_published_sizes),
        cmocka_unit_test(test_nets_have_holes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
