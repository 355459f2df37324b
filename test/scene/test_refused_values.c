/* What scenes may not say, at the limits of their keys: each is refused with the place and a
 * message that tells what is allowed. test_parse.c and test_load.c hold the common refusals. */
#define _POSIX_C_SOURCE 200809L
#include "scene_text.h"

#include <stdbool.h>

#define TIME "time: {frames: 3}\n"
#define SHEET "cloth:\n  - mesh: {shape: rectangle, size: [2, 2], resolution: [3, 3]}\n"
#define LONG_WORD "abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefghijklmnop" /* 68 */

/* A scene, an override of it or null, and the first problem. */
static const struct {
    const char *text, *override_text;
    tulle_status status;
    int line, column;
    const char *message; /* its beginning */
} cases[] = {
    {TIME SHEET "obstacles: 3\n", NULL, TULLE_ERROR_PARSE, 4, 12,
     "obstacles: is text, must be a list of maps (lines beginning with '-')"},
    {TIME "cloth: []\nobstacles:\n  - {mesh: {shape: box}, motion: {keyframes: []}}\n", NULL,
     TULLE_ERROR_PARSE, 4, 46,
     "obstacles[0].motion.keyframes: has 0 entries, must have 1 to 100000"},
    {"time: {frames: three}\n" SHEET, NULL, TULLE_ERROR_PARSE, 1, 16,
     "time.frames: is 'three', must be a whole number from 1 to 10000000"},
    {"time: {frames: 3, step: [1]}\n" SHEET, NULL, TULLE_ERROR_PARSE, 1, 25,
     "time.step: is a list, must be a number in s, ms, min, as in '2 s'"},
    {TIME "seed: -1\n" SHEET, NULL, TULLE_ERROR_PARSE, 2, 7,
     "seed: is '-1', must be a whole number from 0 to 9007199254740992"},
    {TIME SHEET "    pins: [{vertices: []}]\n", NULL, TULLE_ERROR_PARSE, 4, 23,
     "cloth[0].pins[0].vertices: is a list, must be a list of vertex numbers from 0 or ranges as "
     "3-9"},
    {TIME SHEET "    pins: [{vertices: 3}]\n", NULL, TULLE_ERROR_PARSE, 4, 23,
     "cloth[0].pins[0].vertices: is '3', must be a list of vertex numbers from 0 or ranges as 3-9"},
    {TIME SHEET "    pins: [{vertices: [[1]]}]\n", NULL, TULLE_ERROR_PARSE, 4, 24,
     "cloth[0].pins[0].vertices: is a list, must be a list of vertex numbers from 0 or ranges as "
     "3-9"},
    {TIME SHEET "    pins: [{vertices: [3-1]}]\n", NULL, TULLE_ERROR_PARSE, 4, 24,
     "cloth[0].pins[0].vertices: is '3-1', must be a list of vertex numbers from 0 or ranges as "
     "3-9"},
    {TIME SHEET "    pins: [{vertices: [" LONG_WORD "-3]}]\n", NULL, TULLE_ERROR_PARSE, 4, 24,
     "cloth[0].pins[0].vertices: is "
     "'abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefgh...', must be a lis"},
    {TIME SHEET "    pins: [{vertices: [99999999999]}]\n", NULL, TULLE_ERROR_PARSE, 4, 24,
     "cloth[0].pins[0].vertices: is '99999999999', must be a list of vertex numbers from 0 or "
     "ranges as 3-9"},
    {TIME SHEET "    pins: [{vertices: [9]}]\n", NULL, TULLE_ERROR_INVALID_ARGUMENT, 4, 23,
     "cloth[0].pins[0].vertices: names vertex 9, must be below 9, the cloth's number of vertices"},
    {TIME SHEET "    mesh: {shape: box}\n", NULL, TULLE_ERROR_PARSE, 4, 5,
     "the key 'mesh' is given twice, first in line 3, column 5; remove one"},
    {TIME "cloth:\n  - mesh: {shape: rectangle, irregular: 1, seed: x}\n", NULL, TULLE_ERROR_PARSE,
     3, 41, "cloth[0].mesh.irregular: is '1', must be true or false"},
    {TIME "cloth:\n  - mesh: {shape: rectangle, irregular: [true]}\n", NULL, TULLE_ERROR_PARSE, 3,
     41, "cloth[0].mesh.irregular: is a list, must be true or false"},
    {TIME "cloth:\n  - mesh: {shape: rectangle, seed: 1.5}\n", NULL, TULLE_ERROR_PARSE, 3, 36,
     "cloth[0].mesh.seed: is '1.5', must be a whole number from 0 to 9007199254740992, or the word "
     "auto"},
    {TIME "cloth:\n  - mesh: {shape: rectangle, resolution: [2, 3, 4]}\n", NULL, TULLE_ERROR_PARSE,
     3, 42,
     "cloth[0].mesh.resolution: is a list of 3, must be a list of 1 to 2, each a whole number"},
    {TIME "cloth:\n  - mesh: {shape: rectangle, size: [1, 1, 1, 1]}\n", NULL, TULLE_ERROR_PARSE, 3,
     36,
     "cloth[0].mesh.size: is a list of 4, must be a list of 2 to 3, each a number in m, km, cm, "
     "mm, um, in, ft, as in '2 m'"},
    {TIME "cloth:\n  - mesh: {shape: rectangle, size: [1, 1, 1]}\n", NULL, TULLE_ERROR_PARSE, 3, 36,
     "cloth[0].mesh.size: is a list of 3, must be a list of 2 for shape rectangle"},
    {TIME "cloth:\n  - mesh: {shape: " LONG_WORD "}\n", NULL, TULLE_ERROR_PARSE, 3, 19,
     "cloth[0].mesh.shape: is 'abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefgh...', "
     "must be one of rect"},
    {TIME "cloth:\n  - mesh: {shape: ca\xc3\xa9"
          "" LONG_WORD "}\n",
     NULL, TULLE_ERROR_PARSE, 3, 19,
     "cloth[0].mesh.shape: is 'ca\xc3\xa9"
     "abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcd...', must be one of recta"},
    {TIME "cloth:\n  - mesh: {shape: "
          "abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefg\xe2\x82\xac\xe2\x82\xac}\n",
     NULL, TULLE_ERROR_PARSE, 3, 19,
     "cloth[0].mesh.shape: is 'abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyzabcdefg...', "
     "must be one of recta"},
    {TIME SHEET "    material: {preset: steel}\n", NULL, TULLE_ERROR_PARSE, 4, 24,
     "cloth[0].material.preset: is 'steel', must be one of " PRESET_NAMES},
    {TIME SHEET "    material: {preset: coton}\n", NULL, TULLE_ERROR_PARSE, 4, 24,
     "cloth[0].material.preset: is 'coton', must be one of " PRESET_NAMES
     "; did you mean 'cotton'?"},
    {TIME SHEET "    thickness: 2 m\n", NULL, TULLE_ERROR_INVALID_ARGUMENT, 4, 16,
     "cloth[0].thickness: is '2 m', must be above 0 m and at most 1 m"},
    {TIME SHEET "    translate: [0, 0, 1 m/0]\n", NULL, TULLE_ERROR_PARSE, 4, 23,
     "cloth[0].translate: '1 m/0' has an unknown unit; allowed here: m, km, cm, mm, um, in, ft"},
    {TIME SHEET "    translate: [0, 0, 1/x m]\n", NULL, TULLE_ERROR_PARSE, 4, 23,
     "cloth[0].translate: is '1/x m', must be a number in m, km, cm, mm, um, in, ft, as in '2 m'"},
    {TIME SHEET "    translate: [0, 0, 1/2/3]\n", NULL, TULLE_ERROR_PARSE, 4, 23,
     "cloth[0].translate: is '1/2/3', must be a number in m, km, cm, mm, um, in, ft, as in '2 m'"},
    {TIME SHEET "contact: {pairs: [{between: [[cloth0], cloth0], friction: 1}]}\n", NULL,
     TULLE_ERROR_PARSE, 4, 30,
     "contact.pairs[0].between: is a list, must be the name of a cloth or obstacle"},
    {TIME SHEET "contact: {pairs: [{between: cloth0, friction: 1}]}\n", NULL, TULLE_ERROR_PARSE, 4,
     29, "contact.pairs[0].between: is 'cloth0', must be a list of 2, each a name"},
    {TIME SHEET "contact: {pairs: [{between: [cloth0, cloth0, cloth0], friction: 1}]}\n", NULL,
     TULLE_ERROR_PARSE, 4, 29,
     "contact.pairs[0].between: is a list of 3, must be a list of 2, each a name"},
    {TIME SHEET "contact: {pairs: [{between: [cloth0, table], friction: 1}]}\n", NULL,
     TULLE_ERROR_INVALID_ARGUMENT, 4, 38,
     "contact.pairs[0].between: no cloth or obstacle is called 'table'"},
    {TIME SHEET "contact: {materials: [{between: [cotton, silk], friction: 1}, {between: [silk, "
                "cotton], friction: 1}]}\n",
     NULL, TULLE_ERROR_INVALID_ARGUMENT, 4, 73,
     "contact.materials[1].between: a law of 'silk' and 'cotton' is given before, in line 4; keep "
     "one"},
    {TIME SHEET "contact: {materials: [{between: [cotton, silk], friction: 1}, {between: [silk, "
                "silk], friction: 1}, {between: [cotton, silk], friction: 2}]}\n",
     NULL, TULLE_ERROR_INVALID_ARGUMENT, 4, 111,
     "contact.materials[2].between: a law of 'cotton' and 'silk' is given before, in line 4; keep "
     "one"},
    {TIME SHEET "contact: {materials: [{between: [cotton, stone], friction: 1}]}\n", NULL,
     TULLE_ERROR_INVALID_ARGUMENT, 4, 42,
     "contact.materials[0].between: no cloth, obstacle or preset has the material 'stone'; "
     "there are " PRESET_NAMES},
    {TIME SHEET "obstacles: [{mesh: {shape: box}, name: a}, {mesh: {shape: box}, name: "
                "b}]\ncontact: {pairs: [{between: [a, b], friction: 1}]}\n",
     NULL, TULLE_ERROR_INVALID_ARGUMENT, 5, 30,
     "contact.pairs[0].between: 'a' and 'b' are both obstacles, which do not touch; one must be a "
     "cloth or dynamic"},
    {TIME SHEET "obstacles: [{mesh: {shape: box}, name: a, copies: {row: {count: 2, offset: [3, 0, "
                "0]}}, dynamic: true}]\ncontact: {pairs: [{between: [a, a], friction: 1}, "
                "{between: [a, a], friction: 2}]}\n",
     NULL, TULLE_ERROR_INVALID_ARGUMENT, 5, 61,
     "contact.pairs[1].between: a law of 'a' and 'a' is given before, in line 5; keep one"},
    {TIME SHEET "obstacles: [{mesh: {shape: box}, name: a, copies: {row: {count: 2, offset: [3, 0, "
                "0]}}, dynamic: true}]\ncontact: {pairs: [{between: [a, a.001], friction: 1}]}\n",
     NULL, TULLE_ERROR_INVALID_ARGUMENT, 5, 33,
     "contact.pairs[0].between: names 'a.001' twice; friction of a cloth on itself is "
     "contact.friction, or by its material contact.materials"},
    {TIME SHEET "obstacles: [{mesh: {shape: box}, name: cloth0}]\n", NULL,
     TULLE_ERROR_INVALID_ARGUMENT, 4, 40,
     "obstacles[0].name: 'cloth0' is the name of an object before; names must differ"},
    {TIME SHEET "obstacles: [{mesh: {shape: box}, name: a}, {mesh: {shape: box}, name: a}]\n", NULL,
     TULLE_ERROR_INVALID_ARGUMENT, 4, 71,
     "obstacles[1].name: 'a' is the name of an object before; names must differ"},
    {TIME SHEET "render: {camera: {orbit: [0, 89.5 deg]}}\n", NULL, TULLE_ERROR_INVALID_ARGUMENT, 4,
     26, "render.camera.orbit: the elevation should be -89 deg to 89 deg"},
    {TIME SHEET "render: {camera: {orbit: [0, -89.5 deg]}}\n", NULL, TULLE_ERROR_INVALID_ARGUMENT,
     4, 26, "render.camera.orbit: the elevation should be -89 deg to 89 deg"},
    {TIME SHEET "render: {camera: {position: [1, 2, 3], target: [1, 2, 3]}}\n", NULL,
     TULLE_ERROR_INVALID_ARGUMENT, 4, 48,
     "render.camera.target: is the camera's position; it should be elsewhere"},
    {TIME SHEET "\"a\\0b\": 3\n", NULL, TULLE_ERROR_PARSE, 4, 1,
     "a key must not hold a NUL character"},
    {TIME SHEET "\"\": 3\n", NULL, TULLE_ERROR_PARSE, 4, 1, "a key must not be empty"},
    {TIME SHEET "obstacles: ''\n", NULL, TULLE_ERROR_PARSE, 4, 12,
     "obstacles: is text, must be a list of maps (lines beginning with '-')"},
    {TIME SHEET "obstacles: [{mesh: {shape: box}, dynamic: 3}]\n", NULL, TULLE_ERROR_PARSE, 4, 43,
     "obstacles[0].dynamic: is text, must be true, false or a map with keys mass, density, "
     "area_density, velocity, s"},
    {TIME SHEET "obstacles: [{mesh: {shape: box}, dynamic: {mass: 1, density: 2}}]\n", NULL,
     TULLE_ERROR_PARSE, 4, 44,
     "obstacles[0].dynamic: may have only one of the keys mass, density, area_density"},
    {TIME SHEET
     "obstacles: [{mesh: {shape: box}, copies: {row: {count: 4097, offset: [1, 0, 0]}}}]\n",
     NULL, TULLE_ERROR_PARSE, 4, 56,
     "obstacles[0].copies.row.count: is '4097', must be a whole number from 1 to 4096"},
    {TIME SHEET "obstacles: [{motion: {sequence: {files: f.obj, last: 2, interval: 1}}}]\n", NULL,
     TULLE_ERROR_PARSE, 4, 41,
     "obstacles[0].motion.sequence.files: is 'f.obj', must hold one number as %d or %03d, as in "
     "body_%02d.obj"},
    {TIME SHEET "obstacles: [{motion: {sequence: {files: f_%99d.obj, last: 2, interval: 1}}}]\n",
     NULL, TULLE_ERROR_PARSE, 4, 41,
     "obstacles[0].motion.sequence.files: is 'f_%99d.obj', must hold one number as %d or %03d, as "
     "in body_%02d.obj"},
    {TIME SHEET "obstacles: [{motion: {sequence: {files: f_%d_%d.obj, last: 2, interval: 1}}}]\n",
     NULL, TULLE_ERROR_PARSE, 4, 41,
     "obstacles[0].motion.sequence.files: is 'f_%d_%d.obj', must hold one number as %d or %03d, as "
     "in body_%02d.obj"},
    {TIME SHEET "obstacles: [{motion: {sequence: {files: f_%d.obj, first: 1, last: 900000000, "
                "interval: 1}}}]\n",
     NULL, TULLE_ERROR_INVALID_ARGUMENT, 4, 67,
     "obstacles[0].motion.sequence.last: is 900000000, must be at least first (1) and less than "
     "1000000 above"},
    {TIME SHEET, "cloth[0].mesh.resolution=\xff", TULLE_ERROR_PARSE, 0, 0,
     "invalid leading UTF-8 octet; the file must be UTF-8 text"},
    {TIME SHEET, "cloth[0].mesh=[1, 2", TULLE_ERROR_PARSE, 0, 0,
     "not valid YAML: did not find expected ',' or ']' while parsing a flow sequence"},
    {TIME SHEET, "cloth[0]." LONG_WORD "=3", TULLE_ERROR_PARSE, 0, 0,
     "a key of the path is too long; an override reads PATH=VALUE, as in time.frames=10 or "
     "'cloth[0].mesh.resolution=[40, 40]'"},
    {TIME SHEET, "cloth[=3", TULLE_ERROR_PARSE, 0, 0,
     "an index is a number between [ and ]; an override reads PATH=VALUE, as in time.frames=10 or "
     "'cloth[0].mesh.resolution=[40, 40]'"},
    {TIME SHEET, "cloth[0=3", TULLE_ERROR_PARSE, 0, 0,
     "an index is a number between [ and ]; an override reads PATH=VALUE, as in time.frames=10 or "
     "'cloth[0].mesh.resolution=[40, 40]'"},
    {TIME SHEET, "cloth[99999999]=3", TULLE_ERROR_PARSE, 0, 0,
     "an index is too large; an override reads PATH=VALUE, as in time.frames=10 or "
     "'cloth[0].mesh.resolution=[40, 40]'"},
    {TIME SHEET, "cloth[5].mesh=3", TULLE_ERROR_PARSE, 0, 0,
     "index 5 is past the end of a list of 1"},
    {TIME SHEET, "cloth[0]mesh=3", TULLE_ERROR_PARSE, 0, 0,
     "the path must continue with . or [; an override reads PATH=VALUE, as in time.frames=10 or "
     "'cloth[0].mesh.resolution=[40, 40]'"},
    {TIME SHEET, "cloth.mesh=3", TULLE_ERROR_PARSE, 0, 0,
     "the path does not fit the scene: before the key mesh it finds a list, not a map"},
    {TIME SHEET, "time[0]=3", TULLE_ERROR_PARSE, 0, 0,
     "the path does not fit the scene: before an index it finds a map, not a list"},
    {TIME SHEET, "time.=3", TULLE_ERROR_PARSE, 0, 0,
     "a key of the path is empty; an override reads PATH=VALUE, as in time.frames=10 or "
     "'cloth[0].mesh.resolution=[40, 40]'"},
    {TIME SHEET, "=3", TULLE_ERROR_PARSE, 0, 0,
     "the path is empty; an override reads PATH=VALUE, as in time.frames=10 or "
     "'cloth[0].mesh.resolution=[40, 40]'"},
    {TIME SHEET, "time=", TULLE_ERROR_PARSE, 1, 1,
     "the key 'time' is missing: how long the scene is simulated, and in which steps"},
    {TIME SHEET, "time.frames=''", TULLE_ERROR_PARSE, 0, 0,
     "time.frames: is '', must be a whole number from 1 to 10000000"},
    {TIME SHEET, "time.frames=# nothing", TULLE_ERROR_PARSE, 0, 0, "the value is empty"},
    {TIME SHEET, "time.frames.x=3", TULLE_ERROR_PARSE, 0, 0,
     "the path does not fit the scene: before the key x it finds text, not a map"},
};

static void values_are_refused(void **state) {
    (void)state;
    static tulle_scene_problems problems;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        tulle_scene_destroy(load_good(TIME SHEET)); /* what is refused leaves no trace */
        write_text_file("s.yaml", cases[i].text);
        char path[128];
        snprintf(path, sizeof path, "%s/s.yaml", folder_path);
        tulle_scene *loaded = NULL;
        tulle_status const status = tulle_scene_load(
            path, &cases[i].override_text, cases[i].override_text != NULL, &loaded, &problems);
        assert_null(loaded);
        const tulle_error *const first = &problems.list[0];
        bool const is_as_told =
            status == cases[i].status && first->status == status && first->line == cases[i].line &&
            first->column == cases[i].column &&
            strncmp(first->message, cases[i].message, strlen(cases[i].message)) == 0;
        if (!is_as_told)
            fail_msg("%s: status %d, %d:%d: %s", cases[i].text, (int)status, first->line,
                     first->column, first->message);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(values_are_refused)};
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
