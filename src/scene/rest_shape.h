/* scene/rest_shape.h - a cloth's triangles at the start, at rest and in the plane of texture
 * coordinates, for make_rest.c, which makes the rest shape, and note_rest.c, which looks at it. */
#ifndef TULLE_SCENE_REST_SHAPE_H
#define TULLE_SCENE_REST_SHAPE_H

#include "scene/scene_data.h"

#include "math/vec3.h"

typedef struct rest_work {
    const scene_work *scene;
    const cloth_keys *keys;
    scene_cloth *cloth;
    const double *corner_uvs; /* null: the mesh has none */
    const uint32_t *lines;    /* of the triangles in an OBJ file; null: none */
    uint32_t *regions;        /* of the triangles; UINT32_MAX: none. Null without regions */
} rest_work;

/* A triangle, from corner 0. */
typedef struct edge_pair {
    vec3 first, second;
} edge_pair;

edge_pair get_start(const rest_work *work, size_t triangle);
edge_pair get_rest(const rest_work *work, size_t triangle);
edge_pair get_texture(const rest_work *work, size_t triangle); /* z = 0 */

static inline double measure_double_area(edge_pair edges) {
    return vec3_norm(vec3_cross(edges.first, edges.second));
}

/* "triangle 5", with its line where there are lines; null without memory. */
const char *name_triangle(const rest_work *work, size_t triangle);

/* The region of a triangle; null: none. */
static inline const region_keys *get_region(const rest_work *work, size_t triangle) {
    const region_keys *const regions = work->keys->regions.items;
    bool const has_one = work->regions && work->regions[triangle] != UINT32_MAX;
    return has_one ? &regions[work->regions[triangle]] : NULL;
}
/* Finds the region of each triangle. False after a problem: one has none, or memory is out. */
bool find_regions(rest_work *work);
/* Lists the edges of creases. False after a problem: a crease has none, or memory is out. */
bool list_creases(const rest_work *work);
/* Whether the triangles of a region have a grain of their own, or one shrinks or has a factor on
 * its stiffness. */
bool has_region_grain(const rest_work *work);
bool has_region_shrink(const rest_work *work);
bool has_region_stiffness(const rest_work *work);
/* Fills the factors on the stiffness of triangles, where there are any. False after a problem. */
bool make_stiffness(const rest_work *work);

/* Notes what is allowed in a rest shape and is seldom meant. False, with a problem, without memory.
 */
bool note_odd_rest(const rest_work *work, const rest_keys *keys);

#endif
