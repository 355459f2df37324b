/* The scenes whose meshes no one here made load and start free of intersection. Skipped where the
 * folder of given files is missing. */
#define _POSIX_C_SOURCE 200809L
#include "scene_start.h"

static void test_scenes_load_and_start_free(void **state) {
    (void)state;
    static const char *const names[] = {"body", "table", "spot"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        tulle_scene *loaded = load_scene_file(names[i]);
        if (!loaded) fail_msg("%s does not load", names[i]);
        size_t pair_count = count_start_intersections(loaded);
        if (pair_count > 0) fail_msg("%s: %zu intersections", names[i], pair_count);
        tulle_scene_destroy(loaded);
    }
}

int main(void) {
    const char *source = getenv("TULLE_SOURCE_DIR");
    char path[1024];
    if (snprintf(path, sizeof path, "%s/../shared/data/body/body_40.obj", source ? source : ".") <
        0)
        return 1;
    FILE *file = fopen(path, "rb");
    if (!file) {
        printf("skipped: %s is missing\n", path);
        return 77;
    }
    fclose(file);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_scenes_load_and_start_free)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
