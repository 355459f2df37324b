/* support/patch_scene.h - moving surfaces for tests of patches, and what must hold for labels. */
#ifndef TULLE_TEST_SUPPORT_PATCH_SCENE_H
#define TULLE_TEST_SUPPORT_PATCH_SCENE_H

#include "detect/patches/kept_patches.h"

typedef enum patch_shape {
    PATCH_SHEET,    /* a waving square */
    PATCH_RAMP,     /* a helix of 1.6 turns */
    PATCH_SPIRAL,   /* a flat spiral of 1.6 turns, nearly in one plane */
    PATCH_ANNULUS,  /* a ring with a hole */
    PATCH_SLIT,     /* a square, slit from an edge to beyond its middle */
    PATCH_SPHERE,   /* closed */
    PATCH_MOEBIUS,  /* a strip with one side */
    PATCH_CYLINDER, /* two boundaries */
    PATCH_FOLDED,   /* a sheet folded over itself, nearly flat */
    PATCH_SOUP,     /* random triangles over few vertices: edges with many triangles, needles */
    PATCH_SHAPE_COUNT
} patch_shape;

typedef struct patch_scene {
    size_t vertex_count, triangle_count;
    uint32_t *triangles;
    double *x0, *x1; /* [m] */
    topology topo;
    surface_range range;
    surface_set set; /* one surface */
    memory heap;
} patch_scene;

/* About 2 n^2 triangles within a box of some metres; x1 is x0. The struct may not move. */
void patch_scene_make(patch_scene *scene, patch_shape shape, size_t n, uint64_t *seed);
/* From arrays, which are copied. */
void patch_scene_make_of(patch_scene *scene, const double *x0, const double *x1,
                         size_t vertex_count, const uint32_t *triangles, size_t triangle_count);
void patch_scene_destroy(patch_scene *scene);
/* Sets x1: a smooth flow of size `flow` and noise of size `noise` [m] added to x0. */
void patch_scene_move(patch_scene *scene, double flow, double noise, uint64_t *seed);

/* Every patch is an edge-connected disc of consistently oriented triangles: fails the test. */
void assert_patches_are_discs(const patch_scene *scene, const uint32_t *labels);
/* By rational arithmetic: no vertex and triangle, no two edges of one patch that share no vertex
 * touch at any time; with separation > 0 they are farther apart at some sampled times. Returns how
 * many pairs were looked at exactly. */
size_t assert_patches_are_apart(const patch_scene *scene, const uint32_t *labels, double separation,
                                uint64_t *seed);

#endif
