/* detect/trees/tree_kernels.h - the trees as their kernels see them, and those kernels
 * (kernels/...).
 *
 * The boxes of a leaf's features are fitted from those of vertices. Where most leaves need theirs,
 * all are fitted beforehand. Else those of a leaf are fitted when a pair of leaves needs them, and
 * each worker keeps them for the leaves that it met last.
 *
 * They lie together, one block a leaf: a header, then groups of six rows of sixteen lanes with the
 * low x, y, z, high x, y, z of its features. The first group has eight triangles and eight
 * vertices, the next ones have its edges, then come vertices beyond eight. Lanes without a feature
 * meet nothing.
 *
 * Where straight paths are followed and are long, a leaf has a drift: a motion d, along each axis
 * the one nearest to 0 between the least and the largest of its vertices. Boxes of features hold
 * the paths x(t) - t d, as seen from what drifts along. All paths being straight, they lie in the
 * hull of start and end - d. Of two leaves a and b, the first drifts against the second by t (d_a -
 * d_b). So features can only meet if the box of the first, widened by 0 .. d_a - d_b, meets that of
 * the second. This holds for any drifts. With these, no pair is left whose boxes around whole paths
 * are apart: d cuts a box around a whole path by |d| at one side, and the widening gives back no
 * more than both cuts together. Else boxes hold all of the paths, and the drift is 0. */
#ifndef TULLE_DETECT_TREES_TREE_KERNELS_H
#define TULLE_DETECT_TREES_TREE_KERNELS_H

#include "detect/impact/pair_batch.h"
#include "math/kernel_target.h"

enum {
    LEAF_TRIANGLES = 8,              /* most in a leaf: one vector */
    LEAF_SLOTS = 3 * LEAF_TRIANGLES, /* most edges, or vertices, of a leaf */
    LEAF_HEADER = 16,                /* floats: box as in vertex_box, drift: low, minus high */
    GROUP_LANES = 16,
    GROUP_FLOATS = 6 * GROUP_LANES,
    FACE_VERTICES = GROUP_LANES - LEAF_TRIANGLES, /* vertices in the group of the triangles */
    MOST_GROUPS = 4,
    LONGEST_BLOCK = LEAF_HEADER + MOST_GROUPS * GROUP_FLOATS,
    LEAF_NEIGHBOURS = 8,
    NODE_LANES = 8, /* most children of a node */
    LEAF_PAIR_ROOM =
        LEAF_SLOTS * LEAF_SLOTS + 16, /* feature pairs of two leaves, and spare lanes */
    KEPT_BLOCKS = 256,                /* of a worker: with the vertices around, what caches hold */
    EXPANDED_PAIRS = 8,               /* node pairs that are opened at a time */
    PAIR_ROOM = EXPANDED_PAIRS * NODE_LANES * NODE_LANES + NODE_LANES
};

/* Neighbour that stands for any leaf of the tree. */
#define LEAF_ANY UINT32_MAX

