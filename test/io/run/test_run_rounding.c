/* Frames of a run as its files hold them: rounding to float may lead no surface through another or
 * itself, also where none intersects afterwards. */
#define _DEFAULT_SOURCE
#include "io/run_support.h"

#include "tulle/check.h"

/* A sheet of a centimetre in the plane z = x + height, and a large triangle under or over it. Far
 * corners of that are rounded by up to a millimetre, so its middle sinks. */
static const uint32_t sheet_triangles[] = {0, 1, 2, 2, 1, 3}, large_triangle[] = {0, 1, 2};
static const double far_corners[9] = {20000.0,    0.0,      20000.0009, -10000.0,  -17320.0,
                                      -9999.9996, -10000.0, 17320.0,    -9999.9996};
static const double middle = (0.0009 + 2.0 * 0.0004) / 3.0; /* [m] of the triangle, before */

static void place_sheet(double height, double sheet[12]) {
    for (int i = 0; i < 4; i++) {
        sheet[3 * i] = 0.01 * (i % 2) - 0.005;
        sheet[3 * i + 1] = 0.01 * (i / 2) - 0.005;
        sheet[3 * i + 2] = sheet[3 * i] + height;
    }
}

typedef struct pair_case {
    double height;           /* [m] of the sheet */
    bool is_whole;           /* the triangle's corners are whole numbers */
    bool is_static, is_away; /* of the triangle */
    bool is_dynamic;
    tulle_status expected;
} pair_case;

static tulle_status write_pair(const pair_case *of, double sheet[12], double corners[9],
                               tulle_error *error) {
    place_sheet(of->height, sheet);
    for (int i = 0; i < 9; i++) corners[i] = of->is_whole ? round(far_corners[i]) : far_corners[i];
    tulle_run_body const pair[2] = {{.name = "sheet", .mesh = {sheet, 4, sheet_triangles, 2}},
                                    {.name = "plane",
                                     .mesh = {corners, 3, large_triangle, 1},
                                     .is_obstacle = 1,
                                     .is_static = of->is_static,
                                     .is_dynamic = of->is_dynamic}};
    tulle_run_def def = tulle_run_def_default();
    def.directory = test_path("pair");
    def.time_step = 0.01;
    def.bodies = pair;
    def.body_count = 2;
    tulle_run_writer *writer = NULL;
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, error), TULLE_OK);
    const double *const positions[2] = {sheet, corners};
    int const present[2] = {1, !of->is_away};
    tulle_transform const transform = {0};
    tulle_run_frame const frame = {
        .positions = positions, .is_present = present, .transforms = &transform};
    tulle_status const status = tulle_run_write_frame(writer, &frame, error);
    assert_int_equal(tulle_run_get_frame_count(writer), status == TULLE_OK);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, NULL), TULLE_OK);
    remove_tree(def.directory);
    return status;
}

static size_t count_intersections(const double sheet[12], const double corners[9]) {
    double rounded[2][12];
    for (int i = 0; i < 12; i++) rounded[0][i] = (double)(float)sheet[i];
    for (int i = 0; i < 9; i++) rounded[1][i] = (double)(float)corners[i];
    tulle_check_body const pair[2] = {{{rounded[0], 4, sheet_triangles, 2}, 0},
                                      {{rounded[1], 3, large_triangle, 1}, 1}};
    tulle_check_result result;
    assert_int_equal(tulle_check_intersections(pair, 2, 1, &result, NULL), TULLE_OK);
    size_t const count = result.pair_count;
    tulle_check_result_destroy(&result);
    return count;
}

static void no_sheet_changes_sides(void **state) {
    (void)state;
    const pair_case cases[] = {
        {.height = 0.5 * middle, .expected = TULLE_ERROR_LIMIT}, /* goes to the other side */
        {.height = 0.5 * middle, .is_dynamic = true, .expected = TULLE_ERROR_LIMIT},
        {.height = 2.0 * middle, .expected = TULLE_OK},  /* is above before and after */
        {.height = -0.5 * middle, .expected = TULLE_OK}, /* under it */
        {.height = 0.5 * middle, .is_whole = true, .expected = TULLE_OK},
        {.height = 0.5 * middle,
         .is_static = true,
         .expected = TULLE_OK}, /* its file has doubles */
        {.height = 0.5 * middle, .is_away = true, .expected = TULLE_OK},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double sheet[12], corners[9];
        tulle_error error = {0};
        assert_int_equal(write_pair(&cases[i], sheet, corners, &error), cases[i].expected);
        /* no judge of what the files hold would see it */
        assert_int_equal(count_intersections(sheet, corners), 0);
        if (cases[i].expected == TULLE_OK) continue;
        assert_non_null(strstr(error.message, "frame 0 cannot be kept"));
        assert_non_null(strstr(error.message, "move vertex 0 of 'plane' at (20000, 0, 20000) m"));
        assert_non_null(strstr(error.message, "through 'sheet'"));
    }
}

/* A vertex a hair over a face of its own cloth; the face is sloped, so its corners are rounded past
 * the vertex. Where cloth passed through the face already, rounding takes no blame. */
static void cloth_does_not_pass_through_itself(void **state) {
    (void)state;
    static const uint32_t triangles[] = {0, 1, 2, 3, 4, 5};
    for (int is_caught = 0; is_caught < 2; is_caught++) {
        double x[18];
        memcpy(x, far_corners, sizeof far_corners);
        double const tip = 0.5 * middle;
        double const top[9] = {0.0, 0.0, tip, 0.0, 1.0, -5.0, 0.0, -1.0, is_caught ? 5.0 : -5.0};
        memcpy(x + 9, top, sizeof top);
        tulle_run_body const body = {.name = "fold", .mesh = {x, 6, triangles, 2}};
        tulle_run_def def = tulle_run_def_default();
        def.directory = test_path("fold");
        def.time_step = 0.01;
        def.bodies = &body;
        def.body_count = 1;
        tulle_run_writer *writer = NULL;
        tulle_error error = {0};
        assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error), TULLE_OK);
        const double *const positions[1] = {x};
        tulle_run_frame const frame = {.positions = positions};
        assert_int_equal(tulle_run_write_frame(writer, &frame, &error),
                         is_caught ? TULLE_OK : TULLE_ERROR_LIMIT);
        if (!is_caught) assert_non_null(strstr(error.message, "and so through itself"));
        assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, NULL), TULLE_OK);
        remove_tree(def.directory);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_sheet_changes_sides),
        cmocka_unit_test(cloth_does_not_pass_through_itself),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
