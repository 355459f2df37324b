/* Materials of scenes: what stands for both yarns and what for one, material files, and every
 * refusal with its place. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_data.h"
#include "scene_text.h"

#include <math.h>

/* A cloth with this material, on line 2; `material` begins at column 47. */
#define SCENE(material)                                                                            \
    "time: {frames: 3}\ncloth: [{mesh: {shape: rectangle}, material: " material "}]\n"

static tulle_material make_preset(const char *name) {
    tulle_material material;
    assert_int_equal(tulle_material_preset(name, &material), TULLE_OK);
    return material;
}

static void check_material(const char *scene, tulle_material wanted, const char *name) {
    tulle_scene *const loaded = load_good(scene);
    /* Their members are doubles alone, so equal values have equal bytes. */
    assert_memory_equal(&loaded->cloths[0].material, &wanted, sizeof wanted);
    assert_string_equal(loaded->cloths[0].contact_material, name);
    tulle_scene_destroy(loaded);
}

static void keys_replace_values_of_the_preset(void **state) {
    (void)state;
    tulle_material silk = make_preset("silk");
    check_material(SCENE("{preset: silk}"), silk, "silk");
    silk.warp.limit = 0.25;
    silk.shear.stiffness = 40.0;
    silk.bend_weft = 3e-6;
    silk.poisson = -0.2;
    check_material(SCENE("{preset: silk, warp: {limit: 25 %}, shear: {stiffness: 40}, bend_weft: 3 "
                         "uN m, poisson: -0.2}"),
                   silk, "silk");
    tulle_material cotton = make_preset("cotton");
    cotton.bend_hysteresis_warp = 5e-4;
    cotton.bend_hysteresis_weft = 3e-4;
    cotton.shear_hysteresis = 200.0;
    check_material(SCENE("{bend_hysteresis_warp: 0.5 mN, bend_hysteresis_weft: 3e-4, "
                         "shear_hysteresis: 2 N/cm}"),
                   cotton, "cotton");
}

static void every_preset_is_known_by_its_name(void **state) {
    (void)state;
    const char *name;
    for (size_t i = 0; (name = tulle_material_preset_name(i)); i++) {
        char scene[200];
        snprintf(scene, sizeof scene, SCENE("{preset: %s}"), name);
        check_material(scene, make_preset(name), name);
    }
}

/* A run with hysteresis goes on as one with the same alone. */
static void the_hash_of_a_scene_knows_hysteresis(void **state) {
    (void)state;
    static const char *const scenes[] = {
        SCENE("{}"), SCENE("{bend_hysteresis_warp: 1e-4}"), SCENE("{bend_hysteresis_weft: 1e-4}"),
        SCENE("{shear_hysteresis: 1}"), SCENE("{shear_hysteresis: 2}")};
    enum { COUNT = sizeof scenes / sizeof scenes[0] };
    uint64_t hashes[COUNT];
    for (int i = 0; i < COUNT; i++) {
        tulle_scene *const loaded = load_good(scenes[i]);
        hashes[i] = loaded->hash;
        tulle_scene_destroy(loaded);
        for (int k = 0; k < i; k++) assert_true(hashes[k] != hashes[i]);
    }
}

static void short_keys_go_before_those_of_one_direction(void **state) {
    (void)state;
    tulle_material cotton = make_preset("cotton");
    cotton.warp.stiffness = cotton.weft.stiffness = cotton.springs.stretch_stiffness = 5000.0;
    cotton.warp.knee = cotton.weft.knee = cotton.springs.stiffening_strain = 0.1;
    cotton.bend_warp = cotton.bend_weft = cotton.springs.bend_stiffness = 2e-5;
    cotton.bend_twist = 1e-5;
    check_material(SCENE("{stretch: 5 kN/m, stiffening_strain: 0.1, bend: 2e-5}"), cotton,
                   "cotton");
    cotton.weft.stiffness = 100.0;
    cotton.warp.knee = 0.0;
    cotton.bend_twist = 0.0;
    check_material(SCENE("{bend_twist: 0, warp: {knee: 0}, weft: {stiffness: 100}, stretch: 5 "
                         "kN/m, stiffening_strain: 0.1, bend: 2e-5}"),
                   cotton, "cotton");
}

static void a_file_stands_in_for_the_preset(void **state) {
    (void)state;
    write_text_file("f.yaml", "name: felt\npreset: wool\nsource: 'typed in: page 3'\n"
                              "area_density: 200 gsm\nshear: {stiffness: 1 gf/cm/deg}\n"
                              "bend_warp: 0.1 gf cm^2/cm\n");
    tulle_material felt = make_preset("wool");
    felt.area_density = 0.2;
    felt.shear.stiffness = 9.80665e-3 / 1e-2 / 0.017453292519943295;
    felt.bend_warp = 9.80665e-3 * 1e-2 * 0.1;
    tulle_scene *const loaded = load_good(SCENE("{file: f.yaml}"));
    const tulle_material *const found = &loaded->cloths[0].material;
    assert_true(fabs(found->shear.stiffness - felt.shear.stiffness) < 1e-12);
    assert_true(fabs(found->bend_warp - felt.bend_warp) < 1e-19);
    felt.shear.stiffness = found->shear.stiffness;
    felt.bend_warp = found->bend_warp;
    uint64_t const first = loaded->hash;
    tulle_scene_destroy(loaded);
    check_material(SCENE("{file: f.yaml}"), felt, "felt");
    felt.friction = 0.1;
    check_material(SCENE("{file: f.yaml, name: loden, friction: 0.1}"), felt, "loden");

    /* A run of the file as it was is not one of the file as it is. */
    write_text_file("f.yaml", "name: felt\npreset: wool\n");
    tulle_scene *const later = load_good(SCENE("{file: f.yaml}"));
    assert_true(later->hash != first);
    tulle_scene_destroy(later);
}

