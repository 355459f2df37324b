/* Arguments of the public functions of libtulle_io but those of runs, against files and a scene
 * that are good. */
#define _XOPEN_SOURCE 700
#include "io/io_support.h"

#include "api/arguments.h"
#include "tulle_io/tulle_io.h"

static double square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
static tulle_mesh_view const sheet = {square, 4, corners, 2};
static tulle_mesh_view const bad_views[] = {{NULL, 4, corners, 2}, {square, 4, NULL, 2}};

static const char scene_text[] =
    "time: {step: 0.01 s, frames: 2}\n"
    "cloth:\n"
    "  - mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [4, 4]}\n"
    "    translate: [0, 0, 0.2]\n"
    "obstacles:\n"
    "  - mesh: {shape: plane, size: [2, 2]}\n";

static tulle_scene_problems problems; /* large */
static tulle_scene *scene;
static tulle_subdivision *subdivision;
static const char *mesh_path, *cache_path, *vtp_path, *scene_path;
static double positions[12]; /* of whatever is read */

static int set_up(void **state) {
    make_test_folder(state);
    mesh_path = test_path("mesh.obj");
    cache_path = test_path("cache.pc2");
    vtp_path = test_path("mesh.vtp");
    scene_path = test_path("scene.yaml");
    FINE(tulle_mesh_write(mesh_path, sheet, &error));
    FINE(tulle_vtp_write(vtp_path, sheet, NULL, &error));
    FINE(tulle_file_write(scene_path, scene_text, strlen(scene_text), &error));
    tulle_pc2_writer *writer = NULL;
    FINE(tulle_pc2_writer_open(cache_path, 4, 0, &writer, &error));
    FINE(tulle_pc2_writer_append(writer, square, &error));
    FINE(tulle_pc2_writer_close(writer, &error));
    if (tulle_scene_load(scene_path, NULL, 0, &scene, &problems) != TULLE_OK)
        fail_msg("%s", problems.list[0].message);
    tulle_subdivision_def const def = tulle_subdivision_def_default();
    FINE(tulle_subdivision_create(sheet, &def, &subdivision, &error));
    return 0;
}

static int tear_down(void **state) {
    tulle_scene_destroy(scene);
    tulle_subdivision_destroy(subdivision);
    return remove_test_folder(state);
}

/* ---- point caches ---- */

ARGUMENTS_OF(tulle_pc2_open) {
    tulle_pc2 *cache = NULL;
    tulle_pc2_info info;
    REFUSED(tulle_pc2_open(NULL, &cache, &info, &error));
    REFUSED(tulle_pc2_open(cache_path, NULL, &info, &error));
    FINE(tulle_pc2_open(cache_path, &cache, NULL, NULL));
    tulle_pc2_close(cache);
}

ARGUMENTS_OF(tulle_pc2_read_frame) {
    tulle_pc2 *cache = NULL;
    FINE(tulle_pc2_open(cache_path, &cache, NULL, &error));
    REFUSED(tulle_pc2_read_frame(NULL, 0, positions, &error));
    REFUSED(tulle_pc2_read_frame(cache, 0, NULL, &error));
    REFUSED(tulle_pc2_read_frame(cache, 1, positions, &error));
    REFUSED(tulle_pc2_read_frame(cache, UINT32_MAX, positions, &error));
    FINE(tulle_pc2_read_frame(cache, 0, positions, NULL));
    tulle_pc2_close(cache);
}

ARGUMENTS_OF(tulle_pc2_get_time) {
    tulle_pc2 *cache = NULL;
    double time = 0.0;
    FINE(tulle_pc2_open(cache_path, &cache, NULL, &error));
    REFUSED(tulle_pc2_get_time(NULL, 0, &time, &error));
    REFUSED(tulle_pc2_get_time(cache, 0, NULL, &error));
    REFUSED(tulle_pc2_get_time(cache, 1, &time, &error));
    REFUSED(tulle_pc2_get_time(cache, UINT32_MAX, &time, &error));
    FINE(tulle_pc2_get_time(cache, 0, &time, NULL));
    assert_true(isnan(time));
    tulle_pc2_close(cache);
}

