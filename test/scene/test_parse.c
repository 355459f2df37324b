/* The reader of scene files, from text to keys: every class of error with its exact place and text,
 * units, defaults, overrides; and no text, however mangled, may crash it. */
#include "scene/keys.h"
#include "scene/tree.h"

#include "base/hash.h"
#include "support/comma_locale.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A text being read to keys. */
typedef struct attempt {
    memory heap;
    arena storage;
    tulle_scene_problems *problems;
    scene_keys keys;
    bool is_good;
} attempt;

static void read_scene(attempt *work, const char *text, size_t length, const char *override_text) {
    memset(work, 0, sizeof *work);
    work->heap = memory_default();
    work->storage = arena_make(&work->heap);
    work->problems = calloc(1, sizeof *work->problems);
    assert_non_null(work->problems);
    tree_source const source = {.name = "s.yaml",
                                .needs = "a scene has at least the keys time and cloth",
                                .has_lines = true,
                                .text = text,
                                .length = length};
    scene_node *root = tree_read(&source, &work->storage, work->problems);
    if (!root) return;
    if (override_text && !tree_override(root, override_text, &work->storage, work->problems))
        return;
    schema_reader reader = {&work->storage, work->problems, "s.yaml"};
    work->keys.head = (schema_head){.node = root, .place = {"s.yaml", 1, 1}, .path = ""};
    work->is_good = schema_read(&reader, &scene_map, root, &work->keys);
}

static void release(attempt *work) {
    /* Good and without problems are the same thing. */
    assert_int_equal(work->is_good, work->problems->total_count == 0);
    arena_destroy(&work->storage);
    assert_int_equal(work->heap.bytes_held, 0);
    free(work->problems);
}

static const char base[] = "time: {frames: 10}\n"
                           "cloth:\n"
                           "  - mesh: {shape: rectangle, size: [1, 2], resolution: [5, 6]}\n";

/* Reads base text and more after it. */
static void read_more(attempt *work, const char *more, const char *override_text) {
    char text[4096];
    int length = snprintf(text, sizeof text, "%s%s", base, more);
    assert_true(length > 0 && (size_t)length < sizeof text);
    read_scene(work, text, (size_t)length, override_text);
}

/* One expected error: "line:column: message", the message to be found in full. */
typedef struct refusal {
    const char *text;
    bool is_whole; /* else follows the base scene */
    int line, column;
    const char *message;
} refusal;

