/* The parts of the ray tracer that need no rays: evenly spread samples, the light's closed forms,
 * normals at creases, the camera that sees a box whole, memory. */
#include "render/render_fixture.h"

#include "io/failing_heap.h"
#include "render/geometry.h"
#include "render/lighting.h"
#include "render/sampling.h"

static const double pi = 3.14159265358979323846;

/* Each aligned run of 2^m samples has one point in each box of 2^-a by 2^-(m-a), for every a. */
static void samples_are_a_net(void **state) {
    (void)state;
    for (uint32_t seed = 0; seed < 200; seed++)
        for (uint32_t m = 0; m <= 7; m++)
            for (uint32_t a = 0; a <= m; a++) {
                uint32_t const count = 1u << m, first = seed % 3 * count;
                bool is_taken[128] = {false};
                for (uint32_t i = 0; i < count; i++) {
                    double point[2];
                    sampling_get_pair(first + i, seed * 7919u, seed % 5, point);
                    assert_true(point[0] >= 0.0 && point[0] < 1.0);
                    assert_true(point[1] >= 0.0 && point[1] < 1.0);
                    uint32_t const column = (uint32_t)(point[0] * (1u << a));
                    uint32_t const row = (uint32_t)(point[1] * (1u << (m - a)));
                    uint32_t const box = (column << (m - a)) | row;
                    assert_false(is_taken[box]);
                    is_taken[box] = true;
                }
            }
}

/* Over many pixels each sample is uniform, and two pairs of one pixel have nothing in common. */
static void scrambles_are_unbiased(void **state) {
    (void)state;
    enum { PIXELS = 20000 };
    for (uint32_t index = 0; index < 20; index += 3) {
        double mean[4] = {0}, square = 0.0, product[4] = {0};
        for (uint32_t pixel = 0; pixel < PIXELS; pixel++) {
            double a[4];
            sampling_get_pair(index, sampling_hash(pixel, 3), 0, a);
            sampling_get_pair(index, sampling_hash(pixel, 3), 1, a + 2);
            for (int i = 0; i < 4; i++) mean[i] += (a[i] - 0.5) / PIXELS;
            square += (a[0] - 0.5) * (a[0] - 0.5) / PIXELS;
            for (int i = 1; i < 4; i++) product[i] += (a[0] - 0.5) * (a[i] - 0.5) / PIXELS;
        }
        /* Five standard deviations: sqrt(1/12/PIXELS) of a mean, 1/12/sqrt(PIXELS) of a product. */
        for (int i = 0; i < 4; i++) assert_true(fabs(mean[i]) < 5 * sqrt(1.0 / 12 / PIXELS));
        for (int i = 1; i < 4; i++) assert_true(fabs(product[i]) < 5.0 / 12 / sqrt(PIXELS));
        assert_true(fabs(square - 1.0 / 12) < 0.005);
    }
}

/* The mean of the sky over a tilted hemisphere against a sum over directions. */
static void ambient_light_is_the_mean_of_the_sky(void **state) {
    (void)state;
    render_lighting lighting = render_lighting_default();
    lighting.sky_color[0] = 0.1f;
    lighting.horizon_color[0] = 0.9f;
    render_light const light = render_light_prepare(&lighting);
    for (int trial = 0; trial <= 8; trial++) {
        double const tilt = pi * trial / 8;
        vec3 const normal = vec3_make(sin(tilt), 0.0, cos(tilt));
        double sum = 0.0, ambient[3];
        enum { COUNT = 20000 };
        for (uint32_t i = 0; i < COUNT; i++) {
            double point[2], sky[3];
            sampling_get_pair(i, 5, 0, point);
            vec3 const direction = sampling_get_hemisphere(point, normal);
            assert_true(fabs(vec3_norm(direction) - 1.0) < 1e-12);
            assert_true(vec3_dot(direction, normal) >= 0.0);
            render_light_get_sky(&light, direction, sky);
            sum += sky[0] / COUNT;
        }
        render_light_get_ambient(&light, normal, ambient);
        assert_true(fabs(sum - ambient[0]) < 2e-4);
    }
}

