/* render/font.c - see font.h.
 *
 * A glyph is drawn on a grid: baseline at 0, small letters 20 high, capitals 28, descenders to -8;
 * x from 0 to its width. Its strokes are text: M moves, L draws a line, H and V a quarter of an
 * ellipse that leaves horizontally or vertically, C a cubic Bezier curve.
 *
 * Fitting to pixels: edges of strokes at the baseline, at the height of small letters and at that
 * of capitals fall on edges of pixels, as does every other end of a piece. So horizontal and
 * vertical strokes are sharp. */
#include "render/font.h"

#include <math.h>

enum { CAP_HEIGHT = 28, SMALL_HEIGHT = 20, DESCENT = 8, SPACING = 8, CURVE_STEPS = 10 };
static double const stroke_width = 3.3;   /* of the grid */
static double const kappa = 0.5522847498; /* control points of a quarter of a circle as a cubic */

typedef struct glyph_shape {
    uint16_t code_point;
    uint8_t width;
    const char *strokes;
} glyph_shape;

#define BOWL_RIGHT "M0 10 C0 16 3 20 8 20 C12 20 15 16 15 10 C15 4 12 0 8 0 C3 0 0 4 0 10"
#define BOWL_LEFT "M15 10 C15 16 12 20 7 20 C3 20 0 16 0 10 C0 4 3 0 7 0 C12 0 15 4 15 10"
#define ROUND_O "M11 28 C18 28 22 22 22 14 C22 6 18 0 11 0 C4 0 0 6 0 14 C0 22 4 28 11 28"
#define CURVED_S                                                                                   \
    "M16 22 C15 26 12 28 8 28 C4 28 1 25 1 21 C1 12 17 17 17 7 C17 3 13 0 8 0 C4 0 1 2 0 7"

static const glyph_shape missing = {0, 14, "M0 0 L14 0 L14 28 L0 28 L0 0"};

