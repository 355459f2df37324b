/* detect/trees/refit_boxes.c - boxes of moving vertices, features, leaves and nodes, and labels of
 * nodes.
 *
 * In: the paths of all vertices. Out: boxes in the nodes of all trees. The box of a vertex holds
 * its path widened by margin / 2; all other boxes are unions of those, so every method sees the
 * same feature boxes bit for bit.
 *
 * There are two parallel loops. The first makes the boxes of vertices, the second those of leaves
 * and of the nodes right above them; the few nodes higher up follow at the end. Work is cut into
 * tasks of fixed size, and each writes its own boxes only. */
#include "base/parallel.h"
#include "detect/trees/broad_phase_parts.h"

#include <math.h>

enum {
    VERTICES_PER_TASK = 2048, /* some 20 microseconds */
    RECORDS_APART = 8,        /* two leaves */
    NODES_PER_TASK = 32       /* some 200 leaves, some 20 microseconds */
};
/* [mean edge] Where vertices move farther, boxes that hold their paths cost more than drift does.
 */
static const double LONG_MOTION = 0.2;
/* [motion] Where neighbours on a surface move more than this against one another, following paths
 * leaves out little. */
static const double RELATIVE_MOTION = 0.5;
/* Limit on half a margin, in box coordinates. It reaches beyond all boxes, which are cut at 3e38.
 */
static const double FRAME_REACH = 1e39;

bool choose_box_frame(broad_phase *broad, const topology *topo, const double *rest) {
    double low[3] = {0.0, 0.0, 0.0}, high[3] = {0.0, 0.0, 0.0}, extent = 0.0;
    bool is_first = true;
    for (size_t i = 0; i < broad->vertex_count; i++) {
        bool const has_triangle =
            topo->vertex_triangles.begin[i] < topo->vertex_triangles.begin[i + 1];
        for (int k = 0; k < 3; k++) {
            double const x = rest[3 * i + (size_t)k];
            if (!isfinite(x)) return false;
            if (!has_triangle) continue; /* may lie far away, and meets nothing */
            if (is_first || x < low[k]) low[k] = x;
            if (is_first || x > high[k]) high[k] = x;
        }
        is_first = is_first && !has_triangle;
    }
    for (int k = 0; k < 3; k++) {
        broad->origin[k] = 0.5 * low[k] + 0.5 * high[k];
        extent = fmax(extent, 0.5 * high[k] - 0.5 * low[k]);
    }
    int exponent = 0;
    if (extent > 0.0) frexp(extent, &exponent);
    if (exponent < -1000) exponent = -1000;
    broad->scale = ldexp(1.0, -exponent);
    for (size_t i = 0; i < 3 * topo->edge_count; i++) {
        const uint32_t *const ends = topo->edges + 2 * (i / 3);
        double const difference =
            rest[3 * (size_t)ends[1] + i % 3] - rest[3 * (size_t)ends[0] + i % 3];
        broad->mean_edge += fabs(difference) * broad->scale / (double)topo->edge_count;
    }
    return true;
}

/* Cuts begin .. end - 1 into tasks. */
static size_t append_tasks(broad_phase *broad, size_t count, uint32_t surface, uint32_t begin,
                           uint32_t end, uint32_t size) {
    for (uint32_t at = begin; at<end; at = end - at> size ? at + size : end)
        broad->fit_tasks[count++] =
            (fit_task){.surface = surface, .begin = at, .end = end - at > size ? at + size : end};
    return count;
}

typedef struct vertex_context {
    broad_phase *broad;
    vertex_fit fit;
} vertex_context;

/* Fits the boxes of some vertices. Where it matters whether paths are long, it also samples how far
 * every RECORDS_APART-th vertex moves, and how differently the next sample moves. Records are in
 * the order of leaves, so the next sample belongs to a leaf nearby. */
static void fit_vertex_task(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)begin, (void)end, (void)worker;
    const vertex_context *const vertices = context;
    const vertex_fit *const fit = &vertices->fit;
    fit_task *const task = &vertices->broad->fit_tasks[chunk];
    task->is_finite = TULLE_PICK_KERNEL(fit_vertices)(fit, task->begin, task->end, &task->sums);
    if (vertices->broad->following != PATHS_WHERE_LONG) return;
    task->ways = (way_sums){0.0, 0.0};
    for (uint32_t i = task->begin; task->end - i > RECORDS_APART; i += RECORDS_APART) {
        uint32_t const next = i + RECORDS_APART;
        size_t const own = 3 * (size_t)(fit->vertices ? fit->vertices[i] : i);
        size_t const other = 3 * (size_t)(fit->vertices ? fit->vertices[next] : next);
        double sum = 0.0, relative = 0.0;
        for (size_t k = 0; k < 3; k++) {
            double const way = fit->x1[own + k] - fit->x0[own + k];
            sum += fabs(way);
            relative += fabs(way - (fit->x1[other + k] - fit->x0[other + k]));
        }
        task->ways.own += sum;
        task->ways.relative += relative;
    }
}

