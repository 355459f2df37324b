/* `tulle reproduce`: every run that its figures need has a scene that came with the program, which
 * --quick makes coarser and shorter. */
#include "app/reproduce.h"
#include "scene/scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* The session as it is in the source tree. */
static reproduce make_session(void) {
    const char *const source = getenv("TULLE_SOURCE_DIR");
    char place[REPRODUCE_PATH_SIZE / 2];
    reproduce self = {.directory = "none", .is_quick = true, .threads = 1};
    assert_non_null(source);
    snprintf(place, sizeof place, "%s/scenes/paper", source);
    assert_int_equal(reproduce_find_scenes(&self, place), 0);
    return self;
}

static scene *load(const char *path, const char *const *overrides, size_t count) {
    scene *loaded = NULL;
    scene_problems *const problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    if (scene_load(path, overrides, count, &loaded, problems) != TULLE_OK)
        scene_print_problems(problems, stdout);
    free(problems);
    assert_non_null(loaded);
    return loaded;
}

static size_t count_cloth_vertices(const scene *loaded) {
    size_t count = 0;
    for (size_t i = 0; i < scene_get_cloth_count(loaded); i++)
        count += scene_get_cloth_mesh(loaded, i).vertex_count;
    return count;
}

static void every_run_has_a_scene(void **state) {
    (void)state;
    reproduce const self = make_session();
    const reproduce_run *runs[REPRODUCE_RUNS_MAX];
    size_t const count = reproduce_list_runs(runs);
    assert_true(count > 24 && count < REPRODUCE_RUNS_MAX);
    for (size_t i = 0; i < count; i++) {
        assert_true(reproduce_has_scene(&self, runs[i]));
        assert_non_null(reproduce_find_quick(runs[i]->scene));
    }
}

static void quick_scenes_are_coarser_and_shorter(void **state) {
    (void)state;
    reproduce const self = make_session();
    const reproduce_run *runs[REPRODUCE_RUNS_MAX];
    size_t const count = reproduce_list_runs(runs);
    for (size_t i = 0; i < count; i++) {
        if (i > 0 && strcmp(runs[i]->scene, runs[i - 1]->scene) == 0) continue;
        const reproduce_quick *const quick = reproduce_find_quick(runs[i]->scene);
        const reproduce_shared *const shared = reproduce_find_shared(runs[i]->scene);
        char path[2 * REPRODUCE_PATH_SIZE];
        size_t overrides = 0;
        snprintf(path, sizeof path, "%s/%s.yaml", self.scenes,
                 shared ? shared->file : runs[i]->scene);
        while (quick->overrides[overrides]) overrides++;
        scene *const whole =
            load(path, shared ? &shared->override : NULL, shared && shared->override ? 1 : 0);
        scene *const coarse = load(path, quick->overrides, overrides);
        assert_true(3 * count_cloth_vertices(coarse) < 2 * count_cloth_vertices(whole));
        assert_true((uint32_t)quick->frames <= scene_get_frame_count(whole));
        scene_destroy(whole);
        scene_destroy(coarse);
    }
}

static void frames_that_are_looked_at_are_few(void **state) {
    (void)state;
    for (uint32_t frames = 2; frames < 300; frames++)
        for (uint32_t most = 1; most < 40; most++) {
            uint32_t const stride = reproduce_find_stride(frames, most);
            uint32_t looked_at = 0;
            for (uint32_t frame = 1; frame < frames; frame += stride) looked_at++;
            assert_true(looked_at >= 1 && looked_at <= most);
            assert_true(frames > most || looked_at == frames - 1);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_run_has_a_scene),
        cmocka_unit_test(quick_scenes_are_coarser_and_shorter),
        cmocka_unit_test(frames_that_are_looked_at_are_few),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
