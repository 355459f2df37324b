/* Loading a scene of the folder scenes/ and judging its start, for tests. */
#ifndef TULLE_TEST_SCENE_START_H
#define TULLE_TEST_SCENE_START_H

#include "scene/scene.h"

#include "tulle/check.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

/* Loads scenes/NAME.yaml; null when a problem is found, after printing it. */
static tulle_scene *load_scene_file(const char *name) {
    const char *source = getenv("TULLE_SOURCE_DIR");
    char path[1024];
    int length = snprintf(path, sizeof path, "%s/scenes/%s.yaml", source ? source : ".", name);
    assert_true(length > 0 && (size_t)length < sizeof path);
    tulle_scene_problems *problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    tulle_scene *loaded = NULL;
    tulle_scene_load(path, NULL, 0, &loaded, problems);
    if (!loaded) scene_print_problems(problems, stderr);
    free(problems);
    return loaded;
}

/* The number of intersecting pairs at the start. */
static size_t count_start_intersections(const tulle_scene *loaded) {
    size_t cloth_count = tulle_scene_get_cloth_count(loaded);
    size_t count = cloth_count + tulle_scene_get_obstacle_count(loaded);
    tulle_check_body *bodies = calloc(count, sizeof *bodies);
    assert_non_null(bodies);
    for (size_t i = 0; i < count; i++) {
        bodies[i].is_obstacle = i >= cloth_count;
        bodies[i].mesh = i < cloth_count ? tulle_scene_get_cloth_mesh(loaded, i)
                                         : tulle_scene_get_obstacle_mesh(loaded, i - cloth_count);
    }
    tulle_check_result result;
    tulle_error error = {0};
    if (tulle_check_intersections(bodies, count, 1, &result, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    size_t pair_count = result.pair_count;
    tulle_check_result_destroy(&result);
    free(bodies);
    return pair_count;
}

#endif