bool fit_vertex_boxes(broad_phase *broad, const surface_set *set, const double *x0,
                      const double *x1, int threads) {
    size_t task_count = 0;
    for (uint32_t s = 0; s < set->surface_count; s++) {
        const surface_range *const range = &set->surfaces[s];
        if (range->is_present && !broad->trees[s].is_fitted)
            task_count = append_tasks(broad, task_count, s, range->vertex_begin, range->vertex_end,
                                      VERTICES_PER_TASK);
    }
    size_t const new_count = task_count;
    for (uint32_t s = 0; broad->scratch && s < set->surface_count; s++) {
        const surface_range *const range = &set->surfaces[s];
        if (range->is_present && broad->trees[s].is_fitted)
            task_count = append_tasks(broad, task_count, s, range->vertex_begin, range->vertex_end,
                                      VERTICES_PER_TASK);
    }
    vertex_context context = {.broad = broad,
                              .fit = {.vertices = broad->record_vertices,
                                      .x0 = x0,
                                      .x1 = x1,
                                      .records = broad->records,
                                      .points = broad->points,
                                      .boxes = broad->vertex_boxes}};
    for (int k = 0; k < 8; k++) {
        if (k % 4 == 3) continue;
        context.fit.origin[k] = broad->origin[k % 4];
        context.fit.scale[k] = broad->scale;
        context.fit.half[k] = fmin(0.5 * broad->margin * broad->scale, FRAME_REACH);
    }
    parallel_for(task_count, 1, threads, fit_vertex_task, &context);

    /* Whether paths are long. Only surfaces that may move count, since a static one may have been
     * fitted in an earlier call, and that must not matter. */
    bool is_finite = true;
    double motion = 0.0, count = 0.0;
    way_sums ways = {0.0, 0.0};
    for (uint32_t s = 0; s < set->surface_count; s++)
        if (!broad->trees[s].is_fitted) broad->trees[s].largest = 0.0;
    for (size_t i = 0; i < new_count; i++) {
        const fit_task *const task = &broad->fit_tasks[i];
        surface_tree *const tree = &broad->trees[task->surface];
        is_finite = is_finite && task->is_finite;
        tree->largest = fmax(tree->largest, task->sums.largest);
        if (set->surfaces[task->surface].is_static) continue;
        motion += task->sums.motion;
        ways.own += task->ways.own;
        ways.relative += task->ways.relative;
        count += (double)(task->end - task->begin);
    }
    broad->tables.largest_point = 0.0;
    for (uint32_t s = 0; s < set->surface_count; s++)
        if (set->surfaces[s].is_present)
            broad->tables.largest_point =
                fmax(broad->tables.largest_point, broad->trees[s].largest);
    bool const moves_together =
        broad->following == PATHS_ALWAYS || ways.relative < RELATIVE_MOTION * ways.own;
    broad->is_straight = broad->following != PATHS_IN_BOXES && moves_together &&
                         motion > LONG_MOTION * broad->mean_edge * count;
    return is_finite;
}

/* Fits lowest nodes and what is below them. A leaf bears the label that all its triangles bear, or
 * 0. */
static void fit_lowest_task(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)begin, (void)end, (void)worker;
    const broad_phase *const broad = context;
    const fit_task *const task = &broad->fit_tasks[chunk];
    surface_tree *const tree = &broad->trees[task->surface];
    bool const needs_blocks = broad->has_all_blocks && !tree->has_blocks;
    leaf_slabs *const slabs = broad->has_all_blocks ? broad->slabs : NULL;
    if (!tree->is_fitted || (slabs && needs_blocks)) TULLE_PICK_KERNEL(fit_lowest_nodes)
    (&broad->fit, tree->nodes.data, slabs, task->begin, task->end);
    const tree_node *const first = &tree->nodes.data[task->begin];
    const tree_node *const last = &tree->nodes.data[task->end - 1];
    if (needs_blocks)
        TULLE_PICK_KERNEL(fit_leaves)(&broad->fit, first->first, last->first + last->child_count);
    const uint32_t *const labels = broad->patches.labels;
    const uint32_t *const triangles = broad->triangles.features;
    for (uint32_t i = task->begin; !broad->is_labelled && i < task->end; i++) {
        tree_node *const node = &tree->nodes.data[i];
        for (uint32_t c = 0; c < node->child_count; c++) {
            const tree_leaf *const leaf = &broad->leaves[node->first + c];
            uint32_t const label = labels[triangles[leaf->triangle_begin]];
            uint32_t slot = leaf->triangle_begin + 1;
            while (slot < leaf->triangle_end && labels[triangles[slot]] == label) slot++;
            node->labels[c] = slot == leaf->triangle_end ? label : 0;
        }
    }
}

