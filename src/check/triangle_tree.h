/* check/triangle_tree.h - a binary tree of boxes over triangles, the broad phase of the judge.
 *
 * Inputs: the exact boxes of the triangles. Output: nodes in depth-first order, the left child
 * right behind its parent. Built in O(n log n) whatever the input: the triangles are sorted along
 * each axis once, and every node is split at the median along the axis in which its box centres
 * spread widest, so that neither outliers nor equal centres unbalance it.
 */
#ifndef TULLE_CHECK_TRIANGLE_TREE_H
#define TULLE_CHECK_TRIANGLE_TREE_H

#include "base/memory.h"

typedef struct check_box {
    double low[3], high[3]; /* [m] both included */
} check_box;

typedef struct tree_node {
    check_box box;
    uint32_t right;        /* index of the right child; of a leaf: first item */
    uint32_t leaf_count;   /* items of a leaf; 0 for an inner node */
    uint32_t highest_item; /* greatest triangle number below the node */
} tree_node;

enum {
    TREE_LEAF_SIZE = 4,
    TREE_DEPTH_LIMIT = 40 /* medians halve at most 2^31 triangles */
};

typedef struct triangle_tree {
    tree_node *nodes; /* node_count; [0] is the root; null without triangles */
    size_t node_count;
    uint32_t *items; /* item_count triangle numbers, leaf after leaf */
    size_t item_count;
} triangle_tree;

/* A tree over the triangles 0 .. count-1 whose kinds[] equals `kind`.
 * False when memory is short; the tree is then empty. */
bool triangle_tree_build(memory *heap, const check_box *boxes, const uint8_t *kinds, uint8_t kind,
                         size_t count, triangle_tree *tree);
void triangle_tree_destroy(memory *heap, triangle_tree *tree);

static inline bool check_boxes_meet(const check_box *a, const check_box *b) {
    return a->low[0] <= b->high[0] && b->low[0] <= a->high[0] && a->low[1] <= b->high[1] &&
           b->low[1] <= a->high[1] && a->low[2] <= b->high[2] && b->low[2] <= a->high[2];
}

#endif
