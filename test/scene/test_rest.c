/* What cloth of a scene is like at rest: rest meshes, patterns by texture coordinates, shrinkage,
 * folds and the warp, and every refusal with its place. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_data.h"
#include "scene_text.h"

#include <math.h>

#define TIME "time: {frames: 3}\n"
/* One cloth; the key `mesh` is on line 2, `keys` begin on line 3. */
#define CLOTH(keys) TIME "cloth: [{mesh: {file: m.obj},\n" keys "}]\n"

/* Two triangles of a square of 1 m in the plane z = 0. As a pattern they lie apart, twice as large,
 * and the second one is turned by a right angle. */
#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
#define UVS "vt 0 0\nvt 2 0\nvt 2 2\nvt 9 9\nvt 7 11\nvt 7 9\n"
static const char dressed[] = SQUARE UVS "f 1/1 2/2 3/3\nf 1/4 3/5 4/6\n";

static tulle_scene *load_cloth(const char *text) {
    write_text_file("m.obj", dressed);
    return load_good(text);
}

static void assert_numbers(const double *found, const double *wanted, size_t count) {
    assert_non_null(found);
    for (size_t i = 0; i < count; i++)
        if (!(fabs(found[i] - wanted[i]) < 1e-12))
            fail_msg("number %zu is %.17g, not %.17g", i, found[i], wanted[i]);
}

static void the_start_is_the_rest_shape(void **state) {
    (void)state;
    tulle_scene *const loaded = load_cloth(CLOTH("grain: [0, 1, 0]"));
    const scene_cloth *const cloth = loaded->cloths;
    assert_null(cloth->rest_positions);
    assert_null(cloth->rest_corners);
    assert_null(cloth->warps);
    assert_false(cloth->has_flat_rest);
    tulle_scene_destroy(loaded);
}

static void texture_coordinates_are_a_pattern(void **state) {
    (void)state;
    tulle_scene *loaded = load_cloth(CLOTH("rest: {uv: 0.5 m}, rotate: [90 deg, 0, 0]"));
    const scene_cloth *cloth = loaded->cloths;
    double const corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 4.5, 4.5, 0, 3.5, 5.5, 0, 3.5, 4.5, 0};
    assert_numbers(cloth->rest_corners, corners, 18);
    assert_null(cloth->rest_positions);
    assert_true(cloth->has_flat_rest);
    /* The grain of the start, x, is where it lies in each triangle of the pattern: the second one
     * has turned by a right angle. */
    assert_numbers(cloth->warps, (double[]){1, 0, 0, 0, 1, 0}, 6);
    tulle_scene_destroy(loaded);

    loaded = load_cloth(CLOTH("rest: {uv: 0.5 m, folds: keep, shrink: 0.8}, grain_uv: [0, 3]"));
    cloth = loaded->cloths;
    assert_false(cloth->has_flat_rest);
    assert_numbers(cloth->rest_corners + 9, (double[]){3.6, 3.6, 0, 2.8, 4.4, 0, 2.8, 3.6, 0}, 9);
    assert_numbers(cloth->warps, (double[]){0, 1, 0, 0, 1, 0}, 6);
    tulle_scene_destroy(loaded);
}

static void the_warp_may_follow_texture_coordinates_alone(void **state) {
    (void)state;
    tulle_scene *const loaded = load_cloth(CLOTH("grain_uv: [1, 0]"));
    assert_null(loaded->cloths->rest_corners);
    assert_numbers(loaded->cloths->warps, (double[]){1, 0, 0, 0, -1, 0}, 6);
    tulle_scene_destroy(loaded);
}

static void a_rest_mesh_gives_lengths_and_folds(void **state) {
    (void)state;
    write_text_file("r.obj", "v 0 0 0\nv 0.5 0 0\nv 0.5 0.5 0.1\nv 0 0.5 0\nf 1 2 3\nf 1 3 4\n");
    tulle_scene *loaded = load_cloth(CLOTH("rest: {file: r.obj}, scale: 2, translate: [0, 0, 5]"));
    const double shape[] = {0, 0, 5, 1, 0, 5, 1, 1, 5.2, 0, 1, 5};
    assert_numbers(loaded->cloths->rest_positions, shape, 12);
    assert_null(loaded->cloths->rest_corners);
    assert_false(loaded->cloths->has_flat_rest);
    tulle_scene_destroy(loaded);

    /* With vertices of its own: a pattern. */
    write_text_file("p.obj",
                    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 5 5 0\nv 4 6 0\nv 4 5 0\nf 1 2 3\nf 4 5 6\n");
    loaded = load_cloth(CLOTH("rest: {file: p.obj, folds: flat}"));
    const double corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 5, 5, 0, 4, 6, 0, 4, 5, 0};
    assert_numbers(loaded->cloths->rest_corners, corners, 18);
    assert_true(loaded->cloths->has_flat_rest);
    tulle_scene_destroy(loaded);
}

