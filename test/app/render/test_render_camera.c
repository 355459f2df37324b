/* Cameras and sizes of pictures: what their texts say and which texts are refused; cameras see what
 * they are to see, by projecting it. */
#include "app/render/camera.h"
#include "app/render/options.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static void test_sizes(void **state) {
    (void)state;
    uint32_t width = 0, height = 0;
    assert_int_equal(picture_read_size("640x360", &width, &height, NULL), TULLE_OK);
    assert_true(width == 640 && height == 360);
    assert_int_equal(picture_read_size("1x16384", &width, &height, NULL), TULLE_OK);
    static const char *const malformed[] = {"",        "640",      "x",     "640x",      "x360",
                                            "-1x5",    "1e9x5",    "6.5x5", "640x360x2", "640 x360",
                                            "640X360", " 640x360", "nanx5"};
    for (size_t i = 0; i < sizeof malformed / sizeof malformed[0]; i++)
        assert_int_equal(picture_read_size(malformed[i], &width, &height, NULL),
                         TULLE_ERROR_INVALID_ARGUMENT);
    static const char *const out_of_range[] = {"0x0",
                                               "0x5",
                                               "5x0",
                                               "16385x1",
                                               "16384x16384",
                                               "99999999999999999999999x1",
                                               "18446744073709551617x1"};
    for (size_t i = 0; i < sizeof out_of_range / sizeof out_of_range[0]; i++)
        assert_int_equal(picture_read_size(out_of_range[i], &width, &height, NULL),
                         TULLE_ERROR_LIMIT);
    assert_true(width == 1 && height == 16384); /* untouched by failures */
}

static void test_camera_texts(void **state) {
    (void)state;
    scene_camera camera = {0};
    assert_int_equal(
        picture_read_camera("position=1,-2,80cm,target=0,0.5,-1,fov=40deg", &camera, NULL),
        TULLE_OK);
    assert_true(camera.has_position && camera.has_target && camera.has_field_of_view);
    assert_false(camera.has_orbit || camera.has_turn || camera.has_distance);
    assert_true(camera.position[0] == 1.0 && camera.position[1] == -2.0);
    assert_true(fabs(camera.position[2] - 0.8) < 1e-15 && camera.target[1] == 0.5);
    assert_true(fabs(camera.field_of_view - 40.0 * acos(-1.0) / 180.0) < 1e-12);

    camera = (scene_camera){0};
    assert_int_equal(picture_read_camera("orbit=0.5rad,-20deg,3m,turn=1turn", &camera, NULL),
                     TULLE_OK);
    assert_true(camera.has_orbit && camera.has_distance && camera.has_turn);
    assert_true(camera.azimuth == 0.5 && camera.distance == 3.0);
    assert_int_equal(picture_read_camera("orbit=0,0", &camera, NULL), TULLE_OK);
    assert_false(camera.has_distance);
}

static void test_camera_texts_refused(void **state) {
    (void)state;
    static const char *const refused[] = {"",
                                          "orbit",
                                          "orbit=",
                                          "orbit=30,20",
                                          "orbit=30deg",
                                          "orbit=30deg,20deg,1,2",
                                          "orbit=30deg,90deg",
                                          "orbit=30deg,20deg,0",
                                          "orbit=30deg,20deg,-1",
                                          "position=1,2",
                                          "position=1,2,3,4",
                                          "position=nan,0,0",
                                          "position=1,2,inf",
                                          "position=1,2,3deg",
                                          "position=1e300,0,0",
                                          "fov=40",
                                          "fov=0deg",
                                          "fov=180deg",
                                          "fov=-40deg",
                                          "fov=nan",
                                          "zoom=2",
                                          "position=1,2,3,orbit=0,0",
                                          "orbit=1deg,2deg,orbit=3deg,4deg",
                                          "position=1,2,3,",
                                          "orbit=0,0,,",
                                          "=1",
                                          ",",
                                          "turn=1e9turn",
                                          "position=1,,3",
                                          "fov=40deg,1"};
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        scene_camera before = {.has_turn = true, .turn = 1.0};
        tulle_error error = {0};
        if (picture_read_camera(refused[i], &before, &error) != TULLE_ERROR_INVALID_ARGUMENT)
            fail_msg("\"%s\" is not refused", refused[i]);
        assert_true(strncmp(error.message, "--camera:", 9) == 0);
        assert_true(before.has_turn && before.turn == 1.0 && !before.has_position &&
                    !before.has_orbit);
    }
    char longest[1000];
    memset(longest, '1', sizeof longest - 1);
    longest[sizeof longest - 1] = '\0';
    scene_camera camera = {0};
    assert_int_equal(picture_read_camera(longest, &camera, NULL), TULLE_ERROR_INVALID_ARGUMENT);
}

