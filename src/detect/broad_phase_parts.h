/* detect/broad_phase_parts.h - the inside of the broad phase, shared by its files only.
 *
 * Each surface has a tree over its triangles. The triangles are listed in leaf order, at most
 * LEAF_TRIANGLES a leaf; each vertex and each edge belongs to the lowest of its triangles and so to
 * one leaf. Boxes are floats in a frame of the rest shape (about -1 .. 1), rounded outward, equal
 * for every method, since they are made from boxes of the vertices. */
#ifndef TULLE_DETECT_BROAD_PHASE_PARTS_H
#define TULLE_DETECT_BROAD_PHASE_PARTS_H

#include "detect/broad_phase.h"
#include "detect/pair_store.h"

enum {
    LEAF_TRIANGLES =
        8,            /* fewer make more leaf pairs to visit, which cost more than what they save */
    NODE_CHILDREN = 4 /* of one node of a refitted tree; the root may have 2 */
};

typedef struct tree_box {
    float low[4], high[4]; /* x, y, z and 0; one load each */
} tree_box;

/* Parts are joined under a node. Children are consecutive nodes and lie before their parent. */
typedef struct tree_node {
    tree_box box;
    uint32_t first;       /* child, or the leaf itself */
    uint32_t child_count; /* 0 for a leaf */
    uint32_t label;       /* patch that holds all triangles below; 0: none */
} tree_node;

/* Ranges of slots, see slot_list. */
typedef struct tree_leaf {
    uint32_t triangle_begin, triangle_end, vertex_begin, vertex_end, edge_begin, edge_end;
} tree_leaf;

/* Features of one kind in leaf order: slot -> feature, its corners and its box. */
typedef struct slot_list {
    uint32_t *features;
    uint32_t *corners; /* corner_count a slot: vertex indices */
    float *sides[6];   /* low x, y, z, high x, y, z; one of each a slot */
    uint32_t corner_count;
    size_t count;
} slot_list;

typedef struct surface_tree {
    ARRAY(tree_node) nodes; /* the root is the last; none for a surface without triangles */
    uint32_t leaf_begin, leaf_count;
    bool is_fitted; /* boxes are those of the last build_trees */
} surface_tree;

/* A range of vertices or leaves of one surface. */
typedef struct fit_task {
    uint32_t surface, begin, end;
    bool is_finite;
} fit_task;

/* Two nodes whose boxes meet, or one node against itself. */
typedef struct node_pair {
    uint32_t surface[2], node[2];
} node_pair;

/* What one worker finds: batches that are handed on when they are full. */
typedef struct worker_output {
    pair_batch batches[2]; /* by feature_kind */
    pair_consumer consume;
    void *context;
    const pair_tables *tables;
    int worker;
    uint64_t candidate_count, leaf_pair_count, box_pair_count;
} worker_output;

struct broad_phase {
    memory *heap;
    broad_phase_method method;
    size_t vertex_count, edge_count, triangle_count, surface_count;
    double origin[3], scale; /* box coordinate = (x - origin) * scale */
    double margin;           /* [m] of the fitted boxes; negative before the first */
    bool is_built;
    tree_box *vertex_boxes;
    vertex_record *records;
    pair_tables tables;
    patch_labels patches;
    surface_tree *trees;
    tree_leaf *leaves;
    slot_list triangles, vertices, edges;
    uint64_t *voxel_keys[2]; /* one a triangle; voxel trees only */
    fit_task *fit_tasks;
    size_t fit_task_capacity;
    ARRAY(node_pair) node_pairs[2];
    pair_store stores[2];         /* by feature_kind */
    ARRAY(worker_output) outputs; /* one a worker */
    ARRAY(pair_writer) writers;   /* two a worker, for the sorted list */
};

static inline bool boxes_meet(const tree_box *a, const tree_box *b) {
    return (a->low[0] <= b->high[0]) & (a->low[1] <= b->high[1]) & (a->low[2] <= b->high[2]) &
           (b->low[0] <= a->high[0]) & (b->low[1] <= a->high[1]) & (b->low[2] <= a->high[2]);
}

static inline void box_include(tree_box *box, const tree_box *other) {
    for (int k = 0; k < 4; k++) {
        if (other->low[k] < box->low[k]) box->low[k] = other->low[k];
        if (other->high[k] > box->high[k]) box->high[k] = other->high[k];
    }
}

/* refit_tree.c: order of the triangles and nodes of one surface, from rest positions. */
tulle_status shape_refit_tree(broad_phase *broad, const surface_set *set, uint32_t surface,
                              const double *rest);
/* voxel_tree.c: the same from the vertex boxes. */
tulle_status shape_voxel_tree(broad_phase *broad, const surface_set *set, uint32_t surface);

/* tree_boxes.c */
/* The frame of the boxes; false when a rest position is not finite. */
bool choose_box_frame(broad_phase *broad, const double *rest);
/* Fills the slots of a surface from the order of its triangles and the leaves' triangle ranges. */
void assign_slots(broad_phase *broad, const surface_set *set, uint32_t surface);
/* Boxes of the vertices of surfaces that are present and not fitted; false when a position is not
 * finite. */
bool fit_vertex_boxes(broad_phase *broad, const surface_set *set, const double *x0,
                      const double *x1, int threads);
/* Labels of the nodes of fixed trees, from those of the triangles. */
void label_trees(broad_phase *broad, const surface_set *set);
/* Boxes of their slots, leaves and nodes. */
void fit_trees(broad_phase *broad, const surface_set *set, int threads);
/* Union of the vertex boxes of a triangle. */
tree_box find_triangle_box(const broad_phase *broad, const topology *topo, uint32_t triangle);

/* leaf_pairs.c */
typedef struct leaf_search {
    const broad_phase *broad;
    worker_output *output;
    bool counts_box_pairs;
} leaf_search;
/* Writes all pairs of features of one leaf, or of two different ones, whose boxes meet; `box` is
 * that of the whole leaf. */
void search_leaf(const leaf_search *search, const tree_leaf *leaf, const tree_box *box);
/* Hands on what is left in the batches. */
void finish_batches(worker_output *output);
void search_leaf_pair(const leaf_search *search, const tree_leaf *a, const tree_box *box_a,
                      const tree_leaf *b, const tree_box *box_b);

#endif