static void cloth_may_shrink(void **state) {
    (void)state;
    tulle_scene *const loaded = load_cloth(CLOTH("rest: {shrink: 0.9}"));
    const double wanted[] = {0, 0, 0, 0.9, 0, 0, 0.9, 0.9, 0, 0, 0.9, 0};
    assert_numbers(loaded->cloths->rest_positions, wanted, 12);
    assert_numbers(loaded->cloths->warps, (double[]){1, 0, 0, 1, 0, 0}, 6);
    tulle_scene_destroy(loaded);
}

/* What is at rest reaches the world: the same cloth, smaller at rest, draws together. */
static void worlds_are_built_so(void **state) {
    (void)state;
    tulle_scene *const loaded = load_cloth(
        TIME "membrane: woven\ngravity: [0, 0, 0]\ncloth: [{mesh: {file: m.obj}, rest: {uv: 0.4 "
             "m}, material: {air_damping: 20}}]\n");
    tulle_scene_world built;
    tulle_error error;
    assert_int_equal(tulle_scene_build_world(loaded, 1, NULL, &built, &error), TULLE_OK);
    for (int i = 0; i < 60; i++)
        assert_int_equal(tulle_world_step(built.world, 1.0 / 60.0, NULL, &error), TULLE_OK);
    const double *const at = tulle_cloth_get_positions(built.world, built.cloths[0], NULL);
    double const length = hypot(at[3] - at[0], at[4] - at[1]);
    assert_true(fabs(length - 0.8) < 1e-3);
    tulle_scene_destroy_world(&built);
    tulle_scene_destroy(loaded);
}

/* ---- regions ---- */

#define BOX "box: {min: [-1, -1, -1], max: [2, 2, 2]}"

static void regions_shrink_and_turn_the_warp(void **state) {
    (void)state;
    /* The second triangle, 0 2 3, is half as long; its warp lies along y. */
    tulle_scene *loaded =
        load_cloth(CLOTH("regions: [{vertices: [0, 2, 3], shrink: 0.5, grain: [0, 7, 0]}]"));
    const scene_cloth *cloth = loaded->cloths;
    double const corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0.5, 0.5, 0, 0, 0.5, 0};
    assert_numbers(cloth->rest_corners, corners, 18);
    assert_null(cloth->rest_positions);
    assert_false(cloth->has_flat_rest);
    assert_numbers(cloth->warps, (double[]){1, 0, 0, 0, 1, 0}, 6);
    tulle_scene_destroy(loaded);

    /* The last region counts; what shrinks as a whole shrinks beside it. */
    loaded = load_cloth(CLOTH("rest: {shrink: 0.9}, regions: [{" BOX ", shrink: 0.7}, "
                              "{vertices: [0-2], shrink: 0.8}]"));
    cloth = loaded->cloths;
    assert_numbers(cloth->rest_corners, (double[]){0, 0, 0, 0.72, 0, 0, 0.72, 0.72, 0}, 9);
    assert_numbers(cloth->rest_corners + 9, (double[]){0, 0, 0, 0.63, 0.63, 0, 0, 0.63, 0}, 9);
    tulle_scene_destroy(loaded);

    /* A grain alone leaves the rest shape; where the cloth lies by its pattern, regions go before.
     */
    loaded = load_cloth(CLOTH("regions: [{line: {from: [0, 0, 0], to: [1, 1, 0], radius: 0.8}, "
                              "grain: [0, 1, 0]}]"));
    cloth = loaded->cloths;
    assert_null(cloth->rest_corners);
    assert_numbers(cloth->warps, (double[]){0, 1, 0, 0, 1, 0}, 6);
    tulle_scene_destroy(loaded);
    loaded = load_cloth(CLOTH("rest: {uv: 0.5}, grain_uv: [1, 0], regions: [{vertices: [0, 2, 3], "
                              "grain: [1, 0, 0]}]"));
    assert_numbers(loaded->cloths->warps, (double[]){1, 0, 0, 0, 1, 0}, 6);
    tulle_scene_destroy(loaded);
}