static const refusal refusals[] = {
    /* YAML itself */
    {"", true, 0, 0, "the file is empty; a scene has at least the keys time and cloth"},
    {"# only a comment\n", true, 0, 0,
     "the file is empty; a scene has at least the keys time and cloth"},
    {"time: [1, 2\n", true, 2, 1,
     "not valid YAML: did not find expected ',' or ']' while parsing a flow sequence"},
    {"time:\n\t- 3\n", true, 2, 1, "a tab: indent with spaces, YAML takes no tabs there"},
    {"a: b: c\n", true, 1, 5, "not valid YAML: mapping values are not allowed in this context"},
    {"a: \"\\q\"\n", true, 1, 5,
     "not valid YAML: found unknown escape character while parsing a quoted scalar"},
    {"a: 1\nb: \xff\n", true, 2, 4, "invalid leading UTF-8 octet; the file must be UTF-8 text"},
    {"a: \x01\n", true, 1, 4, "control characters are not allowed; the file must be UTF-8 text"},
    {"a: \"\\0\"\n", true, 1, 4, "text must not hold a NUL character"},
    {"a: 1\n---\nb: 2\n", true, 2, 1, "a second document begins here; a scene file holds one"},
    {"time: 1\ntime: 2\n", true, 2, 1,
     "the key 'time' is given twice, first in line 1, column 1; remove one"},
    {"? [1]\n: 2\n", true, 1, 3, "a key must be a word, not a list or a map"},
    {"'': 2\n", true, 1, 1, "a key must not be empty"},
    {"a: &x 1\n", true, 1, 4,
     "anchors (&) and aliases (*) are not supported; write the value out, in quotes if it begins "
     "with & or *"},
    {"a: *x\n", true, 1, 4,
     "anchors (&) and aliases (*) are not supported; write the value out, in quotes if it begins "
     "with & or *"},
    {"a: !!int 1\n", true, 1, 4,
     "tags (!) are not supported; write the value without, in quotes if it begins with !"},
    {"[1, 2]\n", true, 1, 1,
     "the scene is a list, must be a map with keys title, seed, time, gravity, wind, cloth, "
     "obstacles, membrane, on_overstretch, contact, solver, render"},
    {"just text\n", true, 1, 1,
     "the scene is text, must be a map with keys title, seed, time, gravity, wind, cloth, "
     "obstacles, membrane, on_overstretch, contact, solver, render"},
    /* keys */
    {"time: {frames: 3}\ncloth:\n", true, 2, 7,
     "cloth: is nothing, must be a list of maps (lines beginning with '-')"},
    {"gravty: [0, 0, 1]\n", false, 4, 1, "gravty: unknown key; did you mean 'gravity'?"},
    {"zzz: 1\n", false, 4, 1,
     "zzz: unknown key; known here: title, seed, time, gravity, wind, cloth, obstacles, membrane, "
     "on_overstretch, contact, solver, render"},
    {"obstacles:\n  - mesh: {shape: sphere, heigth: 2}\n", false, 5, 27,
     "obstacles[0].mesh.heigth: unknown key; known here: file, shape, radius, resolution"},
    {"obstacles:\n  - mesh: {shape: sphere, height: 2}\n", false, 5, 27,
     "obstacles[0].mesh.height: does not apply to shape sphere; known here: file, shape, radius, "
     "resolution"},
    {"obstacles:\n  - mesh: {file: a.obj, height: 2}\n", false, 5, 25,
     "obstacles[0].mesh.height: has a meaning only together with the key 'shape'"},
    {"obstacles:\n  - mesh: {file: a.obj, shape: box}\n", false, 5, 12,
     "obstacles[0].mesh: may have only one of the keys file, shape"},
    {"obstacles:\n  - mesh: {}\n", false, 5, 5,
     "obstacles[0].mesh: needs one of the keys file, shape"},
    {"time: {}\ncloth: [{mesh: {shape: net}}]\n", true, 1, 1,
     "time: needs one of the keys frames, duration"},
    /* types */
    {"seed: -3\n", false, 4, 7, "seed: is '-3', must be a whole number from 0 to 9007199254740992"},
    {"seed: 1.5\n", false, 4, 7,
     "seed: is '1.5', must be a whole number from 0 to 9007199254740992"},
    {"seed: 9007199254740993\n", false, 4, 7,
     "seed: is '9007199254740993', must be a whole number from 0 to 9007199254740992"},
    {"contact: {alpha_max: 1e-13 rad}\n", false, 4, 22,
     "contact.alpha_max: is '1e-13 rad', must be at least 1e-12 rad and at most 1.57 rad"},
    {"gravity: 5\n", false, 4, 10,
     "gravity: is '5', must be a list of 3, each a number in m/s^2, cm/s^2, ft/s^2, as in '2 "
     "m/s^2'"},
    {"gravity: [0, 1]\n", false, 4, 10,
     "gravity: is a list of 2, must be a list of 3, each a number in m/s^2, cm/s^2, ft/s^2, as in "
     "'2 "
     "m/s^2'"},
    {"gravity: [0, x, 1]\n", false, 4, 14,
     "gravity: is 'x', must be a number in m/s^2, cm/s^2, ft/s^2, as in '2 m/s^2'"},
    {"wind: [1]\n", false, 4, 7,
     "wind: is a list, must be a map with keys velocity, gust_strength, gust_length, gust_time, "
     "drag, seed"},
    {"wind: {drag: }\n", false, 4, 14,
     "wind.drag: is nothing, must be a number in kg/m^3, as in '2 kg/m^3'"},
    {"wind: {drag: {}}\n", false, 4, 14,
     "wind.drag: is a map, must be a number in kg/m^3, as in '2 kg/m^3'"},
    {"title: [a]\n", false, 4, 8, "title: is a list, must be text"},
    {"contact: {method: bvix}\n", false, 4, 19,
     "contact.method: is 'bvix', must be one of patches, refit, bvox, paper; did you mean 'bvox'?"},
    {"contact: {method: octopus}\n", false, 4, 19,
     "contact.method: is 'octopus', must be one of patches, refit, bvox, paper"},
    {"contact: {method: [bvox]}\n", false, 4, 19,
     "contact.method: is a list, must be one of patches, refit, bvox, paper"},
    {"obstacles:\n  - {mesh: {shape: box}, name: a/b}\n", false, 5, 32,
     "obstacles[0].name: is 'a/b', must be a name of letters and digits of any "
     "script, '-', '_', '.' and blanks within, of 1 to 64 bytes in UTF-8, not beginning with '.'"},
    {"obstacles:\n  - {mesh: {shape: box}, name: ../x}\n", false, 5, 32,
     "obstacles[0].name: is '../x', must be a name of letters and digits of any "
     "script, '-', '_', '.' and blanks within, of 1 to 64 bytes in UTF-8, not beginning with '.'"},
    {"obstacles:\n  - {mesh: {file: ''}}\n", false, 5, 19,
     "obstacles[0].mesh.file: is '', must be the path of a file, relative to the scene file"},
    {"obstacles:\n  - {mesh: {shape: box}, motion: {keyframes: [{time: 0}], eased: yes}}\n", false,
     5, 66, "obstacles[0].motion.eased: is 'yes', must be true or false"},
    {"obstacles:\n  - {mesh: {shape: box}, rotate: 90}\n", false, 5, 34,
     "obstacles[0].rotate: is '90', must be three angles about x, y, z, as in [0, 90 deg, 0], or "
     "{axis: [0, 0, 1], angle: 30 deg}"},
    {"obstacles:\n  - {mesh: {shape: box}, rotate: {axis: [0, 0, 0], angle: 1}}\n", false, 5, 41,
     "obstacles[0].rotate: is zero, must be a direction"},
    {"obstacles:\n  - {mesh: {shape: box}, rotate: {axis: [0, 0, 1]}}\n", false, 5, 34,
     "obstacles[0].rotate: the key 'angle' is missing: how far to turn"},
    {"obstacles:\n  - {mesh: {shape: box}, scale: [1, 2]}\n", false, 5, 33,
     "obstacles[0].scale: is a list of 2, must be a list of 3, each a number, or one for all"},
    {"obstacles:\n  - {mesh: {shape: box}, motion: still}\n", false, 5, 34,
     "obstacles[0].motion: is text, must be a map with keys keyframes, sequence, eased, pivot"},
    /* ranges, units, NaN */
    {"obstacles:\n  - {mesh: {shape: box}, scale: 0}\n", false, 5, 33,
     "obstacles[0].scale: is '0', must be at least -1000000 and at most 1000000, and not 0"},
    {"obstacles:\n  - {mesh: {shape: box}, friction: -1}\n", false, 5, 36,
     "obstacles[0].friction: is '-1', must be at least 0 and at most 10"},
    {"wind: {gust_length: -2 mm}\n", false, 4, 21,
     "wind.gust_length: is '-2 mm', must be above 0 m and at most 1000000 m"},
    {"wind: {gust_length: 2 furlong}\n", false, 4, 21,
     "wind.gust_length: '2 furlong' has an unknown unit; allowed here: m, km, cm, mm, um, in, ft"},
    {"wind: {gust_length: 2 s}\n", false, 4, 21,
     "wind.gust_length: '2 s' has an unknown unit; allowed here: m, km, cm, mm, um, in, ft"},
    {"contact: {friction: 2 m}\n", false, 4, 21,
     "contact.friction: '2 m' has an unknown unit; allowed here: none or %"},
    {"wind: {gust_length: .nan}\n", false, 4, 21,
     "wind.gust_length: is '.nan', must be finite: a number in m, km, cm, mm, um, in, ft, as in '2 "
     "m'"},
    {"wind: {gust_length: -.INF}\n", false, 4, 21,
     "wind.gust_length: is '-.INF', must be finite: a number in m, km, cm, mm, um, in, ft, as in "
     "'2 m'"},
    {"wind: {gust_length: 1e999}\n", false, 4, 21,
     "wind.gust_length: is '1e999', must be finite: a number in m, km, cm, mm, um, in, ft, as in "
     "'2 m'"},
    {"wind: {gust_length: 1/0}\n", false, 4, 21,
     "wind.gust_length: is '1/0', must be finite: a number in m, km, cm, mm, um, in, ft, as in '2 "
     "m'"},
    {"contact: {delta_c: twice}\n", false, 4, 20,
     "contact.delta_c: is 'twice', must be a number in m, km, cm, mm, um, in, ft, as in '2 m', or "
     "the word "
     "auto"},
    {"time: {frames: 3, step: -1/90 s}\ncloth: [{mesh: {shape: net}}]\n", true, 1, 25,
     "time.step: is '-1/90 s', must be above 0 s and at most 1 s"},
    {"time: {frames: 0}\ncloth: [{mesh: {shape: net}}]\n", true, 1, 16,
     "time.frames: is '0', must be a whole number from 1 to 10000000"},
    {"time: {frames: 3, duration: 4}\ncloth: [{mesh: {shape: net}}]\n", true, 1, 8,
     "time: may have only one of the keys frames, duration"},
    {"time: {frames: 3}\ncloth: [{mesh: {shape: net}, material: {area_density: -0.1}}]\n", true, 2,
     55,
     "cloth[0].material.area_density: is '-0.1', must be above 0 kg/m^2 and at most 10000 kg/m^2"},
    {"time: {frames: 3}\ncloth: [{mesh: {shape: net}, pins: [{vertices: [3, 7-4]}]}]\n", true, 2,
     52,
     "cloth[0].pins[0].vertices: is '7-4', must be a list of vertex numbers from 0 or ranges as "
     "3-9"},
    {"time: {frames: 3}\ncloth: [{mesh: {shape: net}, pins: [{vertices: [1, -4]}]}]\n", true, 2, 52,
     "cloth[0].pins[0].vertices: is '-4', must be a list of vertex numbers from 0 or ranges as "
     "3-9"},
    {"time: {frames: 3}\ncloth: [{mesh: {shape: net}, pins: [{vertices: [0-19999999, 7]}]}]\n",
     true, 2, 61, "cloth[0].pins[0].vertices: is '7', must be within 20000000 indices in all"},
    {"time: {frames: 3}\ncloth: [{mesh: {shape: net}, pins: [{}]}]\n", true, 2, 37,
     "cloth[0].pins[0]: needs one of the keys box, line, sphere, near, group, material, vertices, "
     "nearest"},
    {"time: {frames: 3}\ncloth: [{mesh: {shape: rectangle, resolution: [1000000000000, 5]}}]\n",
     true, 2, 48,
     "cloth[0].mesh.resolution: is '1000000000000', must be a whole number from 2 to 10000000"},
};

