/* render/overlay.h - rectangles, text and legends drawn on a picture. The same input gives the same
 * bytes; nothing is ever drawn outside the picture. */
#ifndef TULLE_RENDER_OVERLAY_H
#define TULLE_RENDER_OVERLAY_H

#include "render/color_map.h"
#include "render/image.h"
#include "render/ticks.h"

/* [pixels] from the picture's top left corner. */
typedef struct overlay_rectangle {
    int x, y, width, height;
} overlay_rectangle;

/* Fills with an sRGB color; opacity 0 .. 1. */
void overlay_fill(render_image *image, overlay_rectangle rectangle, const uint8_t color[3],
                  double opacity);

typedef struct overlay_text {
    const char *text;       /* UTF-8, one line */
    int x, baseline;        /* [pixels] left end; lower edge of letters without descenders */
    int cap_height;         /* [pixels] of capital letters, >= 1 */
    uint8_t color[3];       /* sRGB */
    overlay_rectangle clip; /* nothing is drawn outside; all zero: the whole picture */
} overlay_text;

/* font_measure of render/font.h gives the width. */
void overlay_draw_text(render_image *image, const overlay_text *text);

/* ---- legends ---- */

typedef enum overlay_corner {
    OVERLAY_TOP_LEFT,
    OVERLAY_TOP_RIGHT,
    OVERLAY_BOTTOM_LEFT,
    OVERLAY_BOTTOM_RIGHT
} overlay_corner;

/* A color with its meaning. */
typedef struct overlay_swatch {
    const char *name;
    float color[3]; /* linear RGB */
    uint64_t count; /* how many of it are in the picture */
    bool has_count;
} overlay_swatch;

enum { OVERLAY_SWATCH_MAX = 16 };

/* What the colors of a picture mean: a gradient with ticks, or swatches, or both. */
typedef struct overlay_legend {
    overlay_corner corner;
    const char *title;
    bool has_gradient;
    color_map map; /* scale.low has the map's color 0, scale.high its color 1 */
    tick_scale scale;
    const overlay_swatch *swatches; /* below the gradient */
    size_t swatch_count;            /* those past OVERLAY_SWATCH_MAX are left out */
    const char *note;               /* null or a last line */
} overlay_legend;

/* Where everything of a legend goes in a picture of a size. */
typedef struct overlay_layout {
    bool is_drawn; /* false: the picture is too small for it */
    int cap_height;
    overlay_rectangle box, gradient;
    tick_list ticks;
    int tick_rows[TICK_MAX]; /* y of each tick's middle row */
    overlay_rectangle swatches[OVERLAY_SWATCH_MAX];
    size_t swatch_count;
    char title[128]; /* with the unit */
    int title_baseline, note_baseline;
} overlay_layout;

void overlay_layout_legend(uint32_t width, uint32_t height, const overlay_legend *legend,
                           overlay_layout *layout);
/* Draws it. Its gradient shows the map's colors themselves, not blended with the picture. */
void overlay_draw_legend(render_image *image, const overlay_legend *legend);

#endif
