/* Placement of meshes in scenes: upright, to a size, centred, on a height or an obstacle, mirrored;
 * against coordinates worked out by hand and boxes found here. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_data.h"
#include "scene_text.h"

#include <math.h>

#define TIME "time: {frames: 3, step: 10 ms}\n"
#define TABLE "obstacles:\n  - name: table\n    mesh: {shape: plane}\n    translate: [0, 0, -50]\n"

typedef struct box {
    double low[3], high[3];
} box;

static box find_box(tulle_mesh_view mesh) {
    box found = {{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++) {
        found.low[i % 3] = fmin(found.low[i % 3], mesh.positions[i]);
        found.high[i % 3] = fmax(found.high[i % 3], mesh.positions[i]);
    }
    return found;
}

static void assert_near(double value, double expected) {
    if (!(fabs(value - expected) < 1e-12)) fail_msg("%.17g, not %.17g", value, expected);
}

/* The text that a run keeps leads to the same scene. */
static void end_scene(tulle_scene *loaded) {
    char *const text = strdup(tulle_scene_get_canonical_text(loaded));
    assert_non_null(text);
    tulle_scene *const again = load_good(text);
    assert_true(tulle_scene_get_hash(again) == tulle_scene_get_hash(loaded));
    free(text);
    tulle_scene_destroy(again);
    tulle_scene_destroy(loaded);
}

