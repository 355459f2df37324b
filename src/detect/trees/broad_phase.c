/* detect/trees/broad_phase.c - building the trees, and the life of the broad phase; see
 * broad_phase.h.
 *
 * Everything but the lists of pairs, boxes of features and the nodes of voxel trees is reserved at
 * creation. A surface is fitted again unless it is static and was fitted with the same margin in
 * the last call. */
#include "detect/trees/broad_phase_parts.h"

#include "base/parallel.h"
#include "detect/trees/tree_shape.h"

#include <math.h>
#include <string.h>

/* Room for the node pairs that a search shares out among workers; more only where they all meet. */
enum { SEARCH_TASKS = 4096, TRIANGLES_PER_TASK = 32 };

static bool reserve_parts(broad_phase *broad, const surface_set *set) {
    memory *const heap = broad->heap;
    size_t const vertices = broad->vertex_count, triangles = broad->triangle_count;
    bool const is_refit = broad->method == BROAD_PHASE_REFIT;
    broad->trees = memory_allocate_zeroed(heap, broad->surface_count, sizeof *broad->trees);
    if (!broad->trees) return false;

    /* Leaves are numbered through the surfaces. A voxel tree may need one for each triangle. */
    for (size_t s = 0; s < set->surface_count; s++) {
        const surface_range *const range = &set->surfaces[s];
        size_t const count = range->triangle_end - range->triangle_begin;
        broad->trees[s].leaf_begin = (uint32_t)broad->leaf_capacity;
        if (is_refit) broad->trees[s].leaf_count = choose_leaf_count(count);
        broad->leaf_capacity += is_refit ? broad->trees[s].leaf_count : count;
    }

    /* A fit task takes many vertices or lowest nodes of one surface, and there are fewer nodes than
     * triangles. */
    broad->fit_task_capacity = 2 * broad->surface_count + (vertices + triangles) / 32;
    broad->vertex_boxes = memory_allocate_zeroed(heap, vertices, sizeof *broad->vertex_boxes);
    broad->records = memory_allocate_zeroed(heap, vertices, sizeof *broad->records);
    broad->points = memory_allocate_zeroed(heap, vertices, sizeof *broad->points);
    broad->leaves = memory_allocate_zeroed(heap, broad->leaf_capacity, sizeof *broad->leaves);
    broad->fit_tasks =
        memory_allocate_zeroed(heap, broad->fit_task_capacity, sizeof *broad->fit_tasks);
    if (!broad->vertex_boxes || !broad->records || !broad->points || !broad->leaves ||
        !broad->fit_tasks)
        return false;
    size_t const task_count = triangles / TRIANGLES_PER_TASK;
    for (int k = 0; k < 2; k++)
        if (!ARRAY_RESERVE(heap, &broad->search_tasks[k],
                           task_count < SEARCH_TASKS ? task_count : SEARCH_TASKS))
            return false;

    slot_list *const slots[3] = {&broad->vertices, &broad->edges, &broad->triangles};
    size_t const counts[3] = {vertices, broad->edge_count, triangles};
    for (uint32_t k = 0; k < 3; k++) {
        slot_list *const list = slots[k];
        list->count = counts[k] + SLOT_SPARE;
        list->corner_count = k + 1;
        list->features = memory_allocate_zeroed(heap, list->count, sizeof *list->features);
        list->corners = memory_allocate_zeroed(heap, (k + 1) * list->count, sizeof *list->corners);
        if (!list->features || !list->corners) return false;
    }

    /* What trees of the method need besides. */
    if (is_refit) {
        broad->record_vertices =
            memory_allocate_zeroed(heap, vertices, sizeof *broad->record_vertices);
        return broad->record_vertices != NULL;
    }
    for (int k = 0; k < 2; k++) {
        broad->voxel_keys[k] =
            memory_allocate_zeroed(heap, triangles, sizeof *broad->voxel_keys[k]);
        if (!broad->voxel_keys[k]) return false;
    }
    return true;
}

