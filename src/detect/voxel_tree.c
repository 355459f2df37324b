/* detect/voxel_tree.c - the backward-voxel tree of one surface, built anew each step: takes the
 * boxes of its vertices, gives an order of its triangles, leaves and nodes.
 *
 * The box of all triangle centres is cut into cubic voxels somewhat larger than a triangle; each
 * triangle goes to one voxel; those that are not empty are the leaves. Eight voxels make one of the
 * next level, and so on up to one root. Voxels are numbered along the Morton curve, so that a level
 * is a run through a sorted list: linear time.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3 (BVOX-AABB). Departures: a voxel with more than LEAF_TRIANGLES triangles is cut
 * into several leaves, and levels on which nothing merges are left out. */
#include "detect/broad_phase_parts.h"

#include <math.h>

enum {
    VOXEL_BITS = 10,   /* of one coordinate at most; a code then has 30 */
    VOXEL_DIGIT = 10,  /* bits that one pass of sorting takes */
    VOXEL_CHILDREN = 8 /* of one node */
};

/* Edge of a voxel in mean lengths of a triangle's box; a sheet then has four to eight triangles a
 * voxel. */
#define VOXEL_EDGE 1.5

typedef struct voxel_grid {
    double low[3];
    double inv_edge;
    unsigned bits; /* of one coordinate */
} voxel_grid;

/* Twice the centre of a box. */
static double double_centre(const tree_box *box, int axis) {
    return (double)box->low[axis] + (double)box->high[axis];
}

static voxel_grid choose_grid(const broad_phase *broad, const topology *topo,
                              const surface_range *range) {
    voxel_grid grid = {.bits = 0};
    double high[3] = {0.0, 0.0, 0.0}, size_sum = 0.0, extent = 0.0;
    for (uint32_t i = range->triangle_begin; i < range->triangle_end; i++) {
        tree_box const box = find_triangle_box(broad, topo, i);
        double size = 0.0;
        for (int k = 0; k < 3; k++) {
            double const centre = double_centre(&box, k);
            if (i == range->triangle_begin || centre < grid.low[k]) grid.low[k] = centre;
            if (i == range->triangle_begin || centre > high[k]) high[k] = centre;
            size = fmax(size, (double)box.high[k] - (double)box.low[k]);
        }
        size_sum += size;
    }
    for (int k = 0; k < 3; k++) extent = fmax(extent, high[k] - grid.low[k]);
    double const edge =
        2.0 * VOXEL_EDGE * size_sum / (double)(range->triangle_end - range->triangle_begin);
    while (grid.bits < VOXEL_BITS && ldexp(edge, (int)grid.bits) < extent) grid.bits++;
    grid.inv_edge = extent > 0.0 ? ldexp(1.0, (int)grid.bits) / extent : 0.0;
    return grid;
}

/* Bit b of a 10-bit number moves to bit 3 b. */
static uint32_t spread_bits(uint32_t value) {
    value = (value | value << 16) & 0x030000ffU;
    value = (value | value << 8) & 0x0300f00fU;
    value = (value | value << 4) & 0x030c30c3U;
    return (value | value << 2) & 0x09249249U;
}