/* Ascending by code point. */
static const glyph_shape shapes[] = {
    {' ', 3, ""},
    {'!', 0, "M0 28 L0 9 M0 0 L0 0"},
    {'"', 6, "M0 28 L0 20 M6 28 L6 20"},
    {'#', 18, "M4 0 L8 28 M11 0 L15 28 M1 19 L18 19 M0 9 L17 9"},
    {'$', 17, CURVED_S " M9 32 L9 -4"},
    {'%', 28, "M0 22 V6 28 H12 22 V6 16 H0 22 M16 6 V22 12 H28 6 V22 0 H16 6 M22 28 L6 0"},
    {'&', 22,
     "M22 0 L5 20 C2 24 4 28 8 28 C12 28 14 24 12 20 C11 17 0 14 0 7 C0 2 4 0 8 0 C14 0 18 5 19 "
     "12"},
    {'\'', 0, "M0 28 L0 20"},
    {'(', 6, "M6 31 C2 26 0 20 0 12 C0 4 2 -2 6 -7"},
    {')', 6, "M0 31 C4 26 6 20 6 12 C6 4 4 -2 0 -7"},
    {'*', 10, "M5 28 L5 17 M0 25 L10 20 M10 25 L0 20"},
    {'+', 16, "M8 20 L8 4 M0 12 L16 12"},
    {',', 2, "M2 0 L0 -6"},
    {'-', 9, "M0 10 L9 10"},
    {'.', 0, "M0 0 L0 0"},
    {'/', 12, "M0 -3 L12 30"},
    {'0', 16, "M0 19 V8 28 H16 19 L16 9 V8 0 H0 9 L0 19"},
    {'1', 16, "M3 23 L9 28 L9 0"},
    {'2', 16, "M0 21 V8 28 H16 20 C16 13 8 9 0 0 L16 0"},
    {'3', 16, "M0 23 C2 26 4 28 8 28 H15 21 V8 15 L6 15 M8 15 H16 7 V8 0 C4 0 1 2 0 6"},
    {'4', 16, "M12 0 L12 28 L0 8 L16 8"},
    {'5', 16, "M14 28 L2 28 L1 15 C3 17 5 18 8 18 H16 9 V8 0 C4 0 1 2 0 5"},
    {'6', 16, "M14 25 C13 27 11 28 9 28 C3 28 0 21 0 12 L0 9 V8 0 H16 9 V8 18 H0 9"},
    {'7', 16, "M0 28 L16 28 C10 20 6 11 6 0"},
    {'8', 16, "M8 15 H1 21 V8 28 H15 21 V8 15 H0 7 V8 0 H16 7 V8 15"},
    {'9', 16, "M2 3 C3 1 5 0 7 0 C13 0 16 7 16 16 L16 19 V8 28 H0 19 V8 10 H16 19"},
    {':', 0, "M0 0 L0 0 M0 17 L0 17"},
    {';', 2, "M2 0 L0 -6 M2 17 L2 17"},
    {'<', 15, "M15 20 L0 12 L15 4"},
    {'=', 16, "M0 16 L16 16 M0 8 L16 8"},
    {'>', 15, "M0 20 L15 12 L0 4"},
    {'?', 14, "M0 22 V7 28 H14 21 C14 15 7 16 7 9 M7 0 L7 0"},
    {'@', 26,
     "M18 16 C17 18 15 19 13 19 C10 19 8 16 8 12 C8 8 10 5 13 5 C16 5 18 9 18 12 L18 19 M18 12 C18 "
     "7 19 5 21 5 C24 5 26 9 26 13 C26 21 21 26 14 26 C6 26 0 20 0 12 C0 3 6 -3 14 -3 C17 -3 20 -2 "
     "22 -1"},
    {'A', 20, "M0 0 L10 28 L20 0 M4 10 L16 10"},
    {'B', 17, "M0 0 L0 28 L9 28 H16 21 V9 15 L0 15 M9 15 H17 7 V9 0 L0 0"},
    {'C', 20, "M20 21 C18 26 15 28 11 28 C4 28 0 22 0 14 C0 6 4 0 11 0 C15 0 18 2 20 7"},
    {'D', 19, "M0 0 L0 28 L8 28 C15 28 19 23 19 14 C19 5 15 0 8 0 L0 0"},
    {'E', 15, "M15 28 L0 28 L0 0 L15 0 M0 15 L13 15"},
    {'F', 15, "M15 28 L0 28 L0 0 M0 14 L12 14"},
    {'G', 21,
     "M20 22 C18 26 15 28 11 28 C4 28 0 22 0 14 C0 6 4 0 11 0 C16 0 20 3 21 8 L21 13 L12 13"},
    {'H', 19, "M0 0 L0 28 M19 0 L19 28 M0 15 L19 15"},
    {'I', 0, "M0 0 L0 28"},
    {'J', 12, "M12 28 L12 8 V6 0 H0 8"},
    {'K', 18, "M0 0 L0 28 M17 28 L0 11 M6 17 L18 0"},
    {'L', 14, "M0 28 L0 0 L14 0"},
    {'M', 22, "M0 0 L0 28 L11 4 L22 28 L22 0"},
    {'N', 19, "M0 0 L0 28 L19 0 L19 28"},
    {'O', 22, ROUND_O},
    {'P', 17, "M0 0 L0 28 L9 28 H17 20 V9 12 L0 12"},
    {'Q', 22, ROUND_O " M14 6 L22 -2"},
    {'R', 18, "M0 0 L0 28 L9 28 H17 20 V9 13 L0 13 M10 13 L18 0"},
    {'S', 17, CURVED_S},
    {'T', 18, "M0 28 L18 28 M9 28 L9 0"},
    {'U', 18, "M0 28 L0 10 C0 4 3 0 9 0 C15 0 18 4 18 10 L18 28"},
    {'V', 20, "M0 28 L10 0 L20 28"},
    {'W', 28, "M0 28 L7 0 L14 28 L21 0 L28 28"},
    {'X', 18, "M0 0 L17 28 M1 28 L18 0"},
    {'Y', 18, "M0 28 L9 13 L18 28 M9 13 L9 0"},
    {'Z', 17, "M0 28 L17 28 L0 0 L17 0"},
    {'[', 5, "M5 31 L0 31 L0 -7 L5 -7"},
    {'\\', 12, "M0 30 L12 -3"},
    {']', 5, "M0 31 L5 31 L5 -7 L0 -7"},
    {'^', 12, "M0 20 L6 28 L12 20"},
    {'_', 16, "M0 -5 L16 -5"},
    {'`', 4, "M0 28 L4 23"},
    {'a', 14,
     "M1 15 C2 18 4 20 7 20 C12 20 14 18 14 14 L14 0 M14 11 C10 11 0 12 0 5 C0 2 3 0 6 0 C10 0 14 "
     "3 14 7"},
    {'b', 15, "M0 0 L0 28 " BOWL_RIGHT},
    {'c', 14, "M14 15 C13 18 11 20 8 20 C3 20 0 16 0 10 C0 4 3 0 8 0 C11 0 13 2 14 5"},
    {'d', 15, "M15 0 L15 28 " BOWL_LEFT},
    {'e', 15, "M0 11 L15 11 C15 17 12 20 8 20 C3 20 0 16 0 10 C0 4 3 0 8 0 C11 0 13 1 15 5"},
    {'f', 10, "M10 28 L8 28 C4 28 3 26 3 23 L3 0 M0 20 L9 20"},
    {'g', 15, BOWL_LEFT " M15 20 L15 0 C15 -5 12 -8 7 -8 C4 -8 2 -7 1 -5"},
    {'h', 14, "M0 0 L0 28 M0 12 C0 17 3 20 7 20 C11 20 14 18 14 13 L14 0"},
    {'i', 0, "M0 0 L0 20 M0 27 L0 27"},
    {'j', 5, "M5 20 L5 -3 C5 -7 3 -8 0 -8 M5 27 L5 27"},
    {'k', 13, "M0 0 L0 28 M12 20 L0 8 M5 12 L13 0"},
    {'l', 0, "M0 0 L0 28"},
    {'m', 24,
     "M0 0 L0 20 M0 13 C0 17 3 20 6 20 C10 20 12 18 12 13 L12 0 M12 13 C12 17 15 20 18 20 C22 20 "
     "24 18 24 13 L24 0"},
    {'n', 14, "M0 0 L0 20 M0 12 C0 17 3 20 7 20 C11 20 14 18 14 13 L14 0"},
    {'o', 16, "M8 20 C13 20 16 16 16 10 C16 4 13 0 8 0 C3 0 0 4 0 10 C0 16 3 20 8 20"},
    {'p', 15, "M0 20 L0 -8 " BOWL_RIGHT},
    {'q', 15, "M15 20 L15 -8 " BOWL_LEFT},
    {'r', 8, "M0 0 L0 20 M0 11 C0 16 3 20 8 20"},
    {'s', 13,
     "M12 16 C11 19 9 20 6 20 C3 20 1 18 1 15 C1 9 13 12 13 5 C13 2 10 0 7 0 C3 0 1 1 0 4"},
    {'t', 9, "M3 26 L3 5 C3 2 4 0 7 0 L9 0 M0 20 L9 20"},
    {'u', 14, "M0 20 L0 7 C0 2 3 0 7 0 C11 0 14 3 14 8 M14 20 L14 0"},
    {'v', 14, "M0 20 L7 0 L14 20"},
    {'w', 22, "M0 20 L6 0 L11 20 L16 0 L22 20"},
    {'x', 14, "M0 0 L13 20 M1 20 L14 0"},
    {'y', 14, "M0 20 L7 1 M14 20 L7 1 L6 -3 C5 -6 3 -8 0 -8"},
    {'z', 13, "M0 20 L13 20 L0 0 L13 0"},
    {'{', 8, "M8 31 C3 31 4 27 4 22 C4 16 4 13 0 12 C4 11 4 8 4 2 C4 -3 3 -7 8 -7"},
    {'|', 0, "M0 31 L0 -7"},
    {'}', 8, "M0 31 C5 31 4 27 4 22 C4 16 4 13 8 12 C4 11 4 8 4 2 C4 -3 5 -7 0 -7"},
    {'~', 16, "M0 10 C2 16 5 15 8 12 C11 9 14 8 16 14"},
    {0xB0, 10, "M5 28 H10 23 V5 18 H0 23 V5 28"}, /* degree */
    {0xB2, 10, "M0 24 V5 28 H10 24 C10 20 5 18 0 13 L10 13"},
    {0xB5, 14, "M0 20 L0 -8 M0 7 C0 2 3 0 7 0 C11 0 14 3 14 8 M14 20 L14 0"},  /* micro */
    {0xB7, 0, "M0 11 L0 11"},                                                  /* middle dot */
    {0xD7, 12, "M0 6 L12 18 M12 6 L0 18"},                                     /* times */
    {0x3BC, 14, "M0 20 L0 -8 M0 7 C0 2 3 0 7 0 C11 0 14 3 14 8 M14 20 L14 0"}, /* mu */
    {0x2013, 16, "M0 10 L16 10"},                                              /* dash */
    {0x2212, 16, "M0 12 L16 12"},                                              /* minus */
};
enum { SHAPE_COUNT = sizeof shapes / sizeof shapes[0] };

