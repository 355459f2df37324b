/* Text, ticks and legends by what a reader relies on: ink stays in its box, the gradient shows the
 * map's colors, ticks stand where their values are, and nothing leaves the picture. */
#include "support/test_support.h"

#include "render/color_space.h"
#include "render/font.h"
#include "render/overlay.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static render_image make_image(uint32_t width, uint32_t height, int grey) {
    render_image image;
    assert_int_equal(render_image_create(width, height, &image, NULL), TULLE_OK);
    memset(image.pixels, grey, 3 * (size_t)width * height);
    return image;
}

static const uint8_t *get_pixel(const render_image *image, int x, int y) {
    return image->pixels + 3 * ((size_t)y * image->width + (size_t)x);
}

static void test_every_glyph_has_ink_inside_its_box(void **state) {
    (void)state;
    enum { SIDE = 80, LEFT = 20, BASELINE = 45 };
    for (int cap = FONT_HEIGHT_MIN; cap <= 24; cap += 3)
        for (char c = '!'; c <= '~'; c++) {
            char const text[2] = {c, '\0'};
            render_image image = make_image(SIDE, SIDE, 255);
            overlay_draw_text(
                &image,
                &(overlay_text){.text = text, .x = LEFT, .baseline = BASELINE, .cap_height = cap});
            int const width = font_measure(text, cap), descent = font_get_descent(cap);
            long ink = 0, lost = 0;
            for (int y = 0; y < SIDE; y++)
                for (int x = 0; x < SIDE; x++) {
                    int const dark = 255 - get_pixel(&image, x, y)[0];
                    bool const is_inside = x >= LEFT && x < LEFT + width &&
                                           y >= BASELINE - cap - descent &&
                                           y < BASELINE + descent + 1;
                    ink += dark;
                    if (!is_inside) lost += dark;
                }
            assert_true(ink > 100);
            assert_int_equal(lost, 0);
            font_glyph glyph;
            font_get_glyph((unsigned char)c, cap, &glyph);
            assert_true(glyph.segment_count < FONT_SEGMENT_MAX);
            assert_true(glyph.advance >= glyph.width);
            render_image_destroy(&image);
        }
}

static void test_capitals_fill_their_height(void **state) {
    (void)state;
    for (int cap = FONT_HEIGHT_MIN; cap <= 16; cap++) {
        render_image image = make_image(40, 40, 255);
        overlay_draw_text(&image,
                          &(overlay_text){.text = "H", .x = 5, .baseline = 30, .cap_height = cap});
        assert_true(get_pixel(&image, 5, 29)[0] < 80); /* sharp but for round ends */
        assert_int_equal(get_pixel(&image, 5, 30)[0], 255);
        assert_int_equal(get_pixel(&image, 4, 29)[0], 255);
        assert_true(get_pixel(&image, 5, 30 - cap + 2)[0] < 80);
        assert_int_equal(get_pixel(&image, 5, 30 - cap - 1)[0], 255);
        render_image_destroy(&image);
    }
}

static void test_utf8(void **state) {
    (void)state;
    const char *text = "a\xC2\xB5\xE2\x88\x92\xF0\x9F\x98\x80\xFF\xC2";
    uint32_t const expected[] = {'a', 0xB5, 0x2212, 0x1F600, 0xFFFD, 0xFFFD};
    for (int i = 0; i < 6; i++) assert_int_equal(font_next_code_point(&text), expected[i]);
    assert_int_equal(*text, 0);
    assert_int_equal(font_measure("", 10), 0);
}

/* The inverse of tick_scale_get_part. */
static double get_tick_value(const tick_scale *scale, double part) {
    if (!scale->is_logarithmic) return scale->low + part * (scale->high - scale->low);
    return scale->low * pow(scale->high / scale->low, part);
}

