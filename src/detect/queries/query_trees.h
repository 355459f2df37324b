/* detect/queries/query_trees.h - trees over surfaces as they are at one moment, for questions about
 * places: rays, nearest points, boxes.
 *
 * Each surface has a tree of its own over its triangles, eight children a node. Its shape comes
 * from the rest shape once, in the order that refitted trees of the broad phase have. Its boxes are
 * exact, and hold the triangles at the positions that they were fitted to last. */
#ifndef TULLE_DETECT_QUERIES_QUERY_TREES_H
#define TULLE_DETECT_QUERIES_QUERY_TREES_H

#include "detect/trees/broad_phase.h"

enum { QUERY_LANES = 8 };

/* Boxes of the children side by side; those beyond child_count are empty and meet nothing. */
typedef struct query_node {
    double low[3][QUERY_LANES], high[3][QUERY_LANES]; /* [m] both included */
    uint32_t first, child_count; /* children are consecutive nodes of the tree, or leaves */
} query_node;

typedef struct query_tree {
    query_node *nodes;   /* level by level, the lowest first, the root last */
    uint32_t node_count; /* 0 for a surface without triangles */
    uint32_t low_count;  /* nodes whose children are leaves */
    uint32_t leaf_count; /* leaf l holds triangles count * l / leaf_count on, of `order` */
    uint32_t *order;     /* triangles of the surface, leaf after leaf */
    size_t count;        /* of them */
    bool is_fitted;
} query_tree;

typedef struct query_trees {
    query_tree *trees; /* of each surface */
    size_t surface_count, node_count;
    query_node *nodes; /* of all trees */
    uint32_t *order;   /* of all triangles */
} query_trees;

/* Makes trees without boxes. rest: positions from which they are shaped, unless `broad` has the
 * order already. False when memory is short; there are none then. */
bool query_trees_make(query_trees *trees, memory *heap, const surface_set *set,
                      const broad_phase *broad, const double *rest, size_t triangle_count);
/* Fine for zeroed trees. */
void query_trees_destroy(query_trees *trees, memory *heap, size_t triangle_count);
/* Fits the boxes of all present surfaces that are not fitted, or that move. */
void query_trees_fit(query_trees *trees, const surface_set *set, const double *positions,
                     int threads);

/* A question that is put to trees one after the other. */
typedef struct tree_query {
    /* For each child of a node a lower bound on what counts as distance of what is in it; INFINITY
     * where nothing can matter. */
    void (*measure)(const struct tree_query *query, const query_node *node,
                    double distances[QUERY_LANES]);
    /* Looks at a triangle; may lower the reach. */
    void (*visit)(struct tree_query *query, uint32_t triangle);
    double reach; /* what is farther is left out */
} tree_query;
/* Visits all triangles in leaves within reach, near ones first. */
void query_tree_visit(const query_tree *tree, tree_query *query);

#endif
