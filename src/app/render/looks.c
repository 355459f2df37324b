/* app/render/looks.c - how bodies look where the scene does not say: colors that tell cloths, their
 * two sides and obstacles apart, a check by the size of the cloth, and the floor. */
#include "app/render/run.h"
#include "render/color_space.h"

#include <math.h>
#include <string.h>

/* Lightness, chroma and hue [degrees] of OKLab. */
typedef struct lch_color {
    double lightness, chroma, hue;
} lch_color;

/* Muted, far apart in hue, and of alternating lightness, so that neighbours differ in grey, too. */
static const lch_color palette[] = {
    {0.60, 0.105, 32.0}, /* brick */
    {0.56, 0.09, 240.0}, /* slate blue */
    {0.76, 0.10, 88.0},  /* ochre */
    {0.55, 0.09, 155.0}, /* fir green */
    {0.68, 0.09, 325.0}, /* mauve */
    {0.66, 0.08, 200.0}, /* teal */
    {0.48, 0.11, 285.0}, /* violet */
    {0.80, 0.09, 125.0}, /* lime */
};
enum { PALETTE_COUNT = sizeof palette / sizeof palette[0] };
static const lch_color static_color = {0.74, 0.012, 75.0};  /* warm grey */
static const lch_color moving_color = {0.62, 0.035, 250.0}; /* bluish, darker */
/* The back: lighter and paler than the front. */
static const double BACK_LIGHTNESS = 0.55, BACK_CHROMA = 0.4;
static const double CREASE_ANGLE = 0.7; /* [rad] of obstacles: 40 degrees */
static const double CHECKS = 24.0;      /* across a square cloth */
/* [of the cloths' size] A ground may lie this much above the lowest cloth; a floor lies so much
 * below everything, far enough not to touch. */
static const double GROUND_TOLERANCE = 1e-3, FLOOR_DEPTH = 1e-3;

/* Where colors stand for something, shade takes less away from them. */
static const float EXPLAINING_LIGHT = 0.4f, EXPLAINING_SKY = 1.25f;

static void set_color(lch_color from, float color[3]) {
    double rgb[3];
    color_from_oklch(from.lightness, from.chroma, from.hue, rgb);
    for (int k = 0; k < 3; k++) color[k] = (float)fmin(fmax(rgb[k], 0.0), 1.0);
}

void picture_make_linear(const double srgb[3], float linear[3]) {
    for (int k = 0; k < 3; k++) linear[k] = (float)color_decode_srgb(srgb[k]);
}

/* A paler color than the front's, of the same hue. */
static void set_back(const float front[3], float back[3]) {
    double const rgb[3] = {(double)front[0], (double)front[1], (double)front[2]};
    double lab[3], result[3];
    color_to_oklab(rgb, lab);
    lab[0] += BACK_LIGHTNESS * (1.0 - lab[0]);
    lab[1] *= BACK_CHROMA;
    lab[2] *= BACK_CHROMA;
    color_from_oklab(lab, result);
    for (int k = 0; k < 3; k++) back[k] = (float)fmin(fmax(result[k], 0.0), 1.0);
}

static double get_area(tulle_mesh_view mesh) {
    double sum = 0.0;
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        const double *x[3];
        for (size_t k = 0; k < 3; k++)
            x[k] = mesh.positions + 3 * (size_t)mesh.triangles[3 * t + k];
        double a[3], b[3];
        for (int k = 0; k < 3; k++) {
            a[k] = x[1][k] - x[0][k];
            b[k] = x[2][k] - x[0][k];
        }
        double const n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                             a[0] * b[1] - a[1] * b[0]};
        sum += 0.5 * sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    }
    return sum;
}

/* 1, 2 or 5 times a power of ten, the nearest by ratio. */
static double round_nicely(double value) {
    double const power = pow(10.0, floor(log10(value)));
    double const digits = value / power;
    return power * (digits < 1.5 ? 1.0 : digits < 3.2 ? 2.0 : digits < 7.1 ? 5.0 : 10.0);
}