static void test_refusals(void **state) {
    (void)state;
    size_t wrong_count = 0;
    for (size_t i = 0; i < sizeof refusals / sizeof refusals[0]; i++) {
        const refusal *wanted = &refusals[i];
        attempt work;
        if (wanted->is_whole)
            read_scene(&work, wanted->text, strlen(wanted->text), NULL);
        else
            read_more(&work, wanted->text, NULL);
        const tulle_error *error = &work.problems->list[0];
        bool is_as_wanted = work.problems->total_count == 1 && error->line == wanted->line &&
                            error->column == wanted->column &&
                            strcmp(error->message, wanted->message) == 0 &&
                            strcmp(error->file, "s.yaml") == 0;
        if (!is_as_wanted) {
            print_error("for:\n%s\nwanted %d:%d: %s\nfound %zu problems:\n", wanted->text,
                        wanted->line, wanted->column, wanted->message, work.problems->total_count);
            scene_print_problems(work.problems, stderr);
        }
        wrong_count += !is_as_wanted;
        release(&work);
    }
    assert_int_equal(wrong_count, 0);
}

static void test_all_problems_are_reported(void **state) {
    (void)state;
    attempt work;
    read_more(&work, "gravty: 1\nseed: x\nwind: {drag: -1, gusts: 3}\n", NULL);
    assert_int_equal(work.problems->count, 4);
    assert_int_equal(work.problems->list[0].line, 4);
    assert_int_equal(work.problems->list[1].line, 5);
    assert_int_equal(work.problems->list[2].line, 6);
    assert_int_equal(work.problems->list[2].column, 18); /* unknown keys of a map come first */
    assert_int_equal(work.problems->list[3].column, 14);
    release(&work);
    char many[2000] = "obstacles:\n";
    for (int i = 0; i < 30; i++) strcat(many, "  - {mesh: {shape: box}, friction: -1}\n");
    read_more(&work, many, NULL);
    assert_int_equal(work.problems->count, TULLE_SCENE_PROBLEMS_MAX);
    assert_int_equal(work.problems->total_count, 30);
    release(&work);
}

