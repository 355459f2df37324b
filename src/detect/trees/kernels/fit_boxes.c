/* detect/trees/kernels/fit_boxes.c - boxes of nodes above leaves and of the features of a leaf, and
 * slabs of leaves.
 *
 * All are unions of the boxes of vertices, without rounding. Eight features are united at a time
 * and turned into rows.
 *
 * Slabs bound a leaf along the axes and the four diagonals of a cube, at each end of the step. Two
 * leaves that a direction keeps apart at both ends stay apart in between, since all moves on
 * straight lines. Along a diagonal, which is longer than an axis by sqrt(3), boxes widened by half
 * the margin on each axis are widened by three halves of it: more than enough. */
#include "detect/trees/kernels/box_vectors.h"
#include "detect/trees/tree_kernels.h"

#include <math.h>

/* ---- blocks ---- */

/* Sums and differences of sides are off by less than this part of the largest coordinate of a leaf,
 * and by the smallest float; where coordinates are larger than the limit, sums may overflow. */
static const float SLAB_ROUNDING = 0x1.0p-19F;
static const float SLAB_UNDERFLOW = 0x1.0p-120F;
static const float SLAB_LIMIT = 1e37F;

/* The largest coordinate of boxes united in `all`. */
BOX_INLINE float compute_largest(box_vector all) {
    all = box_vector_most(all, -all);
    all = box_vector_most(all, BOX_SHUFFLE(all, all, 4, 5, 6, 7, 0, 1, 2, 3));
    all = box_vector_most(all, BOX_SHUFFLE(all, all, 1, 0, 3, 2, 5, 4, 7, 6));
    return all[0] > all[2] ? all[0] : all[2];
}

/* Moved outward by the rounding of sums. */
BOX_INLINE box_vector round_sums(box_vector sums, float largest) {
    if (!(largest < SLAB_LIMIT)) return box_vector_fill(-INFINITY);
    return sums - (largest * SLAB_ROUNDING + SLAB_UNDERFLOW);
}

/* The path of a vertex, seen from what moves by `shift` meanwhile. */
BOX_INLINE box_vector load_box(const leaf_fit *fit, uint32_t record, box_vector shift) {
    const vertex_box *const box = &fit->vertex_boxes[record];
    return box_vector_least(box_vector_load(box->start), box_vector_load(box->end) - shift);
}

/* Features of one kind of a leaf: slots begin .. end - 1, corner_count records each. */
typedef struct slot_range {
    const uint32_t *corners;
    uint32_t corner_count, begin, end;
} slot_range;

/* Fits eight of them, from the one at `offset` on, in lanes of rows. Lanes beyond are NaN, which
 * meets nothing, not even what reaches everywhere. Returns the box around all. */
BOX_INLINE box_vector fit_lanes(const leaf_fit *fit, slot_range slots, uint32_t offset,
                                box_vector shift, float *rows) {
    box_vector boxes[8];
    uint32_t const begin = slots.begin + offset;
    const uint32_t *const corners = slots.corners + slots.corner_count * (size_t)begin;
    uint32_t const count = begin < slots.end ? slots.end - begin : 0;
    for (size_t l = 0; l < 8; l++) {
        boxes[l] = box_vector_fill(NAN);
        if (l >= count) continue;
        const uint32_t *const own = corners + slots.corner_count * l;
        boxes[l] = load_box(fit, own[0], shift);
        for (size_t k = 1; k < slots.corner_count; k++)
            boxes[l] = box_vector_least(boxes[l], load_box(fit, own[k], shift));
    }
    box_vectors_write_rows(boxes, rows, GROUP_LANES);
    /* The second one where the first is NaN. */
    for (size_t l = 4; l > 0; l /= 2)
        for (size_t i = 0; i < l; i++) boxes[i] = box_vector_least(boxes[i + l], boxes[i]);
    return boxes[0];
}

typedef struct corner_list {
    const uint32_t *begin, *end;
} corner_list;

