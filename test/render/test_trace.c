/* The ray tracer against closed forms: light that is the same everywhere, the share of a pixel that
 * a triangle covers, the same bits for any number of threads, defs that cannot be drawn. */
#include "render/render_fixture.h"

#include "io/failing_heap.h"

/* A white surface in uniform light sends that light, whatever its shape: no path has another
 * weight than 1 nor another end than the sky, so there is no noise at all and the bound is the
 * rounding of the mean to float. */
static void expect_uniform(const render_frame_def *def, double value) {
    float *const radiance = trace(def);
    for (size_t i = 0; i < 3 * (size_t)def->width * def->height; i++)
        if (fabs((double)radiance[i] - value) > 1e-6 * value)
            fail_msg("pixel %zu is %.9g, not %.9g", i / 3, (double)radiance[i], value);
    free(radiance);
}

static void white_in_uniform_light_is_uniform(void **state) {
    (void)state;
    tulle_mesh sphere = make_sphere(6, 1.0);
    small_mesh const room = make_box(vec3_make(-3, -3, -3), vec3_make(3, 3, 3));
    small_mesh shelf = {0};
    add_rectangle(&shelf, -0.2, -2.0, 2.5, 1.0, -1.5);
    render_surface surfaces[3] = {make_surface(small_mesh_view(&shelf), 1.0f),
                                  make_surface(tulle_mesh_get_view(&sphere), 1.0f),
                                  make_surface(small_mesh_view(&room), 1.0f)};
    render_frame_def def = make_frame(surfaces, 2);
    set_gray(def.lighting.sky_color, 0.7f);
    set_gray(def.lighting.horizon_color, 0.7f);
    set_gray(def.lighting.floor_color, 1.0f);
    def.lighting.floor_height = -2.0;
    def.camera = (render_camera){{2.9, 0.5, 1.0}, {0.0, 0.0, -0.3}, {0.0, 0.0, 1.0}, 1.4};
    for (uint32_t trial = 0; trial < 16; trial++) {
        def.lighting.bounces = trial % 4;
        def.lighting.has_floor = (trial / 4) % 2;
        def.surface_count = trial < 8 ? 2 : 3; /* the room is seen from inside */
        for (int s = 0; s < 3; s++)
            surfaces[s].crease_angle = trial % 3 == 0 ? 0.0 : (double)INFINITY;
        expect_uniform(&def, (double)0.7f);
    }
    tulle_mesh_destroy(&sphere);
}

/* A gray convex body: a path that leaves it never meets it again, so each pixel of it has one
 * value. A single ray that finds the surface it starts from would show. */
static void convex_bodies_do_not_see_themselves(void **state) {
    (void)state;
    double const gray = (double)0.4f, sky = (double)0.9f;
    for (int trial = 0; trial < 6; trial++) {
        double const scale = trial % 2 ? 1e-3 : 3.0, away = trial < 4 ? 0.0 : 500.0 * scale;
        tulle_mesh sphere = make_sphere(8, scale);
        for (size_t i = 0; i < 3 * sphere.vertex_count; i++) sphere.positions[i] += away;
        render_surface surface = make_surface(tulle_mesh_get_view(&sphere), 0.4f);
        surface.crease_angle = trial / 2 % 2 ? (double)INFINITY : 0.0;
        render_frame_def def = make_frame(&surface, 1);
        double const target[3] = {away, away, away};
        memcpy(def.camera.target, target, sizeof target);
        vec3_store(def.camera.position, 0,
                   vec3_make(away + 2.5 * scale, away - 1.1 * scale, away + 0.7 * scale));
        def.camera.field_of_view = 0.3; /* nothing but the body is seen */
        set_gray(def.lighting.sky_color, 0.9f);
        set_gray(def.lighting.horizon_color, 0.9f);
        def.lighting.bounces = 2;
        expect_uniform(&def, gray * sky);
        tulle_mesh_destroy(&sphere);
    }
}

static double cross2(const double a[2], const double b[2], double x, double y) {
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
}

static bool is_inside(double corners[3][2], double x, double y) {
    double const a = cross2(corners[0], corners[1], x, y);
    double const b = cross2(corners[1], corners[2], x, y);
    double const c = cross2(corners[2], corners[0], x, y);
    return (a >= 0.0 && b >= 0.0 && c >= 0.0) || (a <= 0.0 && b <= 0.0 && c <= 0.0);
}