static void test_units(void **state) {
    (void)state;
    static const struct {
        const char *text;
        unit_dimension unit;
        double value;
    } good[] = {
        {"2", UNIT_LENGTH, 2},
        {"2 mm", UNIT_LENGTH, 0.002},
        {"2 in", UNIT_LENGTH, 0.0508},
        {"5 ft", UNIT_LENGTH, 1.524},
        {"1/8 in", UNIT_LENGTH, 0.003175},
        {"12 in/s", UNIT_VELOCITY, 0.3048},
        {"10 ft/s", UNIT_VELOCITY, 3.048},
        {"-32 ft/s^2", UNIT_ACCELERATION, -9.7536},
        {"2mm", UNIT_LENGTH, 0.002},
        {"-1.5e2 cm", UNIT_LENGTH, -1.5},
        {".5 km", UNIT_LENGTH, 500},
        {"+3. um", UNIT_LENGTH, 3e-6},
        {"1/90 s", UNIT_TIME, 1.0 / 90},
        {"1/90", UNIT_TIME, 1.0 / 90},
        {"3/4 ms", UNIT_TIME, 0.75e-3},
        {"180 deg", UNIT_ANGLE, 3.141592653589793},
        {"0.5 turn", UNIT_ANGLE, 3.141592653589793},
        {"36 km/h", UNIT_VELOCITY, 10},
        {"0.2 kg/m^2", UNIT_AREA_DENSITY, 0.2},
        {"200 g/m^2", UNIT_AREA_DENSITY, 0.2},
        {"9.81 m/s^2", UNIT_ACCELERATION, 9.81},
        {"1.5 kN/m", UNIT_STIFFNESS, 1500},
        {"500 gf/cm", UNIT_STIFFNESS, 490.3325},
        {"1 gf/cm/deg", UNIT_STIFFNESS, 0.980665 / 0.017453292519943295},
        {"0.1 gf cm^2/cm", UNIT_BENDING, 9.80665e-6},
        {"0.05 gf cm/cm", UNIT_LINE_MOMENT, 4.903325e-4},
        {"0.2 mN", UNIT_LINE_MOMENT, 2e-4},
        {"2 gf/cm", UNIT_LINE_FORCE, 1.96133},
        {"120 gsm", UNIT_AREA_DENSITY, 0.12},
        {"12 mg/cm^2", UNIT_AREA_DENSITY, 0.12},
        {"12 oz/yd^2", UNIT_AREA_DENSITY, 12 * 0.028349523125 / (0.9144 * 0.9144)},
        {"30 uN m", UNIT_BENDING, 30e-6},
        {"2 1/s", UNIT_RATE, 2},
        {"25 %", UNIT_NONE, 0.25},
        {"25%", UNIT_NONE, 0.25},
        {"1.2 kg/m^3", UNIT_DRAG, 1.2},
        {"1 min", UNIT_TIME, 60},
    };
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        double value = NAN;
        assert_int_equal(quantity_read(good[i].text, good[i].unit, &value), QUANTITY_READ);
        assert_true(fabs(value - good[i].value) <= 4e-16 * fabs(good[i].value));
    }
    static const char *const bad[] = {"",     "m",   "-",     ".",  "e5", "0x10 ?", "1,5",   "1 /2",
                                      "1..2", "--1", "1_000", " 1", "1/", "1/x",    "1:30 s"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        double value = 7;
        quantity_state found = quantity_read(bad[i], UNIT_LENGTH, &value);
        assert_true(found == QUANTITY_NOT_A_NUMBER || found == QUANTITY_UNKNOWN_UNIT);
        assert_true(value == 7);
    }
}