uint32_t font_next_code_point(const char **text) {
    const unsigned char *const bytes = (const unsigned char *)*text;
    uint32_t const first = bytes[0];
    int const length = first < 0x80   ? 1
                       : first < 0xC2 ? 0
                       : first < 0xE0 ? 2
                       : first < 0xF0 ? 3
                       : first < 0xF5 ? 4
                                      : 0;
    uint32_t code_point = length <= 1 ? first : first & (0x7Fu >> length);
    int have = 1;
    /* The text's closing zero is no continuation byte, so this never reads past it. */
    while (have < length && (bytes[have] & 0xC0) == 0x80)
        code_point = code_point << 6 | (bytes[have++] & 0x3Fu);
    if (have != length) {
        *text += 1;
        return 0xFFFD;
    }
    *text += length;
    return code_point;
}

static const glyph_shape *find_shape(uint32_t code_point) {
    size_t low = 0, high = SHAPE_COUNT;
    while (low < high) {
        size_t const middle = (low + high) / 2;
        if (shapes[middle].code_point == code_point) return &shapes[middle];
        if (shapes[middle].code_point < code_point)
            low = middle + 1;
        else
            high = middle;
    }
    return &missing;
}

double font_get_stroke_width(int cap_height) {
    double const width = stroke_width * cap_height / (CAP_HEIGHT + stroke_width);
    return width < 1.4 ? 1.0 : width; /* a thinner stroke would only be paler */
}

