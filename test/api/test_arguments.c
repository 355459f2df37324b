/* Arguments of the public functions of libtulle that need no world: statuses, judge, detector,
 * meshes and shapes. */
#include "api/arguments.h"

/* A square of two triangles. */
static double square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
static tulle_mesh_view const sheet = {square, 4, corners, 2};
static tulle_mesh_view const bad_views[] = {{NULL, 4, corners, 2}, {square, 4, NULL, 2}};

ARGUMENTS_OF(tulle_status_text) {
    for (int i = -2; i < TULLE_STATUS_COUNT + 2; i++)
        assert_non_null(tulle_status_text((tulle_status)i));
    assert_non_null(tulle_status_text((tulle_status)INT_MAX));
}

ARGUMENTS_OF(tulle_version) {
    char wanted[64];
    snprintf(wanted, sizeof wanted, "%d.%d.%d", TULLE_VERSION_MAJOR, TULLE_VERSION_MINOR,
             TULLE_VERSION_PATCH);
    assert_string_equal(tulle_version(), wanted);
}

/* Every struct of the headers that is no secret is known, with the size that it has here. */
static void expect_structs(const char *header) {
    const char *const source = getenv("TULLE_SOURCE_DIR");
    if (!source) skip(); /* CTest sets it */
    char path[1024], line[512];
    snprintf(path, sizeof path, "%s/include/tulle/%s.h", source, header);
    FILE *const file = fopen(path, "r");
    assert_non_null(file);
    bool is_struct = false;
    while (fgets(line, sizeof line, file)) {
        if (strncmp(line, "typedef ", 8) == 0) is_struct = strncmp(line + 8, "struct ", 7) == 0;
        if (strncmp(line, "} tulle_", 8) != 0 || !is_struct) continue;
        line[strcspn(line, ";")] = '\0';
        REFUSED(tulle_check_struct(line + 2, SIZE_MAX, &error));
        (void)tulle_check_struct(line + 2, SIZE_MAX, &error);
        if (!strstr(error.message, "bytes in the program"))
            fail_msg("%s: %s: %s", header, line + 2, error.message);
        error = (tulle_error){0};
    }
    fclose(file);
}

ARGUMENTS_OF(tulle_check_struct) {
    REFUSED(tulle_check_struct(NULL, 0, &error));
    REFUSED(tulle_check_struct("", 0, &error));
    REFUSED(tulle_check_struct("tulle_world", 8, &error));
    REFUSED(tulle_check_struct("tulle_world_def ", sizeof(tulle_world_def), &error));
    REFUSED(tulle_check_struct("tulle_world_def", sizeof(tulle_world_def) - 8, &error));
    assert_int_equal(tulle_check_struct(NULL, 0, NULL), TULLE_ERROR_INVALID_ARGUMENT);
    FINE(TULLE_CHECK_STRUCT(tulle_world_def, &error));
    FINE(TULLE_CHECK_STRUCT(tulle_cloth_def, &error));
    FINE(TULLE_CHECK_STRUCT(tulle_obstacle_def, &error));
    FINE(TULLE_CHECK_STRUCT(tulle_step_report, NULL));
    static const char *const headers[] = {"base",  "check",  "detect",  "live", "mesh",
                                          "paper", "shapes", "threads", "world"};
    for (size_t i = 0; i < sizeof headers / sizeof headers[0]; i++) expect_structs(headers[i]);
}

ARGUMENTS_OF(tulle_check_intersections) {
    tulle_check_body const body = {.mesh = sheet};
    tulle_check_result result;
    REFUSED(tulle_check_intersections(&body, 1, 1, NULL, &error));
    REFUSED(tulle_check_intersections(NULL, 1, 1, &result, &error));
    int const threads[] = {-1, 257, INT_MIN, INT_MAX};
    for (int i = 0; i < 4; i++)
        REFUSED(tulle_check_intersections(&body, 1, threads[i], &result, &error));
    for (int i = 0; i < 2; i++) {
        tulle_check_body const bad = {.mesh = bad_views[i]};
        REFUSED(tulle_check_intersections(&bad, 1, 1, &result, &error));
        assert_null(result.pairs);
    }
    tulle_check_body const huge = {.mesh = {square, SIZE_MAX, corners, SIZE_MAX}};
    REFUSED_WITH(TULLE_ERROR_LIMIT, tulle_check_intersections(&huge, 1, 1, &result, &error));
    FINE(tulle_check_intersections(NULL, 0, 1, &result, NULL));
    FINE(tulle_check_intersections(&body, 1, 1, &result, NULL));
    tulle_check_result_destroy(&result);
}