static void test_linear_ticks(void **state) {
    (void)state;
    double const lows[] = {0.0, -10.0, 0.3, -1e-7, 1e6, 0.0},
                 highs[] = {2.37, 10.0, 0.31, 3e-7, 1.1e6, 1e-300};
    for (int i = 0; i < 6; i++)
        for (size_t most = 2; most <= 16; most++) {
            tick_scale const scale = {lows[i], highs[i], false, i % 2, "m"};
            tick_list list;
            tick_list_make(&scale, most, &list);
            assert_in_range(list.count, 1, most);
            for (size_t k = 0; k < list.count; k++) {
                const tick *const t = &list.ticks[k];
                assert_true(fabs(get_tick_value(&scale, t->part) - t->value) <=
                            1e-9 * (highs[i] - lows[i]));
                assert_true(t->part >= 0.0 && t->part <= 1.0);
                assert_true(k == 0 || t->part > list.ticks[k - 1].part);
                assert_true(t->label[0] != '\0');
            }
        }
    tick_list list;
    tick_list_make(&(tick_scale){0.0, 0.002, false, true, "m"}, 5, &list);
    assert_int_equal(list.count, 5);
    assert_string_equal(list.unit, "mm");
    assert_string_equal(list.ticks[1].label, "0.5");
    tick_list_make(&(tick_scale){-10.0, 10.0, false, false, "%"}, 5, &list);
    assert_string_equal(list.ticks[0].label, "-10");
    assert_string_equal(list.ticks[2].label, "0");
    tick_list_make(&(tick_scale){1.0, 1.0, false, false, ""}, 5, &list);
    assert_int_equal(list.count, 0);
    tick_list_make(&(tick_scale){NAN, 1.0, false, false, ""}, 5, &list);
    assert_int_equal(list.count, 0);
}

static void test_logarithmic_ticks(void **state) {
    (void)state;
    tick_list list;
    tick_list_make(&(tick_scale){1e-6, 1e-2, true, true, "m"}, 6, &list);
    const char *const labels[] = {"1 \xC2\xB5m", "10 \xC2\xB5m", "100 \xC2\xB5m", "1 mm", "10 mm"};
    size_t found = 0;
    for (size_t i = 0; i < list.count; i++) {
        if (!list.ticks[i].label[0]) continue;
        assert_in_range(found, 0, 4);
        assert_string_equal(list.ticks[i].label, labels[found]);
        assert_true(fabs(list.ticks[i].part - (double)found / 4.0) < 1e-9);
        found++;
    }
    assert_int_equal(found, 5);
    assert_string_equal(list.unit, "");
    tick_list_make(&(tick_scale){1e-300, 1e300, true, false, ""}, 5, &list);
    assert_in_range(list.count, 2, 6);
    tick_list_make(&(tick_scale){0.0, 1.0, true, false, ""}, 5, &list);
    assert_int_equal(list.count, 0);
}

static overlay_legend make_legend(overlay_corner corner,
                                  overlay_swatch swatches[COLOR_CONTACT_COUNT]) {
    for (int i = 0; i < COLOR_CONTACT_COUNT; i++) {
        swatches[i] = (overlay_swatch){.name = color_map_contact_name((color_contact)i),
                                       .count = 37345u >> i,
                                       .has_count = true};
        color_map_contact((color_contact)i, swatches[i].color);
    }
    return (overlay_legend){.corner = corner,
                            .title = "Gap",
                            .has_gradient = true,
                            .map = COLOR_MAP_SEQUENTIAL,
                            .scale = {1e-6, 1e-2, true, true, "m"},
                            .swatches = swatches,
                            .swatch_count = COLOR_CONTACT_COUNT};
}

static void check_pixel(const render_image *image, int x, int y, const float color[3]) {
    uint8_t bytes[3];
    color_to_bytes(color, bytes);
    for (int i = 0; i < 3; i++) assert_true(abs(get_pixel(image, x, y)[i] - bytes[i]) <= 1);
}

