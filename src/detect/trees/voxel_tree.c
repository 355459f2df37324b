/* detect/trees/voxel_tree.c - backward-voxel trees of one surface, built anew each step: take the
 * boxes of its vertices, and labels of its patches or none; give an order of its triangles, leaves
 * and nodes.
 *
 * Triangles form groups: those of each patch, and the isolated ones; without labels all are one
 * group. The box of the centres of a group is cut into cubic voxels somewhat larger than its
 * triangles. Each triangle goes to one voxel; voxels that are not empty are the leaves. Eight
 * voxels make one of the next level, and so on up to the root of the group. The roots of groups are
 * joined the same way by voxels of their boxes. Voxels are numbered along the Morton curve, so that
 * a level is a run through a list sorted by group and voxel: linear time, for all groups at once.
 * A group that is done early gets nodes with one child on the levels that others still need.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3 (BVOX-AABB). Departures: a voxel with more than LEAF_TRIANGLES triangles is cut
 * into several leaves, and levels on which nothing merges are left out. */
#include "detect/trees/broad_phase_parts.h"

#include <math.h>
#include <string.h>

enum {
    VOXEL_BITS = 10, /* of one coordinate at most; a code then has 30 */
    VOXEL_DIGIT = 10 /* bits that one pass of sorting takes */
};

/* Edge of a voxel in mean lengths of a triangle's box; a sheet then has four to eight triangles a
 * voxel. */
static const double VOXEL_EDGE = 1.5;

/* Records are in the order of vertices. */
static tree_box make_triangle_box(const broad_phase *broad, const topology *topo,
                                  uint32_t triangle) {
    const uint32_t *const corners = topo->triangles + 3 * (size_t)triangle;
    tree_box box;
    for (int k = 0; k < 3; k++) {
        box.low[k] = box.high[k] = (float)INFINITY;
        for (int c = 0; c < 3; c++) {
            const vertex_box *const around = &broad->vertex_boxes[corners[c]];
            box.low[k] = fminf(box.low[k], fminf(around->start[k], around->end[k]));
            box.high[k] = fminf(box.high[k], fminf(around->start[4 + k], around->end[4 + k]));
        }
        box.high[k] = -box.high[k];
    }
    return box;
}

/* Counts a box in. */
static void grid_include(voxel_grid *grid, const tree_box *box) {
    double size = 0.0;
    for (int k = 0; k < 3; k++) {
        double const centre = (double)box->low[k] + (double)box->high[k]; /* doubled */
        if (grid->count == 0 || centre < grid->low[k]) grid->low[k] = centre;
        if (grid->count == 0 || centre > grid->high[k]) grid->high[k] = centre;
        size = fmax(size, (double)box->high[k] - (double)box->low[k]);
    }
    grid->size_sum += size;
    grid->count++;
}

/* Once all boxes are counted in. */
static void grid_cut(voxel_grid *grid) {
    double extent = 0.0;
    for (int k = 0; k < 3; k++) extent = fmax(extent, grid->high[k] - grid->low[k]);
    double const edge = 2.0 * VOXEL_EDGE * grid->size_sum / (double)grid->count;
    grid->bits = 0;
    while (grid->bits < VOXEL_BITS && ldexp(edge, (int)grid->bits) < extent) grid->bits++;
    grid->inv_edge = extent > 0.0 ? ldexp(1.0, (int)grid->bits) / extent : 0.0;
}

/* The voxel of a box: the bits of its three coordinates in turn. */
static uint32_t choose_voxel(const voxel_grid *grid, const tree_box *box) {
    uint32_t const last = (1U << grid->bits) - 1;
    uint32_t code = 0;
    for (int k = 0; k < 3; k++) {
        double const centre = (double)box->low[k] + (double)box->high[k];
        double const cell = (centre - grid->low[k]) * grid->inv_edge;
        uint32_t bits = cell < (double)last ? (uint32_t)cell : last;
        bits = (bits | bits << 16) & 0x030000ffU; /* bit b moves to bit 3 b */
        bits = (bits | bits << 8) & 0x0300f00fU;
        bits = (bits | bits << 4) & 0x030c30c3U;
        bits = (bits | bits << 2) & 0x09249249U;
        code |= bits << k;
    }
    return code;
}

/* Sorts keys stably by the voxel in their upper half; `keys` and `spare` change places. */
static void sort_by_voxel(uint64_t **keys, uint64_t **spare, size_t count, unsigned bits) {
    for (unsigned done = 0; done < 3 * bits; done += VOXEL_DIGIT) {
        uint32_t begin[(1 << VOXEL_DIGIT) + 1] = {0};
        for (size_t i = 0; i < count; i++)
            begin[((*keys)[i] >> (32 + done) & ((1 << VOXEL_DIGIT) - 1)) + 1]++;
        for (size_t d = 0; d < 1 << VOXEL_DIGIT; d++) begin[d + 1] += begin[d];
        for (size_t i = 0; i < count; i++)
            (*spare)[begin[(*keys)[i] >> (32 + done) & ((1 << VOXEL_DIGIT) - 1)]++] = (*keys)[i];
        uint64_t *const swapped = *keys;
        *keys = *spare;
        *spare = swapped;
    }
}

