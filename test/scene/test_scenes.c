/* Every scene of the folder scenes/ loads, has the sizes that it promises, and starts free of
 * intersection. Those that need files from elsewhere are in test_scenes_of_given_files.c. */
#define _POSIX_C_SOURCE 200809L
#include "scene_start.h"
#include "scene_text.h"

#include "tulle/mesh.h"

#include <math.h>
#include <string.h>

typedef struct expectation {
    const char *name;
    size_t particle_count, cloth_count, obstacle_count, moving_count;
} expectation;

static const expectation expectations[] = {
    {"needles", 9801, 1, 82, 80}, {"sphere", 9801, 1, 2, 0},
    {"spikes", 9801, 1, 8, 0},    {"layers", 61 * 61 + 56 * 56 + 41 * 41, 3, 2, 0},
    {"ribbon", 2005, 1, 5, 0},    {"net", 0, 1, 26, 0},
    {"pinch", 1681, 1, 2, 1},     {"pinch_zero", 1681, 1, 2, 1},
    {"rings", 0, 1, 6, 3},        {"hammock", 37 * 21, 1, 4, 4},
    {"chain", 300, 1, 21, 20},
};

static void test_scenes_load_and_start_free(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof expectations / sizeof expectations[0]; i++) {
        const expectation *wanted = &expectations[i];
        tulle_scene *loaded = load_scene_file(wanted->name);
        if (!loaded) fail_msg("%s does not load", wanted->name);
        size_t particle_count = 0, moving_count = 0;
        for (size_t c = 0; c < tulle_scene_get_cloth_count(loaded); c++)
            particle_count += tulle_scene_get_cloth_mesh(loaded, c).vertex_count;
        for (size_t o = 0; o < tulle_scene_get_obstacle_count(loaded); o++)
            if (tulle_scene_is_obstacle_moving(loaded, o)) moving_count++;
        if (wanted->particle_count > 0) assert_int_equal(particle_count, wanted->particle_count);
        assert_int_equal(tulle_scene_get_cloth_count(loaded), wanted->cloth_count);
        assert_int_equal(tulle_scene_get_obstacle_count(loaded), wanted->obstacle_count);
        assert_int_equal(moving_count, wanted->moving_count);
        assert_true(tulle_scene_get_time_step(loaded) == 1.0 / 90);
        size_t pair_count = count_start_intersections(loaded);
        if (pair_count > 0) fail_msg("%s: %zu intersections", wanted->name, pair_count);
        tulle_scene_destroy(loaded);
    }
}

/* What a run records of its scene is that scene. */
static void test_canonical_text_is_the_same_scene(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof expectations / sizeof expectations[0]; i++) {
        tulle_scene *const loaded = load_scene_file(expectations[i].name);
        assert_non_null(loaded);
        tulle_scene *const again = load_good(tulle_scene_get_canonical_text(loaded));
        if (tulle_scene_get_hash(loaded) != tulle_scene_get_hash(again))
            fail_msg("%s comes back as another scene", expectations[i].name);
        tulle_scene_destroy(loaded);
        tulle_scene_destroy(again);
    }
}

/* The net's holes are real. */
static void test_net_has_holes(void **state) {
    (void)state;
    tulle_scene *loaded = load_scene_file("net");
    assert_non_null(loaded);
    tulle_mesh_info info;
    tulle_error error;
    assert_int_equal(tulle_mesh_get_info(tulle_scene_get_cloth_mesh(loaded, 0), &info, &error),
                     TULLE_OK);
    assert_int_equal(info.component_count, 1);
    assert_int_equal(info.boundary_loop_count, 1 + 12 * 12);
    assert_int_equal(info.euler_characteristic, 1 - 12 * 12);
    tulle_scene_destroy(loaded);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scenes_load_and_start_free),
        cmocka_unit_test_teardown(test_canonical_text_is_the_same_scene, remove_folder),
        cmocka_unit_test(test_net_has_holes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
