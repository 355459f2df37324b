/* detect/trees/tree_slots.c - from the order of the triangles of a surface, cut into leaves, to the
 * slots of its features: every vertex and edge goes to one leaf that has a triangle around it. */
#include "detect/trees/broad_phase_parts.h"

/* Leaves around a vertex with more triangles count as neighbours of all leaves. That saves
 * comparing each of them with each. */
enum { HUB_TRIANGLES = 64 };

void assign_slot(slot_list *list, uint32_t slot, uint32_t feature, const uint32_t *corners) {
    list->features[slot] = feature;
    for (uint32_t k = 0; k < list->corner_count; k++)
        list->corners[list->corner_count * (size_t)slot + k] = corners[k];
}

/* What is needed while the features of one surface are dealt out. Arrays are indexed by what they
 * hold minus the begin of the surface's range. */
typedef struct dealer {
    broad_phase *broad;
    const topology *topo;
    const surface_range *range;
    tree_leaf *leaves;
    uint32_t leaf_begin, leaf_count;
    uint32_t *triangle_leaf;           /* leaf of each triangle, counted in the tree */
    uint32_t *vertex_leaf, *edge_leaf; /* TULLE_NONE: not yet dealt, or without triangle */
    uint32_t *vertex_slot;
} dealer;

/* Deals vertices and edges out: each goes to the leaf around it that has fewest. Meanwhile
 * vertex_end and edge_end of a leaf are numbers of what it has. */
static void deal_features(dealer *deal) {
    const topology *const topo = deal->topo;
    const slot_list *const triangles = &deal->broad->triangles;
    tree_leaf *const leaves = deal->leaves;
    uint32_t *const leaf_of = deal->triangle_leaf;
    uint32_t const first = deal->range->triangle_begin;
    for (uint32_t l = 0; l < deal->leaf_count; l++)
        for (uint32_t slot = leaves[l].triangle_begin; slot < leaves[l].triangle_end; slot++)
            leaf_of[triangles->features[slot] - first] = l;
    for (size_t i = 3 * (size_t)first; i < 3 * (size_t)deal->range->triangle_end; i++) {
        size_t const corner = 3 * (size_t)triangles->features[i / 3] + i % 3;
        uint32_t const vertex = topo->triangles[corner], edge = topo->triangle_edges[corner];
        uint32_t *owner = &deal->vertex_leaf[vertex - deal->range->vertex_begin];
        if (*owner == TULLE_NONE) {
            const adjacency *const around = &topo->vertex_triangles;
            for (uint32_t k = around->begin[vertex]; k < around->begin[vertex + 1]; k++) {
                uint32_t const leaf = leaf_of[around->items[k] - first];
                if (*owner == TULLE_NONE || leaves[leaf].vertex_end < leaves[*owner].vertex_end)
                    *owner = leaf;
            }
            leaves[*owner].vertex_end++;
        }
        owner = &deal->edge_leaf[edge - deal->range->edge_begin];
        if (*owner == TULLE_NONE) {
            const uint32_t *const beside = topo->edge_triangles + 2 * (size_t)edge;
            *owner = leaf_of[beside[0] - first];
            if (beside[1] != TULLE_NONE) {
                uint32_t const other = leaf_of[beside[1] - first];
                if (leaves[other].edge_end < leaves[*owner].edge_end) *owner = other;
            }
            leaves[*owner].edge_end++;
        }
    }
}

/* Numbers of features become ranges of slots, and features go to the slots of their leaves. */
static void fill_slots(dealer *deal) {
    broad_phase *const broad = deal->broad;
    const surface_range *const range = deal->range;
    uint32_t vertex_slot = range->vertex_begin, edge_slot = range->edge_begin;
    for (uint32_t l = 0; l < deal->leaf_count; l++) {
        tree_leaf *const leaf = &deal->leaves[l];
        uint32_t const vertex_count = leaf->vertex_end, edge_count = leaf->edge_end;
        leaf->vertex_begin = leaf->vertex_end = vertex_slot; /* ends grow as slots are filled */
        leaf->edge_begin = leaf->edge_end = edge_slot;
        vertex_slot += vertex_count;
        edge_slot += edge_count;
    }
    uint32_t last = range->vertex_end; /* records of vertices without triangles come last */
    for (uint32_t v = range->vertex_begin; v < range->vertex_end; v++) {
        uint32_t const owner = deal->vertex_leaf[v - range->vertex_begin];
        if (owner == TULLE_NONE) {
            broad->record_vertices[--last] = v;
            continue;
        }
        uint32_t const slot = deal->leaves[owner].vertex_end++;
        deal->vertex_slot[v - range->vertex_begin] = slot;
        assign_slot(&broad->vertices, slot, v, &slot);
        broad->record_vertices[slot] = v;
    }
    for (uint32_t e = range->edge_begin; e < range->edge_end; e++) {
        uint32_t corners[2];
        for (size_t k = 0; k < 2; k++)
            corners[k] =
                deal->vertex_slot[deal->topo->edges[2 * (size_t)e + k] - range->vertex_begin];
        tree_leaf *const leaf = &deal->leaves[deal->edge_leaf[e - range->edge_begin]];
        assign_slot(&broad->edges, leaf->edge_end++, e, corners);
    }
    for (uint32_t slot = range->triangle_begin; slot < range->triangle_end; slot++) {
        uint32_t const triangle = broad->triangles.features[slot];
        uint32_t corners[3];
        for (size_t k = 0; k < 3; k++)
            corners[k] = deal->vertex_slot[deal->topo->triangles[3 * (size_t)triangle + k] -
                                           range->vertex_begin];
        assign_slot(&broad->triangles, slot, triangle, corners);
    }
}

