/* What files say of their axes and units, in scenes: of sequences and of plain meshes, of cloth and
 * obstacles; `up`, `scale` and `place` overrule it; sizes that speak of another unit are noted. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_data.h"
#include "scene_text.h"

#include <math.h>

#define HEAD                                                                                       \
    "time: {frames: 20, step: 50 ms}\n"                                                            \
    "cloth:\n  - {mesh: {shape: rectangle, resolution: [2, 2]}, translate: [0, 0, 900]}\n"

/* A triangle of 2 x 4 x 0 units that moves 100 units along `way`. */
static void write_usd(const char *name, const char *head) {
    char text[600];
    snprintf(text, sizeof text,
             "#usda 1.0\n(\n %s\n timeCodesPerSecond = 1\n)\n"
             "def Mesh \"b\"\n{\n int[] faceVertexCounts = [3]\n"
             " int[] faceVertexIndices = [0, 1, 2]\n uniform token subdivisionScheme = \"none\"\n"
             " point3f[] points = [(10, 0, 0), (12, 0, 0), (10, 4, 0)]\n"
             " double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 1: (0, 100, 0) }\n"
             " uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}\n",
             head);
    write_text_file(name, text);
}

/* Checks the third corner at the start and, where it is an obstacle that moves, a second later. */
static void expect(const char *text, bool is_cloth, const double start[3], const double *end) {
    tulle_scene *const loaded = load_good(text);
    tulle_mesh_view const mesh =
        is_cloth ? tulle_scene_get_cloth_mesh(loaded, 1) : tulle_scene_get_obstacle_mesh(loaded, 0);
    for (size_t k = 0; k < 3; k++)
        if (!(fabs(mesh.positions[6 + k] - start[k]) < 1e-9))
            fail_msg("%s: coordinate %zu is %g, not %g", text, k, mesh.positions[6 + k], start[k]);
    double positions[9];
    tulle_error error = {0};
    if (end && sequence_read(loaded->obstacles[0].sequence, 20, positions, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    for (size_t k = 0; end && k < 3; k++)
        if (!(fabs(positions[6 + k] - end[k]) < 1e-9))
            fail_msg("%s: at 1 s %zu is %g, not %g", text, k, positions[6 + k], end[k]);
    tulle_scene_destroy(loaded);
}

#define POINT(...) ((const double[3]){__VA_ARGS__})
#define SEQUENCE(file, more)                                                                       \
    HEAD "obstacles:\n  - {motion: {sequence: {cache: " file "}}" more "}\n"
#define OBSTACLE(file, more) HEAD "obstacles:\n  - {mesh: {file: " file "}" more "}\n"
#define CLOTH(file, more) HEAD "  - {mesh: {file: " file "}" more "}\n"

static void test_what_files_say(void **state) {
    (void)state;
    write_usd("cm.usda", "upAxis = \"Y\"\n metersPerUnit = 0.01");
    write_usd("silent.usda", "");
    write_usd("z.usda", "upAxis = \"Z\"\n metersPerUnit = 1");
    write_text_file("t.obj", "v 10 0 0\nv 12 0 0\nv 10 4 0\nf 1 2 3\n");
    write_text_file(
        "t.gltf",
        "{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{\"mesh\": 0}], \"meshes\": "
        "[{\"primitives\": [{\"attributes\": {\"POSITION\": 0}}]}], \"accessors\": [{\"bufferView\""
        ": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\"}], \"bufferViews\": "
        "[{\"buffer\": 0, \"byteLength\": 36}], \"buffers\": [{\"byteLength\": 36, \"uri\": "
        "\"data:application/octet-stream;base64,"
        "AAAgQQAAAAAAAAAAAABAQQAAAAAAAAAAAAAgQQAAgEAAAAAA\"}]}");
    expect(SEQUENCE("cm.usda", ""), false, POINT(0.1, 0, 0.04), POINT(0.1, 0, 1.04));
    expect(SEQUENCE("silent.usda", ""), false, POINT(0.1, 0, 0.04), POINT(0.1, 0, 1.04));
    expect(SEQUENCE("z.usda", ""), false, POINT(10, 4, 0), POINT(10, 104, 0));
    expect(OBSTACLE("cm.usda", ""), false, POINT(0.1, 0, 0.04), NULL);
    expect(OBSTACLE("t.gltf", ""), false, POINT(10, 0, 4), NULL);
    expect(OBSTACLE("t.obj", ""), false, POINT(10, 4, 0), NULL);
    expect(CLOTH("cm.usda", ""), true, POINT(0.1, 0, 0.04), NULL);
    expect(CLOTH("z.usda", ""), true, POINT(10, 4, 0), NULL);
}

static void test_keys_overrule(void **state) {
    (void)state;
    write_usd("cm.usda", "upAxis = \"Y\"\n metersPerUnit = 0.01");
    expect(SEQUENCE("cm.usda", ", scale: 1"), false, POINT(10, 0, 4), POINT(10, 0, 104));
    expect(SEQUENCE("cm.usda", ", scale: 0.1"), false, POINT(1, 0, 0.4), POINT(1, 0, 10.4));
    expect(SEQUENCE("cm.usda", ", place: {up: z}"), false, POINT(0.1, 0.04, 0),
           POINT(0.1, 1.04, 0));
    expect(SEQUENCE("cm.usda", ", place: {up: z}, scale: 1"), false, POINT(10, 4, 0),
           POINT(10, 104, 0));
    expect(SEQUENCE("cm.usda", ", place: {up: y}"), false, POINT(0.1, 0, 0.04),
           POINT(0.1, 0, 1.04));
    /* Set down by its box: the triangle is 4 units high. */
    expect(SEQUENCE("cm.usda", ", place: {height: 2, on: 1}"), false, POINT(5, 0, 3),
           POINT(5, 0, 53));
    expect(CLOTH("cm.usda", ", rotate: [0, 0, 90 deg]"), true, POINT(0, 0.1, 0.04), NULL);
    /* On a body, as it was modelled. */
    expect(CLOTH("cm.usda", ", place: {as: b}") "obstacles:\n  - {name: b, mesh: {file: cm.usda}, "
                                                "translate: [0, 0, -1]}\n",
           true, POINT(0.1, 0, -0.96), NULL);
}

static void expect_note(const char *text, const char *words) {
    tulle_scene *const loaded = load_good(text);
    size_t const count = tulle_scene_get_note_count(loaded);
    bool const is_there = count > 0 && words && strstr(tulle_scene_get_note(loaded, 0), words);
    if (words ? !is_there : count > 0)
        fail_msg("%s: %s", text, count > 0 ? tulle_scene_get_note(loaded, 0) : "no note");
    tulle_scene_destroy(loaded);
}

static void test_odd_sizes(void **state) {
    (void)state;
    write_text_file("mm.obj", "v 0 0 0\nv 200 0 0\nv 0 1800 0\nf 1 2 3\n");
    write_text_file("km.obj", "v 0 0 0\nv 0.0009 0 0\nv 0 0.0002 0\nf 1 2 3\n");
    expect_note(OBSTACLE("mm.obj", ", name: tall"), "tall is 1.8e+03 m across, more than 100 m");
    expect_note(OBSTACLE("mm.obj", ", name: tall"), "set 'scale'");
    expect_note(OBSTACLE("mm.obj", ", scale: 0.001"), NULL);
    expect_note(OBSTACLE("mm.obj", ", place: {size: 1.8}"), NULL);
    expect_note(OBSTACLE("km.obj", ""), "obstacle0 is 0.0009 m across, less than 1 mm");
    const char *const growing =
        "#usda 1.0\n(\n upAxis = \"Z\"\n metersPerUnit = %s\n timeCodesPerSecond = 1\n)\n"
        "def Mesh \"b\"\n{\n int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2]\n"
        " uniform token subdivisionScheme = \"none\"\n"
        " point3f[] points = [(10, 0, 0), (12, 0, 0), (10, 4, 0)]\n"
        " double3 xformOp:scale.timeSamples = { 0: (%g, %g, %g), 1: (1, 1, 1) }\n"
        " uniform token[] xformOpOrder = [\"xformOp:scale\"]\n}\n";
    char text[600];
    snprintf(text, sizeof text, growing, "1", 0.0, 0.0, 0.0);
    write_text_file("growing.usda", text);
    expect_note(SEQUENCE("growing.usda", ""), NULL);
    snprintf(text, sizeof text, growing, "0.0001", 1.0, 1.0, 1.0);
    write_text_file("tiny.usda", text);
    expect_note(SEQUENCE("tiny.usda", ""), "obstacle0 is 0.0004 m across, less than 1 mm");
    expect_note(CLOTH("mm.obj", ""), "cloth1 is 1.8e+03 m across, more than 100 m");
    expect_note(HEAD "obstacles:\n  - {mesh: {shape: plane, size: [500, 500]}}\n", NULL);
    write_text_file(
        "seam.usda",
        "#usda 1.0\n(\n upAxis = \"Z\"\n metersPerUnit = 1\n)\ndef Mesh \"b\"\n{\n"
        " int[] faceVertexCounts = [3, 3]\n int[] faceVertexIndices = [0, 1, 2, 3, 4, 5]\n"
        " uniform token subdivisionScheme = \"none\"\n"
        " point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (-0, 1, "
        "0)]\n}\n");
    expect_note(CLOTH("seam.usda", ""), "2 vertices are in the place of others");
    expect_note(OBSTACLE("seam.usda", ""), NULL);
    write_usd("cm.usda", "upAxis = \"Y\"\n metersPerUnit = 0.01");
    expect_note(OBSTACLE("cm.usda", ""), "of 2 frames the first one is taken");
}

/* Notes are listed up to a limit, and that there are more is one of them. */
static void test_many_notes(void **state) {
    (void)state;
    write_text_file("mm.obj", "v 0 0 0\nv 200 0 0\nv 0 1800 0\nf 1 2 3\n");
    for (int count = SCENE_NOTE_LIMIT; count < SCENE_NOTE_LIMIT + 4; count++) {
        char text[4000] = HEAD "obstacles:\n";
        for (int i = 0; i < count; i++)
            snprintf(text + strlen(text), sizeof text - strlen(text),
                     "  - {mesh: {file: mm.obj}, translate: [0, 0, %d]}\n", -10 * i);
        tulle_scene *const loaded = load_good(text);
        size_t const notes = tulle_scene_get_note_count(loaded);
        bool const has_more = count > SCENE_NOTE_LIMIT;
        assert_int_equal(notes, SCENE_NOTE_LIMIT + has_more);
        const char *const last = tulle_scene_get_note(loaded, notes - 1);
        assert_true((strstr(last, "there are more notes") != NULL) == has_more);
        tulle_scene_destroy(loaded);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_many_notes),
        cmocka_unit_test(test_what_files_say),
        cmocka_unit_test(test_keys_overrule),
        cmocka_unit_test(test_odd_sizes),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
