/* Shadows where geometry says, from metres down to the thickness of a contact; no light where
 * geometry says that there is none; no spots on lit cloth. */
#include "render/render_fixture.h"

#define CONTACT_GAP 1e-4 /* [m] between cloth and what it lies on */
/* [m] above the surface where rays start: 2^-24 (2 (1.3 + 0.4) + 8 * 8.5), with triangles of 8.5 m.
 */
static const double ray_start_max = 4.3e-6;

/* A rectangle above the plane z = 0, both in the xy plane. */
typedef struct shade {
    double low[2], high[2], height;
    double height_doubt; /* [m] by which rays may start too high */
} shade;

static bool is_in_shade(const shade *s, vec3 point, double slack) {
    return point.x >= s->low[0] - slack && point.x <= s->high[0] + slack &&
           point.y >= s->low[1] - slack && point.y <= s->high[1] + slack;
}

/* What a white point of the plane sends by a light of radiance 1: the mean over the light's disc of
 * the directions that pass the shade. */
static double find_light(const render_lighting *lighting, const shade *s, vec3 point) {
    enum { RINGS = 8, SPOKES = 20 };
    vec3 const middle = vec3_normalize(vec3_load(lighting->light_direction, 0));
    vec3 const side = vec3_normalize(vec3_cross(middle, vec3_make(0.3, 1.0, 0.2)));
    vec3 const other = vec3_cross(middle, side);
    double sum = 0.0;
    for (int ring = 0; ring < RINGS; ring++)
        for (int spoke = 0; spoke < SPOKES; spoke++) {
            double const away = sin(lighting->light_angle) * sqrt((ring + 0.5) / RINGS);
            double const turn = 6.283185307179586 * (spoke + 0.5 * (ring % 2)) / SPOKES;
            vec3 const across =
                vec3_add_scaled(vec3_scale(side, away * cos(turn)), other, away * sin(turn));
            vec3 const direction = vec3_add_scaled(across, middle, sqrt(1.0 - away * away));
            vec3 const above = vec3_add_scaled(point, direction, s->height / direction.z);
            if (!is_in_shade(s, above, 0.0)) sum += direction.z / vec3_dot(direction, middle);
        }
    return sum / (RINGS * SPOKES);
}

/* Expected radiance of a pixel; negative where the shade itself is seen in a part of it. */
static double find_pixel(const render_frame_def *def, const shade *s, uint32_t x, uint32_t y) {
    enum { CUTS = 6 };
    double sum = 0.0;
    for (int i = 0; i < CUTS; i++)
        for (int j = 0; j < CUTS; j++) {
            vec3 const ray = get_view_ray(def, x + 0.5 + get_filter_place(i, CUTS),
                                          y + 0.5 + get_filter_place(j, CUTS));
            vec3 const origin = vec3_load(def->camera.position, 0);
            vec3 const ground = vec3_add_scaled(origin, ray, -origin.z / ray.z);
            vec3 const crossing = vec3_add_scaled(origin, ray, (s->height - origin.z) / ray.z);
            double const slack = 1.5 * vec3_norm(vec3_sub(ground, origin)) *
                                 tan(0.5 * def->camera.field_of_view) / def->height;
            if (is_in_shade(s, crossing, slack)) return -1.0;
            sum += find_light(&def->lighting, s, ground);
        }
    return sum / (CUTS * CUTS);
}

/* Every pixel that shows the plane against the integral. 1024 samples that were not stratified
 * would have a standard deviation of 1/64 of the light at most; the bound is four of them. Where
 * the whole light is hidden or free there is no doubt but the light's own slant. */
static void compare_shadow(const render_frame_def *def, const shade *s) {
    float *const radiance = trace(def);
    double const slant = tan(def->lighting.light_angle);
    shade lower = *s;
    lower.height -= s->height_doubt;
    double mean_fault = 0.0;
    size_t dark = 0, lit = 0, half = 0;
    for (uint32_t y = 0; y < def->height; y++)
        for (uint32_t x = 0; x < def->width; x++) {
            double const expected = find_pixel(def, s, x, y);
            double const seen = (double)radiance[3 * ((size_t)y * def->width + x)];
            if (expected < 0.0) continue;
            double const other = find_pixel(def, &lower, x, y);
            double const fault = fmax(fmin(expected, other) - seen, seen - fmax(expected, other));
            if (fault > 4.0 / 64) fail_msg("pixel %u, %u is %g, not %g", x, y, seen, expected);
            mean_fault += fmax(fault, 0.0) / (def->width * def->height);
            if (expected == 0.0 && seen > 0.02)
                fail_msg("pixel %u, %u is %g in the shadow", x, y, seen);
            dark += expected == 0.0;
            lit +=
                expected > 0.999 * vec3_normalize(vec3_load(def->lighting.light_direction, 0)).z &&
                fabs(seen - expected) < 0.01 + 0.1 * slant;
            half += expected > 0.1 && expected < 0.6;
        }
    free(radiance);
    assert_true(mean_fault < 0.01);
    assert_true(dark > 8 && lit > 50 && half > 8); /* the picture shows all three */
}