/* Maps the grid to pixels. */
typedef struct glyph_fit {
    double stroke;  /* [pixels] */
    double scale_x; /* [pixels] a step of the grid */
    double small,
        cap; /* [pixels] of small and of capital letters' topmost stroke above the lowest */
    font_glyph *glyph;
    double x, y; /* [pixels] where the pen is */
} glyph_fit;

static double fit_x(const glyph_fit *fit, double x) { return x * fit->scale_x; }

/* Up from the center of the baseline's stroke. */
static double fit_y(const glyph_fit *fit, double y) {
    if (y <= SMALL_HEIGHT) return y * fit->small / SMALL_HEIGHT;
    return fit->small + (y - SMALL_HEIGHT) * (fit->cap - fit->small) / (CAP_HEIGHT - SMALL_HEIGHT);
}

static void add_segment(glyph_fit *fit, double x, double y) {
    font_glyph *const glyph = fit->glyph;
    if (glyph->segment_count < FONT_SEGMENT_MAX) {
        double const half = 0.5 * fit->stroke;
        glyph->segments[glyph->segment_count++] =
            (font_segment){fit->x + half, -fit->y - half, x + half, -y - half};
    }
    fit->x = x;
    fit->y = y;
}

/* Control points and end, in pixels. */
static void add_curve(glyph_fit *fit, const double p[6]) {
    double const x = fit->x, y = fit->y;
    for (int i = 1; i <= CURVE_STEPS; i++) {
        double const t = (double)i / CURVE_STEPS, u = 1.0 - t;
        double const a = u * u * u, b = 3.0 * u * u * t, c = 3.0 * u * t * t, d = t * t * t;
        add_segment(fit, a * x + b * p[0] + c * p[2] + d * p[4],
                    a * y + b * p[1] + c * p[3] + d * p[5]);
    }
}

