/* detect/tree_kernels.h - the trees as their kernels see them, and those kernels (kernels/...).
 *
 * The boxes of a leaf's features are fitted from those of vertices: of all leaves beforehand, or,
 * where most are not needed, when a pair of leaves needs them; then each worker keeps them for the
 * leaves it met last. They lie together, one block a leaf: its own box (LEAF_HEADER floats of which
 * 6 are used), then six rows with the low x, y, z, high x, y, z of its triangles and then its
 * vertices, then six rows of its edges. Rows are as long as the leaf needs; what is loaded beyond
 * them is masked. */
#ifndef TULLE_DETECT_TREE_KERNELS_H
#define TULLE_DETECT_TREE_KERNELS_H

#include "detect/pair_batch.h"
#include "math/kernel_target.h"

enum {
    LEAF_TRIANGLES = 8,              /* most in a leaf: one vector */
    LEAF_SLOTS = 3 * LEAF_TRIANGLES, /* most edges, or vertices, of a leaf */
    LEAF_HEADER = 8,                 /* floats */
    LEAF_NEIGHBOURS = 8,
    NODE_LANES = 8, /* most children of a node */
    LEAF_PAIR_ROOM =
        LEAF_SLOTS * LEAF_SLOTS + 16, /* feature pairs of two leaves, and spare lanes */
    BLOCK_SPARE = 16,                 /* floats that may be read and written beyond a block */
    KEPT_BLOCKS = 256,                /* of a worker: with the vertices around, what caches hold */
    EXPANDED_PAIRS = 16,              /* node pairs that are opened at a time */
    PAIR_ROOM = EXPANDED_PAIRS * NODE_LANES * NODE_LANES + NODE_LANES
};

/* Neighbour that stands for any leaf of the tree. */
#define LEAF_ANY UINT32_MAX

/* Ranges of slots. Leaves are numbered through all trees. */
typedef struct tree_leaf {
    uint32_t triangle_begin, triangle_end, vertex_begin, vertex_end, edge_begin, edge_end;
    uint64_t block; /* [floats] where its boxes begin, among those of all leaves */
    /* Leaves of higher number with which it shares a vertex, then zeros; or LEAF_ANY first. */
    uint32_t neighbours[LEAF_NEIGHBOURS];
} tree_leaf;

/* Boxes of the children side by side; those beyond child_count hold nothing and meet nothing. */
typedef struct tree_node {
    float sides[6][NODE_LANES];  /* low x, y, z, high x, y, z */
    float box[6];                /* around all children */
    uint32_t first, child_count; /* children are consecutive nodes, or leaves */
    uint32_t labels[NODE_LANES]; /* of a patch to which all triangles of a child belong, or 0 */
} tree_node;

/* Box of a moving vertex: low x, y, z, -; -high x, y, z, -; so that a union is one minimum. */
typedef struct vertex_box {
    float sides[8];
} vertex_box;

/* Boxes of the paths of vertices, and their records. */
typedef struct vertex_fit {
    const uint32_t *vertices; /* of each record; null: the record's own number */
    const double *x0, *x1;
    double origin[4], scale[4], half[4]; /* the fourth of each is 0 */
    vertex_record *records;
    vertex_box *boxes;
} vertex_fit;

typedef struct leaf_fit {
    const tree_leaf *leaves;
    const uint32_t *triangle_corners, *vertex_corners, *edge_corners; /* records */
    const vertex_box *vertex_boxes;
    float *blocks; /* of all leaves; null: workers keep their own */
} leaf_fit;

/* Blocks of one worker. Each leaf has its place among KEPT_BLOCKS, and its block is there if
 * leaves[place] names it; one more place is for a leaf whose own is taken by the other of a pair.
 */
typedef struct leaf_cache {
    float *blocks;
    size_t stride;                /* [floats] of each of KEPT_BLOCKS + 1 places */
    uint32_t leaves[KEPT_BLOCKS]; /* UINT32_MAX: none */
} leaf_cache;

/* Pairs of nodes of two trees at equal height; equal nodes of one tree: the node with itself. */
typedef struct node_pairs {
    uint32_t first[PAIR_ROOM], second[PAIR_ROOM];
    size_t count;
} node_pairs;

typedef struct node_search {
    const tree_node *trees[2]; /* nodes of both trees, the same for one tree with itself */
    uint32_t label_mask;       /* all bits, or 0: labels do not count */
} node_search;

typedef struct leaf_tables {
    leaf_fit fit;
    bool is_one_tree; /* leaves of a pair may be equal, or share vertices */
} leaf_tables;

/* Records begin .. end - 1; false when a position is not finite. */
TULLE_DECLARE_KERNEL(bool, fit_vertices, (const vertex_fit *fit, size_t begin, size_t end))
/* Blocks of leaves begin .. end - 1, among those of all. */
TULLE_DECLARE_KERNEL(void, fit_leaves, (const leaf_fit *fit, size_t begin, size_t end))
/* Boxes of nodes begin .. end - 1 whose children are leaves. */
TULLE_DECLARE_KERNEL(void, fit_lowest_nodes,
                     (const leaf_fit *fit, tree_node *nodes, size_t begin, size_t end))
/* The block of a leaf; writes up to BLOCK_SPARE floats beyond it. */
TULLE_DECLARE_KERNEL(void, fit_block, (const leaf_fit *fit, const tree_leaf *leaf, float *block))
/* Appends to `to` all pairs of children of `count` <= EXPANDED_PAIRS pairs that meet and are not
 * within one patch. */
TULLE_DECLARE_KERNEL(void, open_node_pairs,
                     (const node_search *search, const uint32_t *first, const uint32_t *second,
                      size_t count, node_pairs *to))
/* Feature pairs of leaf pairs begin .. ; ends early, when a batch may get too full for the next
 * pair. Returns how far it came. batches: by feature_kind. */
TULLE_DECLARE_KERNEL(size_t, pair_leaves,
                     (const leaf_tables *tables, leaf_cache *cache, const node_pairs *pairs,
                      size_t begin, pair_batch *batches))

#endif