/* The leaves around a vertex, counted in the tree, each once; returns how many. */
static uint32_t list_leaves(const dealer *deal, uint32_t vertex, uint32_t leaves[HUB_TRIANGLES]) {
    const adjacency *const around = &deal->topo->vertex_triangles;
    uint32_t leaf_count = 0;
    for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++) {
        uint32_t const leaf = deal->triangle_leaf[around->items[i] - deal->range->triangle_begin];
        uint32_t at = 0;
        while (at < leaf_count && leaves[at] != leaf) at++;
        if (at == leaf_count) leaves[leaf_count++] = leaf;
    }
    return leaf_count;
}

/* Leaves that share a vertex become neighbours. */
static void join_leaves(dealer *deal) {
    const adjacency *const around = &deal->topo->vertex_triangles;
    uint32_t const first = deal->range->triangle_begin;
    for (uint32_t v = deal->range->vertex_begin; v < deal->range->vertex_end; v++) {
        const uint32_t *const triangles = around->items + around->begin[v];
        uint32_t const count = around->begin[v + 1] - around->begin[v];
        if (count > HUB_TRIANGLES) {
            for (uint32_t i = 0; i < count; i++)
                deal->leaves[deal->triangle_leaf[triangles[i] - first]].neighbours[0] = LEAF_ANY;
            continue;
        }
        uint32_t leaves[HUB_TRIANGLES];
        uint32_t const leaf_count = list_leaves(deal, v, leaves);
        for (uint32_t i = 0; i < leaf_count; i++) {
            uint32_t *const neighbours = deal->leaves[leaves[i]].neighbours;
            for (uint32_t j = 0; j < leaf_count && neighbours[0] != LEAF_ANY; j++) {
                if (leaves[j] <= leaves[i]) continue;
                /* no leaf has 0 as neighbour of higher number: it marks a free place */
                uint32_t const neighbour = deal->leaf_begin + leaves[j];
                size_t at = 0;
                while (at < LEAF_NEIGHBOURS && neighbours[at] != neighbour && neighbours[at] != 0)
                    at++;
                if (at < LEAF_NEIGHBOURS)
                    neighbours[at] = neighbour;
                else
                    neighbours[0] = LEAF_ANY;
            }
        }
    }
}

/* Lists the records of the corners of each leaf, each once; false when memory is short. */
static bool list_corners(dealer *deal) {
    broad_phase *const broad = deal->broad;
    uint32_t *const listed_by = deal->vertex_leaf; /* no longer needed: now of records */
    uint32_t const first = deal->range->vertex_begin;
    for (uint32_t v = first; v < deal->range->vertex_end; v++) listed_by[v - first] = TULLE_NONE;
    for (uint32_t l = 0; l < deal->leaf_count; l++) {
        tree_leaf *const leaf = &deal->leaves[l];
        if (!ARRAY_RESERVE(broad->heap, &broad->leaf_corners, LEAF_SLOTS)) return false;
        const uint32_t *const corners = broad->triangles.corners + 3 * (size_t)leaf->triangle_begin;
        leaf->corner_begin = (uint32_t)broad->leaf_corners.count;
        for (uint32_t i = 0; i < 3 * (leaf->triangle_end - leaf->triangle_begin); i++) {
            if (listed_by[corners[i] - first] == l) continue;
            listed_by[corners[i] - first] = l;
            broad->leaf_corners.data[broad->leaf_corners.count++] = corners[i];
        }
        leaf->corner_end = (uint32_t)broad->leaf_corners.count;
        leaf->group_begin = broad->group_count;
        broad->group_count += count_groups(leaf);
    }
    return true;
}

tulle_status assign_even_slots(broad_phase *broad, const surface_set *set, uint32_t surface) {
    const surface_range *const range = &set->surfaces[surface];
    surface_tree *const tree = &broad->trees[surface];
    memory *const heap = broad->heap;
    size_t const vertices = range->vertex_end - range->vertex_begin;
    size_t const edges = range->edge_end - range->edge_begin;
    size_t const triangles = range->triangle_end - range->triangle_begin;
    size_t const owner_count = 2 * vertices + edges + triangles;
    size_t const owner_bytes = (owner_count + 1) * sizeof(uint32_t);
    uint32_t *const owners = memory_allocate(heap, owner_bytes);
    if (!owners) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < owner_count; i++) owners[i] = TULLE_NONE;
    dealer deal = {.broad = broad,
                   .topo = set->topo,
                   .range = range,
                   .leaves = broad->leaves + tree->leaf_begin,
                   .leaf_begin = tree->leaf_begin,
                   .leaf_count = tree->leaf_count,
                   .triangle_leaf = owners,
                   .edge_leaf = owners + triangles,
                   .vertex_leaf = owners + triangles + edges,
                   .vertex_slot = owners + triangles + edges + vertices};
    deal_features(&deal);
    fill_slots(&deal);
    join_leaves(&deal);
    /* pairs of a leaf that neighbours any other are not counted */
    tree->near_pair_count = tree->leaf_count;
    for (uint32_t l = 0; l < tree->leaf_count; l++) {
        const uint32_t *const neighbours = deal.leaves[l].neighbours;
        for (size_t i = 0; i < LEAF_NEIGHBOURS && neighbours[i] != 0; i++)
            tree->near_pair_count += neighbours[0] != LEAF_ANY;
    }
    bool const has_room = list_corners(&deal);
    memory_release(heap, owners, owner_bytes);
    return has_room ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
