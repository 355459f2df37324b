/* detect/trees/broad_phase_parts.h - the inside of the broad phase, shared by its files only.
 *
 * Each surface has a tree over its triangles. The triangles are listed in leaf order, at most
 * LEAF_TRIANGLES a leaf. Each vertex and each edge belongs to one leaf, which has a triangle around
 * it. All leaves of a tree are equally deep. Boxes are floats in a frame of the rest shape (about
 * -1 .. 1), rounded outward. Every method makes them from the same boxes of vertices, so they are
 * equal for all methods. */
#ifndef TULLE_DETECT_TREES_BROAD_PHASE_PARTS_H
#define TULLE_DETECT_TREES_BROAD_PHASE_PARTS_H

#include "detect/pairs/pair_store.h"
#include "detect/trees/broad_phase.h"
#include "detect/trees/tree_kernels.h"

enum { MOST_LEVELS = 48 }; /* a voxel tree of 2^31 triangles has fewer */

/* Features of one kind in leaf order: slot -> feature and the records of its corners. The arrays
 * end with room for SLOT_SPARE more slots, which may be read. */
typedef struct slot_list {
    uint32_t *features;
    uint32_t *corners; /* corner_count a slot */
    uint32_t corner_count;
    size_t count;
} slot_list;
enum { SLOT_SPARE = 16 };

/* Nodes level by level: those above the leaves first, the root last. */
typedef struct surface_tree {
    ARRAY(tree_node) nodes; /* none for a surface without triangles */
    uint32_t level_begin[MOST_LEVELS];
    uint32_t level_count;            /* of nodes */
    uint32_t leaf_begin, leaf_count; /* in the leaves of the broad phase */
    uint32_t near_pair_count;        /* leaves, and pairs of neighbours among them */
    bool is_fitted;                  /* boxes are those of the last build_trees */
    bool has_blocks;                 /* so are the blocks of its leaves */
    double largest;                  /* of its vertex_sums */
} surface_tree;

/* Voxels of a voxel tree; coordinates are those of boxes, doubled. */
typedef struct voxel_grid {
    double low[3], high[3]; /* of the centres of what is counted in */
    double size_sum;        /* of the longest sides of their boxes */
    double inv_edge;
    uint32_t count;
    unsigned bits; /* of one coordinate */
} voxel_grid;

typedef struct tree_box {
    float low[3], high[3];
} tree_box;

/* The triangles of one patch, or the isolated ones, of the surface whose trees are being built. */
typedef struct voxel_group {
    voxel_grid grid;
    tree_box centres; /* around the centres of the triangles' boxes */
    uint32_t begin;   /* in the sorted list of triangles */
    uint32_t voxel;   /* of the group among the groups */
} voxel_group;

/* [m] Sums over some vertices: of how far they move along the axes, and of how much that differs
 * from what a vertex nearby does. */
typedef struct way_sums {
    double own, relative;
} way_sums;

/* A range of vertices, or of lowest nodes, of one surface. */
typedef struct fit_task {
    uint32_t surface, begin, end;
    bool is_finite;
    vertex_sums sums;
    way_sums ways; /* where paths are followed if they are long */
} fit_task;

/* Two nodes whose boxes meet, or one node against itself. */
typedef struct search_task {
    uint32_t surface[2], node[2], level[2];
} search_task;

/* Node of the tree over the roots of all trees; the nodes below it come next. */
typedef struct root_node {
    float box[6];
    uint32_t surface;      /* whose root it is, or TULLE_NONE */
    uint32_t last_surface; /* the highest below it */
    uint32_t end;          /* the first node after those below it */
} root_node;

/* What one worker finds. */
typedef struct worker_output {
    pair_batch batches[2]; /* by feature_kind */
    search_counts counts;
    leaf_cache cache;
} worker_output;