static uint32_t find_voxel(const voxel_grid *grid, const tree_box *box) {
    uint32_t const last = (1U << grid->bits) - 1;
    uint32_t code = 0;
    for (int k = 0; k < 3; k++) {
        double const cell = (double_centre(box, k) - grid->low[k]) * grid->inv_edge;
        uint32_t const index = cell < (double)last ? (uint32_t)cell : last;
        code |= spread_bits(index) << k;
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

static uint32_t voxel_of(uint64_t key) { return (uint32_t)(key >> 32); }

/* Runs of one voxel, at most LEAF_TRIANGLES long; codes takes the voxel of each leaf. */
static void build_leaves(broad_phase *broad, const surface_range *range, surface_tree *tree,
                         const uint64_t *keys, uint64_t *codes) {
    uint32_t const count = range->triangle_end - range->triangle_begin;
    tree->leaf_begin = range->triangle_begin;
    tree->leaf_count = 0;
    for (uint32_t begin = 0; begin < count;) {
        uint32_t end = begin + 1;
        while (end < count && end - begin < LEAF_TRIANGLES &&
               voxel_of(keys[end]) == voxel_of(keys[begin]))
            end++;
        codes[tree->leaf_count] = voxel_of(keys[begin]);
        tree_leaf *const leaf = &broad->leaves[tree->leaf_begin + tree->leaf_count++];
        leaf->triangle_begin = range->triangle_begin + begin;
        leaf->triangle_end = range->triangle_begin + end;
        begin = end;
    }
    for (uint32_t i = 0; i < count; i++)
        broad->triangles.features[range->triangle_begin + i] = (uint32_t)keys[i];
}

/* End of the run of nodes from `begin` that share the voxel of a level, VOXEL_CHILDREN at most. */
static size_t find_run_end(const uint64_t *codes, size_t begin, size_t count, unsigned shift) {
    size_t end = begin + 1;
    while (end < count && end - begin < VOXEL_CHILDREN &&
           codes[end] >> shift == codes[begin] >> shift)
        end++;
    return end;
}

static size_t count_runs(const uint64_t *codes, size_t count, unsigned shift) {
    size_t runs = 0;
    for (size_t begin = 0; begin < count; begin = find_run_end(codes, begin, count, shift)) runs++;
    return runs;
}

/* Levels of nodes over the leaves. A level repeats while runs were cut at VOXEL_CHILDREN.
 * usual_count: room for nodes that hardly any shape passes, so that the array rarely grows. */
static bool build_levels(memory *heap, surface_tree *tree, uint64_t *codes, size_t usual_count) {
    size_t level_begin = 0, level_count = tree->leaf_count;
    tree->nodes.count = 0;
    size_t const least_count = level_count > usual_count ? level_count : usual_count;
    if (!ARRAY_RESERVE(heap, &tree->nodes, least_count)) return false;
    for (uint32_t l = 0; l < tree->leaf_count; l++)
        tree->nodes.data[tree->nodes.count++] = (tree_node){.first = l};
    for (unsigned shift = 0; level_count > 1;) {
        size_t const run_count = count_runs(codes, level_count, shift);
        if (run_count == level_count) {
            shift += 3;
            continue;
        }
        if (!ARRAY_RESERVE(heap, &tree->nodes, run_count)) return false;
        size_t runs = 0;
        for (size_t begin = 0, end; begin < level_count; begin = end) {
            end = find_run_end(codes, begin, level_count, shift);
            codes[runs++] = codes[begin];
            tree->nodes.data[tree->nodes.count++] = (tree_node){
                .first = (uint32_t)(level_begin + begin), .child_count = (uint32_t)(end - begin)};
        }
        level_begin += level_count;
        level_count = runs;
    }
    return true;
}

tulle_status shape_voxel_tree(broad_phase *broad, const surface_set *set, uint32_t surface) {
    const surface_range *const range = &set->surfaces[surface];
    surface_tree *const tree = &broad->trees[surface];
    size_t const count = range->triangle_end - range->triangle_begin;
    tree->leaf_count = 0;
    tree->nodes.count = 0;
    if (count == 0) return TULLE_OK;
    voxel_grid const grid = choose_grid(broad, set->topo, range);
    uint64_t *keys = broad->voxel_keys[0], *codes = broad->voxel_keys[1];
    for (uint32_t i = 0; i < count; i++) {
        tree_box const box = find_triangle_box(broad, set->topo, range->triangle_begin + i);
        keys[i] = (uint64_t)find_voxel(&grid, &box) << 32 | (range->triangle_begin + i);
    }
    sort_by_voxel(&keys, &codes, count, grid.bits);
    build_leaves(broad, range, tree, keys, codes);
    if (!build_levels(broad->heap, tree, codes, count)) {
        tree->nodes.count = 0;
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    assign_slots(broad, set, surface);
    return TULLE_OK;
}