/* Ranges of slots. Leaves are numbered through all trees. */
typedef struct tree_leaf {
    uint32_t triangle_begin, triangle_end, vertex_begin, vertex_end, edge_begin, edge_end;
    uint32_t corner_begin, corner_end; /* of leaf_fit.leaf_corners */
    uint32_t group_begin;              /* its groups, among those of all leaves */
    uint32_t mask_begin;               /* its masks, in leaf_tables */
    uint16_t mask_stride, mask_groups; /* of a neighbour; for each edge */
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

/* How far a leaf reaches at both ends of the step: low x, y, z, -, and four diagonals; then the
 * same of minus the upper ends. */
typedef struct leaf_slabs {
    float low[2][8], high[2][8];
} leaf_slabs;

/* Boxes of a moving vertex at both ends: low x, y, z, -; -high x, y, z, -; so that a union is one
 * minimum. */
typedef struct vertex_box {
    float start[8], end[8];
} vertex_box;

/* Boxes of the paths of vertices, and their records. */
typedef struct vertex_fit {
    const uint32_t *vertices; /* of each record; null: the record's own number */
    const double *x0, *x1;
    double origin[8], scale[8], half[8]; /* for both ends; the fourth of each is 0 */
    vertex_record *records;              /* null: none */
    vertex_point *points;                /* null: none */
    vertex_box *boxes;
} vertex_fit;

/* Of some vertices, in box coordinates. */
typedef struct vertex_sums {
    double motion;  /* how far they move along each axis, in all */
    double largest; /* of all coordinates, at both ends */
} vertex_sums;

typedef struct leaf_fit {
    const tree_leaf *leaves;
    const uint32_t *triangle_corners, *vertex_corners, *edge_corners; /* records */
    const uint32_t *leaf_corners; /* of the triangles of each leaf, each once; or null */
    const vertex_box *vertex_boxes;
    float *blocks;    /* of all leaves; null: workers keep their own */
    bool is_straight; /* boxes are seen from the drift of their leaf */
} leaf_fit;

static inline uint32_t count_edge_groups(const tree_leaf *leaf) {
    return leaf->edge_end - leaf->edge_begin > GROUP_LANES ? 2 : 1;
}
static inline uint32_t count_groups(const tree_leaf *leaf) {
    return 1 + count_edge_groups(leaf) + (leaf->vertex_end - leaf->vertex_begin > FACE_VERTICES);
}
/* [floats] Where the block of a leaf begins, among those of all leaves. */
static inline size_t compute_block_begin(const tree_leaf *leaf, size_t leaf_number) {
    return LEAF_HEADER * leaf_number + GROUP_FLOATS * (size_t)leaf->group_begin;
}

/* Blocks of one worker. Each leaf has its place among place_count, and its block is there if
 * leaves[place] names it; one more place is for a leaf whose own is taken by the other of a pair.
 */
typedef struct leaf_cache {
    float *blocks;
    size_t stride;                /* [floats] of each of place_count + 1 places */
    uint32_t place_count;         /* a power of two, at most KEPT_BLOCKS */
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
    /* Which features of two leaves share no vertex, and are to be compared. A leaf has such masks
     * for itself, then for each of its neighbours. Each edge of the leaf has bits of the other's
     * edges, group by group. Each vertex of the leaf has bits of the other's triangles, and each
     * vertex of the other has bits of the leaf's triangles. Null until they are made. */
    const uint16_t *masks;
    bool has_neighbours; /* leaves know theirs */
    bool is_one_tree;    /* leaves of a pair may be equal, or share vertices */
} leaf_tables;

/* Records begin .. end - 1; false when a position is not finite. */
TULLE_DECLARE_KERNEL(bool, fit_vertices,
                     (const vertex_fit *fit, size_t begin, size_t end, vertex_sums *sums))
/* Blocks of leaves begin .. end - 1, among those of all. */
TULLE_DECLARE_KERNEL(void, fit_leaves, (const leaf_fit *fit, size_t begin, size_t end))
/* Boxes of nodes begin .. end - 1 whose children are leaves, and slabs of these, unless null. */
TULLE_DECLARE_KERNEL(void, fit_lowest_nodes,
                     (const leaf_fit *fit, tree_node *nodes, leaf_slabs *slabs, size_t begin,
                      size_t end))
/* The block of a leaf. */
TULLE_DECLARE_KERNEL(void, fit_block, (const leaf_fit *fit, const tree_leaf *leaf, float *block))
/* Appends to `to` all pairs of children of `count` <= EXPANDED_PAIRS pairs that meet and are not
 * within one patch. */
TULLE_DECLARE_KERNEL(void, open_node_pairs,
                     (const node_search *search, const uint32_t *first, const uint32_t *second,
                      size_t count, node_pairs *to))
/* Takes pairs of leaves off the list that their slabs keep apart at both ends. */
TULLE_DECLARE_KERNEL(void, drop_apart_leaves, (const leaf_slabs *slabs, node_pairs *pairs))
/* Feature pairs of leaf pairs begin .. ; ends early, when a batch may get too full for the next
 * pair. Returns how far it came. batches: by feature_kind. */
TULLE_DECLARE_KERNEL(size_t, pair_leaves,
                     (const leaf_tables *tables, leaf_cache *cache, const node_pairs *pairs,
                      size_t begin, pair_batch *batches))

#endif
