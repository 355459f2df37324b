/* Attachments of scenes: they do what the world's calls do; what cannot be attached is told with
 * its place in the file. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_data.h"
#include "scene_text.h"

#include "tulle/attach.h"

#include <math.h>

#define TIME "time: {frames: 3, step: 10 ms}\n"
#define SHEET                                                                                      \
    "cloth:\n"                                                                                     \
    "  - name: sheet\n"                                                                            \
    "    mesh: {shape: rectangle, size: [1, 1], resolution: [5, 5]}\n"                             \
    "    attach:\n"
#define BOX                                                                                        \
    "obstacles:\n"                                                                                 \
    "  - name: shelf\n"                                                                            \
    "    mesh: {shape: box, size: [2, 0.2, 0.1]}\n"                                                \
    "    translate: [0, -0.62, 0]\n"                                                               \
    "    motion: {keyframes: [{time: 0}, {time: 0.1, translate: [0, 0, 0.05]}]}\n"

static tulle_scene_world build(tulle_scene *loaded) {
    tulle_scene_world built;
    tulle_error error = {0};
    if (tulle_scene_build_world(loaded, 1, NULL, &built, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    return built;
}

static void step(tulle_world *world) {
    tulle_error error = {0};
    if (tulle_world_step(world, 0.01, NULL, &error) != TULLE_OK) fail_msg("%s", error.message);
}

/* The row of vertices 2 cm beside the shelf rises with it; the rest of the region is too far. */
static void test_vertices_follow(void **state) {
    (void)state;
    tulle_scene *const loaded = load_good(
        TIME SHEET "      - {box: {min: [-2, -0.6, -1], max: [2, 0, 1]}, to: shelf, within: 3 cm, "
                   "release: 0.095}\n" BOX);
    tulle_scene_world built = build(loaded);
    tulle_error error = {0};
    assert_int_equal(tulle_world_start(built.world, &error), TULLE_OK);
    assert_int_equal(tulle_attachment_get_report(built.world, 1).held_count, 5);
    for (int i = 1; i <= 10; i++) {
        step(built.world);
        const double *const x = tulle_cloth_get_positions(built.world, built.cloths[0], NULL);
        size_t held = 0;
        for (uint32_t v = 0; v < 25; v++) {
            if (!tulle_attachment_holds(built.world, 1, v)) continue;
            held++;
            assert_true(fabs(x[3 * v + 1] + 0.5) < 1e-12);
            assert_true(fabs(x[3 * v + 2] - 0.005 * i) < 1e-12);
        }
        assert_int_equal(held, 5);
    }
    step(built.world);
    assert_int_equal(tulle_attachment_get_report(built.world, 1).held_count, 0);
    tulle_scene_destroy_world(&built);
    tulle_scene_destroy(loaded);
}

/* Values reach the world: a spring that is too weak for its break force lets go. */
static void test_values_arrive(void **state) {
    (void)state;
    tulle_scene *const loaded =
        load_good(TIME SHEET "      - {vertices: [0-4], to: shelf, stiffness: 2 N/cm}\n"
                             "      - {nearest: [0.5, 0.5, 0], to: other, breaks_at: 0.1 mN}\n"
                             "  - name: other\n"
                             "    mesh: {shape: rectangle, size: [1, 1], resolution: [3, 3]}\n"
                             "    translate: [0, 0, 0.2]\n"
                             "    pins: [{vertices: [0-8]}]\n" BOX);
    const attach_keys *const keys = loaded->cloths[0].keys->attach.items;
    assert_true(keys[0].stiffness == 200.0 && isinf(keys[0].breaks_at) && isinf(keys[0].within));
    assert_true(isinf(keys[1].stiffness) && fabs(keys[1].breaks_at - 1e-4) < 1e-18);
    assert_true(isinf(keys[1].release));
    tulle_scene_world built = build(loaded);
    for (int i = 0; i < 3; i++) step(built.world);
    assert_int_equal(tulle_attachment_get_report(built.world, 1).held_count, 5);
    assert_int_equal(tulle_attachment_get_report(built.world, 2).held_count, 0); /* broke off */
    tulle_scene_destroy_world(&built);
    tulle_scene_destroy(loaded);
}

static void refuse(const char *text, int line, const char *words) {
    tulle_scene_problems *const problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    assert_null(load_text(text, problems));
    if (problems->list[0].line != line || !strstr(problems->list[0].message, words))
        fail_msg("line %d: %s", problems->list[0].line, problems->list[0].message);
    free(problems);
}

static void test_problems_have_a_place(void **state) {
    (void)state;
    refuse(TIME SHEET "      - {vertices: [0], to: shelv}\n" BOX, 6, "did you mean 'shelf'?");
    refuse(TIME SHEET "      - {vertices: [0]}\n" BOX, 6, "to");
    refuse(TIME SHEET "      - {to: shelf}\n" BOX, 6, "box");
    refuse(TIME SHEET "      - {vertices: [25], to: shelf}\n" BOX, 6, "must be below 25");
    refuse(TIME SHEET "      - {to: shelf, box: {min: [4, 4, 4], max: [5, 5, 5]}}\n" BOX, 6,
           "attaches no vertex");
    refuse(TIME SHEET "      - {vertices: [0], to: shelf, stiffness: 0 N/m}\n" BOX, 6, "stiffness");
    refuse(TIME SHEET "      - {vertices: [0], to: shelf, breaks_at: 3 kg}\n" BOX, 6, "breaks_at");
    refuse(TIME SHEET "      - {vertices: [0], to: shelf, within: 0}\n" BOX, 6, "within");
}

/* What only the start can know is its error. */
static void test_the_start_refuses(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {TIME SHEET "      - {vertices: [24], to: shelf, within: 10 cm}\n" BOX, "within 0.1 m"},
        {TIME SHEET "      - {vertices: [0], to: shelf}\n      - {vertices: [0], to: shelf}\n" BOX,
         "rigidly"},
        {TIME SHEET "      - {vertices: [0], to: shelf}\n    pins: [{vertices: [0]}]\n" BOX, "pin"},
        {TIME SHEET "      - {vertices: [0], to: shelf}\n" BOX "    appears: 0.02\n",
         "not in the scene"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        tulle_scene *const loaded = load_good(cases[i][0]);
        tulle_scene_world built = build(loaded);
        tulle_error error = {0};
        assert_int_equal(tulle_world_start(built.world, &error), TULLE_ERROR_INVALID_ARGUMENT);
        if (!strstr(error.message, cases[i][1])) fail_msg("case %zu: %s", i, error.message);
        tulle_scene_destroy_world(&built);
        tulle_scene_destroy(loaded);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_vertices_follow),
        cmocka_unit_test(test_values_arrive),
        cmocka_unit_test(test_problems_have_a_place),
        cmocka_unit_test(test_the_start_refuses),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