ARGUMENTS_OF(tulle_pc2_close) { tulle_pc2_close(NULL); }

ARGUMENTS_OF(tulle_pc2_writer_open) {
    const char *const path = test_path("written.pc2");
    tulle_pc2_writer *writer = NULL;
    REFUSED(tulle_pc2_writer_open(NULL, 4, 0, &writer, &error));
    REFUSED(tulle_pc2_writer_open(path, 4, 0, NULL, &error));
    REFUSED(tulle_pc2_writer_open(path, 0, 0, &writer, &error));
    REFUSED(tulle_pc2_writer_open(path, UINT32_MAX, 0, &writer, &error));
    REFUSED_WITH(TULLE_ERROR_PARSE,
                 tulle_pc2_writer_open(cache_path, 4, UINT32_MAX, &writer, &error));
    assert_null(writer);
}

ARGUMENTS_OF(tulle_pc2_writer_append) {
    tulle_pc2_writer *writer = NULL;
    FINE(tulle_pc2_writer_open(test_path("appended.pc2"), 4, 0, &writer, &error));
    REFUSED(tulle_pc2_writer_append(NULL, square, &error));
    REFUSED(tulle_pc2_writer_append(writer, NULL, &error));
    for (int i = 0; i < NO_NUMBER_COUNT; i++) {
        double bad[12];
        memcpy(bad, square, sizeof bad);
        bad[7] = no_numbers[i];
        REFUSED(tulle_pc2_writer_append(writer, bad, &error));
    }
    FINE(tulle_pc2_writer_append(writer, square, NULL));
    FINE(tulle_pc2_writer_close(writer, NULL));
}

ARGUMENTS_OF(tulle_pc2_writer_defer_flush) { tulle_pc2_writer_defer_flush(NULL); }
ARGUMENTS_OF(tulle_pc2_writer_close) { FINE(tulle_pc2_writer_close(NULL, NULL)); }

/* ---- mesh files ---- */

ARGUMENTS_OF(tulle_mesh_read) {
    tulle_mesh mesh;
    REFUSED(tulle_mesh_read(NULL, &mesh, &error));
    REFUSED(tulle_mesh_read(mesh_path, NULL, &error));
    FINE(tulle_mesh_read(mesh_path, &mesh, NULL));
    tulle_mesh_destroy(&mesh);
}

ARGUMENTS_OF(tulle_mesh_read_source) {
    tulle_mesh mesh;
    tulle_mesh_source source;
    REFUSED(tulle_mesh_read_source(NULL, &mesh, &source, &error));
    REFUSED(tulle_mesh_read_source(mesh_path, NULL, &source, &error));
    assert_null(source.vertex_lines);
    FINE(tulle_mesh_read_source(mesh_path, &mesh, NULL, NULL));
    tulle_mesh_destroy(&mesh);
}

ARGUMENTS_OF(tulle_mesh_source_destroy) {
    tulle_mesh_source empty = {0};
    tulle_mesh_source_destroy(NULL);
    tulle_mesh_source_destroy(&empty);
}

ARGUMENTS_OF(tulle_mesh_write) {
    static const char *const names[] = {"w.obj", "w.ply", "w.stl"};
    REFUSED(tulle_mesh_write(NULL, sheet, &error));
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 2; k++)
            REFUSED(tulle_mesh_write(test_path(names[i]), bad_views[k], &error));
    for (int i = 0; i < 3; i++) assert_int_not_equal(access(test_path(names[i]), F_OK), 0);
    uint32_t const high[3] = {0, 1, UINT32_MAX};
    tulle_mesh_view const outside = {square, 4, high, 1};
    REFUSED_WITH(TULLE_ERROR_INVALID_MESH, tulle_mesh_write(test_path(names[0]), outside, &error));
}