void broad_phase_destroy(broad_phase *broad) {
    if (!broad) return;
    memory *const heap = broad->heap;
    broad_phase_release_blocks(broad);
    for (size_t s = 0; broad->trees && s < broad->surface_count; s++)
        ARRAY_FREE(heap, &broad->trees[s].nodes);
    memory_release(heap, broad->trees, broad->surface_count * sizeof *broad->trees);
    if (!broad->scratch)
        memory_release(heap, broad->vertex_boxes,
                       broad->vertex_count * sizeof *broad->vertex_boxes);
    memory_release(heap, broad->records, broad->vertex_count * sizeof *broad->records);
    memory_release(heap, broad->points, broad->vertex_count * sizeof *broad->points);
    memory_release(heap, broad->record_vertices,
                   broad->vertex_count * sizeof *broad->record_vertices);
    memory_release(heap, broad->leaves, broad->leaf_capacity * sizeof *broad->leaves);
    memory_release(heap, broad->fit_tasks, broad->fit_task_capacity * sizeof *broad->fit_tasks);
    for (int k = 0; k < 2; k++) {
        memory_release(heap, broad->voxel_keys[k],
                       broad->triangle_count * sizeof *broad->voxel_keys[k]);
        ARRAY_FREE(heap, &broad->search_tasks[k]);
        ARRAY_FREE(heap, &broad->stores[k].keys);
        ARRAY_FREE(heap, &broad->stores[k].spare);
        ARRAY_FREE(heap, &broad->stores[k].counts);
    }
    ARRAY_FREE(heap, &broad->leaf_corners);
    ARRAY_FREE(heap, &broad->masks);
    ARRAY_FREE(heap, &broad->voxel_groups);
    ARRAY_FREE(heap, &broad->root_nodes);
    ARRAY_FREE(heap, &broad->roots);
    ARRAY_FREE(heap, &broad->outputs);
    ARRAY_FREE(heap, &broad->kept_blocks);
    ARRAY_FREE(heap, &broad->lists);
    ARRAY_FREE(heap, &broad->writers);
    const slot_list *const slots[3] = {&broad->triangles, &broad->vertices, &broad->edges};
    for (int k = 0; k < 3; k++) {
        const slot_list *const list = slots[k];
        memory_release(heap, list->features, list->count * sizeof *list->features);
        memory_release(heap, list->corners,
                       list->corner_count * list->count * sizeof *list->corners);
    }
    memory_release(heap, broad, sizeof *broad);
}

tulle_status broad_phase_create(memory *heap, const surface_set *set, const double *rest,
                                broad_phase_method method, broad_phase **result) {
    *result = NULL;
    broad_phase *const broad = memory_allocate_zeroed(heap, 1, sizeof *broad);
    if (!broad) return TULLE_ERROR_OUT_OF_MEMORY;
    broad->heap = heap;
    broad->method = method;
    broad->vertex_count = set->topo->vertex_count;
    broad->edge_count = set->topo->edge_count;
    broad->triangle_count = set->topo->triangle_count;
    broad->surface_count = set->surface_count;
    broad->margin = -1.0;
    pair_store_prepare(&broad->stores[FEATURE_VERTEX_TRIANGLE], broad->vertex_count,
                       broad->triangle_count);
    pair_store_prepare(&broad->stores[FEATURE_EDGE_EDGE], broad->edge_count, broad->edge_count);
    tulle_status status = reserve_parts(broad, set) ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK && !choose_box_frame(broad, set->topo, rest))
        status = TULLE_ERROR_INVALID_ARGUMENT;
    if (method == BROAD_PHASE_REFIT) {
        for (uint32_t s = 0; status == TULLE_OK && s < set->surface_count; s++)
            status = shape_refit_tree(broad, set, s, rest);
        ARRAY_TRIM(heap, &broad->leaf_corners);
    }
    if (status != TULLE_OK) {
        broad_phase_destroy(broad);
        return status;
    }
    broad->tables = (pair_tables){.vertex_features = broad->vertices.features,
                                  .edge_features = broad->edges.features,
                                  .triangle_features = broad->triangles.features,
                                  .vertex_corners = broad->vertices.corners,
                                  .edge_corners = broad->edges.corners,
                                  .triangle_corners = broad->triangles.corners,
                                  .records = broad->records,
                                  .points = broad->points,
                                  .point_scale = broad->scale};
    *result = broad;
    return TULLE_OK;
}