ARGUMENTS_OF(tulle_check_result_destroy) { tulle_check_result_destroy(NULL); }

ARGUMENTS_OF(tulle_check_triangle_pair) {
    double const apart[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1};
    uint32_t const first[3] = {0, 1, 2}, second[3] = {3, 4, 5};
    assert_int_equal(tulle_check_triangle_pair(apart, first, second, 1), 0);
    assert_int_equal(tulle_check_triangle_pair(apart, first, second, INT_MIN), 0);
    assert_int_equal(tulle_check_triangle_pair(NULL, first, second, 1), 1);
    assert_int_equal(tulle_check_triangle_pair(apart, NULL, second, 1), 1);
    assert_int_equal(tulle_check_triangle_pair(apart, first, NULL, 1), 1);
}

ARGUMENTS_OF(tulle_detect_def_default) { assert_true(tulle_detect_def_default().cookie != 0); }

static tulle_detect_def make_detect_def(void) {
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = corners;
    def.triangle_count = 2;
    def.vertex_count = 4;
    def.threads = 1;
    return def;
}

static tulle_detector *make_detector(void) {
    tulle_detect_def const def = make_detect_def();
    tulle_detector *detector = NULL;
    FINE(tulle_detector_create(&def, &detector, &error));
    return detector;
}

ARGUMENTS_OF(tulle_detector_create) {
    tulle_detect_def def = make_detect_def();
    tulle_detector *detector = NULL;
    REFUSED(tulle_detector_create(NULL, &detector, &error));
    REFUSED(tulle_detector_create(&def, NULL, &error));
    assert_int_equal(tulle_detector_create(NULL, NULL, NULL), TULLE_ERROR_INVALID_ARGUMENT);
    double *const numbers[] = {&def.thickness, &def.minimum_separation, &def.max_angle};
    for (int n = 0; n < 3; n++)
        for (int i = 0; i < NO_NUMBER_COUNT; i++) {
            def = make_detect_def();
            *numbers[n] = no_numbers[i];
            REFUSED(tulle_detector_create(&def, &detector, &error));
        }
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        def = make_detect_def();
        SET_CHOICE(def.method, no_choices[i]);
        REFUSED(tulle_detector_create(&def, &detector, &error));
        def = make_detect_def();
        SET_CHOICE(def.cone, no_choices[i]);
        REFUSED(tulle_detector_create(&def, &detector, &error));
        def = make_detect_def();
        def.threads = i == 1 ? 257 : no_choices[i];
        REFUSED(tulle_detector_create(&def, &detector, &error));
    }
    def = make_detect_def();
    def.triangles = NULL;
    REFUSED(tulle_detector_create(&def, &detector, &error));
    def = make_detect_def();
    def.surface_count = 1;
    REFUSED(tulle_detector_create(&def, &detector, &error));
    def = make_detect_def();
    def.vertex_count = def.triangle_count = SIZE_MAX;
    REFUSED_WITH(TULLE_ERROR_LIMIT, tulle_detector_create(&def, &detector, &error));
    def = make_detect_def();
    square[4] = (double)NAN;
    def.rest = square;
    REFUSED(tulle_detector_create(&def, &detector, &error));
    square[4] = 0.0;
    tulle_detect_surface surface = {0, UINT32_MAX, 0, UINT32_MAX, 0.0, 0, 0, 0};
    def.rest = NULL;
    def.surfaces = &surface;
    def.surface_count = 1;
    REFUSED(tulle_detector_create(&def, &detector, &error));
    surface = (tulle_detect_surface){0, 4, 0, 2, (double)NAN, 0, 0, 0};
    REFUSED(tulle_detector_create(&def, &detector, &error));
    assert_null(detector);
}