static void triangles_may_be_stiffer_and_softer(void **state) {
    (void)state;
    tulle_scene *loaded = load_cloth(CLOTH("regions: [{" BOX ", shrink: 0.9}]"));
    assert_null(loaded->cloths->stiffness_factors);
    tulle_scene_destroy(loaded);
    loaded = load_cloth(CLOTH("regions: [{vertices: [0, 2, 3], stiffness: 20}]"));
    assert_numbers(loaded->cloths->stiffness_factors, (double[]){1, 20}, 2);
    assert_null(loaded->cloths->rest_corners);
    tulle_scene_destroy(loaded);

    /* A triangle takes the mean of its corners, and a region counts beside it. */
    write_text_file("w.txt", "# by vertex\n 1 2\n\n 3 # the third\n4");
    loaded = load_cloth(CLOTH("stiffness_file: w.txt"));
    assert_numbers(loaded->cloths->stiffness_factors, (double[]){2, 8.0 / 3.0}, 2);
    uint64_t const hash = tulle_scene_get_hash(loaded);
    tulle_scene_destroy(loaded);
    loaded = load_cloth(CLOTH("stiffness_file: w.txt, regions: [{vertices: [0-2], stiffness: 3}]"));
    assert_numbers(loaded->cloths->stiffness_factors, (double[]){6, 8.0 / 3.0}, 2);
    tulle_scene_destroy(loaded);
    write_text_file("w.txt", "1 2 3 5");
    loaded = load_cloth(CLOTH("stiffness_file: w.txt"));
    assert_true(tulle_scene_get_hash(loaded) != hash);

    /* They reach the world: under its weight a stiffer cloth stretches less. */
    double lengths[2];
    for (int i = 0; i < 2; i++) {
        tulle_scene_destroy(loaded);
        write_text_file("w.txt", i == 0 ? "1 1 1 1" : "50 50 50 50");
        loaded = load_cloth(TIME "gravity: [0, -500, 0]\ncloth: [{mesh: {file: m.obj}, pins: "
                                 "[{vertices: [2, 3]}], stiffness_file: w.txt}]\n");
        tulle_scene_world built;
        tulle_error error;
        assert_int_equal(tulle_scene_build_world(loaded, 1, NULL, &built, &error), TULLE_OK);
        for (int k = 0; k < 60; k++)
            assert_int_equal(tulle_world_step(built.world, 1.0 / 60.0, NULL, &error), TULLE_OK);
        const double *const at = tulle_cloth_get_positions(built.world, built.cloths[0], NULL);
        lengths[i] = at[10] - at[1] - 1.0;
        tulle_scene_destroy_world(&built);
    }
    assert_true(lengths[1] > 0.0 && lengths[0] > 10.0 * lengths[1]);
    tulle_scene_destroy(loaded);
}

static void creases_are_edges(void **state) {
    (void)state;
    tulle_scene *const loaded =
        load_cloth(CLOTH("rest: {creases: [{" BOX ", angle: 10 deg}, {line: {from: [0, 0, 0], to: "
                         "[1, 1, 0]}, angle: -0.5}]}"));
    const scene_cloth *const cloth = loaded->cloths;
    /* 0 1, 1 2, 0 2, 2 3 from lower to higher; 3 0 and 2 0 are not. Then the diagonal. */
    uint32_t const ends[] = {0, 1, 1, 2, 0, 2, 2, 3, 0, 2};
    assert_int_equal(cloth->crease_count, 5);
    for (size_t i = 0; i < 5; i++) {
        assert_memory_equal(cloth->creases[i].vertices, ends + 2 * i, 2 * sizeof(uint32_t));
        assert_true(fabs(cloth->creases[i].angle - (i < 4 ? 0.17453292519943295 : -0.5)) < 1e-15);
    }
    tulle_scene_destroy(loaded);
}

/* ---- notes ---- */

typedef struct noted {
    const char *scene, *mesh, *note; /* null: none */
} noted;