/* ---- groups ---- */

/* What all steps of building one surface's trees share. */
typedef struct voxel_build {
    broad_phase *broad;
    const surface_set *set;
    surface_tree *tree;
    const surface_range *range;
    uint32_t triangle_count;
    const uint32_t *labels; /* by triangle; null: one group */
    uint32_t label_min;     /* of the patches; group 0 is that of the isolated triangles */
    uint64_t *keys, *spare; /* voxel and triangle; spare also takes the voxels of a level */
} voxel_build;

static uint32_t get_group(const voxel_build *build, uint32_t triangle) {
    if (!build->labels || build->labels[triangle] == 0) return 0;
    return build->labels[triangle] - build->label_min + 1;
}

/* Sorts the triangles by the voxel of their group, by group, and by their own voxel. */
static void sort_triangles(voxel_build *build) {
    voxel_group *const groups = build->broad->voxel_groups.data;
    size_t const group_count = build->broad->voxel_groups.count;
    const topology *const topo = build->set->topo;
    uint32_t const first = build->range->triangle_begin, count = build->triangle_count;

    /* Voxels within each group, and voxels for the groups. */
    voxel_grid grid = {.count = 0};
    unsigned bits = 0;
    for (uint32_t i = 0; i < count; i++) {
        tree_box const box = make_triangle_box(build->broad, topo, first + i);
        grid_include(&groups[get_group(build, first + i)].grid, &box);
    }
    for (uint32_t g = 0; g < group_count; g++) {
        voxel_group *const group = &groups[g];
        if (group->grid.count == 0) continue;
        grid_cut(&group->grid);
        if (group->grid.bits > bits) bits = group->grid.bits;
        for (int k = 0; k < 3; k++) {
            group->centres.low[k] = (float)(0.5 * group->grid.low[k]);
            group->centres.high[k] = (float)(0.5 * group->grid.high[k]);
        }
        grid_include(&grid, &group->centres);
    }
    grid_cut(&grid);

    /* The groups by voxel: where the triangles of each begin. */
    uint32_t used = 0, begin = 0;
    for (uint32_t g = 0; g < group_count; g++) {
        if (groups[g].grid.count == 0) continue;
        groups[g].voxel = choose_voxel(&grid, &groups[g].centres);
        build->keys[used++] = (uint64_t)groups[g].voxel << 32 | g;
    }
    sort_by_voxel(&build->keys, &build->spare, used, grid.bits);
    for (uint32_t i = 0; i < used; i++) {
        voxel_group *const group = &groups[(uint32_t)build->keys[i]];
        group->begin = begin;
        begin += group->grid.count;
    }

    /* The triangles by voxel, then to their groups. */
    for (uint32_t i = 0; i < count; i++) {
        tree_box const box = make_triangle_box(build->broad, topo, first + i);
        uint32_t const voxel = choose_voxel(&groups[get_group(build, first + i)].grid, &box);
        build->keys[i] = (uint64_t)voxel << 32 | (first + i);
    }
    sort_by_voxel(&build->keys, &build->spare, count, bits);
    if (group_count == 1) return;
    for (uint32_t i = 0; i < count; i++)
        build->spare[groups[get_group(build, (uint32_t)build->keys[i])].begin++] = build->keys[i];
    uint64_t *const sorted = build->spare;
    build->spare = build->keys;
    build->keys = sorted;
}

/* ---- leaves and nodes ---- */

/* Leaves are runs of one voxel of one group, at most LEAF_TRIANGLES long; their codes go to
 * `spare`. A triangle brings to its leaf the vertices and edges of which it is the lowest triangle.
 */
static void build_leaves(voxel_build *build) {
    broad_phase *const broad = build->broad;
    surface_tree *const tree = build->tree;
    const topology *const topo = build->set->topo;
    const adjacency *const around = &topo->vertex_triangles;
    tree_leaf *leaf = NULL;
    uint32_t vertex_slot = build->range->vertex_begin, edge_slot = build->range->edge_begin;
    for (uint32_t i = 0; i < build->triangle_count; i++) {
        uint32_t const slot = build->range->triangle_begin + i, triangle = (uint32_t)build->keys[i];
        uint64_t const code = (uint64_t)get_group(build, triangle) << 32 | build->keys[i] >> 32;
        bool const continues = leaf && slot - leaf->triangle_begin < LEAF_TRIANGLES &&
                               build->spare[tree->leaf_count - 1] == code;
        if (!continues) {
            leaf = &broad->leaves[tree->leaf_begin + tree->leaf_count];
            *leaf = (tree_leaf){.triangle_begin = slot,
                                .vertex_begin = vertex_slot,
                                .edge_begin = edge_slot,
                                .neighbours = {LEAF_ANY}};
            build->spare[tree->leaf_count++] = code;
        }
        const uint32_t *const corners = topo->triangles + 3 * (size_t)triangle;
        assign_slot(&broad->triangles, slot, triangle, corners);
        for (int k = 0; k < 3; k++) {
            uint32_t const vertex = corners[k];
            uint32_t const edge = topo->triangle_edges[3 * (size_t)triangle + (size_t)k];
            if (around->items[around->begin[vertex]] == triangle)
                assign_slot(&broad->vertices, vertex_slot++, vertex, &vertex);
            if (topo->edge_triangles[2 * (size_t)edge] == triangle)
                assign_slot(&broad->edges, edge_slot++, edge, topo->edges + 2 * (size_t)edge);
        }
        leaf->triangle_end = slot + 1;
        leaf->vertex_end = vertex_slot;
        leaf->edge_end = edge_slot;
    }
}

