/* How tight both rules of cones are on real steps: a moving body and a falling cloth that no one
 * here made. Reads TULLE_DATA_DIR; exit code 77 without it. */
#include "support/cone_tightness.h"
#include "tulle/mesh.h"
#include "tulle_io/mesh_files.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const char *data_path;

static tulle_mesh read_mesh(const char *name) {
    char path[2048];
    snprintf(path, sizeof path, "%s/%s", data_path, name);
    tulle_mesh mesh = {0};
    tulle_error error = {0};
    if (tulle_mesh_read(path, &mesh, &error)) fail_msg("%s: %s", path, error.message);
    return mesh;
}

/* Every seventh triangle: the best cone takes a millisecond to search. */
static tightness measure_step(const char *start_name, const char *end_name) {
    tulle_mesh start = read_mesh(start_name), end = read_mesh(end_name);
    assert_int_equal(start.triangle_count, end.triangle_count);
    assert_memory_equal(start.triangles, end.triangles, 12 * start.triangle_count);
    tightness row = {0};
    for (size_t t = 0; t < start.triangle_count; t += 7) {
        vec3 corners[2][3];
        for (size_t k = 0; k < 3; k++) {
            corners[0][k] = vec3_load(start.positions, start.triangles[3 * t + k]);
            corners[1][k] = vec3_load(end.positions, end.triangles[3 * t + k]);
        }
        add_triangle(&row, corners[0], corners[1]);
    }
    tulle_mesh_destroy(&start);
    tulle_mesh_destroy(&end);
    finish_row(&row, start_name);
    return row;
}

static void real_steps_gain_by_bernstein_cones(void **state) {
    (void)state;
    static const struct {
        const char *start, *end;
        double paper, bernstein; /* [degrees] the figures that decided; 0: none */
    } steps[] = {
        {"body/body_40.obj", "body/body_41.obj", 4.8, 1.5},
        {"body/body_41.obj", "body/body_42.obj", 4.6, 1.6},
        {"body/body_40.obj", "body/body_45.obj", 0.0, 0.0},
        {"cloth-funnel/frames/227.ply", "cloth-funnel/frames/228.ply", 0.0, 0.0},
    };
    print_tightness_header();
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        tightness const row = measure_step(steps[i].start, steps[i].end);
        assert_true(row.bernstein < 0.6 * row.paper);
        assert_true(row.bernstein < 1.2 * row.best);
        if (steps[i].paper == 0.0) continue;
        assert_true(fabs(row.paper - steps[i].paper) < 0.2);
        assert_true(fabs(row.bernstein - steps[i].bernstein) < 0.1);
    }
}

int main(void) {
    data_path = getenv("TULLE_DATA_DIR");
    FILE *const file = data_path ? fopen(data_path, "r") : NULL;
    if (!file) {
        printf("skipped: TULLE_DATA_DIR names no folder\n");
        return 77;
    }
    fclose(file);
    const struct CMUnitTest tests[] = {cmocka_unit_test(real_steps_gain_by_bernstein_cones)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