ARGUMENTS_OF(tulle_vtp_read) {
    tulle_mesh mesh;
    tulle_vtp_passed_over passed;
    REFUSED(tulle_vtp_read(NULL, &mesh, &passed, &error));
    REFUSED(tulle_vtp_read(vtp_path, NULL, &passed, &error));
    FINE(tulle_vtp_read(vtp_path, &mesh, NULL, NULL));
    tulle_mesh_destroy(&mesh);
}

ARGUMENTS_OF(tulle_vtp_write) {
    REFUSED(tulle_vtp_write(NULL, sheet, NULL, &error));
    for (int k = 0; k < 2; k++) {
        const char *const path = test_path("w.vtp");
        REFUSED(tulle_vtp_write(path, bad_views[k], NULL, &error));
        assert_int_not_equal(access(path, F_OK), 0);
    }
}

ARGUMENTS_OF(tulle_pvd_write) {
    const char *const path = test_path("w.pvd");
    const char *const files[2] = {"a.vtp", NULL};
    double const times[2] = {0, 1};
    REFUSED(tulle_pvd_write(NULL, files, times, 1, &error));
    REFUSED(tulle_pvd_write(path, NULL, times, 1, &error));
    REFUSED(tulle_pvd_write(path, files, NULL, 1, &error));
    REFUSED(tulle_pvd_write(path, files, times, 2, &error));
    assert_int_not_equal(access(path, F_OK), 0);
    FINE(tulle_pvd_write(path, NULL, NULL, 0, NULL));
}

ARGUMENTS_OF(tulle_file_write) {
    REFUSED(tulle_file_write(NULL, "a", 1, &error));
    REFUSED(tulle_file_write(test_path("bytes"), NULL, 1, &error));
    assert_int_not_equal(access(test_path("bytes"), F_OK), 0);
    FINE(tulle_file_write(test_path("bytes"), NULL, 0, NULL));
}

/* ---- scenes ---- */