/* Where a point is in the picture, in pixels from the top left corner. */
static void project(const render_frame_def *def, vec3 point, double place[2]) {
    vec3 const origin = get_view_ray(def, 0.0, 0.0);
    vec3 const across = vec3_sub(get_view_ray(def, 1.0, 0.0), origin);
    vec3 const down = vec3_sub(get_view_ray(def, 0.0, 1.0), origin);
    vec3 const forward = vec3_normalize(vec3_cross(across, down));
    vec3 const to_point = vec3_sub(point, vec3_load(def->camera.position, 0));
    vec3 const on_plane = vec3_sub(
        vec3_scale(to_point, vec3_dot(origin, forward) / vec3_dot(to_point, forward)), origin);
    place[0] = vec3_dot(on_plane, across) / vec3_norm2(across);
    place[1] = vec3_dot(on_plane, down) / vec3_norm2(down);
}

/* Share of a pixel, weighted by the filter, that lies in the triangle. */
static double find_cover(double corners[3][2], uint32_t x, uint32_t y) {
    enum { CUTS = 40 };
    int inside = 0;
    for (int i = 0; i < CUTS; i++)
        for (int j = 0; j < CUTS; j++)
            inside += is_inside(corners, x + 0.5 + get_filter_place(i, CUTS),
                                y + 0.5 + get_filter_place(j, CUTS));
    return (double)inside / (CUTS * CUTS);
}

/* Draws a black triangle before a sky of 1 and compares each pixel; returns the largest fault. */
static double compare_triangle(const double positions[9], uint32_t width, uint32_t height) {
    uint32_t const triangle[3] = {0, 1, 2};
    tulle_mesh_view const mesh = {positions, 3, triangle, 1};
    render_surface const surface = make_surface(mesh, 0.0f);
    render_frame_def def = make_frame(&surface, 1);
    def.width = width;
    def.height = height;
    def.samples = 256;
    def.camera = (render_camera){{4.0, -3.0, 2.0}, {0.1, 0.0, 0.2}, {0.0, 0.1, 1.0}, 0.5};
    set_gray(def.lighting.sky_color, 1.0f);
    set_gray(def.lighting.horizon_color, 1.0f);
    double corners[3][2], worst = 0.0;
    for (size_t i = 0; i < 3; i++) project(&def, vec3_load(positions, i), corners[i]);
    float *const radiance = trace(&def);
    for (uint32_t y = 0; y < height; y++) {
        double row_fault = 0.0;
        for (uint32_t x = 0; x < width; x++) {
            double const seen = (double)radiance[3 * ((size_t)y * width + x)];
            double const fault = 1.0 - seen - find_cover(corners, x, y);
            worst = fmax(worst, fabs(fault));
            row_fault += fault;
        }
        worst = fmax(worst, 0.5 * fabs(row_fault)); /* a whole row's width, more than one pixel */
    }
    free(radiance);
    return worst;
}

/* 256 stratified samples have 16 rows of strata along an edge; each row that the edge crosses is in
 * doubt by less than one of them: 16 of 256 at worst, with random signs a quarter of it. */
static void triangles_cover_what_their_projection_covers(void **state) {
    (void)state;
    double const bound = 0.03;
    double const plain[9] = {-0.6, 0.1, -0.4, 0.9, 0.2, -0.1, 0.2, -0.3, 0.9};
    assert_true(compare_triangle(plain, 48, 36) < bound);
    /* A needle's tip: from 2 pixels wide down to a point, nearly level, over the whole picture. */
    double const upright[9] = {0.30, 0.02, -0.3, 0.36, 0.02, -0.3, 0.2, 0.0, 0.75};
    assert_true(compare_triangle(upright, 40, 36) < bound);
    double const level[9] = {-0.4, -0.7, 0.20, -0.4, -0.7, 0.25, 0.5, 0.6, 0.32};
    assert_true(compare_triangle(level, 48, 30) < bound);
}

static void fill_scene(render_surface surfaces[2], tulle_mesh *sphere, small_mesh *sheet,
                       double *rest) {
    *sphere = make_sphere(8, 0.6);
    *sheet = (small_mesh){0};
    add_quad(sheet, vec3_make(-1, -1, 0.4), vec3_make(1, -1, 0.7), vec3_make(1, 1, 0.5),
             vec3_make(-1, 1, 1.0));
    for (size_t v = 0; v < sheet->vertex_count; v++) {
        rest[2 * v] = sheet->positions[3 * v];
        rest[2 * v + 1] = sheet->positions[3 * v + 1];
    }
    surfaces[0] = make_surface(small_mesh_view(sheet), 0.6f);
    surfaces[0].rest_coordinates = rest;
    surfaces[0].pattern = RENDER_PATTERN_WEAVE;
    surfaces[0].pattern_size = 0.2;
    surfaces[0].has_wire = true;
    surfaces[0].crease_angle = INFINITY;
    surfaces[1] = make_surface(tulle_mesh_get_view(sphere), 0.5f);
    surfaces[1].crease_angle = 0.7;
}

