/* render/triangle_boxes.h - a tree of boxes around triangles, where they are now and where they are
 * at rest. */
#ifndef TULLE_RENDER_TRIANGLE_BOXES_H
#define TULLE_RENDER_TRIANGLE_BOXES_H

#include "base/arena.h"
#include "math/vec3.h"

/* Boxes in preorder: the left child follows its parent. */
typedef struct triangle_box {
    vec3 low, high, rest_low, rest_high;
    uint32_t right;        /* index of the right child; 0: a leaf */
    uint32_t first, count; /* of a leaf, in the tree's triangles */
} triangle_box;

typedef struct triangle_boxes {
    triangle_box *boxes;
    uint32_t *triangles;
    size_t surface; /* for the caller */
    uint32_t piece;
} triangle_boxes;

/* What a tree is built of. */
typedef struct triangle_source {
    tulle_mesh_view mesh;
    const double *rest;        /* 3 a vertex; null: rest boxes are those of now */
    const uint32_t *triangles; /* null: all, in order */
    size_t count;              /* of them, > 0 */
} triangle_source;

/* Fills tree->boxes and tree->triangles; false when memory is short. Under 32 deep. */
bool triangle_boxes_build(arena *scratch, const triangle_source *source, triangle_boxes *tree);

/* Distances of the nearest and of the farthest point of a box from p. */
double triangle_box_get_least_distance(vec3 low, vec3 high, vec3 p);
double triangle_box_get_most_distance(vec3 low, vec3 high, vec3 p);

#endif
