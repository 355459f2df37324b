/* render/overlay.c - rectangles and text: see overlay.h. A stroke covers a pixel by how far the
 * pixel's center is from its middle line, which is exact where its edge runs along the pixels and
 * within a few percent elsewhere. Colors are blended as sRGB bytes, which keeps dark text on light
 * ground from looking thin. */
#include "render/overlay.h"

#include "render/font.h"

#include <math.h>

static int larger(int a, int b) { return a > b ? a : b; }
static int smaller(int a, int b) { return a < b ? a : b; }

static overlay_rectangle intersect(overlay_rectangle a, overlay_rectangle b) {
    int const x = larger(a.x, b.x), y = larger(a.y, b.y);
    return (overlay_rectangle){x, y, smaller(a.x + a.width, b.x + b.width) - x,
                               smaller(a.y + a.height, b.y + b.height) - y};
}

static overlay_rectangle get_whole(const render_image *image) {
    return (overlay_rectangle){0, 0, (int)image->width, (int)image->height};
}

static void blend(render_image *image, int x, int y, const uint8_t color[3], double opacity) {
    uint8_t *const pixel = image->pixels + 3 * ((size_t)y * image->width + (size_t)x);
    for (int i = 0; i < 3; i++)
        pixel[i] = (uint8_t)(pixel[i] + opacity * (color[i] - pixel[i]) + 0.5);
}

void overlay_fill(render_image *image, overlay_rectangle rectangle, const uint8_t color[3],
                  double opacity) {
    overlay_rectangle const inside = intersect(rectangle, get_whole(image));
    for (int y = inside.y; y < inside.y + inside.height; y++)
        for (int x = inside.x; x < inside.x + inside.width; x++) blend(image, x, y, color, opacity);
}

static double get_distance2(const font_segment *segment, double x, double y) {
    double const dx = segment->x1 - segment->x0, dy = segment->y1 - segment->y0;
    double const px = x - segment->x0, py = y - segment->y0;
    double const length2 = dx * dx + dy * dy;
    double t = length2 > 0.0 ? (px * dx + py * dy) / length2 : 0.0;
    t = t > 0.0 ? (t < 1.0 ? t : 1.0) : 0.0;
    return (px - t * dx) * (px - t * dx) + (py - t * dy) * (py - t * dy);
}

/* Part of the pixel with its center at (x, y) that the glyph's strokes cover. */
static double get_coverage(const font_glyph *glyph, double half_width, double x, double y) {
    double nearest = INFINITY;
    for (size_t i = 0; i < glyph->segment_count; i++)
        nearest = fmin(nearest, get_distance2(&glyph->segments[i], x, y));
    double const coverage = half_width + 0.5 - sqrt(nearest);
    return coverage > 0.0 ? (coverage < 1.0 ? coverage : 1.0) : 0.0;
}

void overlay_draw_text(render_image *image, const overlay_text *text) {
    overlay_rectangle clip = get_whole(image);
    if (text->clip.width > 0) clip = intersect(clip, text->clip);
    double const half_width = 0.5 * font_get_stroke_width(text->cap_height);
    int const descent = font_get_descent(text->cap_height) + 1;
    int left = text->x;
    font_glyph glyph;
    for (const char *rest = text->text; *rest && left < clip.x + clip.width;) {
        font_get_glyph(font_next_code_point(&rest), text->cap_height, &glyph);
        overlay_rectangle const reach = {left - 1, text->baseline - text->cap_height - descent,
                                         glyph.width + 2, text->cap_height + 2 * descent};
        overlay_rectangle const inside = intersect(reach, clip);
        for (int y = inside.y; y < inside.y + inside.height; y++)
            for (int x = inside.x; x < inside.x + inside.width; x++) {
                double const coverage =
                    get_coverage(&glyph, half_width, x - left + 0.5, y - text->baseline + 0.5);
                if (coverage > 0.0) blend(image, x, y, text->color, coverage);
            }
        left += glyph.advance;
    }
}