static void pictures_do_not_depend_on_threads(void **state) {
    (void)state;
    tulle_mesh sphere;
    small_mesh sheet;
    double rest[2 * 64];
    render_surface surfaces[2];
    fill_scene(surfaces, &sphere, &sheet, rest);
    render_mark const mark = {{0.5, -0.5, 0.8}, 0.1, {1.0f, 0.2f, 0.1f}};
    render_frame_def def = make_frame(surfaces, 2);
    def.marks = &mark;
    def.mark_count = 1;
    def.lighting = render_lighting_default();
    def.camera = (render_camera){{2.5, -3.0, 2.0}, {0.0, 0.0, 0.3}, {0.0, 0.0, 1.0}, 0.6};
    def.width = 70; /* not a multiple of a tile */
    def.height = 45;
    size_t const bytes = 3 * (size_t)def.width * def.height * sizeof(float);
    float *pictures[5];
    int const threads[5] = {1, 2, 5, 0, 1};
    for (int i = 0; i < 5; i++) {
        def.threads = threads[i];
        def.seed = i == 4 ? 2 : 1;
        pictures[i] = trace(&def);
    }
    for (int i = 1; i < 4; i++) assert_memory_equal(pictures[0], pictures[i], bytes);
    assert_memory_not_equal(pictures[0], pictures[4], bytes);
    for (int i = 0; i < 5; i++) free(pictures[i]);
    tulle_mesh_destroy(&sphere);
}

/* A mark has its own color, in front of and behind surfaces as its place says, and throws no
 * shadow. */
static void marks_are_seen_where_they_are(void **state) {
    (void)state;
    small_mesh sheet = {0};
    add_rectangle(&sheet, -5, -5, 5, 5, 0.0);
    render_surface const surface = make_surface(small_mesh_view(&sheet), 1.0f);
    render_mark const marks[2] = {{{1.0, 0.5, 0.1}, 0.4, {0.9f, 0.5f, 0.1f}},
                                  {{-1.0, 0.5, -0.5}, 0.4, {0.1f, 0.1f, 0.9f}}};
    render_frame_def def = make_frame(&surface, 1);
    def.marks = marks;
    def.mark_count = 2;
    set_gray(def.lighting.light_radiance, 0.5f);
    float *const radiance = trace(&def);
    double const pixel = 2.0 * tan(0.25) / def.height;
    for (uint32_t y = 0; y < def.height; y++)
        for (uint32_t x = 0; x < def.width; x++) {
            const float *const color = radiance + 3 * ((size_t)y * def.width + x);
            /* In the plane through the ball's middle, 9.9 m away. */
            double const right = 9.9 * pixel * (x + 0.5 - 0.5 * def.width) - 1.0;
            double const up = 9.9 * pixel * (0.5 * def.height - y - 0.5) - 0.5;
            double const away = hypot(right, up), doubt = 9.9 * pixel * 1.3 + 0.01;
            if (away < 0.4 - doubt) assert_memory_equal(color, marks[0].color, 12);
            if (away > 0.4 + doubt) assert_true(fabsf(color[0] - 0.5f) < 1e-6f);
        }
    free(radiance);
}

static tulle_status try_def(const render_frame_def *def) {
    static float radiance[3 * 48 * 27];
    render_context *context;
    tulle_error error = {0};
    assert_int_equal(render_context_create(&context, &error), TULLE_OK);
    tulle_status const status = render_trace(context, def, radiance, &error);
    if (status != TULLE_OK) assert_true(strlen(error.message) > 10 && error.status == status);
    render_context_destroy(context);
    return status;
}

#define REFUSE(...)                                                                                \
    do {                                                                                           \
        render_surface surface = make_surface(small_mesh_view(&sheet), 1.0f);                      \
        render_frame_def def = make_frame(&surface, 1);                                            \
        render_mark mark = {{0.0, 0.0, 0.0}, 0.1, {0.0f, 0.0f, 0.0f}};                             \
        def.marks = &mark;                                                                         \
        def.mark_count = 1;                                                                        \
        assert_int_equal(try_def(&def), TULLE_OK);                                                 \
        __VA_ARGS__;                                                                               \
        assert_int_equal(try_def(&def), TULLE_ERROR_INVALID_ARGUMENT);                             \
    } while (0)