static void shadows_lie_where_geometry_says(void **state) {
    (void)state;
    shade const above = {{-0.3, -0.2}, {0.3, 0.2}, 0.6, 0.0};
    small_mesh square = {0};
    add_rectangle(&square, above.low[0], above.low[1], above.high[0], above.high[1], above.height);
    render_surface const surface = make_surface(small_mesh_view(&square), 0.0f);
    render_frame_def def = make_frame(&surface, 1);
    def.camera = (render_camera){{-0.7, -4.0, 3.0}, {-0.6, 0.0, 0.0}, {0.0, 0.0, 1.0}, 0.2};
    def.samples = 1024;
    def.width = 40;
    def.height = 22;
    def.lighting.light_direction[0] = 0.9; /* 42 degrees down */
    set_gray(def.lighting.light_radiance, 1.0f);
    set_gray(def.lighting.floor_color, 1.0f);
    def.lighting.has_floor = true;
    def.lighting.light_angle = 0.1;
    compare_shadow(&def, &above);
    def.lighting.light_angle = 0.02;
    compare_shadow(&def, &above);
}

/* A black sheet on a white one, or on the floor, at a contact's distance in a scene of 6 m: its
 * shadow comes out by a tenth of a millimetre, seen 10 micrometres a pixel. */
static void contact_shadows_are_as_thin_as_the_gap(void **state) {
    (void)state;
    shade const above = {{-1.3, -2.9}, {1.0, 2.9}, CONTACT_GAP, ray_start_max};
    small_mesh upper = {0}, lower = {0};
    add_rectangle(&upper, above.low[0], above.low[1], above.high[0], above.high[1], above.height);
    add_rectangle(&lower, -3.0, -3.0, 3.0, 3.0, 0.0);
    render_surface const surfaces[2] = {make_surface(small_mesh_view(&upper), 0.0f),
                                        make_surface(small_mesh_view(&lower), 1.0f)};
    render_frame_def def = make_frame(surfaces, 2);
    /* The shade's left edge, from above and left. */
    def.camera = (render_camera){{-1.8, 0.4, 1.0}, {-1.3001, 0.4, 0.0}, {0.0, 0.0, 1.0}, 0.00025};
    def.samples = 1024;
    def.width = 40;
    def.height = 22;
    def.lighting.light_direction[0] = 1.0; /* 45 degrees down */
    def.lighting.light_angle = 0.15;
    set_gray(def.lighting.light_radiance, 1.0f);
    set_gray(def.lighting.floor_color, 1.0f);
    compare_shadow(&def, &above);
    def.lighting.has_floor = true; /* a sheet that lies in the floor hides it */
    compare_shadow(&def, &above);
    def.surface_count = 1;
    compare_shadow(&def, &above);
}

static void expect_darkness(const render_frame_def *def, const char *what) {
    float *const radiance = trace(def);
    for (size_t i = 0; i < 3 * (size_t)def->width * def->height; i++)
        if (radiance[i] != 0.0f)
            fail_msg("%s: light of %g at pixel %zu", what, (double)radiance[i], i / 3);
    free(radiance);
}

/* A box of cloth, closed, in bright light: no light comes in, with sharp edges and with edges
 * rounded by normals. */
static void closed_boxes_are_dark_inside(void **state) {
    (void)state;
    for (int trial = 0; trial < 8; trial++) {
        double const size = trial % 2 ? 3.0 : 0.01;
        double const flat = trial / 2 % 2 ? CONTACT_GAP / 0.01 : 1.0; /* two sheets at contact */
        small_mesh const box =
            make_box(vec3_make(-size, -size, -size * flat), vec3_make(size, size, size * flat));
        render_surface surface = make_surface(small_mesh_view(&box), 1.0f);
        surface.crease_angle = trial / 4 ? (double)INFINITY : 0.0;
        render_frame_def def = make_frame(&surface, 1);
        def.camera = (render_camera){{-0.9 * size, -0.8 * size, 0.3 * size * flat},
                                     {0.2 * size, 0.3 * size, -0.2 * size * flat},
                                     {0.0, 0.0, 1.0},
                                     1.5};
        def.samples = 64;
        def.lighting.light_direction[0] = 0.4;
        def.lighting.light_direction[1] = -0.7;
        def.lighting.light_angle = 0.3;
        def.lighting.bounces = 2;
        set_gray(def.lighting.light_radiance, 1.0f);
        expect_darkness(&def, "in a box");
    }
}

