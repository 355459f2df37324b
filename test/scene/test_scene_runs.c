/* Every scene of the folder scenes/ that needs no given files runs, see scene_runs.h; those with
 * rigid bodies are in test_body_scene_runs.c. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_runs.h"

static const small_run runs[] = {
    {"needles",
     60,
     TULLE_OK,
     INFINITY,
     2,
     {"cloth[0].mesh.resolution=[17, 17]", "obstacles[2].motion.keyframes=[{time: 0.2}, {time: "
                                           "0.4, translate: [0, 0, -0.22]}]"}},
    {"sphere",
     60,
     TULLE_OK,
     INFINITY,
     2,
     {"cloth[0].mesh.resolution=[17, 17]", "obstacles[1].disappears=0.4"}},
    {"spikes", 50, TULLE_OK, INFINITY, 1, {"cloth[0].mesh.resolution=[17, 17]"}},
    {"layers",
     40,
     TULLE_OK,
     INFINITY,
     3,
     {"cloth[0].mesh.resolution=[11, 11]", "cloth[1].mesh.resolution=[11, 11]",
      "cloth[2].mesh.resolution=[9, 9]"}},
    {"ribbon", 40, TULLE_OK, INFINITY, 1, {"cloth[0].mesh.resolution=[121, 3]"}},
    {"net", 25, TULLE_OK, INFINITY, 2, {"cloth[0].mesh.cells=[6, 6]", "cloth[0].mesh.strand=3 cm"}},
    {"pinch", 225, TULLE_OK, INFINITY, 1, {"cloth[0].mesh.resolution=[7, 7]"}},
    {"pinch_zero", 225, TULLE_ERROR_PINCHED, INFINITY, 1, {"cloth[0].mesh.resolution=[7, 7]"}},
};

static void scenes_run_clean(void **state) {
    (void)state;
    size_t const count = sizeof runs / sizeof runs[0];
    assert_int_equal(run_scenes(runs, count), count);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(scenes_run_clean)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