static const char *read_number(const char *text, double *number) {
    while (*text == ' ') text++;
    double const sign = *text == '-' ? -1.0 : 1.0;
    if (*text == '-') text++;
    *number = 0.0;
    for (; *text >= '0' && *text <= '9'; text++) *number = 10.0 * *number + (*text - '0');
    *number *= sign;
    return text;
}

/* One command and its numbers; returns what follows. */
static const char *draw_command(glyph_fit *fit, const char *text) {
    char const command = *text++;
    double p[6];
    int const count = command == 'C' ? 6 : 2;
    for (int i = 0; i < count; i += 2) {
        text = read_number(text, &p[i]);
        text = read_number(text, &p[i + 1]);
        p[i] = fit_x(fit, p[i]);
        p[i + 1] = fit_y(fit, p[i + 1]);
    }
    double const x = round(p[count - 2]), y = round(p[count - 1]);
    double const dx = kappa * (x - fit->x), dy = kappa * (y - fit->y);
    switch (command) {
    case 'M': fit->x = x, fit->y = y; break;
    case 'L': add_segment(fit, x, y); break;
    case 'H': add_curve(fit, (const double[6]){fit->x + dx, fit->y, x, y - dy, x, y}); break;
    case 'V': add_curve(fit, (const double[6]){fit->x, fit->y + dy, x - dx, y, x, y}); break;
    default: add_curve(fit, (const double[6]){p[0], p[1], p[2], p[3], x, y}); break;
    }
    return text;
}

void font_get_glyph(uint32_t code_point, int cap_height, font_glyph *glyph) {
    const glyph_shape *const shape = find_shape(code_point);
    double const stroke = font_get_stroke_width(cap_height);
    double const cap = fmax(1.0, floor(cap_height - stroke)), scale = cap / CAP_HEIGHT;
    double const width = round(shape->width * scale);
    glyph_fit fit = {.stroke = stroke, .cap = cap, .glyph = glyph};
    fit.scale_x = shape->width ? width / shape->width : 0.0;
    fit.small = fmin(cap, round(SMALL_HEIGHT * scale));
    glyph->segment_count = 0;
    glyph->width = (int)ceil(width + stroke);
    glyph->advance = (int)round(width + SPACING * scale + 0.1);
    for (const char *text = shape->strokes; *text;) {
        text = draw_command(&fit, text);
        while (*text == ' ') text++;
    }
}

int font_measure(const char *text, int cap_height) {
    int x = 0, width = 0;
    font_glyph glyph;
    while (*text) {
        font_get_glyph(font_next_code_point(&text), cap_height, &glyph);
        width = x + glyph.width;
        x += glyph.advance;
    }
    return width;
}

int font_get_descent(int cap_height) {
    return (int)ceil((double)DESCENT * cap_height / CAP_HEIGHT);
}