static void test_values_and_defaults(void **state) {
    (void)state;
    attempt work;
    read_more(
        &work,
        "title: \"a 'b'\"\n"
        "wind: {velocity: [5 km/h, 0, -1], drag: 1.2}\n"
        "contact: {delta_c: 4 mm, method: bvox, on_pinch: slow, response: paper, "
        "motion_space: cone}\n"
        "obstacles:\n"
        "  - mesh: {shape: box, size: [1, 2, 30 mm]}\n"
        "    scale: 2\n"
        "    rotate: [0, 0, 90 deg]\n"
        "    disappears: 2 s\n"
        "  - mesh: {file: a/b.obj}\n"
        "    rotate: {axis: [0, 3, 0], angle: 180 deg}\n"
        "    copies: {spiral: {count: 80, radius: 1}, order: last-to-first, stagger: 50 ms}\n",
        NULL);
    assert_true(work.is_good);
    const scene_keys *keys = &work.keys;
    assert_string_equal(keys->title, "a 'b'");
    assert_true(keys->time.step == 1.0 / 90 && keys->time.steps_per_frame == 1);
    assert_int_equal(keys->time.frames, 10);
    assert_true(keys->gravity.value[2] == -9.81 && keys->seed == 1);
    assert_true(fabs(keys->wind.velocity.value[0] - 5 / 3.6) < 1e-15);
    assert_true(keys->wind.seed == SEED_AUTO && keys->wind.gust_length == 0.5);
    assert_true(keys->contact.delta_c == 0.004 && keys->contact.delta_s == 0);
    assert_int_equal(keys->contact.method, 2);
    assert_true(keys->contact.alpha_max == 0.78539816339744831);
    assert_int_equal(keys->contact.certificate, 1);
    assert_int_equal(keys->contact.patches, 0);
    assert_int_equal(keys->contact.on_pinch, 1);
    assert_true(keys->contact.response == 1 && keys->contact.motion_space == 0);
    const cloth_keys *cloth = keys->cloth.items;
    assert_null(cloth->material.preset);
    assert_null(cloth->name);
    assert_true(cloth->mesh.size.count == 2 && cloth->mesh.resolution.value[1] == 6);
    assert_int_equal(cloth->pins.count, 0);
    const obstacle_keys *obstacles = keys->obstacles.items;
    assert_int_equal(keys->obstacles.count, 2);
    assert_true(obstacles[0].scale.value[2] == 2 && obstacles[1].scale.count == 0);
    assert_true(fabs(obstacles[0].rotate.quaternion[3] - sqrt(0.5)) < 1e-15);
    assert_true(fabs(obstacles[1].rotate.quaternion[2] - 1) < 1e-15);
    assert_true(obstacles[0].disappears == 2 && obstacles[1].disappears == (double)INFINITY);
    assert_true(obstacles[0].appears == -(double)INFINITY);
    assert_null(obstacles[0].copies.head.node);
    assert_int_equal(obstacles[1].copies.spiral.count, 80);
    assert_int_equal(obstacles[1].copies.order, STAGGER_LAST_TO_FIRST);
    assert_string_equal(obstacles[1].mesh.file, "a/b.obj");
    assert_string_equal(obstacles[1].copies.spiral.head.path, "obstacles[1].copies.spiral");
    assert_int_equal(schema_place(&obstacles[0], "scale").line, 9);
    assert_int_equal(schema_place(&obstacles[0], "friction").line, 8); /* the entry's own place */
    release(&work);
}