struct broad_phase {
    memory *heap;
    broad_phase_method method;
    size_t vertex_count, edge_count, triangle_count, surface_count;
    double origin[3], scale; /* box coordinate = (x - origin) * scale */
    double mean_edge;        /* of the rest shape, along the axes, in box coordinates */
    double margin;           /* [m] of the fitted boxes; negative before the first */
    bool is_straight;        /* blocks are seen from drifts, see tree_kernels.h */
    bool is_built;
    patch_labels patches;
    stop_poll *stop;           /* may be null */
    bool has_labels;           /* nodes bear labels of patches */
    bool is_labelled;          /* no node needs a new label */
    patch_labels node_patches; /* from which nodes have their labels */
    uint32_t *record_vertices; /* vertex of each record; null: records are in vertex order */
    vertex_record *records;    /* null where they are not kept */
    vertex_point *points;      /* of each record, where these are kept */
    vertex_box *vertex_boxes;  /* of each record */
    arena *scratch;            /* where these are, made by each build_trees; null: on the heap */
    surface_tree *trees;
    path_following following;
    leaf_slabs *slabs; /* of each leaf; null unless paths are followed, and as long as blocks are */
    tree_leaf *leaves;
    size_t leaf_capacity;
    ARRAY(uint32_t) leaf_corners; /* of refitted trees: records around each leaf, each once */
    float *blocks; /* of all leaves, see tree_kernels.h; null where patches leave out most */
    size_t block_capacity;
    uint32_t group_count;  /* of all leaves of refitted trees */
    ARRAY(uint16_t) masks; /* of refitted trees from the second build on, see leaf_tables */
    bool was_built;        /* at least once */
    bool has_masks;
    bool has_all_blocks; /* since the last build_trees */
    leaf_fit fit;        /* what boxes of leaves are fitted from, since then too */
    slot_list triangles, vertices, edges;
    pair_tables tables;
    uint64_t *voxel_keys[2];         /* one a triangle; voxel trees only */
    ARRAY(voxel_group) voxel_groups; /* of the surface built last; voxel trees only */
    fit_task *fit_tasks;
    size_t fit_task_capacity;
    ARRAY(root_node) root_nodes; /* of the search that runs, or ran last */
    ARRAY(uint32_t) roots;       /* surfaces */
    ARRAY(search_task) search_tasks[2];
    pair_store stores[2];         /* by feature_kind */
    ARRAY(worker_output) outputs; /* one a worker */
    ARRAY(float) kept_blocks;     /* of their caches */
    size_t block_stride;          /* [floats] of their places; 0: not yet known */
    ARRAY(node_pairs) lists;      /* list_count a worker: pairs of each level still to be opened */
    size_t list_count;
    ARRAY(pair_writer) writers; /* of find_pairs: two a worker */
    uint64_t most_candidates;   /* of find_pairs; 0: any number */
    size_t most_blocks;         /* a store that claims more holds more candidates than that */
    atomic_bool is_crowded;     /* one has; what is left of the search is passed over */
};

static inline bool boxes_meet(const float a[6], const float b[6]) {
    return a[0] <= b[3] && a[1] <= b[4] && a[2] <= b[5] && b[0] <= a[3] && b[1] <= a[4] &&
           b[2] <= a[5];
}

/* tree_shape.c: order of the triangles, leaves, slots and nodes of one surface, from rest
 * positions. */
tulle_status shape_refit_tree(broad_phase *broad, const surface_set *set, uint32_t surface,
                              const double *rest);
/* voxel_tree.c: the same from the vertex boxes and, by BROAD_PHASE_PAPER, the labels of patches. */
tulle_status shape_voxel_tree(broad_phase *broad, const surface_set *set, uint32_t surface);

/* tree_slots.c */
/* Puts a feature with the records of its corners into a slot. */
void assign_slot(slot_list *list, uint32_t slot, uint32_t feature, const uint32_t *corners);
/* Fills the slots of a surface from the order of its triangles and the leaves' triangle ranges.
 * Leaves get about equally many vertices and edges. They also get to know their neighbours, and
 * records are numbered in leaf order. */
tulle_status assign_even_slots(broad_phase *broad, const surface_set *set, uint32_t surface);

/* leaf_masks.c: which features of a leaf and itself, and its neighbours, share no vertex, for all
 * refitted trees; false when memory is short. */
bool make_leaf_masks(broad_phase *broad);

/* root_pairs.c: fills search_tasks[0] with a task for each pair of surfaces that may meet and whose
 * roots do, ascending; false when memory is short. */
bool list_root_pairs(broad_phase *broad, const surface_set *set);

/* refit_boxes.c */
/* The frame of the boxes, from the vertices of triangles; false when a rest position is not finite.
 */
bool choose_box_frame(broad_phase *broad, const topology *topo, const double *rest);
/* Boxes and records of the vertices of surfaces that are present and not fitted; false when a
 * position is not finite. */
bool fit_vertex_boxes(broad_phase *broad, const surface_set *set, const double *x0,
                      const double *x1, int threads);
/* Boxes and labels of nodes, and blocks of all leaves, unless patches leave out most of them; false
 * when memory is short. */
bool fit_trees(broad_phase *broad, const surface_set *set, int threads);

#endif
