/* The detector as its users meet it: what defs and positions may hold, what an event says. */
#include "math/vec3.h"
#include "support/test_support.h"
#include "tulle/detect.h"

#include <math.h>
#include <string.h>

/* A triangle in the plane z = 0, and one above it that falls through by one corner. */
static const uint32_t triangles[6] = {0, 1, 2, 3, 4, 5};
static const double start[18] = {0,    0,    0,   1, 0, 0, 0, 1, 0, /**/
                                 0.25, 0.25, 0.5, 1, 1, 2, 0, 1, 2};
static const double end[18] = {0,    0,    0,    1, 0, 0, 0, 1, 0, /**/
                               0.25, 0.25, -0.5, 1, 1, 2, 0, 1, 2};

static tulle_detect_def make_def(void) {
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = triangles;
    def.triangle_count = 2;
    def.vertex_count = 6;
    return def;
}

static tulle_detector *make_detector(const tulle_detect_def *def) {
    tulle_error error;
    tulle_detector *detector = NULL;
    tulle_status const status = tulle_detector_create(def, &detector, &error);
    if (status != TULLE_OK) print_error("%s\n", error.message);
    assert_int_equal(status, TULLE_OK);
    return detector;
}

static tulle_detect_result find(tulle_detector *detector, const double *x0, const double *x1) {
    tulle_error error;
    tulle_detect_result result = {0};
    tulle_status const status = tulle_detector_find_events(detector, x0, x1, &result, &error);
    if (status != TULLE_OK) print_error("%s\n", error.message);
    assert_int_equal(status, TULLE_OK);
    return result;
}

static void refuses(const tulle_detect_def *def, tulle_status expected, const char *words) {
    tulle_error error = {0};
    tulle_detector *detector = (tulle_detector *)1;
    assert_int_equal(tulle_detector_create(def, &detector, &error), expected);
    assert_null(detector);
    assert_int_equal(error.status, expected);
    if (!strstr(error.message, words)) print_error("said \"%s\"\n", error.message);
    assert_non_null(strstr(error.message, words));
    assert_int_equal(tulle_detector_create(def, &detector, NULL), expected);
}

