/* Every scene of the folder scenes/paper/ runs, see scene_runs.h; small, with fewer particles,
 * falling from where they soon touch. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_runs.h"

static const small_run runs[] = {
    {"paper/example_one", 30, TULLE_OK, 1e-3, 1, {"cloth[0].mesh.resolution=[13, 9]"}},
    {"paper/animation_1",
     8,
     TULLE_OK,
     1e-3,
     2,
     {"cloth[0].mesh.cells=[4, 4]", "cloth[0].mesh.strand=6 cm"}},
    {"paper/animation_2",
     12,
     TULLE_OK,
     1e-3,
     2,
     {"cloth[0].mesh.cells=[6, 6]", "cloth[0].mesh.strand=8 cm"}},
    {"paper/animation_3", 20, TULLE_OK, 1e-3, 1, {"cloth[0].mesh.resolution=[13, 9]"}},
    {"paper/animation_4", 15, TULLE_OK, 1e-3, 1, {"cloth[0].mesh.resolution=[41, 3]"}},
    {"paper/animation_5", 20, TULLE_OK, 1e-3, 1, {"cloth[0].mesh.resolution=[13, 9]"}},
    {"paper/animation_6",
     15,
     TULLE_OK,
     1e-3,
     2,
     {"cloth[0].mesh.resolution=[13, 13]", "obstacles[2].disappears=0.2"}},
    {"paper/rings",
     20,
     TULLE_OK,
     1e-3,
     2,
     {"cloth[0].mesh.resolution=[48, 8]", "obstacles[2].dynamic.start=0.1"}},
    {"paper/ribbons",
     20,
     TULLE_OK,
     1e-3,
     9,
     {"cloth[0].mesh.resolution=[27, 2]", "cloth[1].mesh.resolution=[27, 2]",
      "cloth[2].mesh.resolution=[27, 2]", "cloth[3].mesh.resolution=[27, 2]",
      "cloth[4].mesh.resolution=[27, 2]", "cloth[5].mesh.resolution=[27, 2]",
      "cloth[6].mesh.resolution=[27, 2]", "cloth[7].mesh.resolution=[27, 2]",
      "cloth[8].mesh.resolution=[27, 2]"}},
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