static void refuse_scene(const char *path, const char *const *overrides, size_t count) {
    tulle_scene *loaded = NULL;
    assert_int_equal(tulle_scene_load(path, overrides, count, &loaded, &problems),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_null(loaded);
    assert_int_equal(problems.count, 1);
    assert_true(problems.list[0].message[0] != '\0');
}

ARGUMENTS_OF(tulle_scene_load) {
    const char *const overrides[2] = {"time.frames=3", NULL};
    tulle_scene *loaded = NULL;
    refuse_scene(NULL, NULL, 0);
    refuse_scene(scene_path, NULL, 1);
    refuse_scene(scene_path, overrides, 2);
    assert_int_equal(tulle_scene_load(scene_path, NULL, 0, NULL, &problems),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_scene_load(scene_path, NULL, 0, &loaded, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_null(loaded);
}

ARGUMENTS_OF(tulle_scene_destroy) { tulle_scene_destroy(NULL); }

/* Functions that give a number of a scene: 0 for null. */
#define NUMBER_OF_SCENE(name)                                                                      \
    ARGUMENTS_OF(name) {                                                                           \
        (void)unused;                                                                              \
        assert_true(name(NULL) == 0);                                                              \
        (void)name(scene);                                                                         \
    }
NUMBER_OF_SCENE(tulle_scene_get_note_count)
NUMBER_OF_SCENE(tulle_scene_get_frame_count)
NUMBER_OF_SCENE(tulle_scene_get_steps_per_frame)
NUMBER_OF_SCENE(tulle_scene_get_seed)
NUMBER_OF_SCENE(tulle_scene_get_cloth_count)
NUMBER_OF_SCENE(tulle_scene_get_obstacle_count)
NUMBER_OF_SCENE(tulle_scene_get_hash)

ARGUMENTS_OF(tulle_scene_get_time_step) { assert_true(tulle_scene_get_time_step(NULL) == 0.0); }
ARGUMENTS_OF(tulle_scene_get_start_intersections) {
    assert_int_equal(tulle_scene_get_start_intersections(NULL), TULLE_START_REFUSE);
}
ARGUMENTS_OF(tulle_scene_get_path) { assert_null(tulle_scene_get_path(NULL)); }
ARGUMENTS_OF(tulle_scene_get_canonical_text) { assert_null(tulle_scene_get_canonical_text(NULL)); }

typedef const char *(*text_of_scene)(const tulle_scene *, size_t);
static void check_text_of_scene(text_of_scene get, size_t count) {
    assert_null(get(NULL, 0));
    assert_null(get(scene, count));
    assert_null(get(scene, SIZE_MAX));
}

ARGUMENTS_OF(tulle_scene_get_note) {
    check_text_of_scene(tulle_scene_get_note, tulle_scene_get_note_count(scene));
}
ARGUMENTS_OF(tulle_scene_get_cloth_name) {
    check_text_of_scene(tulle_scene_get_cloth_name, 1);
    assert_non_null(tulle_scene_get_cloth_name(scene, 0));
}
ARGUMENTS_OF(tulle_scene_get_obstacle_name) {
    check_text_of_scene(tulle_scene_get_obstacle_name, 1);
    assert_non_null(tulle_scene_get_obstacle_name(scene, 0));
}

typedef tulle_mesh_view (*mesh_of_scene)(const tulle_scene *, size_t);
static void check_mesh_of_scene(mesh_of_scene get) {
    assert_true(!get(NULL, 0).positions && get(NULL, 0).vertex_count == 0);
    assert_true(!get(scene, 1).positions && get(scene, SIZE_MAX).triangle_count == 0);
    assert_non_null(get(scene, 0).positions);
}

ARGUMENTS_OF(tulle_scene_get_cloth_mesh) { check_mesh_of_scene(tulle_scene_get_cloth_mesh); }
ARGUMENTS_OF(tulle_scene_get_obstacle_mesh) { check_mesh_of_scene(tulle_scene_get_obstacle_mesh); }
ARGUMENTS_OF(tulle_scene_is_obstacle_moving) {
    assert_int_equal(tulle_scene_is_obstacle_moving(NULL, 0), 0);
    assert_int_equal(tulle_scene_is_obstacle_moving(scene, SIZE_MAX), 0);
}
ARGUMENTS_OF(tulle_scene_is_obstacle_dynamic) {
    assert_int_equal(tulle_scene_is_obstacle_dynamic(NULL, 0), 0);
    assert_int_equal(tulle_scene_is_obstacle_dynamic(scene, SIZE_MAX), 0);
}

ARGUMENTS_OF(tulle_scene_build_world) {
    tulle_scene_world built;
    REFUSED(tulle_scene_build_world(NULL, 1, NULL, &built, &error));
    assert_null(built.world);
    REFUSED(tulle_scene_build_world(scene, 1, NULL, NULL, &error));
    int const threads[] = {-1, 257, INT_MIN, INT_MAX};
    for (int i = 0; i < 4; i++)
        REFUSED(tulle_scene_build_world(scene, threads[i], NULL, &built, &error));
    assert_int_equal(tulle_scene_build_world(scene, -1, NULL, &built, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    FINE(tulle_scene_build_world(scene, 1, NULL, &built, NULL));
    tulle_scene_destroy_world(&built);
}
ARGUMENTS_OF(tulle_scene_destroy_world) {
    tulle_scene_world empty = {0};
    tulle_scene_destroy_world(NULL);
    tulle_scene_destroy_world(&empty);
}

/* ---- subdivision ---- */

ARGUMENTS_OF(tulle_subdivision_def_default) {
    assert_true(tulle_subdivision_def_default().cookie != 0);
}

ARGUMENTS_OF(tulle_subdivision_create) {
    tulle_subdivision_def def = tulle_subdivision_def_default();
    tulle_subdivision *made = NULL;
    REFUSED(tulle_subdivision_create(sheet, NULL, &made, &error));
    REFUSED(tulle_subdivision_create(sheet, &def, NULL, &error));
    for (int k = 0; k < 2; k++)
        REFUSED(tulle_subdivision_create(bad_views[k], &def, &made, &error));
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        def.levels = no_choices[i];
        REFUSED(tulle_subdivision_create(sheet, &def, &made, &error));
    }
    double const angles[] = {(double)NAN, -1.0, 0.0, -(double)INFINITY};
    for (int i = 0; i < 4; i++) {
        def = tulle_subdivision_def_default();
        def.crease_angle = angles[i];
        REFUSED(tulle_subdivision_create(sheet, &def, &made, &error));
        def = tulle_subdivision_def_default();
        def.corner_angle = angles[i];
        REFUSED(tulle_subdivision_create(sheet, &def, &made, &error));
    }
    uint32_t const edge[2] = {0, UINT32_MAX};
    def = tulle_subdivision_def_default();
    def.crease_edge_count = 1;
    REFUSED(tulle_subdivision_create(sheet, &def, &made, &error));
    def.crease_edges = edge;
    REFUSED(tulle_subdivision_create(sheet, &def, &made, &error));
    assert_null(made);
}

ARGUMENTS_OF(tulle_subdivision_destroy) { tulle_subdivision_destroy(NULL); }
ARGUMENTS_OF(tulle_subdivision_get_vertex_count) {
    assert_int_equal(tulle_subdivision_get_vertex_count(NULL), 0);
}
ARGUMENTS_OF(tulle_subdivision_get_triangle_count) {
    assert_int_equal(tulle_subdivision_get_triangle_count(NULL), 0);
}
ARGUMENTS_OF(tulle_subdivision_get_triangles) {
    assert_null(tulle_subdivision_get_triangles(NULL));
}
ARGUMENTS_OF(tulle_subdivision_get_parent_triangle) {
    size_t const count = tulle_subdivision_get_triangle_count(subdivision);
    assert_int_equal(tulle_subdivision_get_parent_triangle(NULL, 0), TULLE_NONE);
    assert_int_equal(tulle_subdivision_get_parent_triangle(subdivision, (uint32_t)count),
                     TULLE_NONE);
    assert_int_equal(tulle_subdivision_get_parent_triangle(subdivision, UINT32_MAX), TULLE_NONE);
    assert_int_equal(tulle_subdivision_get_parent_triangle(subdivision, (uint32_t)count - 1), 1);
}

ARGUMENTS_OF(tulle_subdivision_apply) {
    double result[3 * 64];
    assert_true(tulle_subdivision_get_vertex_count(subdivision) <= 64);
    REFUSED(tulle_subdivision_apply(NULL, square, 3, result, &error));
    REFUSED(tulle_subdivision_apply(subdivision, NULL, 3, result, &error));
    REFUSED(tulle_subdivision_apply(subdivision, square, 3, NULL, &error));
    REFUSED(tulle_subdivision_apply(subdivision, square, 0, result, &error));
    REFUSED(tulle_subdivision_apply(subdivision, square, SIZE_MAX, result, &error));
    FINE(tulle_subdivision_apply(subdivision, square, 3, result, NULL));
}

ARGUMENTS_OF(tulle_subdivision_make_mesh) {
    tulle_mesh mesh;
    REFUSED(tulle_subdivision_make_mesh(NULL, square, &mesh, &error));
    REFUSED(tulle_subdivision_make_mesh(subdivision, NULL, &mesh, &error));
    assert_null(mesh.positions);
    REFUSED(tulle_subdivision_make_mesh(subdivision, square, NULL, &error));
}

int main(void) {
    return run_arguments(HEADERS("tulle_io/cache.h", "tulle_io/mesh_files.h", "tulle_io/scene.h",
                                 "tulle_io/subdivision.h"),
                         set_up, tear_down);
}