/* Records around a leaf, in trees that are built anew some of them several times. */
BOX_INLINE corner_list list_corners(const leaf_fit *fit, const tree_leaf *leaf) {
    if (fit->leaf_corners)
        return (corner_list){fit->leaf_corners + leaf->corner_begin,
                             fit->leaf_corners + leaf->corner_end};
    return (corner_list){fit->triangle_corners + 3 * (size_t)leaf->triangle_begin,
                         fit->triangle_corners + 3 * (size_t)leaf->triangle_end};
}

/* How a leaf moves: see tree_kernels.h. */
typedef struct leaf_motion {
    box_vector drift; /* low, -high, both rounded outward */
    box_vector shift; /* drift, -drift, and rounding, so that what is shifted is rounded outward */
} leaf_motion;

/* The drift along each axis is the motion nearest to 0 between the least and the largest of the
 * vertices. Any other would be as right, but not keep as many features apart. */
BOX_INLINE leaf_motion compute_motion(const leaf_fit *fit, const tree_leaf *leaf) {
    box_vector const zero = box_vector_fill(0.0F);
    box_vector all = box_vector_fill(INFINITY), most = all;
    corner_list const corners = list_corners(fit, leaf);
    for (const uint32_t *corner = corners.begin; corner < corners.end; corner++) {
        box_vector const start = box_vector_load(fit->vertex_boxes[*corner].start);
        box_vector const end = box_vector_load(fit->vertex_boxes[*corner].end);
        all = box_vector_least(all, box_vector_least(start, end));
        most = box_vector_least(most, end - start);
    }
    float const largest = compute_largest(all);
    if (!(largest < SLAB_LIMIT)) return (leaf_motion){zero - INFINITY, zero};
    /* least motions above 0, and minus largest ones below it */
    box_vector const away = box_vector_most(most, zero);
    box_vector const drift = away - BOX_SHUFFLE(away, away, 4, 5, 6, 7, 0, 1, 2, 3);
    /* without drift nothing is rounded: a static leaf has the same block whether paths are long */
    float const most_rounding = largest * SLAB_ROUNDING + SLAB_UNDERFLOW;
    box_vector const size = box_vector_most(drift, -drift);
    box_vector rounding = zero;
    for (int k = 0; k < 8; k++) rounding[k] = size[k] > 0.0F ? most_rounding : 0.0F;
    return (leaf_motion){drift - rounding, drift + rounding};
}

BOX_INLINE void fit_block_as(const leaf_fit *fit, const tree_leaf *leaf, bool is_straight,
                             float *block) {
    slot_range const triangles = {fit->triangle_corners, 3, leaf->triangle_begin,
                                  leaf->triangle_end};
    slot_range const vertices = {fit->vertex_corners, 1, leaf->vertex_begin, leaf->vertex_end};
    slot_range const edges = {fit->edge_corners, 2, leaf->edge_begin, leaf->edge_end};
    float *group = block + LEAF_HEADER;
    box_vector const zero = box_vector_fill(0.0F);
    leaf_motion motion = {zero, zero};
    if (is_straight) motion = compute_motion(fit, leaf);
    box_vector const shift = motion.shift;
    box_vector_store(block, fit_lanes(fit, triangles, 0, shift, group));
    box_vector_store(block + 8, motion.drift);
    fit_lanes(fit, vertices, 0, shift, group + LEAF_TRIANGLES);
    group += GROUP_FLOATS;
    for (uint32_t at = 0; at == 0 || at < edges.end - edges.begin; at += GROUP_LANES) {
        fit_lanes(fit, edges, at, shift, group);
        fit_lanes(fit, edges, at + 8, shift, group + 8);
        group += GROUP_FLOATS;
    }
    if (vertices.end - vertices.begin <= FACE_VERTICES) return;
    fit_lanes(fit, vertices, FACE_VERTICES, shift, group);
    fit_lanes(fit, vertices, FACE_VERTICES + 8, shift, group + 8);
}