static void test_overrides(void **state) {
    (void)state;
    static const char *const good[] = {
        "time.frames=7",  "cloth[0].mesh.resolution=[40, 40]", "time.duration=2 s",
        "wind.drag=1.2",  "obstacles[0].mesh={shape: sphere}", "cloth[1].mesh.shape=net",
        "cloth[0].name=", "contact.friction= 0.5 # as felt"};
    attempt work;
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        read_more(&work, "", good[i]);
        if (!work.is_good) scene_print_problems(work.problems, stderr);
        assert_true(work.is_good);
        const cloth_keys *cloth = work.keys.cloth.items;
        if (i == 0) assert_int_equal(work.keys.time.frames, 7);
        if (i == 1) assert_int_equal(cloth->mesh.resolution.value[0], 40);
        if (i == 2) {
            assert_true(schema_is_given(&time_map, &work.keys.time, "duration"));
            assert_false(schema_is_given(&time_map, &work.keys.time, "frames"));
            assert_true(work.keys.time.duration == 2);
        }
        if (i == 4) assert_int_equal(work.keys.obstacles.count, 1);
        if (i == 5) assert_int_equal(work.keys.cloth.count, 2);
        if (i == 7) assert_true(work.keys.contact.friction == 0.5);
        release(&work);
    }
    static const struct {
        const char *text, *message;
    } bad[] = {
        {"time.frames=ten", "time.frames: is 'ten', must be a whole number from 1 to 10000000"},
        {"time.frame=10", "time.frame: unknown key; did you mean 'frames'?"},
        {"cloth[2].name=x", "index 2 is past the end of a list of 1"},
        {"cloth.name=x", "the path does not fit the scene: before the key name it finds a list, "
                         "not a map"},
        {"time[0]=x",
         "the path does not fit the scene: before an index it finds a map, not a list"},
        {"time.step=[1", "not valid YAML: did not find expected ',' or ']' while parsing a flow "
                         "sequence"},
        {"time.step=#", "the value is empty"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        read_more(&work, "", bad[i].text);
        const tulle_error *error = &work.problems->list[0];
        assert_int_equal(work.problems->total_count, 1);
        assert_string_equal(error->message, bad[i].message);
        assert_int_equal(error->line, 0);
        assert_memory_equal(error->file, "--set ", 6);
        assert_string_equal(error->file + 6, bad[i].text);
        release(&work);
    }
    static const char *const malformed[] = {"",        "=",     "time",  ".x=1",
                                            "time.=1", "a[=1",  "a[]=1", "a[9999999]=1",
                                            "a]b=1",   "a b=1", "[0]=1", "cloth[0x]=1"};
    for (size_t i = 0; i < sizeof malformed / sizeof malformed[0]; i++) {
        read_more(&work, "", malformed[i]);
        assert_false(work.is_good);
        assert_non_null(strstr(work.problems->list[0].message, "an override reads PATH=VALUE"));
        release(&work);
    }
}

