/* Color spaces against their closed forms; color maps by what a reader needs of them: order,
 * evenness, and states that stay apart for color-blind readers and in grey. */
#include "support/test_support.h"

#include "render/color_map.h"
#include "render/color_space.h"

#include <math.h>
#include <string.h>

static void test_srgb_curve_and_inverse(void **state) {
    (void)state;
    assert_true(fabs(color_encode_srgb(0.0031308) - 0.040449936) < 1e-9);
    assert_true(fabs(color_encode_srgb(0.5) - (1.055 * exp(log(0.5) / 2.4) - 0.055)) < 1e-14);
    assert_true(fabs(color_decode_srgb(0.5) - exp(2.4 * log(0.555 / 1.055))) < 1e-14);
    for (int i = 0; i <= 1000; i++) {
        double const value = i / 1000.0;
        /* The two pieces of the standard's curve meet within 3e-8. */
        assert_true(fabs(color_decode_srgb(color_encode_srgb(value)) - value) < 1e-7);
    }
    assert_true(color_encode_srgb(-1.0) == 0.0 && color_encode_srgb(2.0) == 1.0);
    assert_true(color_decode_srgb(-1.0) == 0.0 && color_decode_srgb(2.0) == 1.0);
    for (int byte = 0; byte < 256; byte++) {
        float const linear = (float)color_decode_srgb(byte / 255.0);
        uint8_t bytes[3];
        color_to_bytes((const float[3]){linear, 0.0f, 1.0f}, bytes);
        assert_int_equal(bytes[0], byte);
        assert_int_equal(bytes[1], 0);
        assert_int_equal(bytes[2], 255);
    }
}

static void test_oklab_of_known_colors_and_inverse(void **state) {
    (void)state;
    double lab[3], back[3];
    color_to_oklab((const double[3]){1.0, 1.0, 1.0}, lab);
    assert_true(fabs(lab[0] - 1.0) < 1e-6 && fabs(lab[1]) < 1e-6 && fabs(lab[2]) < 1e-6);
    color_to_oklab((const double[3]){1.0, 0.0, 0.0}, lab); /* sRGB's red: 0.628, 0.225, 0.126 */
    assert_true(fabs(lab[0] - 0.62796) < 1e-4 && fabs(lab[1] - 0.22486) < 1e-4 &&
                fabs(lab[2] - 0.12585) < 1e-4);
    for (int i = 0; i < 125; i++) {
        double const rgb[3] = {i % 5 / 4.0, i / 5 % 5 / 4.0, i / 25 / 4.0};
        color_to_oklab(rgb, lab);
        color_from_oklab(lab, back);
        for (int k = 0; k < 3; k++) assert_true(fabs(back[k] - rgb[k]) < 1e-6);
    }
}

static void get_lab(const float rgb[3], double lab[3]) {
    color_to_oklab((const double[3]){(double)rgb[0], (double)rgb[1], (double)rgb[2]}, lab);
}

