/* The scenes of the folder scenes/ with meshes from elsewhere run, see scene_runs.h; skipped where
 * those are missing. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_runs.h"

enum { SKIPPED = 77 };

static const small_run runs[] = {
    {"body", 40, TULLE_OK, INFINITY, 1, {"cloth[0].mesh.resolution=[17, 17]"}},
    {"table", 1, TULLE_OK, INFINITY, 0, {NULL}},
    {"spot", 40, TULLE_OK, INFINITY, 1, {"cloth[0].mesh.resolution=[20, 17]"}},
};
static size_t run_count;

static void given_scenes_run_clean(void **state) {
    (void)state;
    run_count = run_scenes(runs, sizeof runs / sizeof runs[0]);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(given_scenes_run_clean)};
    int const failed = cmocka_run_group_tests(tests, NULL, NULL);
    return failed == 0 && run_count == 0 ? SKIPPED : failed;
}