/* Fits all nodes but the lowest. A node bears the label that all its children bear, or 0. */
static void fit_upper_nodes(const broad_phase *broad, surface_tree *tree) {
    if (tree->level_count < 2) return;
    for (uint32_t i = tree->level_begin[1]; i < tree->nodes.count; i++) {
        tree_node *const node = &tree->nodes.data[i];
        for (uint32_t c = 0; !broad->is_labelled && c < node->child_count; c++) {
            const tree_node *const child = &tree->nodes.data[node->first + c];
            uint32_t const label = child->labels[0];
            uint32_t k = 1;
            while (k < child->child_count && child->labels[k] == label) k++;
            node->labels[c] = k == child->child_count ? label : 0;
        }
        if (tree->is_fitted) continue;
        for (int k = 0; k < 3; k++) {
            node->box[k] = INFINITY;
            node->box[3 + k] = -INFINITY;
            /* a side below all others and one above them: a lane without child meets nothing */
            for (uint32_t c = node->child_count; c < NODE_LANES; c++) {
                node->sides[k][c] = INFINITY;
                node->sides[3 + k][c] = -INFINITY;
            }
        }
        for (uint32_t c = 0; c < node->child_count; c++) {
            const float *const child = tree->nodes.data[node->first + c].box;
            for (int k = 0; k < 6; k++) node->sides[k][c] = child[k];
            for (int k = 0; k < 3; k++) {
                if (child[k] < node->box[k]) node->box[k] = child[k];
                if (child[3 + k] > node->box[3 + k]) node->box[3 + k] = child[3 + k];
            }
        }
    }
}

void broad_phase_release_blocks(broad_phase *broad) {
    memory *const heap = broad->heap;
    memory_release(heap, broad->slabs, broad->leaf_capacity * sizeof *broad->slabs);
    memory_release(heap, broad->blocks, broad->block_capacity * sizeof *broad->blocks);
    broad->slabs = NULL;
    broad->blocks = NULL;
    for (size_t s = 0; broad->trees && s < broad->surface_count; s++)
        broad->trees[s].has_blocks = false;
}

bool fit_trees(broad_phase *broad, const surface_set *set, int threads) {
    /* Nodes bear labels where there are patches, and may have theirs already. Absent surfaces get
     * none, so the next call has to label again. */
    const patch_labels *const patches = &broad->patches, *const known = &broad->node_patches;
    broad->has_labels = patches->labels && broad->method != BROAD_PHASE_BVOX;
    broad->is_labelled = !broad->has_labels;
    if (broad->has_labels) {
        broad->is_labelled = broad->method == BROAD_PHASE_REFIT && patches->version != 0 &&
                             patches->labels == known->labels && patches->version == known->version;
        broad->node_patches = *patches;
        for (uint32_t s = 0; s < set->surface_count; s++)
            if (!set->surfaces[s].is_present) broad->node_patches.version = 0;
    }

    /* Refitted trees have blocks and slabs of all leaves where no patches leave out pairs of
     * leaves; else workers keep blocks of their own. */
    memory *const heap = broad->heap;
    broad->has_all_blocks = !broad->has_labels && broad->method == BROAD_PHASE_REFIT;
    if (!broad->has_all_blocks && broad->blocks) broad_phase_release_blocks(broad);
    if (broad->has_all_blocks && !broad->blocks && broad->leaf_capacity > 0) {
        bool const needs_slabs = broad->following != PATHS_IN_BOXES;
        ARRAY_FREE(heap, &broad->kept_blocks);
        broad->block_capacity =
            LEAF_HEADER * broad->leaf_capacity + GROUP_FLOATS * (size_t)broad->group_count;
        broad->blocks = memory_allocate(heap, broad->block_capacity * sizeof *broad->blocks);
        if (needs_slabs)
            broad->slabs = memory_allocate(heap, broad->leaf_capacity * sizeof *broad->slabs);
        if (!broad->blocks || (needs_slabs && !broad->slabs)) {
            broad_phase_release_blocks(broad);
            return false;
        }
    }

    /* Leaves and lowest nodes, then the nodes above them. */
    broad->fit = (leaf_fit){.leaves = broad->leaves,
                            .triangle_corners = broad->triangles.corners,
                            .vertex_corners = broad->vertices.corners,
                            .edge_corners = broad->edges.corners,
                            .leaf_corners = broad->leaf_corners.data,
                            .vertex_boxes = broad->vertex_boxes,
                            .blocks = broad->has_all_blocks ? broad->blocks : NULL,
                            .is_straight = broad->is_straight};
    size_t task_count = 0;
    for (uint32_t s = 0; s < set->surface_count; s++) {
        surface_tree *const tree = &broad->trees[s];
        if (!set->surfaces[s].is_present || tree->level_count == 0) continue;
        tree->has_blocks = tree->is_fitted && tree->has_blocks;
        bool const needs_blocks = broad->has_all_blocks && !tree->has_blocks;
        if (!tree->is_fitted || !broad->is_labelled || needs_blocks)
            task_count =
                append_tasks(broad, task_count, s, 0, tree->level_begin[1], NODES_PER_TASK);
    }
    parallel_for(task_count, 1, threads, fit_lowest_task, broad);
    for (uint32_t s = 0; s < set->surface_count; s++) {
        surface_tree *const tree = &broad->trees[s];
        if (!set->surfaces[s].is_present) continue;
        fit_upper_nodes(broad, tree);
        tree->has_blocks = broad->has_all_blocks || tree->has_blocks;
        tree->is_fitted = true;
    }
    return true;
}
