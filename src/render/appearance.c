/* render/appearance.c - the color of a place on a surface: its material's, a pattern in the flat
 * cloth at rest, a wire of one pixel's width.
 *
 * Patterns have a mean of 1 and fade to it before their period comes down to two pixels, where they
 * would turn into moiré. Widths in pixels come from how the barycentric coordinates change from one
 * pixel to the next.
 *
 * Based on: Homan Igehy, Tracing ray differentials, 1999 (transfer to a plane);
 *           J. Andreas Bærentzen et al., Single-pass wireframe rendering, 2006 (lines from the
 *           distance to the edges in pixels). */
#include "render/surface_point.h"

static const double wire_half_width = 0.55; /* [pixels] */
static const double wire_strength = 0.8;    /* share of the light that the wire takes */
/* [pixels] heights of a triangle between which wires fade: below, lines would cover all of it. */
static const double wire_height_none = 2.0, wire_height_full = 6.0;

static const double fade_begin = 0.25, fade_end = 0.5; /* [periods] of one pixel */
static const double check_contrast = 0.26;             /* a square's deviation from the mean */
/* Brightness lost from the middle of a thread to its edge and to where it dips under. */
static const double thread_roundness = 0.30, thread_dip = 0.18;
static const double weave_contrast = 0.05; /* threads of the two directions, from their mean */

/* Change of the barycentric coordinates over one pixel across and down. */
typedef struct weight_change {
    double across[3], down[3];
} weight_change;

/* Where the next pixel's ray meets the plane of the triangle, less where this one does. */
static vec3 transfer(const render_footprint *footprint, vec3 change, vec3 normal, double distance) {
    double const slope = vec3_dot(normal, footprint->direction);
    double const along = slope != 0.0 ? vec3_dot(normal, change) / slope : 0.0;
    return vec3_scale(vec3_add_scaled(change, footprint->direction, -along), distance);
}

static weight_change compute_weight_change(const render_geometry *geometry,
                                           const render_point *point,
                                           const render_footprint *footprint) {
    const uint32_t *const corners = geometry->triangles + 3 * (size_t)point->triangle;
    vec3 const across = transfer(footprint, footprint->across, point->normal, point->distance);
    vec3 const down = transfer(footprint, footprint->down, point->normal, point->distance);
    vec3 const a = render_geometry_get_vertex(geometry, corners[0]);
    vec3 const ab = vec3_sub(render_geometry_get_vertex(geometry, corners[1]), a);
    vec3 const ac = vec3_sub(render_geometry_get_vertex(geometry, corners[2]), a);
    vec3 const cross = vec3_cross(ab, ac);
    double const area2 = vec3_norm2(cross);
    if (!(area2 > 0.0)) return (weight_change){0};
    /* Gradients of the second and third coordinate in the plane; all three sum to zero. */
    vec3 const g1 = vec3_scale(vec3_cross(ac, cross), 1.0 / area2);
    vec3 const g2 = vec3_scale(vec3_cross(cross, ab), 1.0 / area2);
    weight_change change = {{0.0, vec3_dot(g1, across), vec3_dot(g2, across)},
                            {0.0, vec3_dot(g1, down), vec3_dot(g2, down)}};
    change.across[0] = -change.across[1] - change.across[2];
    change.down[0] = -change.down[1] - change.down[2];
    return change;
}

/* 1 below `begin`, 0 above `end`, smooth between. */
static double fade(double value, double begin, double end) {
    double const s = fmin(fmax((value - begin) / (end - begin), 0.0), 1.0);
    return 1.0 - s * s * (3.0 - 2.0 * s);
}

static double get_weave(double s, double t) {
    double const row = floor(s), column = floor(t);
    double const u = 2.0 * (s - row) - 1.0, v = 2.0 * (t - column) - 1.0;
    bool const is_warp = fmod(row + column, 2.0) == 0.0;
    double const side = is_warp ? u : v, along = is_warp ? v : u;
    return (is_warp ? weave_contrast : -weave_contrast) +
           thread_roundness * (1.0 / 3.0 - side * side) + thread_dip * (1.0 / 3.0 - along * along);
}

