/* math/dissection.h - nested dissection: an order of elimination for a sparse symmetric matrix over
 * the vertices of a mesh, and the tree of its separators. */
#ifndef TULLE_MATH_DISSECTION_H
#define TULLE_MATH_DISSECTION_H

#include "base/memory.h"
#include "math/block_matrix.h"

/* Nodes come children first; those below a node are the ones just before it. A node owns the
 * vertices order[begin .. end), end being the next node's begin. No entry of the pattern joins two
 * nodes unless one is above the other. */
typedef struct dissection_node {
    uint32_t begin, end;
    uint32_t parent; /* TULLE_NONE: a root */
    uint32_t depth;  /* nodes above it */
} dissection_node;

typedef struct dissection {
    uint32_t *order; /* vertex_count */
    size_t vertex_count;
    ARRAY(dissection_node) nodes;
} dissection;

/* The pattern is symmetric, with or without diagonal entries; positions (3 * vertex_count, null:
 * all zero) only make separators small. False: no memory. */
bool dissection_build(memory *heap, size_t vertex_count, block_pattern pattern,
                      const double *positions, dissection *result);
void dissection_destroy(memory *heap, dissection *result);

#endif