static void dress_cloth(picture_body *body, size_t index) {
    render_surface *const surface = &body->surface;
    const scene_look *const look = &body->look;
    if (look->has_color)
        picture_make_linear(look->color, surface->front_color);
    else
        set_color(palette[index % PALETTE_COUNT], surface->front_color);
    if (look->has_back_color)
        picture_make_linear(look->back_color, surface->back_color);
    else
        set_back(surface->front_color, surface->back_color);
    surface->pattern = look->has_pattern ? (render_pattern)look->pattern : RENDER_PATTERN_CHECK;
    double const area = get_area(body->rest);
    surface->pattern_size = look->pattern_size;
    if (!(surface->pattern_size > 0.0) && area > 0.0)
        surface->pattern_size = round_nicely(sqrt(area) / CHECKS) *
                                (surface->pattern == RENDER_PATTERN_WEAVE ? 0.25 : 1.0);
    surface->rest_coordinates = body->rest_coordinates;
    surface->crease_angle = (double)INFINITY;
    if (!(surface->pattern_size > 0.0)) surface->pattern = RENDER_PATTERN_PLAIN;
}

void picture_dress_bodies(picture_run *run) {
    for (size_t i = 0; i < run->body_count; i++) {
        picture_body *const body = &run->bodies[i];
        body->surface.has_wire = run->options->has_wire;
        if (!body->is_obstacle) {
            dress_cloth(body, i);
            continue;
        }
        body->surface.crease_angle = CREASE_ANGLE;
        if (body->look.has_color)
            picture_make_linear(body->look.color, body->surface.front_color);
        else
            set_color(body->is_moving ? moving_color : static_color, body->surface.front_color);
        memcpy(body->surface.back_color, body->surface.front_color,
               sizeof body->surface.back_color);
    }
}

/* ---- the floor ---- */

/* Whether the body is a level rectangle along x and y that stays and lies under all cloth. */
static bool is_ground(const picture_run *run, const picture_body *body,
                      const picture_bounds *cloths) {
    if (!body->is_obstacle || body->is_hidden || body->is_moving || body->is_ever_absent)
        return false;
    picture_bounds box = picture_bounds_empty();
    picture_bounds_add(&box, body->rest.positions, body->rest.vertex_count);
    double const extent = (box.high[0] - box.low[0]) * (box.high[1] - box.low[1]);
    if (!(extent > 0.0) || box.high[2] - box.low[2] > 1e-9 * sqrt(extent)) return false;
    bool const is_under = box.low[0] <= cloths->low[0] && box.low[1] <= cloths->low[1] &&
                          box.high[0] >= cloths->high[0] && box.high[1] >= cloths->high[1] &&
                          box.high[2] <= cloths->low[2] + GROUND_TOLERANCE * run->cloth_size;
    return is_under && fabs(get_area(body->rest) - extent) <= 1e-6 * extent;
}

void picture_choose_floor(picture_run *run, const picture_bounds *cloths, double low) {
    run->has_floor = run->picture.floor != SCENE_FLOOR_OFF && isfinite(low);
    run->floor_height = low - FLOOR_DEPTH * run->cloth_size;
    if (run->picture.floor != SCENE_FLOOR_AUTO) return;
    for (size_t i = run->cloth_count; i < run->body_count; i++) {
        if (!is_ground(run, &run->bodies[i], cloths)) continue;
        run->floor_body = (uint32_t)i;
        run->floor_height = run->bodies[i].rest.positions[2];
        return;
    }
}

render_lighting picture_get_lighting(const picture_run *run) {
    render_lighting lighting = render_lighting_default();
    lighting.has_floor = run->has_floor;
    lighting.floor_height = run->floor_height;
    for (int k = 0; k < 3 && run->options->color != PICTURE_MATERIAL; k++) {
        lighting.light_radiance[k] *= EXPLAINING_LIGHT;
        lighting.sky_color[k] *= EXPLAINING_SKY;
        lighting.horizon_color[k] *= EXPLAINING_SKY;
    }
    if (run->floor_body != TULLE_NONE && run->bodies[run->floor_body].look.has_color)
        picture_make_linear(run->bodies[run->floor_body].look.color, lighting.floor_color);
    return lighting;
}
