/* The scenes of the folder scenes/ with rigid bodies run, see scene_runs.h, with less than one
 * rescue in 1,000 contacts. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_runs.h"

static const small_run runs[] = {
    {"ball", 60, TULLE_OK, 1e-3, 1, {"cloth[0].mesh.resolution=[13, 13]"}},
    {"boxes", 60, TULLE_OK, 1e-3, 1, {"cloth[0].mesh.resolution=[13, 13]"}},
    {"rings",
     75,
     TULLE_OK,
     1e-3,
     2,
     {"cloth[0].mesh.resolution=[36, 12]", "obstacles[2].dynamic.start=0.2"}},
    {"hammock", 60, TULLE_OK, 1e-3, 1, {"cloth[0].mesh.resolution=[19, 11]"}},
    {"chain", 45, TULLE_OK, 1e-3, 1, {"cloth[0].mesh.resolution=[40, 3]"}},
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