#define FOLDED SQUARE "vt 0 0\nvt 1 0\nvt 1 1\nvt 0.5 0\n"
static const noted notes[] = {
    {CLOTH("rest: {uv: 0.5 m}"), dressed, NULL},
    /* both halves share the texture coordinates of the diagonal */
    {CLOTH("rest: {uv: 1}"), FOLDED "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
     "folds over at 1 edges, as between triangle 0 (line 9 of the mesh) and triangle 1 (line 10"},
    /* the same places, but the second half is a piece of its own */
    {CLOTH("rest: {uv: 1}"), FOLDED "vt 1 1.01\nf 1/1 2/2 3/3\nf 1/1 3/5 4/4\n", NULL},
    {CLOTH("rest: {uv: 1}"),
     SQUARE "vt 0 0\nvt 1 0\nvt 1 1\nvt 5 5\nvt 5.3 5\nvt 5.3 5.3\nf 1/1 2/2 3/3\nf 1/4 3/5 4/6\n",
     "1 of 2 triangles are more than 2 times as long at rest as at the start, or as short; most of "
     "all triangle 1 (line 12 of the mesh), 0.3 times"},
    {CLOTH("rest: {uv: 1}"),
     SQUARE "vt 0 0\nvt 1 0\nvt 1 1\nvt 5 5\nvt 15 5\nvt 8 5.05\nf 1/1 2/2 3/3\nf 1/4 3/5 4/6\n",
     "1 triangles are needles at rest and none at the start, as triangle 1 (line 12 of the mesh)"},
};

static void odd_rest_shapes_are_noted(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof notes / sizeof notes[0]; i++) {
        write_text_file("m.obj", notes[i].mesh);
        tulle_scene *const loaded = load_good(notes[i].scene);
        size_t const count = tulle_scene_get_note_count(loaded);
        const char *const note = tulle_scene_get_note(loaded, 0);
        if (count != (notes[i].note != NULL) || (note && !strstr(note, notes[i].note)))
            fail_msg("mesh %zu has %zu notes, the first: %s", i, count, note ? note : "none");
        tulle_scene_destroy(loaded);
    }
}

/* ---- refusals ---- */

typedef struct refusal {
    const char *scene, *mesh, *rest; /* null: not written anew */
    int line, column;
    const char *message;
} refusal;