static void light_is_sampled_as_it_says(void **state) {
    (void)state;
    render_lighting lighting = render_lighting_default();
    lighting.light_angle = 0.4;
    render_light const light = render_light_prepare(&lighting);
    vec3 const middle = vec3_normalize(vec3_load(lighting.light_direction, 0));
    vec3 const facing = vec3_normalize(vec3_make(0.1, -0.2, 1.0));
    double sum = 0.0;
    for (uint32_t i = 0; i < 4096; i++) {
        double point[2];
        sampling_get_pair(i, 9, 1, point);
        vec3 const direction = render_light_get_direction(&light, point);
        assert_true(fabs(vec3_norm(direction) - 1.0) < 1e-12);
        assert_true(vec3_dot(direction, middle) >= cos(0.4) - 1e-12);
        sum += vec3_dot(direction, facing) / vec3_dot(direction, middle) / 4096;
    }
    /* A disc wholly above a surface lights it as its middle does. */
    assert_true(fabs(sum - vec3_dot(middle, facing)) < 1e-3);
}

static void agreement_falls_without_a_step(void **state) {
    (void)state;
    vec3 const normal = vec3_make(0.0, 0.0, 1.0), shading = vec3_make(sin(0.3), 0.0, cos(0.3));
    double last = 1.0;
    for (double angle = 0.0; angle < 1.8; angle += 0.001) {
        vec3 const direction = vec3_make(sin(angle), 0.0, cos(angle));
        double const agreement = render_light_get_agreement(direction, shading, normal);
        assert_true(agreement >= 0.0 && agreement <= last + 1e-12);
        assert_true(last - agreement < 0.01);
        if (angle > 0.5 * pi) assert_true(agreement == 0.0);
        last = agreement;
    }
}

static vec3 get_normal(const float *normals, size_t corner) {
    return vec3_make((double)normals[3 * corner], (double)normals[3 * corner + 1],
                     (double)normals[3 * corner + 2]);
}

/* A cube: sharp below a right angle, and above it the diagonal at each corner however its sides are
 * cut into triangles. */
static void creases_keep_or_join_normals(void **state) {
    (void)state;
    small_mesh const box = make_box(vec3_make(-1, -1, -1), vec3_make(1, 1, 1));
    float normals[9 * 12];
    memory heap = memory_default();
    double const angles[3] = {0.5, 1.5, INFINITY};
    for (int trial = 0; trial < 3; trial++) {
        assert_true(
            render_compute_corner_normals(&heap, small_mesh_view(&box), angles[trial], normals));
        for (size_t corner = 0; corner < 36; corner++) {
            const uint32_t *const t = box.triangles + corner / 3 * 3;
            vec3 const a = vec3_load(box.positions, t[0]);
            vec3 const flat =
                vec3_normalize(vec3_cross(vec3_sub(vec3_load(box.positions, t[1]), a),
                                          vec3_sub(vec3_load(box.positions, t[2]), a)));
            vec3 const diagonal = vec3_normalize(vec3_load(box.positions, t[corner % 3]));
            vec3 const expected = trial == 2 ? diagonal : flat;
            assert_true(vec3_norm(vec3_sub(get_normal(normals, corner), expected)) < 1e-6);
        }
    }
    assert_int_equal(heap.bytes_held, 0);
    tulle_mesh sphere = make_sphere(8, 2.0);
    float *const round = malloc(9 * sphere.triangle_count * sizeof *round);
    assert_true(render_compute_corner_normals(&heap, tulle_mesh_get_view(&sphere), 0.5, round));
    for (size_t corner = 0; corner < 3 * sphere.triangle_count; corner++) {
        vec3 const radial = vec3_normalize(vec3_load(sphere.positions, sphere.triangles[corner]));
        assert_true(vec3_dot(get_normal(round, corner), radial) > cos(0.02));
    }
    free(round);
    tulle_mesh_destroy(&sphere);
}

