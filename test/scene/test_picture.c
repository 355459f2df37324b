/* Keys of pictures: read without meshes, left out of the hash, kept in the canonical text, refused
 * where they do not go together. */
#define _POSIX_C_SOURCE 200809L
#include "scene/picture.h"
#include "scene_text.h"

#include <math.h>

#define TIME "time: {frames: 3}\n"
#define SHEET "cloth:\n  - mesh: {shape: rectangle, size: [2, 2], resolution: [3, 3]}\n"
#define GROUND "obstacles:\n  - mesh: {shape: plane, size: [4, 4]}\n"
#define CAMERA                                                                                     \
    "render: {camera: {orbit: [90 deg, 30 deg], distance: 2, turn: 1 turn}, floor: off}\n"
#define COLORS "    color: [1, 0.5, 0]\n    pattern: weave\n    pattern_size: 2 cm\n"

static void test_hash_without_pictures(void **state) {
    (void)state;
    tulle_scene *plain = load_good(TIME SHEET GROUND);
    tulle_scene *dressed = load_good(TIME SHEET COLORS GROUND "    color: [0, 0, 1]\n" CAMERA);
    tulle_scene *other = load_good(TIME SHEET "    thickness: 1 mm\n" GROUND CAMERA);
    assert_true(tulle_scene_get_hash(plain) == tulle_scene_get_hash(dressed));
    assert_true(tulle_scene_get_hash(plain) != tulle_scene_get_hash(other));
    assert_null(strstr(tulle_scene_get_canonical_text(plain), "render"));
    assert_null(strstr(tulle_scene_get_canonical_text(plain), "color"));
    /* The canonical text keeps them: it loads to the same text again. */
    char *text = strdup(tulle_scene_get_canonical_text(dressed));
    assert_non_null(text);
    assert_non_null(strstr(text, "orbit"));
    tulle_scene *again = load_good(text);
    assert_string_equal(tulle_scene_get_canonical_text(again), text);
    free(text);
    tulle_scene_destroy(plain);
    tulle_scene_destroy(dressed);
    tulle_scene_destroy(other);
    tulle_scene_destroy(again);
}

static tulle_status read_text(const char *text, scene_picture *picture,
                              tulle_scene_problems *problems) {
    write_text_file("s.yaml", text);
    char path[128];
    snprintf(path, sizeof path, "%s/s.yaml", folder_path);
    return scene_read_picture(path, picture, problems);
}

static void test_values(void **state) {
    (void)state;
    tulle_scene_problems *problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    scene_picture picture;
    /* The mesh file is not there: pictures do not need it. */
    assert_int_equal(
        read_text(TIME SHEET COLORS
                  "  - mesh: {file: missing.obj}\n" GROUND
                  "    copies: {row: {count: 3, offset: [1, 0, 0]}}\n"
                  "    color: [0, 0, 1]\n  - mesh: {shape: box}\n    hidden: true\n" CAMERA,
                  &picture, problems),
        TULLE_OK);
    assert_true(picture.camera.has_orbit && picture.camera.has_distance && picture.camera.has_turn);
    assert_false(picture.camera.has_position || picture.camera.has_target ||
                 picture.camera.has_field_of_view);
    double const pi = acos(-1.0);
    assert_true(fabs(picture.camera.azimuth - pi / 2) < 1e-12);
    assert_true(fabs(picture.camera.elevation - pi / 6) < 1e-12);
    assert_true(fabs(picture.camera.turn - 2 * pi) < 1e-12);
    assert_true(picture.camera.distance == 2.0);
    assert_int_equal(picture.floor, SCENE_FLOOR_OFF);
    assert_true(picture.exposure == 1.0);
    assert_int_equal(picture.look_count, 2 + 3 + 1);
    assert_true(picture.looks[0].has_color && picture.looks[0].color[1] == 0.5);
    assert_true(picture.looks[0].has_pattern && !picture.looks[0].has_back_color);
    assert_int_equal(picture.looks[0].pattern, SCENE_PATTERN_WEAVE);
    assert_true(fabs(picture.looks[0].pattern_size - 0.02) < 1e-12);
    assert_false(picture.looks[1].has_color || picture.looks[1].has_pattern);
    for (size_t i = 2; i < 5; i++)
        assert_true(picture.looks[i].has_color && picture.looks[i].color[2] == 1.0);
    assert_false(picture.looks[5].has_color);
    assert_true(picture.looks[5].is_hidden && !picture.looks[4].is_hidden);
    scene_picture_destroy(&picture);
    assert_null(picture.looks);

    assert_int_equal(read_text(TIME SHEET, &picture, problems), TULLE_OK);
    assert_false(picture.camera.has_orbit || picture.camera.has_position);
    assert_int_equal(picture.floor, SCENE_FLOOR_AUTO);
    scene_picture_destroy(&picture);
    free(problems);
}

static void test_refusals(void **state) {
    (void)state;
    static const struct {
        const char *keys, *message;
    } cases[] = {
        {"render: {camera: {position: [1, 0, 0], orbit: [1, 1]}}\n", "only one of the keys"},
        {"render: {camera: {orbit: [0, 90 deg]}}\n", "elevation should be"},
        {"render: {camera: {position: [1, 0, 0], distance: 2}}\n", "belongs to an orbit"},
        {"render: {camera: {position: [1, 2, 3], target: [1, 2, 3]}}\n", "should be elsewhere"},
        {"render: {camera: {field_of_view: 0}}\n", "field_of_view"},
        {"render: {camera: {position: [.nan, 0, 0]}}\n", "position"},
        {"render: {flor: on}\n", "did you mean 'floor'"},
        {"render: 3\n", "must be a map"},
    };
    tulle_scene_problems *problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[1024];
        snprintf(text, sizeof text, "%s%s", TIME SHEET, cases[i].keys);
        scene_picture picture;
        assert_int_not_equal(read_text(text, &picture, problems), TULLE_OK);
        if (!strstr(problems->list[0].message, cases[i].message))
            fail_msg("\"%s\" has no \"%s\"", problems->list[0].message, cases[i].message);
        assert_true(problems->list[0].line > 0);
        assert_null(picture.looks);
        /* A run refuses it, too. */
        assert_null(load_text(text, problems));
    }
    scene_picture picture;
    assert_int_equal(scene_read_picture("/nowhere/s.yaml", &picture, problems), TULLE_ERROR_IO);
    free(problems);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hash_without_pictures),
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
