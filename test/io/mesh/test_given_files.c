/* Real mesh files that no one here made, from TULLE_DATA_DIR: all are read and survive a round
 * trip. Skipped without that folder. */
#define _XOPEN_SOURCE 700
#include "io/io_support.h"
#include "tulle_io/mesh_files.h"

static const char *data_folder;

typedef struct given_file {
    const char *name;
    size_t vertex_count, triangle_count;
} given_file;

static const given_file given_files[] = {
    {"body/body_40.obj", 12811, 25472},    {"body/body_41.obj", 12811, 25472},
    {"body/body_42.obj", 12811, 25472},    {"body/body_43.obj", 12811, 25472},
    {"body/body_44.obj", 12811, 25472},    {"body/body_45.obj", 12811, 25472},
    {"obstacles/cone.obj", 1152, 2176},    {"obstacles/funnel.obj", 288, 552},
    {"obstacles/hammer.obj", 2107, 4090},  {"obstacles/pyramid.obj", 6, 8},
    {"obstacles/spot.obj", 2930, 5856},    {"obstacles/wedge.obj", 3, 1},
    {"synthetic/cring_t0.obj", 847, 1440}, {"synthetic/cring_t1.obj", 847, 1440},
    {"synthetic/ramp_t0.obj", 1078, 1940}, {"synthetic/ramp_t1.obj", 1078, 1940},
    {"table/table.obj", 6712, 13420},      {"table/tableCloth.obj", 14161, 27848},
};

static void given_files_are_read(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof given_files / sizeof given_files[0]; i++) {
        const given_file *const given = &given_files[i];
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", data_folder, given->name);
        tulle_mesh mesh = {0};
        tulle_error error = {0};
        if (tulle_mesh_read(path, &mesh, &error))
            fail_msg("%s:%d:%d: %s", path, error.line, error.column, error.message);
        assert_int_equal(mesh.vertex_count, given->vertex_count);
        assert_int_equal(mesh.triangle_count, given->triangle_count);
        tulle_mesh again = {0};
        const char *const copy = test_path(i % 2 ? "copy.obj" : "copy.ply");
        assert_int_equal(tulle_mesh_write(copy, tulle_mesh_get_view(&mesh), NULL), TULLE_OK);
        assert_int_equal(tulle_mesh_read(copy, &again, NULL), TULLE_OK);
        assert_int_equal(again.vertex_count, mesh.vertex_count);
        assert_memory_equal(again.positions, mesh.positions, mesh.vertex_count * 24);
        assert_memory_equal(again.triangles, mesh.triangles, mesh.triangle_count * 12);
        tulle_mesh_destroy(&mesh);
        tulle_mesh_destroy(&again);
    }
}

int main(void) {
    data_folder = getenv("TULLE_DATA_DIR");
    struct stat facts;
    if (!data_folder || stat(data_folder, &facts) != 0) {
        printf("skipped: TULLE_DATA_DIR names no folder\n");
        return 77;
    }
    const struct CMUnitTest tests[] = {cmocka_unit_test(given_files_are_read)};
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
