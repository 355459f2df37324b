/* render/legend.c - legends: see overlay.h. The layout is made first, from the legend and the
 * picture's size alone, with ever smaller text until it fits; then it is drawn. */
#include "render/overlay.h"

#include "render/color_space.h"
#include "render/font.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Sizes as multiples of the text's height. */
static double const padding = 0.9, row_gap = 0.75, bar_width = 1.5, bar_height = 11.0;
static double const bar_height_least = 4.0, tick_length = 0.45, column_gap = 0.55;
static double const box_opacity = 0.86;
static uint8_t const box_color[3] = {255, 255, 255}, ink_color[3] = {34, 38, 46};

static int scale_length(double multiple, int cap_height) {
    return (int)(multiple * cap_height + 0.5);
}

static int larger(int a, int b) { return a > b ? a : b; }

/* Height of text that reads well: 8 pixels in a picture 360 high, 16 in one 1080 high. */
static int choose_cap_height(uint32_t width, uint32_t height) {
    double const side = fmin((double)height, 9.0 / 16.0 * width);
    return larger(FONT_HEIGHT_MIN, (int)(4.0 + side / 90.0 + 0.5));
}

/* A number with its thousands apart: 37 345. */
static void format_count(uint64_t count, char text[32]) {
    char digits[24];
    int const length = snprintf(digits, sizeof digits, "%llu", (unsigned long long)count);
    int at = 0;
    for (int i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0) text[at++] = ' ';
        text[at++] = digits[i];
    }
    text[at] = '\0';
}

static int measure_ticks(const overlay_layout *layout) {
    int widest = 0;
    for (size_t i = 0; i < layout->ticks.count; i++)
        widest = larger(widest, font_measure(layout->ticks.ticks[i].label, layout->cap_height));
    return widest;
}

/* Width of the rows of swatches with names and counts. */
static int measure_swatches(const overlay_legend *legend, const overlay_layout *layout) {
    int const cap = layout->cap_height;
    int names = 0, counts = 0;
    for (size_t i = 0; i < layout->swatch_count; i++) {
        char count[32];
        format_count(legend->swatches[i].count, count);
        names = larger(names, font_measure(legend->swatches[i].name, cap));
        if (legend->swatches[i].has_count) counts = larger(counts, font_measure(count, cap));
    }
    int const gap = scale_length(column_gap, cap);
    return scale_length(bar_width, cap) + gap + names + (counts ? 2 * gap + counts : 0);
}

static void place_ticks(overlay_layout *layout) {
    for (size_t i = 0; i < layout->ticks.count; i++) {
        int const height = layout->gradient.height;
        int const row = (int)floor((1.0 - layout->ticks.ticks[i].part) * height);
        layout->tick_rows[i] = layout->gradient.y + (row < height ? row : height - 1);
    }
}

/* Lays out rows from the top of the box, at (0, 0), and gives the box its size. */
static void stack_rows(const overlay_legend *legend, int bar, overlay_layout *layout) {
    int const cap = layout->cap_height, pad = scale_length(padding, cap);
    int const gap = scale_length(row_gap, cap);
    int y = pad + cap, width = font_measure(layout->title, cap);
    layout->title_baseline = y;
    if (legend->has_gradient) {
        /* Half a line of room above and below, for the labels at its ends. */
        y += gap + cap / 2;
        layout->gradient = (overlay_rectangle){pad, y, scale_length(bar_width, cap), bar};
        place_ticks(layout);
        y += bar + cap / 2;
        width = larger(width, layout->gradient.width + scale_length(tick_length, cap) +
                                  scale_length(column_gap, cap) + measure_ticks(layout));
    }
    for (size_t i = 0; i < layout->swatch_count; i++) {
        y += gap;
        layout->swatches[i] = (overlay_rectangle){pad, y, scale_length(bar_width, cap), cap};
        y += cap;
    }
    if (layout->swatch_count) width = larger(width, measure_swatches(legend, layout));
    if (legend->note) {
        y += gap + cap;
        layout->note_baseline = y;
        width = larger(width, font_measure(legend->note, cap));
    }
    layout->box = (overlay_rectangle){0, 0, width + 2 * pad, y + pad};
}

static void move_rectangle(overlay_rectangle *rectangle, int dx, int dy) {
    rectangle->x += dx;
    rectangle->y += dy;
}

/* Moves all to the legend's corner. */
static void move_to_corner(overlay_corner corner, int width, int height, overlay_layout *layout) {
    int const margin = scale_length(padding, layout->cap_height);
    bool const is_right = corner == OVERLAY_TOP_RIGHT || corner == OVERLAY_BOTTOM_RIGHT;
    bool const is_low = corner == OVERLAY_BOTTOM_LEFT || corner == OVERLAY_BOTTOM_RIGHT;
    int const dx = is_right ? width - margin - layout->box.width : margin;
    int const dy = is_low ? height - margin - layout->box.height : margin;
    move_rectangle(&layout->box, dx, dy);
    move_rectangle(&layout->gradient, dx, dy);
    for (size_t i = 0; i < layout->ticks.count; i++) layout->tick_rows[i] += dy;
    for (size_t i = 0; i < layout->swatch_count; i++) move_rectangle(&layout->swatches[i], dx, dy);
    layout->title_baseline += dy;
    layout->note_baseline += dy;
}

