/* Small pictures as they were when someone last looked at them, test/render/golden/NAME.png. After
 * a change that is meant to be seen: TULLE_TEST_RENEW_GOLDEN=1 writes them anew; look at them.
 *
 * The same machine gives the same bytes. Another processor may not: Embree picks its code by the
 * vector width, and its divisions are approximate, so a ray near an edge may find the other side of
 * it, and a library's sine may differ in its last bit. That changes single samples: one of 64 is 4
 * of 255, in linear light; near black the curve to sRGB stretches it by up to 3.3 within the range
 * that the pictures use. Three samples of one pixel are allowed, and in the mean a tenth of one. */
#include "render/render_fixture.h"

enum { SAMPLES = 64, BYTE_FAULT_MAX = 3 * 4 * 33 / 10 };
static const double mean_fault_max = 0.4;

enum { CLOTH_SIDE = 33 };

typedef struct scene {
    tulle_mesh cloth;
    small_mesh box;
    double rest[2 * CLOTH_SIDE * CLOTH_SIDE];
    float colors[3 * CLOTH_SIDE * CLOTH_SIDE];
    render_surface surfaces[2];
} scene;

/* A cloth in folds over the corner of a box. */
static void make_scene(scene *s) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = def.size[1] = 2.0;
    def.resolution[0] = def.resolution[1] = CLOTH_SIDE;
    assert_int_equal(tulle_shape_generate(&def, &s->cloth, NULL), TULLE_OK);
    assert_int_equal(s->cloth.vertex_count, CLOTH_SIDE * CLOTH_SIDE);
    for (size_t v = 0; v < s->cloth.vertex_count; v++) {
        double *const p = s->cloth.positions + 3 * v;
        double const away = hypot(p[0], p[1]), angle = atan2(p[1], p[0]);
        s->rest[2 * v] = p[0];
        s->rest[2 * v + 1] = p[1];
        p[2] = 0.82 - 0.3 * away * away + 0.09 * away * away * sin(7.0 * angle);
        s->colors[3 * v] = (float)(0.5 + 0.4 * sin(5.0 * p[0]));
        s->colors[3 * v + 1] = 0.3f;
        s->colors[3 * v + 2] = (float)(0.5 + 0.4 * cos(4.0 * p[1]));
    }
    s->box = make_box(vec3_make(-0.3, -0.4, 0.0), vec3_make(0.5, 0.3, 0.6));
    s->surfaces[0] = (render_surface){.mesh = tulle_mesh_get_view(&s->cloth),
                                      .rest_coordinates = s->rest,
                                      .front_color = {0.45f, 0.07f, 0.06f},
                                      .back_color = {0.72f, 0.50f, 0.30f},
                                      .pattern = RENDER_PATTERN_CHECK,
                                      .pattern_size = 0.25,
                                      .crease_angle = (double)INFINITY};
    s->surfaces[1] = make_surface(small_mesh_view(&s->box), 0.4f);
}

static void compare(const char *name, const render_frame_def *def) {
    const char *const source = getenv("TULLE_SOURCE_DIR");
    char path[1024];
    snprintf(path, sizeof path, "%s/test/render/golden/%s.png", source ? source : ".", name);
    float *const radiance = trace(def);
    render_image image, golden;
    tulle_error error;
    assert_int_equal(render_image_create(def->width, def->height, &image, &error), TULLE_OK);
    render_expose(radiance, 1.0, &image);
    free(radiance);
    if (getenv("TULLE_TEST_RENEW_GOLDEN"))
        assert_int_equal(render_image_write_png(path, &image, NULL, 0, &error), TULLE_OK);
    if (render_image_read_png(path, &golden, NULL, NULL, 0, &error) != TULLE_OK)
        fail_msg("%s: %s", path, error.message);
    assert_int_equal(golden.width, image.width);
    assert_int_equal(golden.height, image.height);
    size_t const count = 3 * (size_t)image.width * image.height;
    double sum = 0.0;
    int worst = 0;
    for (size_t i = 0; i < count; i++) {
        int const fault = abs(image.pixels[i] - golden.pixels[i]);
        sum += fault;
        if (fault > worst) worst = fault;
    }
    print_message("%s: worst %d, mean %.4f\n", name, worst, sum / (double)count);
    assert_true(worst <= BYTE_FAULT_MAX && sum / (double)count <= mean_fault_max);
    render_image_destroy(&image);
    render_image_destroy(&golden);
}

static void pictures_are_as_they_were(void **state) {
    (void)state;
    static scene s;
    make_scene(&s);
    render_frame_def def = make_frame(s.surfaces, 2);
    double const low[3] = {-1.0, -1.0, 0.0}, high[3] = {1.0, 1.0, 0.85};
    def.camera = render_camera_frame(low, high, -1.05, 0.35, 16.0 / 9.0);
    def.lighting = render_lighting_default();
    def.width = 64;
    def.height = 36;
    def.samples = SAMPLES;
    compare("cloth", &def);
    render_mark const marks[2] = {{{0.5, -0.4, 0.75}, 0.08, {0.1f, 0.5f, 0.1f}},
                                  {{-0.3, -0.6, 0.7}, 0.06, {0.8f, 0.6f, 0.0f}}};
    def.marks = marks;
    def.mark_count = 2;
    s.surfaces[0].vertex_colors = s.colors;
    s.surfaces[1].has_wire = true;
    def.camera = render_camera_frame(low, high, 0.4, 0.05, 16.0 / 9.0); /* from beneath the folds */
    compare("colors", &def);
    tulle_mesh_destroy(&s.cloth);
}

int main(void) {
    if (skip_without_ray_tracer()) return SKIPPED;
    const struct CMUnitTest tests[] = {cmocka_unit_test(pictures_are_as_they_were)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