ARGUMENTS_OF(tulle_detector_destroy) { tulle_detector_destroy(NULL); }

typedef tulle_status (*detector_call)(tulle_detector *, const double *, const double *,
                                      tulle_detect_result *, tulle_error *);

static void check_detector_call(detector_call call) {
    tulle_detector *const detector = make_detector();
    tulle_detect_result result = {0};
    REFUSED(call(NULL, square, square, &result, &error));
    REFUSED(call(detector, NULL, square, &result, &error));
    REFUSED(call(detector, square, NULL, &result, &error));
    REFUSED(call(detector, square, square, NULL, &error));
    double bad[12];
    for (int i = 0; i < 3; i++) {
        memcpy(bad, square, sizeof bad);
        bad[11] = no_numbers[i];
        REFUSED(call(detector, bad, square, &result, &error));
        REFUSED(call(detector, square, bad, &result, &error));
    }
    FINE(call(detector, square, square, &result, NULL));
    tulle_detector_destroy(detector);
}

ARGUMENTS_OF(tulle_detector_find_events) { check_detector_call(tulle_detector_find_events); }

ARGUMENTS_OF(tulle_detector_find_earliest) { check_detector_call(tulle_detector_find_earliest); }

static int take_events(void *context, const tulle_detect_event *events, size_t count) {
    (void)context, (void)events, (void)count;
    return 0;
}

static tulle_status stream(tulle_detector *detector, const double *start, const double *end,
                           tulle_detect_result *result, tulle_error *to) {
    return tulle_detector_stream_events(detector, start, end,
                                        (tulle_detect_receiver){take_events, NULL}, result, to);
}

ARGUMENTS_OF(tulle_detector_stream_events) {
    check_detector_call(stream);
    tulle_detector *const detector = make_detector();
    tulle_detect_result result;
    REFUSED(tulle_detector_stream_events(detector, square, square,
                                         (tulle_detect_receiver){NULL, NULL}, &result, &error));
    tulle_detector_destroy(detector);
}

ARGUMENTS_OF(tulle_detector_get_patches) { assert_null(tulle_detector_get_patches(NULL)); }

ARGUMENTS_OF(tulle_mesh_create) {
    tulle_mesh mesh;
    REFUSED(tulle_mesh_create(3, 1, NULL, &error));
    REFUSED_WITH(TULLE_ERROR_LIMIT, tulle_mesh_create(SIZE_MAX, 1, &mesh, &error));
    REFUSED_WITH(TULLE_ERROR_LIMIT, tulle_mesh_create(3, SIZE_MAX, &mesh, &error));
    FINE(tulle_mesh_create(0, 0, &mesh, NULL));
    tulle_mesh_destroy(&mesh);
}

ARGUMENTS_OF(tulle_mesh_destroy) {
    tulle_mesh empty = {0};
    tulle_mesh_destroy(NULL);
    tulle_mesh_destroy(&empty);
}

ARGUMENTS_OF(tulle_mesh_get_view) {
    tulle_mesh_view const view = tulle_mesh_get_view(NULL);
    assert_true(!view.positions && !view.triangles);
    assert_true(view.vertex_count == 0 && view.triangle_count == 0);
}

ARGUMENTS_OF(tulle_mesh_transform) {
    double const scale[3] = {2, 2, 2}, rotation[4] = {1, 0, 0, 0}, translation[3] = {1, 2, 3};
    double positions[12];
    memcpy(positions, square, sizeof square);
    tulle_mesh mesh = {positions, 4, corners, 2}, empty = {0}, bare = {NULL, 4, corners, 2};
    tulle_mesh_transform(NULL, scale, rotation, translation);
    tulle_mesh_transform(&mesh, NULL, rotation, translation);
    tulle_mesh_transform(&mesh, scale, NULL, translation);
    tulle_mesh_transform(&mesh, scale, rotation, NULL);
    assert_memory_equal(positions, square, sizeof square);
    tulle_mesh_transform(&empty, scale, rotation, translation);
    tulle_mesh_transform(&bare, scale, rotation, translation);
    tulle_mesh_transform(&mesh, scale, rotation, translation);
    assert_true(positions[3] == 3.0);
}