void TULLE_KERNEL(fit_block)(const leaf_fit *fit, const tree_leaf *leaf, float *block) {
    if (fit->is_straight)
        fit_block_as(fit, leaf, true, block);
    else
        fit_block_as(fit, leaf, false, block);
}

void TULLE_KERNEL(fit_leaves)(const leaf_fit *fit, size_t begin, size_t end) {
    for (size_t l = begin; l < end; l++) TULLE_KERNEL(fit_block)
    (fit, &fit->leaves[l], fit->blocks + compute_block_begin(&fit->leaves[l], l));
}

/* ---- nodes ---- */

/* Around all triangles of a leaf, so around all features. slabs: lower ends along the diagonals
 * (1 1 1), (1 1 -1), (1 -1 1), (-1 1 1), then minus their upper ends. */
typedef struct leaf_extent {
    box_vector start, end;
    box_vector slabs[2]; /* at the start and the end */
} leaf_extent;

BOX_INLINE box_vector compute_diagonals(box_vector box) {
    return BOX_SHUFFLE(box, box, 0, 0, 0, 4, 4, 4, 4, 0) +
           BOX_SHUFFLE(box, box, 1, 1, 5, 1, 5, 5, 1, 5) +
           BOX_SHUFFLE(box, box, 2, 6, 2, 2, 6, 2, 6, 6);
}

BOX_INLINE leaf_extent compute_extent(const leaf_fit *fit, const tree_leaf *leaf, bool has_slabs) {
    box_vector const nothing = box_vector_fill(INFINITY);
    leaf_extent extent = {nothing, nothing, {nothing, nothing}};
    corner_list const corners = list_corners(fit, leaf);
    for (const uint32_t *corner = corners.begin; corner < corners.end; corner++) {
        box_vector const start = box_vector_load(fit->vertex_boxes[*corner].start);
        box_vector const end = box_vector_load(fit->vertex_boxes[*corner].end);
        extent.start = box_vector_least(extent.start, start);
        extent.end = box_vector_least(extent.end, end);
        if (!has_slabs) continue;
        extent.slabs[0] = box_vector_least(extent.slabs[0], compute_diagonals(start));
        extent.slabs[1] = box_vector_least(extent.slabs[1], compute_diagonals(end));
    }
    float const largest = compute_largest(box_vector_least(extent.start, extent.end));
    for (int k = 0; k < 2; k++) extent.slabs[k] = round_sums(extent.slabs[k], largest);
    return extent;
}

BOX_INLINE void write_slabs(const leaf_extent *extent, leaf_slabs *to) {
    for (int end = 0; end < 2; end++) {
        box_vector const box = end ? extent->end : extent->start, slabs = extent->slabs[end];
        box_vector_store(to->low[end], BOX_SHUFFLE(box, slabs, 0, 1, 2, 3, 8, 9, 10, 11));
        box_vector_store(to->high[end], BOX_SHUFFLE(box, slabs, 4, 5, 6, 7, 12, 13, 14, 15));
    }
}

void TULLE_KERNEL(fit_lowest_nodes)(const leaf_fit *fit, tree_node *nodes, leaf_slabs *slabs,
                                    size_t begin, size_t end) {
    box_vector const nothing = box_vector_fill(INFINITY);
    for (size_t i = begin; i < end; i++) {
        tree_node *const node = &nodes[i];
        box_vector boxes[NODE_LANES], all = nothing;
        for (size_t c = node->child_count; c < NODE_LANES; c++) boxes[c] = nothing;
        for (size_t c = 0; c < node->child_count; c++) {
            size_t const leaf = node->first + c;
            leaf_extent extent;
            if (slabs) {
                extent = compute_extent(fit, &fit->leaves[leaf], true);
                write_slabs(&extent, &slabs[leaf]);
            } else {
                extent = compute_extent(fit, &fit->leaves[leaf], false);
            }
            boxes[c] = box_vector_least(extent.start, extent.end);
            all = box_vector_least(all, boxes[c]);
        }
        box_vectors_write_rows(boxes, node->sides[0], NODE_LANES);
        box_vector_write(all, node->box);
    }
}