/* Limits: depth, nodes, keys, size; and the billion laughs, which need aliases. */
static void test_limits(void **state) {
    (void)state;
    attempt work;
    size_t capacity = (4u << 20) + 16;
    char *text = malloc(capacity);
    assert_non_null(text);
    memset(text, '[', 100000);
    read_scene(&work, text, 100000, NULL);
    assert_int_equal(work.problems->list[0].status, TULLE_ERROR_LIMIT);
    assert_int_equal(work.problems->list[0].column, TREE_DEPTH_LIMIT + 1);
    release(&work);
    memcpy(text, "a: [", 4);
    for (size_t i = 4; i + 1 < capacity; i += 2) memcpy(text + i, "1,", 2);
    read_scene(&work, text, 1 << 20, NULL);
    assert_int_equal(work.problems->list[0].status, TULLE_ERROR_LIMIT);
    release(&work);
    read_scene(&work, text, capacity, NULL);
    assert_int_equal(work.problems->list[0].status, TULLE_ERROR_LIMIT);
    assert_int_equal(work.problems->list[0].line, 0);
    release(&work);
    size_t used = 0;
    for (int i = 0; i < 300; i++) used += (size_t)sprintf(text + used, "k%d: 1\n", i);
    read_scene(&work, text, used, NULL);
    assert_int_equal(work.problems->list[0].status, TULLE_ERROR_LIMIT);
    assert_int_equal(work.problems->list[0].line, TREE_KEY_LIMIT + 1);
    release(&work);
    free(text);
}

static const char corpus[] =
    "# a scene with a little of everything\n"
    "title: \"t\\u00e9st\"\n"
    "seed: 3\n"
    "time: {step: 1/90 s, duration: 2 s, steps_per_frame: 3}\n"
    "wind: {velocity: [5 km/h, 0, 0], gust_strength: 1, drag: 1.2}\n"
    "cloth:\n"
    "  - name: sheet\n"
    "    mesh: {shape: net, size: [1, 1], cells: [3, 4], strand: 2 cm}\n"
    "    rotate: {axis: [0, 0, 1], angle: 30 deg}\n"
    "    material:\n      preset: silk\n      area_density: 0.2 kg/m^2\n"
    "    pins:\n"
    "      - {vertices: [0, 4-7], keyframes: [{time: 0}, {time: 1, rotate: [0, 1, 0]}]}\n"
    "      - {box: {min: [0, 0, 0], max: [1, 1, 1]}, release: 2 s}\n"
    "obstacles:\n"
    "  - mesh: {shape: needle}\n"
    "    copies: {spiral: {count: 8, radius: 1}, stagger: 50 ms}\n"
    "    motion: {keyframes: [{time: 0}, {time: 1, translate: [0, 0, -1]}]}\n"
    "  - mesh: {file: 'a.obj'}\n"
    "    motion: {sequence: {cache: b.pc2, interval: 40 ms}}\n"
    "contact: {delta_c: auto, xi: 1 um, method: bvox}\n"
    "solver: {integrator: bdf2, cg_tolerance: 1e-5}\n";