/* End of the run of nodes from `begin` that share the voxel of a level, NODE_LANES at most. */
static size_t find_run_end(const uint64_t *codes, size_t begin, size_t count, unsigned shift) {
    size_t end = begin + 1;
    while (end < count && end - begin < NODE_LANES && codes[end] >> shift == codes[begin] >> shift)
        end++;
    return end;
}

/* Levels up to the root: first those of the groups, then those that join them. A level repeats
 * while runs were cut at NODE_LANES; levels on which nothing merges are left out. */
static bool build_levels(voxel_build *build) {
    memory *const heap = build->broad->heap;
    surface_tree *const tree = build->tree;
    uint64_t *const codes = build->spare;
    uint32_t first = tree->leaf_begin;
    size_t count = tree->leaf_count;
    unsigned shift = 0;
    while (count > 1 || tree->level_count == 0) {
        size_t run_count = 0;
        for (size_t begin = 0; begin < count; begin = find_run_end(codes, begin, count, shift))
            run_count++;
        bool const merges = run_count < count || count == 1;
        if (!merges && shift < 3 * VOXEL_BITS) {
            shift += 3;
        } else if (!merges) { /* one node a group */
            for (size_t i = 0; i < count; i++)
                codes[i] = build->broad->voxel_groups.data[codes[i] >> 32].voxel;
            shift = 0;
        } else {
            /* a node for each run; its code is that of its first child */
            uint32_t const level_begin = (uint32_t)tree->nodes.count;
            if (!ARRAY_RESERVE(heap, &tree->nodes, run_count)) return false;
            tree->level_begin[tree->level_count++] = level_begin;
            for (size_t begin = 0, end; begin < count; begin = end) {
                end = find_run_end(codes, begin, count, shift);
                codes[tree->nodes.count - level_begin] = codes[begin];
                tree->nodes.data[tree->nodes.count++] = (tree_node){
                    .first = first + (uint32_t)begin, .child_count = (uint32_t)(end - begin)};
            }
            first = level_begin;
            count = run_count;
        }
    }
    tree->level_begin[tree->level_count] = (uint32_t)tree->nodes.count;
    return true;
}

tulle_status shape_voxel_tree(broad_phase *broad, const surface_set *set, uint32_t surface) {
    const surface_range *const range = &set->surfaces[surface];
    surface_tree *const tree = &broad->trees[surface];
    voxel_build build = {.broad = broad,
                         .set = set,
                         .tree = tree,
                         .range = range,
                         .triangle_count = range->triangle_end - range->triangle_begin,
                         .labels =
                             broad->method == BROAD_PHASE_PAPER ? broad->patches.labels : NULL,
                         .keys = broad->voxel_keys[0],
                         .spare = broad->voxel_keys[1]};
    tree->leaf_count = tree->level_count = 0;
    tree->nodes.count = 0;
    if (build.triangle_count == 0) return TULLE_OK;
    /* nodes that hardly any shape passes, so that the array rarely grows */
    size_t const usual_count = build.triangle_count / 4 + 64;
    if (!ARRAY_RESERVE(broad->heap, &tree->nodes, usual_count)) return TULLE_ERROR_OUT_OF_MEMORY;

    /* Empty groups, as many as the labels need. */
    uint32_t label_max = 0;
    build.label_min = UINT32_MAX;
    for (uint32_t t = range->triangle_begin; build.labels && t < range->triangle_end; t++) {
        uint32_t const label = build.labels[t];
        if (label > label_max) label_max = label;
        if (label != 0 && label < build.label_min) build.label_min = label;
    }
    size_t const count = label_max == 0 ? 1 : (size_t)(label_max - build.label_min) + 2;
    broad->voxel_groups.count = 0;
    if (!ARRAY_RESERVE(broad->heap, &broad->voxel_groups, count)) return TULLE_ERROR_OUT_OF_MEMORY;
    memset(broad->voxel_groups.data, 0, count * sizeof *broad->voxel_groups.data);
    broad->voxel_groups.count = count;
    sort_triangles(&build);
    build_leaves(&build);
    if (!build_levels(&build)) {
        tree->level_count = 0;
        tree->nodes.count = 0;
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    return TULLE_OK;
}