/* Lays out at one size of text; false when it does not fit. */
static bool try_size(int width, int height, const overlay_legend *legend, int bar,
                     overlay_layout *layout) {
    int const cap = layout->cap_height, margin = scale_length(padding, cap);
    memset(&layout->ticks, 0, sizeof layout->ticks);
    if (legend->has_gradient) {
        int const label_max = bar / (2 * cap);
        tick_list_make(&legend->scale, (size_t)(label_max < 2 ? 2 : label_max), &layout->ticks);
    }
    const char *const unit = layout->ticks.unit;
    snprintf(layout->title, sizeof layout->title, unit[0] ? "%s [%s]" : "%s%s", legend->title,
             unit);
    stack_rows(legend, bar, layout);
    return layout->box.width + 2 * margin <= width && layout->box.height + 2 * margin <= height;
}

void overlay_layout_legend(uint32_t width, uint32_t height, const overlay_legend *legend,
                           overlay_layout *layout) {
    memset(layout, 0, sizeof *layout);
    layout->swatch_count =
        legend->swatch_count < OVERLAY_SWATCH_MAX ? legend->swatch_count : OVERLAY_SWATCH_MAX;
    int const right = (int)width, bottom = (int)height;
    for (int cap = choose_cap_height(width, height); cap >= FONT_HEIGHT_MIN; cap--) {
        layout->cap_height = cap;
        int const least = cap > FONT_HEIGHT_MIN ? scale_length(0.7 * bar_height, cap)
                                                : scale_length(bar_height_least, cap);
        for (int bar = scale_length(bar_height, cap); bar >= least; bar -= cap) {
            layout->is_drawn = try_size(right, bottom, legend, bar, layout);
            if (layout->is_drawn) {
                move_to_corner(legend->corner, right, bottom, layout);
                return;
            }
            if (!legend->has_gradient) break;
        }
    }
}

static void write(render_image *image, const overlay_layout *layout, const char *text, int x,
                  int baseline) {
    overlay_text label = {.text = text,
                          .x = x,
                          .baseline = baseline,
                          .cap_height = layout->cap_height,
                          .clip = layout->box};
    memcpy(label.color, ink_color, sizeof ink_color);
    overlay_draw_text(image, &label);
}

/* A thin line around a rectangle. */
static void draw_frame(render_image *image, overlay_rectangle r, double opacity) {
    overlay_rectangle const sides[4] = {{r.x - 1, r.y - 1, r.width + 2, 1},
                                        {r.x - 1, r.y + r.height, r.width + 2, 1},
                                        {r.x - 1, r.y, 1, r.height},
                                        {r.x + r.width, r.y, 1, r.height}};
    for (int i = 0; i < 4; i++) overlay_fill(image, sides[i], ink_color, opacity);
}

static void fill_linear(render_image *image, overlay_rectangle rectangle, const float color[3]) {
    uint8_t bytes[3];
    color_to_bytes(color, bytes);
    overlay_fill(image, rectangle, bytes, 1.0);
}

static void draw_gradient(render_image *image, const overlay_legend *legend,
                          const overlay_layout *layout) {
    overlay_rectangle const bar = layout->gradient;
    int const cap = layout->cap_height;
    for (int row = 0; row < bar.height; row++) {
        float color[3];
        color_map_get(legend->map, 1.0 - (row + 0.5) / bar.height, color);
        fill_linear(image, (overlay_rectangle){bar.x, bar.y + row, bar.width, 1}, color);
    }
    draw_frame(image, bar, 0.45);
    int const length = scale_length(tick_length, cap), thickness = 1 + cap / 16;
    int const text_x = bar.x + bar.width + length + scale_length(column_gap, cap);
    for (size_t i = 0; i < layout->ticks.count; i++) {
        const char *const label = layout->ticks.ticks[i].label;
        int const row = layout->tick_rows[i];
        overlay_rectangle const line = {bar.x + bar.width + 1, row - thickness / 2,
                                        label[0] ? length : (length + 1) / 2, thickness};
        overlay_fill(image, line, ink_color, label[0] ? 1.0 : 0.6);
        write(image, layout, label, text_x, row + (cap + 1) / 2);
    }
}

static void draw_swatch(render_image *image, const overlay_legend *legend,
                        const overlay_layout *layout, size_t index) {
    const overlay_swatch *const swatch = &legend->swatches[index];
    overlay_rectangle const place = layout->swatches[index];
    int const cap = layout->cap_height;
    fill_linear(image, place, swatch->color);
    draw_frame(image, place, 0.45);
    int const baseline = place.y + cap;
    write(image, layout, swatch->name, place.x + place.width + scale_length(column_gap, cap),
          baseline);
    if (!swatch->has_count) return;
    char count[32];
    format_count(swatch->count, count);
    int const right = layout->box.x + layout->box.width - scale_length(padding, cap);
    write(image, layout, count, right - font_measure(count, cap), baseline);
}

void overlay_draw_legend(render_image *image, const overlay_legend *legend) {
    overlay_layout layout;
    overlay_layout_legend(image->width, image->height, legend, &layout);
    if (!layout.is_drawn) return;
    overlay_fill(image, layout.box, box_color, box_opacity);
    int const left = layout.box.x + scale_length(padding, layout.cap_height);
    write(image, &layout, layout.title, left, layout.title_baseline);
    if (legend->has_gradient) draw_gradient(image, legend, &layout);
    for (size_t i = 0; i < layout.swatch_count; i++) draw_swatch(image, legend, &layout, i);
    if (legend->note) write(image, &layout, legend->note, left, layout.note_baseline);
}