static void unusable_settings_are_refused(void **state) {
    (void)state;
    double const nan = (double)NAN;
    refuses(NULL, TULLE_ERROR_INVALID_ARGUMENT, "tulle_detect_def_default");
    tulle_detect_def def = {0};
    refuses(&def, TULLE_ERROR_INVALID_ARGUMENT, "tulle_detect_def_default");
    const struct {
        double thickness, separation, angle;
        int method, cone, threads;
        const char *words;
    } cases[] = {
        {-1, 0, 1, 0, 0, 0, "thickness is -1"},
        {nan, 0, 1, 0, 0, 0, "thickness is"},
        {0, -1, 1, 0, 0, 0, "minimum separation is"},
        {0, INFINITY, 1, 0, 0, 0, "inf m"},
        {0, 0, 0, 0, 0, 0, "widest cone"},
        {0, 0, 1.5708, 0, 0, 0, "pi/2"},
        {0, 0, nan, 0, 0, 0, "widest cone"},
        {0, 0, 1, 4, 0, 0, "method 4"},
        {0, 0, 1, 0, 2, 0, "cone 2"},
        {0, 0, 1, 0, 0, -1, "-1 threads"},
        {0, 0, 1, 0, 0, 257, "257 threads"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        def = make_def();
        def.thickness = cases[i].thickness;
        def.minimum_separation = cases[i].separation;
        def.max_angle = cases[i].angle;
        def.method = (tulle_detect_method)cases[i].method;
        def.cone = (tulle_detect_cone)cases[i].cone;
        def.threads = cases[i].threads;
        refuses(&def, TULLE_ERROR_INVALID_ARGUMENT, cases[i].words);
    }
    def = make_def();
    def.vertex_count = 0;
    refuses(&def, TULLE_ERROR_INVALID_ARGUMENT, "no vertices");
    def.vertex_count = (size_t)1 << 31;
    refuses(&def, TULLE_ERROR_LIMIT, "2147483648 vertices");
    def = make_def();
    def.triangles = NULL;
    refuses(&def, TULLE_ERROR_INVALID_ARGUMENT, "triangles is null");
    tulle_detect_def const sound = make_def();
    assert_int_equal(tulle_detector_create(&sound, NULL, NULL), TULLE_ERROR_INVALID_ARGUMENT);
}

static void unusable_triangles_are_refused(void **state) {
    (void)state;
    tulle_detect_def def = make_def();
    const uint32_t beyond[6] = {0, 1, 2, 3, 6, 5}, repeated[6] = {0, 1, 2, 3, 4, 3},
                   crossing[6] = {0, 1, 2, 3, 4, 2};
    def.triangles = beyond;
    refuses(&def, TULLE_ERROR_INVALID_MESH, "corner 1 of triangle 1 is vertex 6, but");
    def.triangles = repeated;
    refuses(&def, TULLE_ERROR_INVALID_MESH, "triangle 1 has vertex 3 twice");
    tulle_detect_surface const surfaces[2] = {
        {.vertex_end = 3, .triangle_end = 1},
        {.vertex_begin = 3, .vertex_end = 6, .triangle_begin = 1, .triangle_end = 2}};
    def.surfaces = surfaces;
    def.surface_count = 2;
    def.triangles = crossing;
    refuses(&def, TULLE_ERROR_INVALID_MESH, "triangle 1 is vertex 2, outside its surface 1");
}

static void unusable_surfaces_are_refused(void **state) {
    (void)state;
    tulle_detect_surface const sound[2] = {
        {.vertex_end = 3, .triangle_end = 1},
        {.vertex_begin = 3, .vertex_end = 6, .triangle_begin = 1, .triangle_end = 2}};
    const struct {
        uint32_t vertices[2], triangles[2]; /* of the second */
        double thickness;
        const char *words;
    } cases[] = {
        {{4, 6}, {1, 2}, 0, "surface 1 starts at vertex 4"},
        {{2, 6}, {1, 2}, 0, "must start at vertex 3"},
        {{3, 2}, {1, 2}, 0, "surface 1 ends at vertex 2"},
        {{3, 6}, {0, 2}, 0, "surface 1 starts at triangle 0"},
        {{3, 6}, {1, 0}, 0, "surface 1 ends at triangle 0"},
        {{3, 5}, {1, 2}, 0, "must cover all 6 vertices"},
        {{3, 6}, {1, 1}, 0, "end at vertex 6 and triangle 1"},
        {{3, 6}, {1, 2}, -1, "thickness of surface 1 is -1"},
    };
    tulle_detect_def def = make_def();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        tulle_detect_surface const surfaces[2] = {sound[0],
                                                  {.vertex_begin = cases[i].vertices[0],
                                                   .vertex_end = cases[i].vertices[1],
                                                   .triangle_begin = cases[i].triangles[0],
                                                   .triangle_end = cases[i].triangles[1],
                                                   .thickness = cases[i].thickness}};
        def.surfaces = surfaces;
        def.surface_count = 2;
        refuses(&def, TULLE_ERROR_INVALID_ARGUMENT, cases[i].words);
    }
    def.surfaces = sound;
    def.surface_count = 0;
    refuses(&def, TULLE_ERROR_INVALID_ARGUMENT, "surface_count is 0");
    def.surface_count = 5000;
    refuses(&def, TULLE_ERROR_LIMIT, "5000 surfaces");
    def.surface_count = 2;
    def.collides = (const unsigned char[4]){1, 0, 1, 1};
    refuses(&def, TULLE_ERROR_INVALID_ARGUMENT, "surface 1 meets 0, but not");
    def.surfaces = NULL;
    refuses(&def, TULLE_ERROR_INVALID_ARGUMENT, "surfaces is null, but");
    def.surface_count = 0;
    refuses(&def, TULLE_ERROR_INVALID_ARGUMENT, "without surfaces");
    double rest[18] = {0};
    rest[7] = (double)NAN;
    def = make_def();
    def.rest = rest;
    refuses(&def, TULLE_ERROR_INVALID_ARGUMENT, "vertex 2 of `rest`");
}

