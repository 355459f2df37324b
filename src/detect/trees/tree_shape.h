/* detect/trees/tree_shape.h - how refitted trees order the triangles of a surface, for all trees
 * that keep their shape. */
#ifndef TULLE_DETECT_TREES_TREE_SHAPE_H
#define TULLE_DETECT_TREES_TREE_SHAPE_H

#include "detect/surface_set.h"
#include "detect/trees/tree_kernels.h"

/* Leaves of a tree over `count` triangles: the fewest of the form 5 .. 8 times a power of two (or
 * 1 .. 8), so that leaves and lowest nodes are nearly full. */
static inline uint32_t choose_leaf_count(size_t count) {
    uint32_t const needed = (uint32_t)((count + LEAF_TRIANGLES - 1) / LEAF_TRIANGLES);
    unsigned levels = 0;
    while (needed > (uint32_t)NODE_LANES << levels) levels++;
    return (needed + (1U << levels) - 1) >> levels << levels;
}

/* tree_shape.c: fills `order` with the triangles of a surface, leaf after leaf: leaf l has those
 * from count * l / leaf_count on. corners: of all triangles. False when memory is short. */
bool order_triangles(memory *heap, uint32_t *order, const surface_range *range, size_t leaf_count,
                     const uint32_t *corners, const double *rest);

#endif
