/* How much of some surfaces cameras see (render_find_sights): counts of pixels that plane geometry
 * gives, what hides them, the floor, the number of threads. */
#include "render/render_fixture.h"

enum { WIDTH = 60, HEIGHT = 40, CAMERAS = 3 };

typedef struct scene {
    small_mesh sheet, wall, shade;
    render_surface surfaces[3];
    render_frame_def def;
    render_camera cameras[CAMERAS];
} scene;

/* A sheet of 1 m in the plane y = 0. A wall before it, at y = -1, hides its lower half from a
 * camera far in front. A shade behind it hides all of it from behind. The third camera is in front,
 * too, and turned aside. */
static void make_scene(scene *s) {
    memset(s, 0, sizeof *s);
    add_quad(&s->sheet, vec3_make(-0.5, 0, 0), vec3_make(0.5, 0, 0), vec3_make(0.5, 0, 1),
             vec3_make(-0.5, 0, 1));
    add_quad(&s->wall, vec3_make(-2, -1, -1), vec3_make(2, -1, -1), vec3_make(2, -1, 0.5),
             vec3_make(-2, -1, 0.5));
    for (int k = 0; k < 5; k++) /* one after the other */
        add_quad(&s->shade, vec3_make(-2, 1 + k, -1), vec3_make(2, 1 + k, -1),
                 vec3_make(2, 1 + k, 2), vec3_make(-2, 1 + k, 2));
    s->surfaces[0] = make_surface(small_mesh_view(&s->sheet), 0.5f);
    s->surfaces[1] = make_surface(small_mesh_view(&s->wall), 0.5f);
    s->surfaces[2] = make_surface(small_mesh_view(&s->shade), 0.5f);
    for (int c = 0; c < CAMERAS; c++)
        s->cameras[c] = (render_camera){.position = {0, c == 1 ? 1000 : -1000, 0.5},
                                        .target = {c == 2 ? 500 : 0, 0, 0.5},
                                        .up = {0, 0, 1},
                                        .field_of_view = 2.0 * atan(1e-3)};
    s->def = (render_frame_def){.surfaces = s->surfaces,
                                .surface_count = 3,
                                .camera = s->cameras[0],
                                .lighting = render_lighting_default(),
                                .width = WIDTH,
                                .height = HEIGHT,
                                .samples = 1,
                                .threads = 1};
    s->def.lighting.has_floor = false;
}

static void look(const scene *s, size_t wanted_count, render_sight *sights) {
    for (int c = 0; c < CAMERAS; c++) sights[c].camera = s->cameras[c];
    render_context *context;
    tulle_error error;
    if (render_context_create(&context, &error) != TULLE_OK ||
        render_find_sights(context, &s->def, wanted_count, sights, CAMERAS, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    render_context_destroy(context);
}

static void halves_and_hiders(void **state) {
    (void)state;
    scene s;
    make_scene(&s);
    for (int threads = 1; threads <= 3; threads += 2) {
        size_t hidden_by[2][4] = {{0}};
        render_sight sights[CAMERAS] = {{.hidden_by = hidden_by[0]}, {.hidden_by = hidden_by[1]}};
        s.def.threads = threads;
        look(&s, 1, sights);
        /* The picture is 2 m high and 40 pixels: the sheet covers 20 by 20. */
        assert_int_equal(sights[0].covered, 400);
        assert_int_equal(sights[0].seen, 200);
        assert_int_equal(hidden_by[0][1], 200);
        assert_int_equal(hidden_by[0][0] + hidden_by[0][2] + hidden_by[0][3], 0);
        assert_int_equal(sights[1].covered, 400);
        assert_int_equal(sights[1].seen, 0);
        assert_int_equal(hidden_by[1][2], 400);
        assert_int_equal(sights[2].covered, 0);
    }
    /* What is wanted hides nothing that is wanted. The numbers are added to. */
    render_sight both[CAMERAS] = {{.covered = 0}};
    for (int k = 1; k < 3; k++) {
        look(&s, 2, both);
        assert_int_equal(both[0].seen, both[0].covered);
        assert_true(both[0].seen == (size_t)k * (200 + WIDTH * HEIGHT / 2));
    }
}

static void the_floor_hides(void **state) {
    (void)state;
    scene s;
    make_scene(&s);
    s.def.lighting.has_floor = true;
    s.def.lighting.floor_height = 2.0; /* over the camera and the sheet: out of sight */
    s.def.surface_count = 1;
    size_t hidden_by[2] = {0};
    render_sight sights[CAMERAS] = {{.hidden_by = hidden_by}};
    look(&s, 1, sights);
    assert_int_equal(sights[0].seen, 400);
    s.cameras[0].position[2] = 300.0; /* from above through the floor */
    look(&s, 1, sights);
    assert_int_equal(sights[0].seen, 400);
    assert_true(hidden_by[1] > 300 && hidden_by[1] == sights[0].covered - 400);
    assert_int_equal(hidden_by[0], 0);
}

static void a_bad_def_is_refused(void **state) {
    (void)state;
    scene s;
    make_scene(&s);
    s.def.width = 0;
    render_context *context;
    render_sight sights[CAMERAS] = {{.covered = 0}};
    tulle_error error;
    assert_int_equal(render_context_create(&context, &error), TULLE_OK);
    assert_int_equal(render_find_sights(context, &s.def, 1, sights, CAMERAS, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(sights[0].covered, 0);
    render_context_destroy(context);
}

int main(void) {
    int const skipped = skip_without_ray_tracer();
    if (skipped) return skipped;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(halves_and_hiders),
        cmocka_unit_test(the_floor_hides),
        cmocka_unit_test(a_bad_def_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