ARGUMENTS_OF(tulle_mesh_validate) {
    for (int i = 0; i < 2; i++)
        REFUSED(tulle_mesh_validate(bad_views[i], TULLE_MESH_ROLE_CLOTH, &error));
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        tulle_mesh_role role;
        SET_CHOICE(role, no_choices[i]);
        REFUSED(tulle_mesh_validate(sheet, role, &error));
    }
    tulle_mesh_view const huge = {square, SIZE_MAX, corners, SIZE_MAX};
    REFUSED_WITH(TULLE_ERROR_LIMIT, tulle_mesh_validate(huge, TULLE_MESH_ROLE_CLOTH, &error));
    FINE(tulle_mesh_validate(sheet, TULLE_MESH_ROLE_CLOTH, NULL));
}

ARGUMENTS_OF(tulle_mesh_validate_lines) {
    uint32_t const lines[4] = {1, 2, 3, 4};
    tulle_mesh_lines const given[] = {{NULL, NULL}, {lines, NULL}, {NULL, lines}};
    for (int i = 0; i < 3; i++) {
        REFUSED(
            tulle_mesh_validate_lines(bad_views[i % 2], TULLE_MESH_ROLE_CLOTH, given[i], &error));
        FINE(tulle_mesh_validate_lines(sheet, TULLE_MESH_ROLE_OBSTACLE, given[i], NULL));
    }
}

ARGUMENTS_OF(tulle_mesh_drop_duplicates) {
    tulle_mesh mesh = {square, 4, corners, 2}, bare = {square, 4, NULL, 2}, empty = {0};
    tulle_mesh_duplicates duplicates;
    REFUSED(tulle_mesh_drop_duplicates(NULL, NULL, &duplicates, &error));
    REFUSED(tulle_mesh_drop_duplicates(&mesh, NULL, NULL, &error));
    REFUSED(tulle_mesh_drop_duplicates(&bare, NULL, &duplicates, &error));
    FINE(tulle_mesh_drop_duplicates(&empty, NULL, &duplicates, NULL));
    FINE(tulle_mesh_drop_duplicates(&mesh, NULL, &duplicates, NULL));
    assert_int_equal(duplicates.count, 0);
}

ARGUMENTS_OF(tulle_mesh_find_degenerate) {
    uint8_t marks[2] = {7, 7};
    REFUSED(tulle_mesh_find_degenerate(sheet, NULL, NULL, &error));
    for (int i = 0; i < 2; i++)
        REFUSED(tulle_mesh_find_degenerate(bad_views[i], marks, NULL, &error));
    FINE(tulle_mesh_find_degenerate(sheet, marks, NULL, NULL));
    assert_int_equal(marks[0] + marks[1], 0);
}

ARGUMENTS_OF(tulle_mesh_drop_marked) {
    tulle_mesh mesh = {square, 4, corners, 2}, bare = {square, 4, NULL, 2}, empty = {0};
    uint8_t const marks[2] = {0, 0};
    REFUSED(tulle_mesh_drop_marked(NULL, marks, NULL, &error));
    REFUSED(tulle_mesh_drop_marked(&mesh, NULL, NULL, &error));
    REFUSED(tulle_mesh_drop_marked(&bare, marks, NULL, &error));
    FINE(tulle_mesh_drop_marked(&empty, NULL, NULL, NULL));
    FINE(tulle_mesh_drop_marked(&mesh, marks, NULL, NULL));
    assert_int_equal(mesh.triangle_count, 2);
}