static void unusable_positions_leave_all_as_it_was(void **state) {
    (void)state;
    tulle_detect_surface const surfaces[2] = {
        {.vertex_end = 3, .triangle_end = 1, .is_static = 1},
        {.vertex_begin = 3, .vertex_end = 6, .triangle_begin = 1, .triangle_end = 2}};
    tulle_detect_def def = make_def();
    def.surfaces = surfaces;
    def.surface_count = 2;
    tulle_detector *const detector = make_detector(&def);
    tulle_detect_result const before = find(detector, start, end);
    tulle_detect_result result = before;
    tulle_error error;
    double moved[18], bad[18];
    memcpy(bad, end, sizeof bad);
    bad[14] = (double)INFINITY;
    memcpy(moved, start, sizeof moved);
    moved[4] += 1e-9;
    const struct {
        const double *x0, *x1;
        const char *words;
    } cases[] = {
        {NULL, end, "start positions are null"},     {start, NULL, "end positions are null"},
        {start, bad, "vertex 4 of `end`"},           {bad, end, "vertex 4 of `start`"},
        {moved, end, "vertex 1 of surface 0 moves"}, {moved, moved, "static"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_int_equal(
            tulle_detector_find_events(detector, cases[i].x0, cases[i].x1, &result, &error),
            TULLE_ERROR_INVALID_ARGUMENT);
        assert_non_null(strstr(error.message, cases[i].words));
        assert_memory_equal(&result, &before, sizeof result);
    }
    assert_int_equal(tulle_detector_find_events(detector, start, end, NULL, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_detector_find_events(NULL, start, end, &result, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_detector_stream_events(detector, start, end, (tulle_detect_receiver){0},
                                                  &result, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    result = find(detector, start, end);
    assert_int_equal(result.event_count, before.event_count);
    tulle_detector_destroy(detector);
    tulle_detector_destroy(NULL);
    assert_null(tulle_detector_get_patches(NULL));
}

/* The falling corner passes z = 0 at t = 1/2, coming from above. */
static void an_event_tells_where_and_when(void **state) {
    (void)state;
    tulle_detect_def def = make_def();
    for (int round = 0; round < 2; round++) {
        def.thickness = round == 0 ? 0.0 : 0.1;
        tulle_detector *const detector = make_detector(&def);
        tulle_detect_result const result = find(detector, start, end);
        assert_int_equal(result.event_count, 1);
        const tulle_detect_event *const event = &result.events[0];
        assert_int_equal(event->kind, TULLE_DETECT_VERTEX_FACE);
        assert_int_equal(event->state, TULLE_DETECT_HIT);
        assert_int_equal(event->face, 0);
        const uint32_t vertices[4] = {3, 0, 1, 2};
        assert_memory_equal(event->vertices, vertices, sizeof vertices);
        double const exact = 0.5 - def.thickness;
        assert_true(event->time <= exact && event->time > exact - 0.02);
        assert_true(result.earliest_time == event->time);
        const double weights[4] = {1.0, -0.5, -0.25, -0.25}, normal[3] = {0.0, 0.0, 1.0};
        for (int k = 0; k < 4; k++) assert_true(fabs(event->weights[k] - weights[k]) < 1e-9);
        for (int k = 0; k < 3; k++) assert_true(fabs(event->normal[k] - normal[k]) < 1e-9);
        assert_true(fabs(event->distance - (0.5 - event->time)) < 1e-9);
        tulle_detector_destroy(detector);
    }
}

/* From both sides, also when the features touch from the start. */
static void normals_point_to_where_the_first_comes_from(void **state) {
    (void)state;
    tulle_detect_def const def = make_def();
    tulle_detector *const detector = make_detector(&def);
    for (int round = 0; round < 4; round++) {
        double x0[18], x1[18];
        memcpy(x0, start, sizeof x0);
        memcpy(x1, end, sizeof x1);
        double const side = round % 2 ? -1.0 : 1.0;
        for (int i = 3; i < 6; i++) x0[3 * i + 2] *= side, x1[3 * i + 2] *= side;
        if (round >= 2) x0[11] = 0.0;
        tulle_detect_result const result = find(detector, x0, x1);
        assert_int_equal(result.event_count, 1);
        const tulle_detect_event *const event = &result.events[0];
        assert_int_equal(event->state,
                         round < 2 ? TULLE_DETECT_HIT : TULLE_DETECT_TOUCHING_AT_START);
        assert_true(round < 2 || (event->time == 0.0 && event->distance == 0.0));
        assert_true(fabs(event->normal[2] - side) < 1e-9);
    }
    tulle_detector_destroy(detector);
}

/* Trees shaped from another state find the same, whatever its size. */
static void rest_may_be_another_state(void **state) {
    (void)state;
    tulle_detect_def def = make_def();
    for (int round = 0; round < 4; round++) {
        static const double sizes[] = {0.0, 1e-3, 1e6, 1e-300};
        double rest[18], large_start[18], large_end[18];
        for (int i = 0; i < 18; i++) {
            rest[i] = sizes[round] * (i % 5);
            large_start[i] = 1e200 * start[i];
            large_end[i] = 1e200 * end[i];
        }
        def.rest = rest;
        tulle_detector *const detector = make_detector(&def);
        assert_int_equal(find(detector, start, end).event_count, 1);
        assert_int_equal(find(detector, large_start, large_end).event_count, 1);
        assert_int_equal(find(detector, start, end).event_count, 1);
        tulle_detector_destroy(detector);
    }
}

/* A vertex without triangles meets nothing and spoils nothing, wherever it is. */
static void a_stray_vertex_costs_nothing(void **state) {
    (void)state;
    enum { SIDE = 20, CORNERS = SIDE * SIDE, TRIANGLES = 2 * (SIDE - 1) * (SIDE - 1) };
    double x0[3 * (CORNERS + 1)], x1[3 * (CORNERS + 1)];
    uint32_t sheet[3 * TRIANGLES], count = 0;
    for (uint32_t i = 0; i < CORNERS; i++) {
        vec3 const x = vec3_make(0.01 * (i % SIDE), 0.01 * (i / SIDE), 0.002 * (i * i % 7));
        vec3_store(x0, i, x);
        vec3_store(x1, i, vec3_make(x.x, x.y + 0.001, x.z));
        if (i % SIDE == SIDE - 1 || i >= CORNERS - SIDE) continue;
        const uint32_t both[6] = {i, i + 1, i + SIDE, i + 1, i + SIDE + 1, i + SIDE};
        memcpy(sheet + 3 * count, both, sizeof both);
        count += 2;
    }
    tulle_detect_def def = tulle_detect_def_default();
    def.method = TULLE_DETECT_REFIT;
    def.triangles = sheet;
    def.triangle_count = count;
    def.vertex_count = CORNERS + 1;
    uint64_t box_pairs[2];
    for (int round = 0; round < 2; round++) {
        vec3_store(x0, CORNERS, vec3_make(1e9 * round, 1e9 * round, 1e9 * round));
        vec3_store(x1, CORNERS, vec3_make(1e9 * round, -1e9 * round, 0.0));
        tulle_detector *const detector = make_detector(&def);
        box_pairs[round] = find(detector, x0, x1).statistics.box_pairs;
        tulle_detector_destroy(detector);
    }
    assert_true(box_pairs[0] > 0);
    assert_int_equal(box_pairs[1], box_pairs[0]);
}

static void nothing_comes_of_no_triangles(void **state) {
    (void)state;
    tulle_detect_def def = tulle_detect_def_default();
    def.vertex_count = 6;
    tulle_detector *const detector = make_detector(&def);
    tulle_detect_result const result = find(detector, start, end);
    assert_int_equal(result.event_count, 0);
    assert_true(result.earliest_time == 1.0);
    tulle_detector_destroy(detector);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unusable_settings_are_refused),
        cmocka_unit_test(unusable_triangles_are_refused),
        cmocka_unit_test(unusable_surfaces_are_refused),
        cmocka_unit_test(unusable_positions_leave_all_as_it_was),
        cmocka_unit_test(an_event_tells_where_and_when),
        cmocka_unit_test(normals_point_to_where_the_first_comes_from),
        cmocka_unit_test(rest_may_be_another_state),
        cmocka_unit_test(a_stray_vertex_costs_nothing),
        cmocka_unit_test(nothing_comes_of_no_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