static void test_options_go_before_scenes(void **state) {
    (void)state;
    scene_camera const option = {.has_orbit = true, .azimuth = 1.0};
    scene_camera const keys = {.has_position = true,
                               .position = {1, 2, 3},
                               .has_target = true,
                               .target = {4, 5, 6},
                               .has_turn = true,
                               .turn = 7.0};
    scene_camera merged = picture_camera_merge(&option, &keys);
    assert_true(merged.has_orbit && !merged.has_position && merged.azimuth == 1.0);
    assert_true(merged.has_target && merged.target[2] == 6.0 && merged.turn == 7.0);
    scene_camera const nothing = {0};
    merged = picture_camera_merge(&nothing, &keys);
    assert_true(merged.has_position && merged.position[2] == 3.0 && !merged.has_orbit);
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Where a point is in the picture: -1 .. 1 from edge to edge; false: behind the camera. */
static bool project(const render_camera *camera, double aspect, const double point[3],
                    double place[2]) {
    double forward[3], right[3], from[3];
    for (int k = 0; k < 3; k++) {
        forward[k] = camera->target[k] - camera->position[k];
        from[k] = point[k] - camera->position[k];
    }
    double const length = sqrt(dot(forward, forward));
    for (int k = 0; k < 3; k++) forward[k] /= length;
    for (int k = 0; k < 3; k++)
        right[k] = forward[(k + 1) % 3] * camera->up[(k + 2) % 3] -
                   forward[(k + 2) % 3] * camera->up[(k + 1) % 3];
    double const right_length = sqrt(dot(right, right));
    for (int k = 0; k < 3; k++) right[k] /= right_length;
    double up[3];
    for (int k = 0; k < 3; k++)
        up[k] =
            right[(k + 1) % 3] * forward[(k + 2) % 3] - right[(k + 2) % 3] * forward[(k + 1) % 3];
    double const depth = dot(from, forward), slope = tan(0.5 * camera->field_of_view);
    place[0] = dot(from, right) / (depth * slope * aspect);
    place[1] = dot(from, up) / (depth * slope);
    return depth > 0.0;
}

static void test_default_camera_fills_the_picture(void **state) {
    (void)state;
    /* A ball of points about (3, -1, 2), squeezed: whatever the direction, shape and angle, all of
     * it is seen, and it reaches near the edges. */
    double points[3 * 2000];
    for (size_t i = 0; i < 2000; i++) {
        double const a = 0.1 * (double)i, z = -1.0 + (double)i / 1000.0, r = sqrt(1.0 - z * z);
        points[3 * i] = 3.0 + r * cos(a);
        points[3 * i + 1] = -1.0 + 0.5 * r * sin(a);
        points[3 * i + 2] = 2.0 + 0.3 * z;
    }
    picture_view view = picture_view_empty();
    picture_view_add(&view, points, 1000);
    picture_view_add(&view, points + 3000, 1000);
    static const double aspects[] = {16.0 / 9.0, 1.0, 0.4};
    for (int i = 0; i < 24; i++) {
        scene_camera const asked = {.has_orbit = i > 0,
                                    .azimuth = 0.7 * i,
                                    .elevation = 1.5 * sin(2.0 * i),
                                    .has_field_of_view = i % 2 == 1,
                                    .field_of_view = 0.2 + 0.05 * i};
        double const aspect = aspects[i % 3];
        render_camera camera;
        assert_int_equal(picture_make_camera(&asked, &view, aspect, 0.0, &camera, NULL), TULLE_OK);
        double most[2] = {0.0, 0.0};
        for (size_t k = 0; k < 2000; k++) {
            double place[2];
            assert_true(project(&camera, aspect, points + 3 * k, place));
            most[0] = fmax(most[0], fabs(place[0]));
            most[1] = fmax(most[1], fabs(place[1]));
        }
        double const worst = fmax(most[0], most[1]);
        if (!(worst < 1.0 && worst > 0.8)) fail_msg("camera %d: reaches to %g", i, worst);
    }
}

static void test_large_ground_does_not_count(void **state) {
    (void)state;
    static const double cloth[] = {-0.5, -0.5, 1, 0.5, 0.5, 0};
    static const double ground[] = {-50, -50, 0, 50, 50, 0};
    static const double needle[] = {0, 0, -0.5, 0.01, 0.01, 0.5};
    static const double elsewhere[] = {5, 5, 0, 5.1, 5.1, 0.1};
    picture_view view = picture_view_empty(), others[3];
    picture_view_add(&view, cloth, 2);
    picture_bounds const cloths = view.bounds;
    for (int i = 0; i < 3; i++) others[i] = picture_view_empty();
    picture_view_add(&others[0], ground, 2);
    picture_view_add(&others[1], needle, 2);
    picture_view_add(&others[2], elsewhere, 2);
    for (int i = 0; i < 3; i++) picture_view_add_obstacle(&view, &cloths, &others[i]);
    static const double low[] = {-0.5, -0.5, -0.5}, high[] = {0.5, 0.5, 1};
    assert_memory_equal(view.bounds.low, low, sizeof low);
    assert_memory_equal(view.bounds.high, high, sizeof high);
}

static void test_positions_and_turns(void **state) {
    (void)state;
    static const double cloth[] = {-1, -1, -1, 1, 1, 1};
    picture_view view = picture_view_empty();
    picture_view_add(&view, cloth, 2);
    scene_camera asked = {
        .has_position = true, .position = {4, 0, 3}, .has_turn = true, .turn = acos(-1.0)};
    render_camera camera;
    assert_int_equal(picture_make_camera(&asked, &view, 1.0, 0.0, &camera, NULL), TULLE_OK);
    assert_true(camera.position[0] == 4.0 && camera.position[2] == 3.0 && camera.target[0] == 0.0);
    /* Half of half a turn. */
    assert_int_equal(picture_make_camera(&asked, &view, 1.0, 0.5, &camera, NULL), TULLE_OK);
    assert_true(fabs(camera.position[0]) < 1e-12 && fabs(camera.position[1] - 4.0) < 1e-12);
    /* From above: up is a direction of its own. */
    asked = (scene_camera){.has_position = true, .position = {0, 0, 5}};
    assert_int_equal(picture_make_camera(&asked, &view, 1.0, 0.0, &camera, NULL), TULLE_OK);
    assert_true(camera.up[1] == 1.0 && camera.up[2] == 0.0);
    /* At its target, given or by default. */
    asked = (scene_camera){.has_position = true};
    assert_int_equal(picture_make_camera(&asked, &view, 1.0, 0.0, &camera, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    asked = (scene_camera){
        .has_position = true, .position = {1, 2, 3}, .has_target = true, .target = {1, 2, 3}};
    assert_int_equal(picture_make_camera(&asked, &view, 1.0, 0.0, &camera, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    /* A whole turn keeps its distance and its target. */
    asked = (scene_camera){.has_turn = true, .turn = 6.0};
    double distances[2];
    for (int i = 0; i < 2; i++) {
        assert_int_equal(picture_make_camera(&asked, &view, 1.5, 0.4 * i, &camera, NULL), TULLE_OK);
        double away[3];
        for (int k = 0; k < 3; k++) away[k] = camera.position[k] - camera.target[k];
        distances[i] = dot(away, away);
    }
    assert_true(fabs(distances[0] - distances[1]) < 1e-9 * distances[0]);
    /* Nothing to be seen is no reason to fail. */
    view = picture_view_empty();
    assert_int_equal(picture_make_camera(&asked, &view, 1.0, 0.0, &camera, NULL), TULLE_OK);
}

/* A body that is hidden or never there has an empty view, which adds nothing to others. */
static void test_empty_views_add_nothing(void **state) {
    (void)state;
    static const double corners[6] = {-1.0, -2.0, -3.0, 4.0, 5.0, 6.0};
    picture_view const empty = picture_view_empty();
    picture_view view = empty;
    picture_view_join(&view, &empty);
    assert_true(picture_bounds_is_empty(&view.bounds));
    picture_bounds_join(&view.bounds, &empty.bounds);
    assert_true(picture_bounds_is_empty(&view.bounds));
    assert_true(picture_bounds_get_diagonal(&view.bounds) == 0.0);
    picture_view_add(&view, corners, 2);
    picture_view const before = view;
    picture_view_join(&view, &empty);
    picture_bounds_join(&view.bounds, &empty.bounds);
    assert_memory_equal(&view, &before, sizeof view);
}

static void test_kinds(void **state) {
    (void)state;
    static const struct {
        const char *name;
        int kind; /* -1: refused */
    } cases[] = {{"a.png", PICTURE_STILL},
                 {"b/a_%04d.png", PICTURE_SERIES},
                 {"b%d/a.png", PICTURE_STILL},
                 {"a.mp4", PICTURE_FILM},
                 {"a.webm", PICTURE_FILM},
                 {"a.gif", PICTURE_FILM},
                 {"a.jpg", -1},
                 {"a", -1},
                 {"", -1},
                 {".png", -1},
                 {"b.png/a", -1},
                 {"a.png/", -1},
                 {"b/.mp4", -1},
                 {"a.PNG", -1}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        picture_kind kind = PICTURE_STILL;
        tulle_status const status = picture_find_kind(cases[i].name, &kind, NULL);
        if ((status == TULLE_OK ? (int)kind : -1) != cases[i].kind)
            fail_msg("\"%s\" is taken wrongly", cases[i].name);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_camera_texts),
        cmocka_unit_test(test_camera_texts_refused),
        cmocka_unit_test(test_options_go_before_scenes),
        cmocka_unit_test(test_default_camera_fills_the_picture),
        cmocka_unit_test(test_large_ground_does_not_count),
        cmocka_unit_test(test_positions_and_turns),
        cmocka_unit_test(test_empty_views_add_nothing),
        cmocka_unit_test(test_kinds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