static void a_file_is_read_alone(void **state) {
    (void)state;
    char path[128];
    tulle_scene_problems *const problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    write_text_file("f.yaml", "preset: wool\nbend_weft: 2e-5\nfriction: 0.1\n");
    snprintf(path, sizeof path, "%s/f.yaml", folder_path);
    tulle_material wool = make_preset("wool"), found;
    wool.bend_weft = 2e-5;
    wool.friction = 0.1;
    assert_int_equal(scene_load_material(path, &found, problems), TULLE_OK);
    assert_memory_equal(&found, &wool, sizeof found);
    assert_int_equal(problems->total_count, 0);
    write_text_file("f.yaml", "preset: wool\nbend_weft: -1\n");
    assert_int_equal(scene_load_material(path, &found, problems), TULLE_ERROR_INVALID_ARGUMENT);
    assert_string_equal(problems->list[0].file, path);
    assert_int_equal(problems->list[0].line, 2);
    assert_memory_equal(&found, &wool, sizeof found); /* as it was */
    snprintf(path, sizeof path, "%s/none.yaml", folder_path);
    assert_int_equal(scene_load_material(path, &found, problems), TULLE_ERROR_IO);
    free(problems);
}

typedef struct refusal {
    const char *scene, *file; /* null: none is written */
    const char *place;        /* the file that is at fault */
    int line, column;
    const char *message;
} refusal;

static const refusal refusals[] = {
    {SCENE("{preset: cottn}"), NULL, "s.yaml", 2, 55, "did you mean 'cotton'?"},
    {SCENE("{warp: 5}"), NULL, "s.yaml", 2, 53, "cloth[0].material.warp: is"},
    {SCENE("{warp: {stiffness: 0}}"), NULL, "s.yaml", 2, 65, "must be above 0 N/m"},
    {SCENE("{shear: {knee: -1}}"), NULL, "s.yaml", 2, 61, "must be at least 0 and"},
    {SCENE("{weft: {limit: 0}}"), NULL, "s.yaml", 2, 61, "must be at least 0.001 and"},
    {SCENE("{poisson: 0.95}"), NULL, "s.yaml", 2, 56, "must be at least -0.9 and at most 0.9"},
    {SCENE("{bend_twist: 5 gf/cm}"), NULL, "s.yaml", 2, 59, "gf cm^2/cm"},
    {SCENE("{shear_hysteresis: 1 gf/cm/deg}"), NULL, "s.yaml", 2, 65, "gf/cm"},
    {SCENE("{bend_hysteresis_warp: -1}"), NULL, "s.yaml", 2, 69, "must be at least 0"},
    {SCENE("{file: none.yaml}"), NULL, "s.yaml", 2, 53, "none.yaml' cannot be opened"},
    {SCENE("{file: f.yaml}"), "area_density: -1\n", "f.yaml", 1, 15, "must be above 0"},
    {SCENE("{file: f.yaml}"), "warp: {stifness: 1}\n", "f.yaml", 1, 8, "did you mean 'stiffness'?"},
    {SCENE("{file: f.yaml}"), "preset: iron\n", "f.yaml", 1, 9, "must be one of"},
    {SCENE("{file: f.yaml}"), "file: g.yaml\n", "f.yaml", 1, 7, "cannot name another one"},
    {SCENE("{file: f.yaml}"), "friction: 0.1\ndynamic_friction: 0.3\n", "f.yaml", 2, 19,
     "must be at most friction"},
    {SCENE("{file: f.yaml}"), "a: [\n", "f.yaml", 2, 1, "not valid YAML"},
    {SCENE("{file: f.yaml}"), "", "f.yaml", 0, 0, "the file is empty"},
    {SCENE("{file: f.yaml}"), "- 1\n", "f.yaml", 1, 1, "material: is a list"},
    {SCENE("{file: f.yaml, preset: silk}"), "name: x\n", "s.yaml", 2, 47,
     "may have only one of the keys file, preset"},
};

static void refusals_name_file_line_and_column(void **state) {
    (void)state;
    size_t wrong_count = 0;
    for (size_t i = 0; i < sizeof refusals / sizeof refusals[0]; i++) {
        const refusal *const wanted = &refusals[i];
        if (wanted->file) write_text_file("f.yaml", wanted->file);
        tulle_scene_problems *const problems = calloc(1, sizeof *problems);
        assert_non_null(problems);
        assert_null(load_text(wanted->scene, problems));
        const tulle_error *const error = &problems->list[0];
        bool const is_as_wanted = problems->total_count == 1 &&
                                  strstr(error->file, wanted->place) &&
                                  error->line == wanted->line && error->column == wanted->column &&
                                  strstr(error->message, wanted->message);
        if (!is_as_wanted) {
            print_error("for:\n%s%s\nwanted %s:%d:%d: ... %s ...\nfound:\n", wanted->scene,
                        wanted->file ? wanted->file : "", wanted->place, wanted->line,
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
        cmocka_unit_test(keys_replace_values_of_the_preset),
        cmocka_unit_test(every_preset_is_known_by_its_name),
        cmocka_unit_test(the_hash_of_a_scene_knows_hysteresis),
        cmocka_unit_test(short_keys_go_before_those_of_one_direction),
        cmocka_unit_test(a_file_stands_in_for_the_preset),
        cmocka_unit_test(a_file_is_read_alone),
        cmocka_unit_test(refusals_name_file_line_and_column),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