/* Coarse bodies with smooth normals bulge, for the light, beyond their triangles. A lid just above
 * a ball is nearer than that bulge and must still keep the light out; and light must not come
 * through a triangle from behind where its bulge begins, as in a tube that is bent. */
static void bulges_let_no_light_in(void **state) {
    (void)state;
    tulle_mesh ball = make_sphere(2, 1.0), ring;
    small_mesh const room = make_box(vec3_make(-1.3, -1.3, -1.3), vec3_make(1.3, 1.3, 1.001));
    tulle_shape_def torus = tulle_shape_def_default(TULLE_SHAPE_TORUS);
    torus.radius = 1.0;
    torus.inner_radius = 0.4;
    torus.resolution[0] = 10;
    torus.resolution[1] = 7;
    assert_int_equal(tulle_shape_generate(&torus, &ring, NULL), TULLE_OK);
    render_surface surfaces[2] = {make_surface(tulle_mesh_get_view(&ball), 1.0f),
                                  make_surface(small_mesh_view(&room), 1.0f)};
    render_surface tube = make_surface(tulle_mesh_get_view(&ring), 1.0f);
    surfaces[0].crease_angle = tube.crease_angle = (double)INFINITY;
    for (int trial = 0; trial < 8; trial++) {
        double const turn = 0.8 * trial;
        render_frame_def def = make_frame(surfaces, 2);
        def.samples = 64;
        def.lighting.light_angle = 0.2;
        def.lighting.bounces = 1;
        set_gray(def.lighting.light_radiance, 1.0f);
        def.lighting.light_direction[0] = cos(turn);
        def.lighting.light_direction[1] = sin(turn);
        def.lighting.light_direction[2] = 0.2;
        def.camera = (render_camera){
            {-1.2 * cos(turn), -1.2 * sin(turn), 0.98}, {0.0, 0.0, 0.9}, {0.0, 0.0, 1.0}, 1.2};
        expect_darkness(&def, "under a lid");
        def.surfaces = &tube;
        def.surface_count = 1;
        def.camera = (render_camera){{1.0, -0.2, 0.05}, {0.6, 0.8, -0.1}, {0.0, 0.0, 1.0}, 1.6};
        expect_darkness(&def, "in a tube");
    }
    tulle_mesh_destroy(&ball);
    tulle_mesh_destroy(&ring);
}

enum { SHEET_SIDE = 61 }; /* vertices along a side of a wavy sheet */

/* A sheet of 6 m with folds, pushed down along z. */
static tulle_mesh make_wavy_sheet(double depth, double lift, double fold_height) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = def.size[1] = 6.0;
    def.resolution[0] = def.resolution[1] = SHEET_SIDE;
    tulle_mesh sheet;
    assert_int_equal(tulle_shape_generate(&def, &sheet, NULL), TULLE_OK);
    for (size_t v = 0; v < sheet.vertex_count; v++) {
        double *const p = sheet.positions + 3 * v;
        p[2] += lift - depth + fold_height * sin(2.1 * p[0]) * cos(1.7 * p[1]);
    }
    return sheet;
}

/* The upper of two sheets at contact looks as it does alone: where the view and the light are the
 * same, only the center of the single precision numbers differs, by half the gap. Light or view
 * through it, or spots, would be differences of a large part of 1. */
static void sheets_at_contact_do_not_show_through(void **state) {
    (void)state;
    for (int trial = 0; trial < 6; trial++) {
        double const lift = trial % 2 ? 300.0 : 0.0, fold_height = trial < 2 ? 0.0 : 0.3;
        tulle_mesh upper = make_wavy_sheet(0.0, lift, fold_height);
        tulle_mesh lower = make_wavy_sheet(CONTACT_GAP, lift, fold_height);
        render_surface surfaces[2] = {make_surface(tulle_mesh_get_view(&upper), 0.6f),
                                      make_surface(tulle_mesh_get_view(&lower), 0.0f)};
        for (int s = 0; s < 2; s++) surfaces[s].crease_angle = trial < 4 ? (double)INFINITY : 0.0;
        render_frame_def def = make_frame(surfaces, 1);
        def.camera =
            (render_camera){{-5.0, -4.0, lift + 2.5}, {0.0, 0.0, lift}, {0.0, 0.0, 1.0}, 0.3};
        def.lighting = render_lighting_default();
        def.lighting.has_floor = false;
        def.width = 96;
        def.height = 54;
        float *const alone = trace(&def);
        def.surface_count = 2;
        float *const both = trace(&def);
        double fault = 0.0;
        size_t const count = 3 * (size_t)def.width * def.height;
        for (size_t i = 0; i < count; i++) fault += fabs((double)(alone[i] - both[i]));
        if (fault / (double)count > 1e-4)
            fail_msg("trial %d: mean difference %g", trial, fault / (double)count);
        free(alone);
        free(both);
        tulle_mesh_destroy(&upper);
        tulle_mesh_destroy(&lower);
    }
}