static void test_truncated_anywhere(void **state) {
    (void)state;
    attempt work;
    size_t good_count = 0;
    for (size_t length = 0; length < sizeof corpus; length++) {
        char *exact = malloc(length + 1); /* exact size, so that sanitizers see any read past it */
        assert_non_null(exact);
        memcpy(exact, corpus, length);
        read_scene(&work, exact, length, NULL);
        good_count += work.is_good;
        release(&work);
        free(exact);
    }
    read_scene(&work, corpus, sizeof corpus - 1, NULL);
    assert_true(work.is_good);
    release(&work);
    assert_true(good_count > 0 && good_count < sizeof corpus / 2);
}

static void test_flipped_bits(void **state) {
    (void)state;
    uint64_t random = 20;
    char text[sizeof corpus];
    for (int trial = 0; trial < 4000; trial++) {
        memcpy(text, corpus, sizeof corpus);
        int flips = 1 + (int)(random_next(&random) % 3);
        for (int i = 0; i < flips; i++) {
            size_t bit = (size_t)(random_next(&random) % (8 * (sizeof corpus - 1)));
            text[bit / 8] = (char)(text[bit / 8] ^ (1 << bit % 8));
        }
        attempt work;
        read_scene(&work, text, sizeof corpus - 1, NULL);
        release(&work);
    }
}

/* The defaults of all maps pass through the reader that reads the user's values. */
static void test_canonical_text_reads_again(void **state) {
    (void)state;
    attempt first, second;
    read_scene(&first, corpus, sizeof corpus - 1, NULL);
    text_buffer written = {.storage = &first.storage};
    schema_write(&scene_map, &first.keys, 0, &written);
    read_scene(&second, written.data, written.count, NULL);
    if (!second.is_good) {
        scene_print_problems(second.problems, stderr);
        print_error("%s\n", written.data);
    }
    assert_true(second.is_good);
    text_buffer again = {.storage = &second.storage};
    schema_write(&scene_map, &second.keys, 0, &again);
    assert_true(written.count > 2000);
    assert_string_equal(written.data, again.data);
    assert_non_null(strstr(written.data, "vertices: [0, 4-7]\n"));
    assert_non_null(strstr(written.data, "rotate: {axis: [0, 0, 1], angle: 0.523"));
    assert_non_null(strstr(written.data, "rotate: [0, 1, 0]\n"));
    assert_non_null(strstr(written.data, "method: bvox\n"));
    assert_non_null(strstr(written.data, "delta_s: auto\n"));
    release(&first);
    release(&second);
}

static const double shift[3] = {0.1, 0.30000000000000004, -1.0 / 90.0};

/* Reads a scene that is shifted so, and writes it. */
static void read_and_write(attempt *work, const char *text, text_buffer *written) {
    read_scene(work, text, strlen(text), NULL);
    assert_true(work->is_good);
    assert_memory_equal(((const cloth_keys *)work->keys.cloth.items)->translate.value, shift,
                        sizeof shift);
    *written = (text_buffer){.storage = &work->storage};
    schema_write(&scene_map, &work->keys, 0, written);
}

static void expect_canonical_numbers(void) {
    attempt first, second;
    text_buffer written, again;
    char text[512];
    snprintf(text, sizeof text, "%s    translate: [0.1, 0.30000000000000004, -1/90]\n", base);
    read_and_write(&first, text, &written);
    assert_non_null(strstr(written.data, "\ngravity: [0, 0, -9.81]\n"));
    assert_non_null(strstr(written.data, "translate: [0.1, 0.30000000000000004, "
                                         "-0.011111111111111112]\n"));
    read_and_write(&second, written.data, &again);
    assert_string_equal(written.data, again.data);
    release(&first);
    release(&second);
}

/* Numbers have the fewest digits that read back to the same double. */
static void test_canonical_numbers(void **state) {
    (void)state;
    expect_canonical_numbers();
}

static void test_canonical_numbers_with_a_decimal_comma(void **state) {
    (void)state;
    use_decimal_comma();
    expect_canonical_numbers();
    test_canonical_text_reads_again(state);
    use_decimal_point();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_all_problems_are_reported),
        cmocka_unit_test(test_units),
        cmocka_unit_test(test_values_and_defaults),
        cmocka_unit_test(test_overrides),
        cmocka_unit_test(test_limits),
        cmocka_unit_test(test_truncated_anywhere),
        cmocka_unit_test(test_flipped_bits),
        cmocka_unit_test(test_canonical_text_reads_again),
        cmocka_unit_test(test_canonical_numbers),
        cmocka_unit_test(test_canonical_numbers_with_a_decimal_comma),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