static void what_cannot_be_drawn_is_refused(void **state) {
    (void)state;
    small_mesh sheet = {0};
    add_rectangle(&sheet, -1, -1, 1, 1, 0.0);
    REFUSE(def.samples = 0);
    REFUSE(def.samples = 70000);
    REFUSE(def.width = 0);
    REFUSE(def.height = RENDER_IMAGE_SIDE_MAX + 1);
    REFUSE(def.camera.position[1] = NAN);
    REFUSE(def.camera.position[2] = 1e300);
    REFUSE(def.camera.position[2] = 0.0);
    REFUSE(def.camera.up[1] = 0.0);
    REFUSE((def.camera.up[1] = 0.0, def.camera.up[2] = -3.0));
    REFUSE(def.camera.field_of_view = 0.0);
    REFUSE(def.camera.field_of_view = 3.2);
    REFUSE(def.lighting.light_direction[2] = 0.0);
    REFUSE(def.lighting.light_angle = 1.6);
    REFUSE(def.lighting.sky_color[0] = -1.0f);
    REFUSE(def.lighting.floor_color[2] = 2.0f);
    REFUSE(def.lighting.bounces = 1000);
    REFUSE((def.lighting.has_floor = true, def.lighting.floor_height = INFINITY));
    REFUSE(sheet.positions[4] = NAN);
    sheet.positions[4] = 0.0;
    REFUSE(sheet.triangles[4] = 4);
    sheet.triangles[4] = 2;
    REFUSE(surface.front_color[0] = 1.5f);
    REFUSE(surface.crease_angle = NAN);
    REFUSE((surface.pattern = RENDER_PATTERN_CHECK, surface.rest_coordinates = sheet.positions));
    REFUSE(surface.vertex_colors = (float[]){0, 0, 0, 0, 0, 0, 0, NAN, 0, 0, 0, 0});
    REFUSE(surface.triangle_colors = (float[]){0, 0, 0, 0, 0, 1.01f});
    REFUSE(mark.radius = 0.0);
    REFUSE(mark.position[0] = NAN);
}

/* No surface, and surfaces without a triangle or with triangles without area. */
static void empty_scenes_show_the_sky(void **state) {
    (void)state;
    small_mesh sheet = {0};
    add_rectangle(&sheet, 1.0, 1.0, 1.0, 1.0, 0.0);
    render_surface surfaces[2] = {make_surface((tulle_mesh_view){0}, 1.0f),
                                  make_surface(small_mesh_view(&sheet), 0.0f)};
    surfaces[1].crease_angle = INFINITY;
    render_frame_def def = make_frame(surfaces, 0);
    set_gray(def.lighting.sky_color, 0.3f);
    set_gray(def.lighting.horizon_color, 0.3f);
    for (def.surface_count = 0; def.surface_count < 3; def.surface_count++)
        expect_uniform(&def, (double)0.3f);
}

/* Each call of the heap fails once, in our part and in Embree's; then the picture is made. */
static void short_memory_is_said(void **state) {
    (void)state;
    if (!HAS_OWN_HEAP) skip();
    small_mesh const box = make_box(vec3_make(-1, -1, -1), vec3_make(1, 1, 1));
    render_surface const surface = make_surface(small_mesh_view(&box), 1.0f);
    render_frame_def def = make_frame(&surface, 1);
    def.threads = 1;
    static float radiance[3 * 48 * 27];
    render_context *context;
    tulle_error error;
    assert_int_equal(render_context_create(&context, &error), TULLE_OK);
    assert_int_equal(render_trace(context, &def, radiance, &error), TULLE_OK);
    bool is_done = false;
    for (long call = 0; !is_done; call++) {
        assert_true(call < 1000);
        watch_heap(call);
        tulle_status const status = render_trace(context, &def, radiance, &error);
        is_done = !unwatch_heap();
        if (is_done) assert_int_equal(status, TULLE_OK);
        if (status != TULLE_OK) assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
    }
    render_context_destroy(context);
}

int main(void) {
    if (skip_without_ray_tracer()) return SKIPPED;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(white_in_uniform_light_is_uniform),
        cmocka_unit_test(convex_bodies_do_not_see_themselves),
        cmocka_unit_test(triangles_cover_what_their_projection_covers),
        cmocka_unit_test(pictures_do_not_depend_on_threads),
        cmocka_unit_test(marks_are_seen_where_they_are),
        cmocka_unit_test(what_cannot_be_drawn_is_refused),
        cmocka_unit_test(empty_scenes_show_the_sky),
        cmocka_unit_test(short_memory_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
