/* render/color_map.c - see color_map.h. Colors are laid out by lightness, chroma and hue in OKLab.
 * Lightness is linear in the value, so order shows in grey as well. Every color of a map lies
 * within sRGB, so nothing is clipped. */
#include "render/color_map.h"

#include "render/color_space.h"

#include <math.h>

/* Lightness, chroma, hue [degrees]. */
typedef struct color_point {
    double lightness, chroma, hue;
} color_point;

static void store(const double rgb[3], float result[3]) {
    for (int i = 0; i < 3; i++)
        result[i] = (float)(rgb[i] > 0.0 ? (rgb[i] < 1.0 ? rgb[i] : 1.0) : 0.0);
}

static void store_point(color_point point, float result[3]) {
    double rgb[3];
    color_from_oklch(point.lightness, point.chroma, point.hue, rgb);
    store(rgb, result);
}

/* Chroma of the sequential map at every tenth: as much as sRGB has along the way of its hues,
 * least about the blue greens. */
static double const sequential_chroma[] = {0.085, 0.125, 0.130, 0.115, 0.098, 0.094,
                                           0.105, 0.130, 0.155, 0.170, 0.165};
enum { CHROMA_STEPS = sizeof sequential_chroma / sizeof sequential_chroma[0] - 1 };

static color_point get_sequential(double value) {
    double const place = value * CHROMA_STEPS;
    int const step = place < CHROMA_STEPS - 1 ? (int)place : CHROMA_STEPS - 1;
    double const part = place - step;
    return (color_point){
        .lightness = 0.27 + 0.65 * value,
        .chroma = (1.0 - part) * sequential_chroma[step] + part * sequential_chroma[step + 1],
        .hue = 308.0 - 202.0 * value,
    };
}

static color_point get_diverging(double value) {
    double const distance = fabs(2.0 * value - 1.0); /* from the middle, 0 .. 1 */
    return (color_point){
        .lightness = 0.93 - 0.45 * distance,
        .chroma = 0.165 * distance * (1.9 - 0.9 * distance) * (0.72 + 0.28 * distance),
        .hue = value < 0.5 ? 260.0 : 27.0,
    };
}

void color_map_get(color_map map, double value, float rgb[3]) {
    if (isnan(value)) {
        store_point((color_point){0.35, 0.0, 0.0}, rgb);
        return;
    }
    double const inside = value > 0.0 ? (value < 1.0 ? value : 1.0) : 0.0;
    store_point(map == COLOR_MAP_SEQUENTIAL ? get_sequential(inside) : get_diverging(inside), rgb);
}

static const struct {
    const char *name;
    color_point color;
} contacts[COLOR_CONTACT_COUNT] = {
    [COLOR_CONTACT_NEW] = {"new", {0.82, 0.165, 88.0}},
    [COLOR_CONTACT_STICK] = {"stick", {0.52, 0.140, 252.0}},
    [COLOR_CONTACT_SLIP] = {"slip", {0.66, 0.190, 40.0}},
    [COLOR_CONTACT_HARD] = {"hard", {0.34, 0.120, 325.0}},
    [COLOR_CONTACT_OPEN] = {"open", {0.92, 0.000, 0.0}},
};

void color_map_contact(color_contact state, float rgb[3]) {
    store_point(contacts[state].color, rgb);
}

const char *color_map_contact_name(color_contact state) {
    return (unsigned)state < COLOR_CONTACT_COUNT ? contacts[state].name : NULL;
}

/* Spread over OKLab between lightness 0.5 and 0.86, the nearest two as far apart as could be. */
static const color_point patch_colors[COLOR_PATCH_COUNT] = {
    {0.680, 0.14, 234.0}, {0.860, 0.18, 108.0}, {0.635, 0.06, 6.0},   {0.635, 0.14, 120.0},
    {0.635, 0.18, 294.0}, {0.725, 0.18, 48.0},  {0.500, 0.06, 174.0}, {0.770, 0.18, 336.0},
    {0.500, 0.18, 258.0}, {0.770, 0.18, 156.0}, {0.500, 0.18, 30.0},  {0.500, 0.18, 330.0},
};

void color_map_patch(uint32_t index, float rgb[3]) {
    color_point const grey = {0.80, 0.0, 0.0};
    store_point(index < COLOR_PATCH_COUNT ? patch_colors[index] : grey, rgb);
}
