/* render/color_map.h - colors that stand for numbers, for states of contacts, and for patches.
 * Colors are linear RGB in 0 .. 1. */
#ifndef TULLE_RENDER_COLOR_MAP_H
#define TULLE_RENDER_COLOR_MAP_H

#include "base/memory.h"

typedef enum color_map {
    COLOR_MAP_SEQUENTIAL, /* dark violet, blue, green, yellow: lightness rises evenly */
    COLOR_MAP_DIVERGING   /* 0 blue (compressed), 0.5 light grey, 1 red (stretched) */
} color_map;

/* The map's color of a value; below 0 and above 1 that of the nearest end, NaN dark grey. */
void color_map_get(color_map map, double value, float rgb[3]);

/* What color-blind readers and a grey print tell apart as well. */
typedef enum color_contact {
    COLOR_CONTACT_NEW,
    COLOR_CONTACT_STICK,
    COLOR_CONTACT_SLIP,
    COLOR_CONTACT_HARD, /* given more than friction can bear */
    COLOR_CONTACT_OPEN, /* near, without force */
    COLOR_CONTACT_COUNT
} color_contact;
void color_map_contact(color_contact state, float rgb[3]);
/* "new", "stick", "slip", "hard", "open"; null out of range. */
const char *color_map_contact_name(color_contact state);

enum { COLOR_PATCH_COUNT = 12 }; /* colors that patches have, the grey of no patch not counted */
/* Least OKLab distance between two of them, and between each and the grey. */
#define COLOR_PATCH_DISTANCE 0.15

/* Color `index` < COLOR_PATCH_COUNT; the neutral grey for TULLE_NONE. */
void color_map_patch(uint32_t index, float rgb[3]);

/* Colors of triangles by patch: two patches that share an edge never have the same. A patch keeps
 * its color from call to call where its neighbours allow it.
 *
 * labels: one a triangle; any numbers; 0 is no patch, drawn grey. mesh.positions is not read;
 * indices are < mesh.vertex_count. triangle_colors: 3 a triangle, filled in.
 * alike_count (may be null): pairs of neighbouring patches that look alike after all. It is 0 when
 * every group of patches has one with fewer than COLOR_PATCH_COUNT neighbours in the group. On a
 * sheet or a sphere whose patches are in one piece each, that is always so.
 * Errors: TULLE_ERROR_OUT_OF_MEMORY; TULLE_ERROR_LIMIT (over 2^30 triangles).
 */
tulle_status color_patches(memory *heap, tulle_mesh_view mesh, const uint32_t *labels,
                           float *triangle_colors, size_t *alike_count, tulle_error *error);

#endif
