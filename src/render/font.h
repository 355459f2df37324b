/* render/font.h - a stroke font: letters as lines and curves of one width, fitted to the pixels of
 * the size that is asked for, so that small text is sharp.
 *
 * It has ASCII and a few signs of units. Text is UTF-8; a character that the font lacks, or a byte
 * that is no UTF-8, shows as a box. Sizes are heights of capital letters in whole pixels. */
#ifndef TULLE_RENDER_FONT_H
#define TULLE_RENDER_FONT_H

#include <stddef.h>
#include <stdint.h>

enum { FONT_SEGMENT_MAX = 192 };
enum { FONT_HEIGHT_MIN = 6 }; /* [pixels] least height of capitals that can be read */

/* A straight piece of a stroke [pixels]: x from the glyph's left, y down from the baseline. */
typedef struct font_segment {
    double x0, y0, x1, y1;
} font_segment;

typedef struct font_glyph {
    font_segment segments[FONT_SEGMENT_MAX];
    size_t segment_count;
    int width;   /* [pixels] of the ink */
    int advance; /* [pixels] to the next glyph's left */
} font_glyph;

/* Next character of *text, which moves on; U+FFFD for a byte that is no UTF-8. *text must not be at
 * the end. */
uint32_t font_next_code_point(const char **text);
/* Strokes of a character at a height of capitals >= 1. */
void font_get_glyph(uint32_t code_point, int cap_height, font_glyph *glyph);
/* [pixels] width of all strokes at this size. */
double font_get_stroke_width(int cap_height);
/* [pixels] width of the ink of a line of text. */
int font_measure(const char *text, int cap_height);
/* [pixels] how far letters such as g reach below the baseline. */
int font_get_descent(int cap_height);

#endif
