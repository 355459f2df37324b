/* support/soup_scene.h - surfaces of random triangles, for the search for pairs. */
#ifndef TULLE_TEST_SOUP_SCENE_H
#define TULLE_TEST_SOUP_SCENE_H

#include "detect/surface_set.h"

enum { MAX_SURFACES = 6, MAX_TRIANGLES = 6000, MAX_VERTICES = 3 * MAX_TRIANGLES };

typedef enum soup_shape {
    SOUP_RANDOM,      /* small triangles anywhere */
    SOUP_OVERLAPPING, /* every triangle through the middle */
    SOUP_NEEDLES,     /* long and thin */
    SOUP_DUPLICATES,  /* few distinct places */
    SOUP_SHEET,       /* a flat grid with shared vertices */
    SOUP_POINTS,      /* boxes without extent, many equal */
    SOUP_CLUSTER,     /* most in one spot, some far away */
    SOUP_SHAPE_COUNT
} soup_shape;

typedef struct soup_scene {
    uint32_t triangles[3 * MAX_TRIANGLES];
    double x0[3 * MAX_VERTICES], x1[3 * MAX_VERTICES];
    surface_range surfaces[MAX_SURFACES];
    size_t surface_count, vertex_count, triangle_count;
    topology topo;
    surface_set set;
} soup_scene;

/* Adds a surface of about `count` triangles that move by up to `motion` along each axis; zeroed is
 * an empty scene. */
void soup_scene_add(soup_scene *to, soup_shape shape, size_t count, double motion, uint64_t *seed);
/* Builds the topology, owned by the caller, and the set. */
void soup_scene_finish(memory *heap, soup_scene *to);

#endif