static void test_legend_shows_its_colors(void **state) {
    (void)state;
    uint32_t const sizes[][2] = {{640, 360}, {1920, 1080}, {300, 300}};
    for (int s = 0; s < 3; s++)
        for (int corner = 0; corner < 4; corner++) {
            render_image image = make_image(sizes[s][0], sizes[s][1], 90);
            overlay_swatch swatches[COLOR_CONTACT_COUNT];
            overlay_legend const legend = make_legend((overlay_corner)corner, swatches);
            overlay_layout layout;
            overlay_layout_legend(image.width, image.height, &legend, &layout);
            assert_true(layout.is_drawn);
            overlay_draw_legend(&image, &legend);
            overlay_rectangle const bar = layout.gradient, box = layout.box;
            for (int y = 0; y < bar.height; y++) {
                float color[3];
                color_map_get(COLOR_MAP_SEQUENTIAL, 1.0 - (y + 0.5) / bar.height, color);
                check_pixel(&image, bar.x, bar.y + y, color);
                check_pixel(&image, bar.x + bar.width - 1, bar.y + y, color);
            }
            for (size_t i = 0; i < layout.ticks.count; i++) {
                int const row = layout.tick_rows[i] - bar.y;
                double const part = layout.ticks.ticks[i].part;
                assert_in_range(row, 0, bar.height - 1);
                assert_true(part * bar.height >= bar.height - row - 1 - 1e-6 &&
                            part * bar.height <= bar.height - row + 1e-6);
                assert_true(get_pixel(&image, bar.x + bar.width + 1, layout.tick_rows[i])[0] < 150);
            }
            for (int i = 0; i < COLOR_CONTACT_COUNT; i++)
                check_pixel(&image, layout.swatches[i].x, layout.swatches[i].y, swatches[i].color);
            for (int y = 0; y < (int)image.height; y++)
                for (int x = 0; x < (int)image.width; x++)
                    if (x < box.x || y < box.y || x >= box.x + box.width || y >= box.y + box.height)
                        assert_int_equal(get_pixel(&image, x, y)[1], 90);
            assert_true((box.x < (int)image.width / 2) ==
                        (corner == OVERLAY_TOP_LEFT || corner == OVERLAY_BOTTOM_LEFT));
            render_image_destroy(&image);
        }
}

/* The sanitizers watch the picture's edges. */
static void test_legend_in_small_pictures(void **state) {
    (void)state;
    bool was_drawn = false;
    int before = 0;
    for (uint32_t side = 1; side < 260; side += 3) {
        render_image image = make_image(side, side, 90), again = make_image(side, side, 90);
        overlay_swatch swatches[COLOR_CONTACT_COUNT];
        overlay_legend legend = make_legend(OVERLAY_BOTTOM_RIGHT, swatches);
        overlay_layout layout;
        overlay_layout_legend(side, side, &legend, &layout);
        assert_true(layout.is_drawn || !was_drawn);
        was_drawn = layout.is_drawn;
        if (was_drawn) {
            assert_in_range(layout.cap_height, FONT_HEIGHT_MIN, 12);
            assert_true(layout.box.x >= 0 && layout.box.y >= 0);
            assert_true(layout.box.x + layout.box.width <= (int)side &&
                        layout.box.y + layout.box.height <= (int)side);
            assert_true(layout.cap_height + 1 >= before);
            before = layout.cap_height;
        }
        overlay_draw_legend(&image, &legend);
        overlay_draw_legend(&again, &legend);
        assert_memory_equal(image.pixels, again.pixels, 3 * (size_t)side * side);
        overlay_draw_text(
            &image,
            &(overlay_text){.text = "across the edges", .x = -9, .baseline = 3, .cap_height = 9});
        render_image_destroy(&image);
        render_image_destroy(&again);
    }
    assert_true(was_drawn);
}

static void test_fill_blends(void **state) {
    (void)state;
    render_image image = make_image(4, 4, 100);
    overlay_fill(&image, (overlay_rectangle){-5, 1, 7, 2}, (const uint8_t[3]){200, 100, 0}, 0.5);
    uint8_t const blended[3] = {150, 100, 50}, kept[3] = {100, 100, 100};
    assert_memory_equal(get_pixel(&image, 1, 1), blended, 3);
    assert_memory_equal(get_pixel(&image, 2, 1), kept, 3);
    assert_memory_equal(get_pixel(&image, 1, 0), kept, 3);
    assert_memory_equal(get_pixel(&image, 0, 3), kept, 3);
    render_image_destroy(&image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_glyph_has_ink_inside_its_box),
        cmocka_unit_test(test_capitals_fill_their_height),
        cmocka_unit_test(test_utf8),
        cmocka_unit_test(test_linear_ticks),
        cmocka_unit_test(test_logarithmic_ticks),
        cmocka_unit_test(test_legend_shows_its_colors),
        cmocka_unit_test(test_legend_in_small_pictures),
        cmocka_unit_test(test_fill_blends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