/* A wedge that is 2 wide, 4 high along y and 1 deep, away from the origin. */
static void write_wedge(void) {
    write_text_file("wedge.obj", "v 10 -3 7\nv 12 -3 7\nv 10 1 7\nv 10 -3 8\n"
                                 "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
}

/* scale [1, 2, -1]; up y: (x, y, z) -> (x, -z, y); a quarter turn about z; to a height of 2; the
 * middle over the origin, on 0.5; then moved. */
static void test_keys_act_in_order(void **state) {
    (void)state;
    write_wedge();
    tulle_scene *const loaded =
        load_good(TIME "cloth:\n  - mesh: {file: wedge.obj}\n    scale: [1, 2, -1]\n"
                       "    place: {up: y, height: 2 m, center: true, on: 50 cm}\n"
                       "    rotate: [0, 0, 90 deg]\n    translate: [1, 2, 3]\n" TABLE);
    static const double file[4][3] = {{10, -3, 7}, {12, -3, 7}, {10, 1, 7}, {10, -3, 8}};
    tulle_mesh_view const mesh = tulle_scene_get_cloth_mesh(loaded, 0);
    double placed[4][3];
    for (int v = 0; v < 4; v++) {
        double const x = file[v][0], y = 2 * file[v][1], z = -file[v][2];
        double const upright[3] = {x, -z, y}; /* y from 7 to 8, z from -6 to 2 */
        double const turned[3] = {-upright[1], upright[0], upright[2]};
        for (int k = 0; k < 3; k++) placed[v][k] = 0.25 * turned[k];
        /* The middle is at x = -7.5 / 4, y = 11 / 4; the bottom at z = -6 / 4. */
        placed[v][0] += 7.5 / 4 + 1;
        placed[v][1] += -11.0 / 4 + 2;
        placed[v][2] += 6.0 / 4 + 0.5 + 3;
        for (int k = 0; k < 3; k++) assert_near(mesh.positions[3 * v + k], placed[v][k]);
    }
    /* The scale mirrors: corners 1 and 2 of each triangle have changed places. */
    static const uint32_t triangles[] = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
    assert_memory_equal(mesh.triangles, triangles, sizeof triangles);
    end_scene(loaded);
}

/* Each key alone, and the axes that may be up; quarter turns are exact. */
static void test_keys_alone(void **state) {
    (void)state;
    write_wedge();
    static const struct {
        const char *place;
        box expected;
    } cases[] = {
        {"{}", {{10, -3, 7}, {12, 1, 8}}},
        {"{up: z}", {{10, -3, 7}, {12, 1, 8}}},
        {"{up: y}", {{10, -8, -3}, {12, -7, 1}}},
        {"{up: x}", {{-8, -3, 10}, {-7, 1, 12}}},
        {"{size: 2}", {{5, -1.5, 3.5}, {6, 0.5, 4}}},
        {"{height: 4}", {{40, -12, 28}, {48, 4, 32}}},
        {"{center: true}", {{-1, -2, 7}, {1, 2, 8}}},
        {"{on: ground}", {{10, -3, 0}, {12, 1, 1}}},
        {"{on: -2 m}", {{10, -3, -2}, {12, 1, -1}}},
        {"{up: y, size: 8 m, center: true, on: ground}", {{-2, -1, 0}, {2, 1, 8}}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[400];
        snprintf(text, sizeof text,
                 TIME "cloth:\n  - {mesh: {file: wedge.obj}, place: %s}\n"
                      "obstacles:\n  - {mesh: {file: wedge.obj}, place: %s}\n",
                 cases[i].place, cases[i].place);
        tulle_scene *const loaded = load_good(text);
        box const found = find_box(tulle_scene_get_cloth_mesh(loaded, 0));
        box const other = find_box(tulle_scene_get_obstacle_mesh(loaded, 0));
        assert_memory_equal(&found, &cases[i].expected, sizeof found);
        assert_memory_equal(&other, &cases[i].expected, sizeof other);
        end_scene(loaded);
    }
}

/* Floats hold the cloth where it is placed, not where its file has it. */
static void test_far_file_is_brought_near(void **state) {
    (void)state;
    write_text_file("far.obj", "v 500000 0 0\nv 500000.02 0 0\nv 500000.02 0.02 0\n"
                               "v 500000 0.02 0\nf 1 2 3 4\n");
    static const struct {
        const char *keys;
        const char *error; /* of the start; null: none */
    } cases[] = {
        {"place: {center: true, on: 1 m}", NULL},
        {"translate: [-500000, 0, 1]", NULL},
        {"translate: [0, 0, 1]", "where the scene reaches 5e+05 m from the origin"},
        {"scale: 0.00001, translate: [0, 0, 1]", "where the scene reaches 5 m from the origin"},
        {"scale: 0.00001, place: {size: 0.02, center: true}", NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[400];
        snprintf(text, sizeof text, TIME "cloth:\n  - {mesh: {file: far.obj}, %s}\n",
                 cases[i].keys);
        tulle_scene *const loaded = load_good(text);
        tulle_error error = {0};
        tulle_scene_world built;
        assert_int_equal(tulle_scene_build_world(loaded, 1, NULL, &built, &error), TULLE_OK);
        tulle_status const status = tulle_world_start(built.world, &error);
        assert_int_equal(status, cases[i].error ? TULLE_ERROR_INVALID_MESH : TULLE_OK);
        if (cases[i].error) assert_non_null(strstr(error.message, cases[i].error));
        tulle_scene_destroy_world(&built);
        end_scene(loaded);
    }
}

/* A tower of obstacles, with copies, and a cloth on top; vertices that no triangle uses do not
 * count. */
static void test_on_top_of(void **state) {
    (void)state;
    write_text_file("spare.obj", "v 0 0 -5\nv 0 0 0\nv 1 0 0\nv 0 0 1\nv 9 9 90\nf 2 3 4\n");
    tulle_scene *const loaded = load_good(
        TIME "cloth:\n  - mesh: {shape: rectangle}\n    place: {on_top_of: posts}\n"
             "    translate: [0, 0, 5 mm]\n"
             "obstacles:\n"
             "  - {name: base, mesh: {shape: sphere, radius: 0.5}, place: {on: ground}}\n"
             "  - {name: posts, mesh: {shape: box, size: [0.1, 0.1, 0.4]}, rotate: [0.3, 0.2, 0],\n"
             "     place: {on_top_of: base}, copies: {row: {count: 3, offset: [1, 0, 0.25]}}}\n"
             "  - {name: fin, mesh: {file: spare.obj}, place: {on_top_of: posts.001}}\n");
    box const base = find_box(tulle_scene_get_obstacle_mesh(loaded, 0));
    box const first = find_box(tulle_scene_get_obstacle_mesh(loaded, 1));
    box const second = find_box(tulle_scene_get_obstacle_mesh(loaded, 2));
    box const third = find_box(tulle_scene_get_obstacle_mesh(loaded, 3));
    assert_near(base.low[2], 0);
    assert_near(base.high[2], 1);
    assert_near(first.low[2], 1);
    assert_near(second.low[2], 1.25);
    assert_near(tulle_scene_get_obstacle_mesh(loaded, 4).positions[5], second.high[2]);
    box const cloth = find_box(tulle_scene_get_cloth_mesh(loaded, 0));
    assert_near(cloth.low[2], third.high[2] + 0.005);
    end_scene(loaded);
}

/* The rest file is placed as the cloth, to the last bit, and texture coordinates follow the corners
 * of a mirrored mesh. */
static void test_rest_is_placed_alike(void **state) {
    (void)state;
    static const char *const uv = "v 3 1 2\nv 4 1 2\nv 4 2 2\nv 3 3 2.5\nvt 0 0\nvt 1 0\nvt 1 1\n"
                                  "vt 0 2\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
    write_text_file("uv.obj", uv);
    tulle_scene *loaded =
        load_good(TIME "cloth:\n  - mesh: {file: uv.obj}\n    rest: {file: uv.obj}\n"
                       "    scale: [-1, 1, 1]\n    rotate: [0.1, 0.2, 0.3]\n"
                       "    place: {up: y, size: 3 m, center: true, on: 1}\n" TABLE);
    const scene_cloth *cloth = &loaded->cloths[0];
    assert_non_null(cloth->rest_positions);
    assert_memory_equal(cloth->rest_positions, cloth->mesh.positions, 12 * sizeof(double));
    end_scene(loaded);
    loaded = load_good(TIME "cloth:\n  - mesh: {file: uv.obj}\n    rest: {uv: 1}\n"
                            "    scale: [1, -1, 1]\n" TABLE);
    cloth = &loaded->cloths[0];
    static const double uvs[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 2}};
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 2; k++)
            assert_near(cloth->rest_corners[3 * i + k], uvs[cloth->mesh.triangles[i]][k]);
    assert_int_equal(cloth->mesh.triangles[1], 2);
    end_scene(loaded);
}

/* All frames of a sequence go where the first one goes; the motion of the files stays. */
static void test_sequence_is_placed_by_its_start(void **state) {
    (void)state;
    write_text_file("s_1.obj", "v 0 0 5\nv 2 0 5\nv 0 1 6\nf 1 2 3\n");
    write_text_file("s_2.obj", "v 0 0 7\nv 6 0 5\nv 0 1 6\nf 1 2 3\n");
    tulle_scene *const loaded = load_good(
        TIME
        "cloth:\n  - {mesh: {shape: rectangle}, translate: [0, 0, 9]}\nobstacles:\n"
        "  - {motion: {sequence: {files: s_%d.obj, first: 1, last: 2, interval: 1}}, scale: -1,\n"
        "     place: {size: 4 m, center: true, on: ground}, copies: {row: {count: 2, offset: "
        "[0, 9, 0]}}}\n");
    double positions[9];
    tulle_error error = {0};
    assert_int_equal(sequence_read(loaded->obstacles[1].sequence, 1, positions, &error), TULLE_OK);
    /* Twice as large and mirrored in the origin, x from -4 to 0, y from -2 to 0, z from -12. */
    static const double expected[9] = {2, 10, -2, -10, 10, 2, 2, 8, 0};
    for (int i = 0; i < 9; i++) assert_near(positions[i], expected[i]);
    static const double start[9] = {2, 10, 2, -2, 10, 2, 2, 8, 0};
    for (int i = 0; i < 9; i++)
        assert_near(tulle_scene_get_obstacle_mesh(loaded, 1).positions[i], start[i]);
    assert_int_equal(tulle_scene_get_obstacle_mesh(loaded, 1).triangles[1], 2);
    end_scene(loaded);
}

/* What is placed as an obstacle lies on it to the last bit, in file and rest, whatever that went
 * through. */
static void test_as_an_obstacle(void **state) {
    (void)state;
    write_wedge();
    tulle_scene *const loaded = load_good(
        TIME
        "cloth:\n  - mesh: {file: wedge.obj}\n    rest: {file: wedge.obj}\n"
        "    place: {as: body}\n"
        "  - {mesh: {file: wedge.obj}, place: {as: ring.002}, translate: [0, 0, 4]}\n"
        "obstacles:\n"
        "  - {name: body, mesh: {file: wedge.obj}, scale: [-1, 2, 1], rotate: [0.1, 0.2, 0.3],\n"
        "     place: {up: y, size: 3 m, center: true, on: 1}, translate: [3, 2, 1]}\n"
        "  - {name: ring, mesh: {file: wedge.obj}, place: {up: x, height: 1, on: 1},\n"
        "     copies: {ring: {count: 3, radius: 2}}, translate: [0, 1, 1]}\n"
        "  - {name: hat, mesh: {file: wedge.obj}, place: {as: body}}\n");
    tulle_mesh_view const cloth = tulle_scene_get_cloth_mesh(loaded, 0);
    static const size_t same[] = {0, 4}; /* body and hat */
    for (int i = 0; i < 2; i++) {
        tulle_mesh_view const body = tulle_scene_get_obstacle_mesh(loaded, same[i]);
        assert_memory_equal(cloth.positions, body.positions, 12 * sizeof(double));
        assert_memory_equal(cloth.triangles, body.triangles, 12 * sizeof(uint32_t));
    }
    assert_memory_equal(loaded->cloths[0].rest_positions, cloth.positions, 12 * sizeof(double));
    tulle_mesh_view const above = tulle_scene_get_cloth_mesh(loaded, 1);
    tulle_mesh_view const copy = tulle_scene_get_obstacle_mesh(loaded, 3);
    for (int i = 0; i < 12; i++)
        assert_near(above.positions[i], copy.positions[i] + (i % 3 == 2 ? 4 : 0));
    end_scene(loaded);
}

static void refuse(const char *text, int line, const char *words) {
    tulle_scene_problems *const problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    assert_null(load_text(text, problems));
    if (problems->total_count != 1 || problems->list[0].line != line ||
        !strstr(problems->list[0].message, words))
        fail_msg("%zu problems, line %d: %s", problems->total_count, problems->list[0].line,
                 problems->list[0].message);
    free(problems);
}

#define POSTS                                                                                      \
    "obstacles:\n  - {name: post, mesh: {shape: box}, copies: {row: {count: 3, offset: [2, 0, "    \
    "0]}}}\n"
#define SHEET(place) TIME "cloth:\n  - mesh: {shape: rectangle}\n    place: " place "\n"
static void test_problems_have_a_place(void **state) {
    (void)state;
    refuse(SHEET("{height: 2}") TABLE, 4, "cloth[0].place.height: the mesh is flat there");
    refuse(SHEET("{size: 1e6}") "    scale: 1e-6\n" TABLE, 4, "it would be scaled by 1e+12");
    refuse(SHEET("{size: 1, height: 2}") TABLE, 4, "only one of the keys size, height");
    refuse(SHEET("{on: 1, on_top_of: table}") TABLE, 4, "only one of the keys on, on_top_of");
    refuse(SHEET("{on_top_of: tabel}") TABLE, 4,
           "on_top_of: no obstacle is called 'tabel'; did you mean 'table'?");
    refuse(SHEET("{on_top_of: cloth0}") TABLE, 4, "no obstacle is called 'cloth0'");
    const char *const posts = "no obstacle is called 'post.3'; copies count from 000, here "
                              "from 'post.000' to 'post.002'";
    refuse(SHEET("{on_top_of: post.3}") POSTS, 4, posts);
    refuse(SHEET("{on_top_of: post.003}") POSTS, 4, "here from 'post.000' to 'post.002'");
    refuse(SHEET("{on_top_of: pst.001}") POSTS, 4, "'pst.001'; did you mean 'post.001'?");
    refuse(SHEET("{on: 1}") "    attach: [{to: post, vertices: [0]}]\n" POSTS, 5,
           "no cloth or obstacle is called 'post'; copies count from 000");
    refuse(SHEET("{on: 1}") "contact: {pairs: [{between: [cloth0, post.3], friction: 1}]}\n" POSTS,
           5, "no cloth or obstacle is called 'post.3'; copies count from 000");
    refuse(SHEET("{on: 3 kg}") TABLE, 4, "place.on");
    refuse(SHEET("{up: w}") TABLE, 4, "place.up");
    refuse(SHEET("{size: 0}") TABLE, 4, "place.size");
    refuse(SHEET("{middle: true}") TABLE, 4, "unknown key");
    refuse(TIME "cloth:\n  - mesh: {shape: rectangle}\nobstacles:\n"
                "  - {name: a, mesh: {shape: box}, place: {on_top_of: b}}\n"
                "  - {name: b, mesh: {shape: box}}\n",
           5, "obstacles[0].place.on_top_of: 'b' must be before it in the file");
    refuse(TIME "cloth:\n  - mesh: {shape: rectangle}\nobstacles:\n"
                "  - {name: a, mesh: {shape: box}, place: {on_top_of: a}}\n",
           5, "'a' must be before it in the file");
    refuse(SHEET("{as: tabl}") TABLE, 4, "did you mean 'table'?");
    refuse(SHEET("{as: table, up: y}") TABLE, 4,
           "place.as: goes with no scale, no rotate and no other");
    refuse(SHEET("{as: table, size: 2}") TABLE, 4, "place.as: goes with no");
    refuse(SHEET("{as: table}") "    scale: 2\n" TABLE, 4, "place.as: goes with no");
    refuse(SHEET("{as: table}") "    rotate: [0, 0, 1]\n" TABLE, 4, "place.as: goes with no");
    refuse(SHEET("{as: table}") TABLE "    copies: {row: {count: 2, offset: [9, 0, 0]}}\n", 4,
           "place.as: has several copies");
    /* What could not be made is told once. */
    refuse(SHEET("{on_top_of: a}") "obstacles:\n  - {name: a, mesh: {file: none.obj}}\n", 0,
           "read for obstacles[0].mesh");
    refuse(TIME "cloth:\n  - {mesh: {shape: rectangle}, scale: [1, 0, 1]}\n" TABLE, 3, "not 0");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_keys_act_in_order),
        cmocka_unit_test(test_keys_alone),
        cmocka_unit_test(test_far_file_is_brought_near),
        cmocka_unit_test(test_on_top_of),
        cmocka_unit_test(test_rest_is_placed_alike),
        cmocka_unit_test(test_sequence_is_placed_by_its_start),
        cmocka_unit_test(test_as_an_obstacle),
        cmocka_unit_test(test_problems_have_a_place),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