static double get_distance(const double a[3], const double b[3]) {
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

enum { STEPS = 512 };

static void test_sequential_rises_evenly(void **state) {
    (void)state;
    double before[3] = {0}, shortest = 1.0, longest = 0.0;
    for (int i = 0; i <= STEPS; i++) {
        float rgb[3];
        double lab[3];
        color_map_get(COLOR_MAP_SEQUENTIAL, (double)i / STEPS, rgb);
        get_lab(rgb, lab);
        /* A clamped color would leave the straight line of lightness. */
        assert_true(fabs(lab[0] - (0.27 + 0.65 * i / STEPS)) < 1e-5);
        if (i > 0) {
            double const length = get_distance(lab, before);
            if (length < shortest) shortest = length;
            if (length > longest) longest = length;
        }
        memcpy(before, lab, sizeof before);
    }
    assert_true(longest < 1.6 * shortest);
}

static void test_diverging_mirrors_its_lightness(void **state) {
    (void)state;
    float rgb[3];
    double lab[3], mirror[3], before = 2.0;
    color_map_get(COLOR_MAP_DIVERGING, 0.5, rgb);
    get_lab(rgb, lab);
    assert_true(fabs(lab[0] - 0.93) < 1e-5 && hypot(lab[1], lab[2]) < 1e-5);
    for (int i = 0; i <= STEPS; i++) {
        double const distance = (double)i / STEPS;
        color_map_get(COLOR_MAP_DIVERGING, 0.5 + 0.5 * distance, rgb);
        get_lab(rgb, lab);
        color_map_get(COLOR_MAP_DIVERGING, 0.5 - 0.5 * distance, rgb);
        get_lab(rgb, mirror);
        assert_true(fabs(lab[0] - mirror[0]) < 1e-5); /* neither end is clamped */
        assert_true(lab[0] < before);
        assert_true(i == 0 || (lab[1] > 0.0 && mirror[2] < 0.0)); /* red; blue */
        before = lab[0];
    }
    assert_true(lab[1] > 0.12 && mirror[2] < -0.12);
}

static void test_values_outside_and_nan(void **state) {
    (void)state;
    for (int map = 0; map < 2; map++) {
        float low[3], high[3], rgb[3];
        color_map_get((color_map)map, 0.0, low);
        color_map_get((color_map)map, 1.0, high);
        color_map_get((color_map)map, -INFINITY, rgb);
        assert_memory_equal(rgb, low, sizeof rgb);
        color_map_get((color_map)map, INFINITY, rgb);
        assert_memory_equal(rgb, high, sizeof rgb);
        color_map_get((color_map)map, NAN, rgb);
        assert_true(rgb[0] > 0.0f && fabsf(rgb[0] - rgb[1]) < 1e-4f);
    }
}

/* What a reader without one kind of cones sees. F. Viénot, H. Brettel, J. D. Mollon, "Digital video
 * colourmaps for checking the legibility of displays by dichromats", 1999. */
static void simulate_dichromat(int kind, const float rgb[3], double seen[3]) {
    double const r = (double)rgb[0], g = (double)rgb[1], b = (double)rgb[2];
    double l = 17.8824 * r + 43.5161 * g + 4.11935 * b;
    double m = 3.45565 * r + 27.1554 * g + 3.86714 * b;
    double const s = 0.0299566 * r + 0.184309 * g + 1.46709 * b;
    if (kind == 0) l = 2.02344 * m - 2.52581 * s;
    if (kind == 1) m = 0.494207 * l + 1.24827 * s;
    seen[0] = fmax(0.0, 0.0809444479 * l - 0.130504409 * m + 0.116721066 * s);
    seen[1] = fmax(0.0, -0.0102485335 * l + 0.0540193266 * m - 0.113614708 * s);
    seen[2] = fmax(0.0, -0.000365296938 * l - 0.00412161469 * m + 0.693511405 * s);
}

static void test_contact_states_stay_apart(void **state) {
    (void)state;
    for (int kind = 0; kind < 3; kind++) /* 2: all cones */
        for (int i = 0; i < COLOR_CONTACT_COUNT; i++)
            for (int k = 0; k < i; k++) {
                float rgb[2][3];
                double seen[2][3], lab[2][3];
                color_map_contact((color_contact)i, rgb[0]);
                color_map_contact((color_contact)k, rgb[1]);
                for (int n = 0; n < 2; n++) {
                    simulate_dichromat(kind, rgb[n], seen[n]);
                    color_to_oklab(seen[n], lab[n]);
                }
                assert_true(get_distance(lab[0], lab[1]) > 0.15);
                if (kind == 2) assert_true(fabs(lab[0][0] - lab[1][0]) > 0.09); /* in grey */
            }
    assert_string_equal(color_map_contact_name(COLOR_CONTACT_HARD), "hard");
    assert_null(color_map_contact_name(COLOR_CONTACT_COUNT));
}

static void test_patch_colors_are_far_apart(void **state) {
    (void)state;
    for (uint32_t i = 0; i <= COLOR_PATCH_COUNT; i++)
        for (uint32_t k = 0; k < i; k++) {
            float rgb[2][3];
            double lab[2][3];
            color_map_patch(i == COLOR_PATCH_COUNT ? TULLE_NONE : i, rgb[0]);
            color_map_patch(k, rgb[1]);
            get_lab(rgb[0], lab[0]);
            get_lab(rgb[1], lab[1]);
            assert_true(get_distance(lab[0], lab[1]) >= COLOR_PATCH_DISTANCE);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_srgb_curve_and_inverse),
        cmocka_unit_test(test_oklab_of_known_colors_and_inverse),
        cmocka_unit_test(test_sequential_rises_evenly),
        cmocka_unit_test(test_diverging_mirrors_its_lightness),
        cmocka_unit_test(test_values_outside_and_nan),
        cmocka_unit_test(test_contact_states_stay_apart),
        cmocka_unit_test(test_patch_colors_are_far_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