static double get_check(double s, double t) {
    return fmod(floor(s) + floor(t), 2.0) == 0.0 ? check_contrast : -check_contrast;
}

/* What the pattern multiplies the color with. */
static double get_pattern(const render_geometry *geometry, const render_part *part,
                          const render_point *point, const weight_change *change) {
    const render_surface *const surface = part->surface;
    double place[2] = {0}, across[2] = {0}, down[2] = {0};
    for (int i = 0; i < 3; i++) {
        size_t const vertex =
            geometry->triangles[3 * (size_t)point->triangle + (size_t)i] - part->first_vertex;
        for (int axis = 0; axis < 2; axis++) {
            double const rest =
                surface->rest_coordinates[2 * vertex + (size_t)axis] / surface->pattern_size;
            place[axis] += point->weights[i] * rest;
            across[axis] += change->across[i] * rest;
            down[axis] += change->down[i] * rest;
        }
    }
    double const pixel = sqrt(
        fmax(across[0] * across[0] + across[1] * across[1], down[0] * down[0] + down[1] * down[1]));
    /* A pattern repeats after two squares or threads. */
    double const strength = fade(0.5 * pixel, fade_begin, fade_end);
    if (strength == 0.0) return 1.0;
    return 1.0 + strength * (surface->pattern == RENDER_PATTERN_WEAVE
                                 ? get_weave(place[0], place[1])
                                 : get_check(place[0], place[1]));
}

/* How much of the point the wires cover, 0 .. 1. */
static double get_wire(const render_point *point, const weight_change *change) {
    double cover = 0.0;
    for (int i = 0; i < 3; i++) {
        double const slope = hypot(change->across[i], change->down[i]);
        if (!(slope > 0.0)) continue;
        if (point->weights[i] < wire_half_width * slope)
            cover = fmax(cover, 1.0 - fade(1.0 / slope, wire_height_none, wire_height_full));
    }
    return cover;
}

static void get_material(const render_geometry *geometry, const render_part *part,
                         const render_point *point, double color[3]) {
    const render_surface *const surface = part->surface;
    size_t const triangle = point->triangle - part->first_triangle;
    const float *material = point->is_front ? surface->front_color : surface->back_color;
    if (surface->triangle_colors) material = surface->triangle_colors + 3 * triangle;
    for (int channel = 0; channel < 3; channel++) color[channel] = (double)material[channel];
    if (!surface->vertex_colors) return;
    for (int channel = 0; channel < 3; channel++) {
        color[channel] = 0.0;
        for (int i = 0; i < 3; i++) {
            size_t const vertex =
                geometry->triangles[3 * (size_t)point->triangle + (size_t)i] - part->first_vertex;
            color[channel] +=
                point->weights[i] * (double)surface->vertex_colors[3 * vertex + (size_t)channel];
        }
    }
}

void render_point_get_color(const render_geometry *geometry, const render_point *point,
                            const render_footprint *footprint, double color[3]) {
    const render_part *const part = &geometry->parts[geometry->part_index[point->triangle]];
    const render_surface *const surface = part->surface;
    get_material(geometry, part, point, color);
    bool const has_pattern = surface->pattern != RENDER_PATTERN_PLAIN &&
                             surface->rest_coordinates && !surface->vertex_colors &&
                             !surface->triangle_colors;
    if (!footprint || !(has_pattern || surface->has_wire)) return;
    weight_change const change = compute_weight_change(geometry, point, footprint);
    double factor = has_pattern ? get_pattern(geometry, part, point, &change) : 1.0;
    if (surface->has_wire) factor *= 1.0 - wire_strength * get_wire(point, &change);
    for (int channel = 0; channel < 3; channel++)
        color[channel] = fmin(color[channel] * factor, 1.0);
}