tulle_status build_trees(broad_phase *broad, const surface_set *set, const double *x0,
                         const double *x1, double margin, int threads) {
    broad->is_built = false;
    if (set->surface_count != broad->surface_count || !(margin >= 0.0) || !isfinite(margin))
        return TULLE_ERROR_INVALID_ARGUMENT;
    for (size_t s = 0; s < set->surface_count; s++) {
        const surface_range *const range = &set->surfaces[s];
        if (!range->is_static || !range->is_present || margin != broad->margin)
            broad->trees[s].is_fitted = false;
    }
    broad->margin = margin;
    tulle_status status = TULLE_OK;
    /* Masks save some comparisons in each search. A single one saves less than they cost. */
    if (broad->method == BROAD_PHASE_REFIT && broad->was_built && !broad->has_masks) {
        broad->has_masks = make_leaf_masks(broad);
        if (!broad->has_masks) status = TULLE_ERROR_OUT_OF_MEMORY;
    }
    if (status == TULLE_OK && broad->scratch) {
        broad->vertex_boxes = ARENA_NEW(broad->scratch, vertex_box, broad->vertex_count);
        if (!broad->vertex_boxes) status = TULLE_ERROR_OUT_OF_MEMORY;
    }
    if (status == TULLE_OK && !fit_vertex_boxes(broad, set, x0, x1, threads))
        status = TULLE_ERROR_INVALID_ARGUMENT;
    for (uint32_t s = 0; broad->method != BROAD_PHASE_REFIT && s < set->surface_count; s++)
        if (status == TULLE_OK && set->surfaces[s].is_present && !broad->trees[s].is_fitted)
            status = shape_voxel_tree(broad, set, s);
    if (status == TULLE_OK && !fit_trees(broad, set, threads)) status = TULLE_ERROR_OUT_OF_MEMORY;
    if (status != TULLE_OK) {
        broad->margin = -1.0; /* nothing is fitted for the next call */
        return status;
    }
    broad->is_built = broad->was_built = true;
    return TULLE_OK;
}

void broad_phase_configure(broad_phase *broad, broad_phase_options options) {
    memory *const heap = broad->heap;
    broad->stop = options.stop;
    broad->most_candidates = options.most_candidates;
    if (broad->method == BROAD_PHASE_REFIT && broad->following != options.following) {
        broad->following = options.following;
        for (size_t s = 0; s < broad->surface_count; s++) broad->trees[s].is_fitted = false;
    }
    if (!options.scratch) return;
    memory_release(heap, broad->records, broad->vertex_count * sizeof *broad->records);
    memory_release(heap, broad->points, broad->vertex_count * sizeof *broad->points);
    if (!broad->scratch)
        memory_release(heap, broad->vertex_boxes,
                       broad->vertex_count * sizeof *broad->vertex_boxes);
    broad->tables.records = broad->records = NULL;
    broad->tables.points = broad->points = NULL;
    broad->vertex_boxes = NULL;
    broad->scratch = options.scratch;
}

bool broad_phase_is_straight(const broad_phase *broad) {
    return broad->is_straight || broad->following == PATHS_ALWAYS;
}

void broad_phase_set_patches(broad_phase *broad, patch_labels patches) { broad->patches = patches; }

const uint32_t *broad_phase_get_order(const broad_phase *broad) {
    return broad->method == BROAD_PHASE_REFIT ? broad->triangles.features : NULL;
}

const pair_tables *broad_phase_get_tables(const broad_phase *broad) { return &broad->tables; }