/* A flat sheet that faces the light, above another at contact: every pixel has the one value. */
static void lit_flat_cloth_has_no_spots(void **state) {
    (void)state;
    tulle_mesh upper = make_wavy_sheet(0.0, 7.0, 0.0);
    tulle_mesh lower = make_wavy_sheet(CONTACT_GAP, 7.0, 0.0);
    render_surface surfaces[2] = {make_surface(tulle_mesh_get_view(&lower), 0.0f),
                                  make_surface(tulle_mesh_get_view(&upper), 0.5f)};
    render_frame_def def = make_frame(surfaces, 2);
    def.camera = (render_camera){{1.0, -2.0, 13.0}, {0.0, 0.5, 7.0}, {0.0, 0.0, 1.0}, 0.3};
    def.lighting.light_angle = 0.2;
    set_gray(def.lighting.light_radiance, 0.8f);
    def.lighting.has_floor = true;
    for (int trial = 0; trial < 2; trial++) {
        for (int s = 0; s < 2; s++) surfaces[s].crease_angle = trial ? (double)INFINITY : 0.0;
        float *const radiance = trace(&def);
        for (size_t i = 0; i < 3 * (size_t)def.width * def.height; i++)
            if (fabs((double)radiance[i] - 0.5 * (double)0.8f) > 1e-6)
                fail_msg("pixel %zu is %.9g", i / 3, (double)radiance[i]);
        free(radiance);
    }
    tulle_mesh_destroy(&upper);
    tulle_mesh_destroy(&lower);
}

/* A flat sheet, tilted, so that no coordinate is free of rounding, twice in one place, so that the
 * number of the triangle that a ray leaves does not save it, and lit from almost the whole
 * hemisphere. The light is centred on the normal, so every sample is the whole light, within the
 * rounding of the vertices over the size of a triangle, 4e-7 / 0.1. */
static void tilted_cloth_has_no_spots(void **state) {
    (void)state;
    for (int trial = 0; trial < 4; trial++) {
        double const slope[2] = {0.3 + 0.1 * trial, -0.7 + 0.4 * trial};
        tulle_mesh sheet = make_wavy_sheet(0.0, 0.0, 0.0);
        for (size_t v = 0; v < sheet.vertex_count; v++) {
            double *const p = sheet.positions + 3 * v;
            p[2] = slope[0] * p[0] + slope[1] * p[1];
        }
        vec3 const normal = vec3_normalize(vec3_make(-slope[0], -slope[1], 1.0));
        render_surface const surface = make_surface(tulle_mesh_get_view(&sheet), 0.5f);
        render_surface const surfaces[2] = {surface, surface};
        render_frame_def def = make_frame(surfaces, 2);
        vec3_store(def.camera.position, 0, vec3_scale(normal, 6.0));
        vec3_store(def.lighting.light_direction, 0, normal);
        def.lighting.light_angle = 1.5;
        def.samples = 256;
        set_gray(def.lighting.light_radiance, 0.8f);
        float *const radiance = trace(&def);
        for (size_t i = 0; i < 3 * (size_t)def.width * def.height; i++)
            if (fabs((double)radiance[i] - 0.5 * (double)0.8f) > 1e-4)
                fail_msg("trial %d: pixel %zu is %.9g", trial, i / 3, (double)radiance[i]);
        free(radiance);
        tulle_mesh_destroy(&sheet);
    }
}

int main(void) {
    if (skip_without_ray_tracer()) return SKIPPED;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shadows_lie_where_geometry_says),
        cmocka_unit_test(contact_shadows_are_as_thin_as_the_gap),
        cmocka_unit_test(closed_boxes_are_dark_inside),
        cmocka_unit_test(bulges_let_no_light_in),
        cmocka_unit_test(sheets_at_contact_do_not_show_through),
        cmocka_unit_test(lit_flat_cloth_has_no_spots),
        cmocka_unit_test(tilted_cloth_has_no_spots),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