static const refusal refusals[] = {
    {CLOTH("rest: {uv: 1}"), SQUARE "f 1 2 3\nf 1 3 4\n", NULL, 3, 12, "no texture coordinates"},
    {CLOTH("grain_uv: [0, 1]"), SQUARE "f 1 2 3\nf 1 3 4\n", NULL, 3, 11, "no texture coordinates"},
    {CLOTH("rest: {uv: 1}"), SQUARE UVS "f 1/1 2/2 3/3\nf 1/4 3/5 4\n", NULL, 3, 12,
     "triangle 1 (line 12 of the mesh) has a corner without texture coordinates"},
    {CLOTH("grain_uv: [0, 1]"), SQUARE UVS "f 1/1 2/2 3/3\nf 1/4 3/4 4/4\n", NULL, 3, 11,
     "triangle 1 (line 12 of the mesh) has no area in the plane"},
    {CLOTH("grain_uv: [0, 0]"), dressed, NULL, 3, 11, "is not a direction"},
    {CLOTH("rest: {uv: 1 mm}"), dressed, NULL, 3, 1, "with uv: 0.5 m it would be as large"},
    {CLOTH("rest: {uv: 0}"), dressed, NULL, 3, 12, "must be above 0 m"},
    {CLOTH("rest: {creases: [{vertices: [1, 3], angle: 1}]}"), dressed, NULL, 3, 18,
     "cloth[0].rest.creases[0]: no edge has both its ends in it; the cloth begins within"},
    {CLOTH("rest: {creases: [{vertices: [1, 4], angle: 1}]}"), dressed, NULL, 3, 29,
     "names vertex 4, must be below 4"},
    {CLOTH("rest: {creases: [{vertices: [1, 2], angle: 4}]}"), dressed, NULL, 3, 44, "at most 3"},
    {CLOTH("regions: [{shrink: 0.9}]"), dressed, NULL, 3, 11, "vertices"},
    {CLOTH("regions: [{vertices: [0, 1], shrink: 0.9}]"), dressed, NULL, 3, 11,
     "cloth[0].regions[0]: no triangle has all its corners in it; the cloth begins within [0, 0, "
     "0]"},
    {CLOTH("regions: [{vertices: [9], shrink: 0.9}]"), dressed, NULL, 3, 22,
     "names vertex 9, must be below 4"},
    {CLOTH("regions: [{" BOX ", grain: [0, 0, 0]}]"), dressed, NULL, 3, 61, "is not a direction"},
    {CLOTH("regions: [{" BOX ", shrink: 0.1}]"), dressed, NULL, 3, 62,
     "must be at least 0.5 and at most 2"},
    {CLOTH("rest: {shrink: 3}"), dressed, NULL, 3, 16, "must be at least 0.5 and at most 2"},
    {CLOTH("rest: {uv: 1, file: r.obj}"), dressed, NULL, 3, 15, "only one of the keys file, uv"},
    {CLOTH("rest: {file: no.obj}"), dressed, NULL, 0, 0, "s.yaml:3:14"},
    {CLOTH("rest: {file: r.obj}"), dressed, "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", 3, 14,
     "has 1 triangles, the mesh has 2"},
    {CLOTH("regions: [{" BOX ", stiffness: 0}]"), dressed, NULL, 3, 65, "stiffness"},
    {CLOTH("regions: [{" BOX ", stiffness: 101}]"), dressed, NULL, 3, 65, "stiffness"},
    {CLOTH("stiffness_file: no.txt"), dressed, NULL, 0, 0, "s.yaml:3:1"},
    {CLOTH("stiffness_file: r.obj"), dressed, "1 1\n1 0\n", 2, 3,
     "of vertex 3 is '0'; it must be a number between 0.01 and 100"},
    {CLOTH("stiffness_file: r.obj"), dressed, "1 1 1 nan", 1, 7, "of vertex 3 is 'nan'"},
    {CLOTH("stiffness_file: r.obj"), dressed, "1 1\n1\n", 3, 0,
     "has 3 factors; the mesh has 4 vertices"},
    {CLOTH("stiffness_file: r.obj"), dressed, "1 1 1 1\n\n1", 3, 1,
     "more factors than the mesh has vertices (4)"},
    {CLOTH("rest: {file: r.obj}"), dressed, SQUARE "f 1 2 3\nf 3 4 1\n", 3, 14,
     "triangle 1 has the vertices 2, 3, 0, in the mesh it has 0, 2, 3"},
    {CLOTH("rest: {file: r.obj}"), dressed,
     "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nf 1 2 3\nf 1 3 4\n", 3, 1,
     "9 times as long at rest as at the start"},
};

static void refusals_name_their_place(void **state) {
    (void)state;
    size_t wrong_count = 0;
    for (size_t i = 0; i < sizeof refusals / sizeof refusals[0]; i++) {
        const refusal *const wanted = &refusals[i];
        write_text_file("m.obj", wanted->mesh);
        if (wanted->rest) write_text_file("r.obj", wanted->rest);
        tulle_scene_problems *const problems = calloc(1, sizeof *problems);
        assert_non_null(problems);
        assert_null(load_text(wanted->scene, problems));
        const tulle_error *const error = &problems->list[0];
        bool const is_as_wanted = problems->total_count == 1 && error->line == wanted->line &&
                                  error->column == wanted->column &&
                                  strstr(error->message, wanted->message);
        if (!is_as_wanted) {
            print_error("for:\n%s\nwanted %d:%d: ... %s ...\nfound:\n", wanted->scene, wanted->line,
                        wanted->column, wanted->message);
            scene_print_problems(problems, stderr);
        }
        wrong_count += !is_as_wanted;
        free(problems);
    }
    assert_int_equal(wrong_count, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_start_is_the_rest_shape),
        cmocka_unit_test(texture_coordinates_are_a_pattern),
        cmocka_unit_test(the_warp_may_follow_texture_coordinates_alone),
        cmocka_unit_test(a_rest_mesh_gives_lengths_and_folds),
        cmocka_unit_test(cloth_may_shrink),
        cmocka_unit_test(worlds_are_built_so),
        cmocka_unit_test(regions_shrink_and_turn_the_warp),
        cmocka_unit_test(triangles_may_be_stiffer_and_softer),
        cmocka_unit_test(creases_are_edges),
        cmocka_unit_test(odd_rest_shapes_are_noted),
        cmocka_unit_test(refusals_name_their_place),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