/* Three sheets at one edge, and neighbours turned the other way: those edges are sharp. */
static void unclear_edges_are_sharp(void **state) {
    (void)state;
    small_mesh fan = {0};
    vec3 const a = {0, 0, 0}, b = {0, 1, 0};
    add_quad(&fan, a, vec3_make(1, 0, 0.1), vec3_make(1, 1, 0.1), b);
    add_quad(&fan, a, b, vec3_make(-1, 1, 0.1), vec3_make(-1, 0, 0.1));
    add_quad(&fan, a, b, vec3_make(0, 1, 1), vec3_make(0, 0, 1));
    for (size_t i = 0; i < 18; i++) { /* one edge for all three */
        uint32_t *const v = &fan.triangles[i];
        if (*v == 4 || *v == 8) *v = 0;
        if (*v == 5 || *v == 9) *v = 3;
    }
    float normals[9 * 6];
    memory heap = memory_default();
    assert_true(
        render_compute_corner_normals(&heap, small_mesh_view(&fan), (double)INFINITY, normals));
    for (size_t corner = 0; corner < 18; corner++) {
        vec3 const n = get_normal(normals, corner);
        double const flat = corner < 12 ? fabs(n.z) : fabs(n.x);
        assert_true(fabs(flat - (corner < 12 ? 1.0 / hypot(1.0, 0.1) : 1.0)) < 1e-6);
    }
}

/* All corners of the box are in the picture, and one is near its edge. */
static void the_camera_sees_the_box(void **state) {
    (void)state;
    double const low[3] = {-1.0, 2.0, 0.0}, high[3] = {3.0, 2.5, 1.0};
    for (int trial = 0; trial < 40; trial++) {
        double const azimuth = 0.7 * trial, elevation = 0.5 * pi * (trial % 9 - 4) / 4;
        double const aspect = trial % 2 ? 16.0 / 9.0 : 0.5;
        render_camera const camera = render_camera_frame(low, high, azimuth, elevation, aspect);
        vec3 const position = vec3_load(camera.position, 0), up = vec3_load(camera.up, 0);
        vec3 const forward = vec3_normalize(vec3_sub(vec3_load(camera.target, 0), position));
        assert_true(fabs(vec3_dot(forward, up)) < 1e-9 && fabs(forward.z + sin(elevation)) < 1e-9);
        vec3 const right = vec3_cross(forward, up);
        double const slope = tan(0.5 * camera.field_of_view);
        double largest = 0.0;
        for (int corner = 0; corner < 8; corner++) {
            vec3 const v =
                vec3_sub(vec3_make(corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1],
                                   corner & 4 ? high[2] : low[2]),
                         position);
            double const depth = vec3_dot(v, forward);
            assert_true(depth > 0.0);
            largest = fmax(largest, fabs(vec3_dot(v, right)) / (depth * slope * aspect));
            largest = fmax(largest, fabs(vec3_dot(v, up)) / (depth * slope));
        }
        assert_true(largest < 1.0 && largest > 0.9);
    }
    render_camera const camera = render_camera_frame(low, low, 0.0, 0.0, 1.0);
    assert_true(camera.position[0] != camera.target[0]);
}

static void short_memory_is_said(void **state) {
    (void)state;
    if (!HAS_OWN_HEAP) skip();
    tulle_mesh sphere = make_sphere(3, 1.0);
    render_surface surface = make_surface(tulle_mesh_get_view(&sphere), 0.5f);
    surface.crease_angle = 1.0;
    render_frame_def const def = make_frame(&surface, 1);
    render_geometry geometry;
    tulle_error error;
    long call = 0;
    for (bool is_done = false; !is_done; call++) {
        watch_heap(call);
        tulle_status const status = render_geometry_build(&def, &geometry, &error);
        is_done = !unwatch_heap();
        assert_int_equal(status, is_done ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY);
        if (is_done) render_geometry_destroy(&geometry);
    }
    assert_true(call > 8);
    tulle_mesh_destroy(&sphere);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_a_net),
        cmocka_unit_test(scrambles_are_unbiased),
        cmocka_unit_test(ambient_light_is_the_mean_of_the_sky),
        cmocka_unit_test(light_is_sampled_as_it_says),
        cmocka_unit_test(agreement_falls_without_a_step),
        cmocka_unit_test(creases_keep_or_join_normals),
        cmocka_unit_test(unclear_edges_are_sharp),
        cmocka_unit_test(the_camera_sees_the_box),
        cmocka_unit_test(short_memory_is_said),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