ARGUMENTS_OF(tulle_mesh_repair) {
    tulle_mesh mesh = {square, 4, corners, 2}, bare = {square, 4, NULL, 2}, empty = {0};
    tulle_mesh_repairs repairs;
    REFUSED(tulle_mesh_repair(NULL, 0.0, &repairs, &error));
    REFUSED(tulle_mesh_repair(&mesh, 0.0, NULL, &error));
    REFUSED(tulle_mesh_repair(&bare, 0.0, &repairs, &error));
    REFUSED(tulle_mesh_repair(&mesh, -1.0, &repairs, &error));
    REFUSED(tulle_mesh_repair(&mesh, (double)NAN, &repairs, &error));
    FINE(tulle_mesh_repair(&empty, 0.0, &repairs, NULL));
    tulle_mesh_destroy(&empty);
}

ARGUMENTS_OF(tulle_mesh_get_info) {
    tulle_mesh_info info;
    REFUSED(tulle_mesh_get_info(sheet, NULL, &error));
    for (int i = 0; i < 2; i++) REFUSED(tulle_mesh_get_info(bad_views[i], &info, &error));
    FINE(tulle_mesh_get_info((tulle_mesh_view){0}, &info, NULL));
    FINE(tulle_mesh_get_info(sheet, &info, NULL));
}

ARGUMENTS_OF(tulle_shape_def_default) {
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        tulle_shape shape;
        SET_CHOICE(shape, no_choices[i]);
        tulle_shape_def const def = tulle_shape_def_default(shape);
        tulle_mesh mesh;
        REFUSED(tulle_shape_generate(&def, &mesh, &error));
    }
}

ARGUMENTS_OF(tulle_shape_name) {
    for (int i = 0; i < NO_CHOICE_COUNT; i++) {
        tulle_shape shape;
        SET_CHOICE(shape, no_choices[i]);
        assert_null(tulle_shape_name(shape));
        assert_int_equal(tulle_shape_is_cloth(shape), 0);
    }
    assert_null(tulle_shape_name(TULLE_SHAPE_COUNT));
}

ARGUMENTS_OF(tulle_shape_is_cloth) {
    assert_int_equal(tulle_shape_is_cloth(TULLE_SHAPE_COUNT), 0);
    assert_int_equal(tulle_shape_is_cloth((tulle_shape)-1), 0);
}

/* Every number of the def, for every shape that uses it. */
ARGUMENTS_OF(tulle_shape_generate) {
    tulle_mesh mesh = {0};
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
    REFUSED(tulle_shape_generate(NULL, &mesh, &error));
    REFUSED(tulle_shape_generate(&def, NULL, &error));
    double *const numbers[] = {&def.size[0],      &def.size[1], &def.size[2],    &def.radius,
                               &def.inner_radius, &def.height,  &def.tip_height, &def.head_radius,
                               &def.head_height,  &def.angle,   &def.strand,     &def.wavelength};
    uint32_t *const counts[] = {&def.resolution[0], &def.resolution[1], &def.cells[0],
                                &def.cells[1], &def.strand_resolution};
    int refused_count = 0;
    for (int shape = 0; shape < TULLE_SHAPE_COUNT; shape++) {
        for (size_t n = 0; n < sizeof numbers / sizeof numbers[0]; n++)
            for (int i = 0; i < NO_NUMBER_COUNT; i++) {
                def = tulle_shape_def_default((tulle_shape)shape);
                *numbers[n] = no_numbers[i];
                if (tulle_shape_generate(&def, &mesh, &error) == TULLE_OK)
                    tulle_mesh_destroy(&mesh); /* the shape does not use it */
                else
                    refused_count++;
                assert_null(mesh.positions);
            }
        for (size_t n = 0; n < sizeof counts / sizeof counts[0]; n++) {
            def = tulle_shape_def_default((tulle_shape)shape);
            *counts[n] = UINT32_MAX;
            if (tulle_shape_generate(&def, &mesh, &error) == TULLE_OK)
                tulle_mesh_destroy(&mesh);
            else
                refused_count++;
        }
    }
    assert_true(refused_count > 5 * TULLE_SHAPE_COUNT);
}

int main(void) {
    return run_arguments(HEADERS("tulle/base.h", "tulle/check.h", "tulle/detect.h", "tulle/mesh.h",
                                 "tulle/shapes.h"),
                         NULL, NULL);
}
