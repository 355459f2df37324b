/* geom/topology.c - see topology.h. Half-edges (triangle * 3 + corner) are sorted by their larger
 * and then, stably, by their smaller vertex with two counting sorts, O(triangles + vertices); equal
 * neighbours in that order are one edge. Stability makes every list ascending. */
#include "geom/topology.h"

#include <string.h>

/* The end of a half-edge, from its corner to the next one, with the smaller or larger number. */
static uint32_t get_end(const uint32_t *triangles, uint32_t half_edge, bool is_larger) {
    uint32_t const next = half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
    uint32_t const a = triangles[half_edge], b = triangles[next];
    return (a < b) == is_larger ? b : a;
}

/* Stable counting sort of half-edges by one end; source null stands for 0, 1, 2 ... `counts` has
 * vertex_count + 1 entries. */
static void sort_half_edges(const topology *topo, const uint32_t *source, bool by_larger,
                            uint32_t *counts, uint32_t *target) {
    uint32_t const count = (uint32_t)(3 * topo->triangle_count);
    memset(counts, 0, (topo->vertex_count + 1) * sizeof *counts);
    for (uint32_t h = 0; h < count; h++) counts[get_end(topo->triangles, h, by_larger) + 1]++;
    for (size_t v = 0; v < topo->vertex_count; v++) counts[v + 1] += counts[v];
    for (uint32_t k = 0; k < count; k++) {
        uint32_t const h = source ? source[k] : k;
        target[counts[get_end(topo->triangles, h, by_larger)]++] = h;
    }
}

/* Lists for each vertex the items that name it, ascending; item k names keys[stride * k] ... False:
 * no memory. */
static bool list_items(memory *heap, const uint32_t *keys, size_t key_count, uint32_t stride,
                       size_t vertex_count, adjacency *lists) {
    lists->count = vertex_count;
    lists->item_count = key_count;
    lists->begin = memory_allocate_zeroed(heap, vertex_count + 1, sizeof(uint32_t));
    lists->items = memory_allocate(heap, key_count * sizeof(uint32_t));
    if (!lists->begin || !lists->items) return false;
    for (size_t k = 0; k < key_count; k++) lists->begin[keys[k] + 1]++;
    for (size_t v = 0; v < vertex_count; v++) lists->begin[v + 1] += lists->begin[v];
    for (size_t k = 0; k < key_count; k++)
        lists->items[lists->begin[keys[k]]++] = (uint32_t)(k / stride);
    /* Filling moved each begin to its end: shift back by one. */
    for (size_t v = vertex_count; v > 0; v--) lists->begin[v] = lists->begin[v - 1];
    lists->begin[0] = 0;
    return true;
}

/* Sorts the half-edges with scratch memory of its own, numbers the edges in that order and fills
 * triangle_edges. */
static bool number_edges(memory *heap, topology *topo) {
    size_t const half_edge_count = 3 * topo->triangle_count;
    uint32_t *const counts = memory_allocate(heap, (topo->vertex_count + 1) * sizeof(uint32_t));
    uint32_t *const by_larger = memory_allocate(heap, half_edge_count * sizeof(uint32_t));
    uint32_t *const sorted = memory_allocate(heap, half_edge_count * sizeof(uint32_t));
    bool const has_memory = counts && by_larger && sorted;
    if (has_memory) {
        sort_half_edges(topo, NULL, true, counts, by_larger);
        sort_half_edges(topo, by_larger, false, counts, sorted);
        size_t count = 0;
        uint32_t low_prev = 0, high_prev = 0;
        for (size_t k = 0; k < half_edge_count; k++) {
            uint32_t const low = get_end(topo->triangles, sorted[k], false);
            uint32_t const high = get_end(topo->triangles, sorted[k], true);
            if (k == 0 || low != low_prev || high != high_prev) count++;
            topo->triangle_edges[sorted[k]] = (uint32_t)(count - 1);
            low_prev = low;
            high_prev = high;
        }
        topo->edge_count = count;
    }
    memory_release(heap, sorted, half_edge_count * sizeof(uint32_t));
    memory_release(heap, by_larger, half_edge_count * sizeof(uint32_t));
    memory_release(heap, counts, (topo->vertex_count + 1) * sizeof(uint32_t));
    return has_memory;
}

tulle_status topology_build_small(memory *heap, const uint32_t *triangles, size_t triangle_count,
                                  size_t vertex_count, topology *result) {
    topology topo = {.vertex_count = vertex_count, .triangle_count = triangle_count};
    size_t const half_edge_count = 3 * triangle_count;
    *result = (topology){0};
    if (triangle_count > TOPOLOGY_TRIANGLES_MAX || vertex_count > TULLE_NONE - 1)
        return TULLE_ERROR_LIMIT;
    topo.triangles = memory_allocate(heap, half_edge_count * sizeof(uint32_t));
    topo.triangle_edges = memory_allocate(heap, half_edge_count * sizeof(uint32_t));
    bool has_memory = topo.triangles && topo.triangle_edges;
    if (has_memory && triangle_count > 0)
        memcpy(topo.triangles, triangles, half_edge_count * sizeof *triangles);
    has_memory = has_memory && number_edges(heap, &topo);
    if (has_memory) {
        topo.edges = memory_allocate(heap, 2 * topo.edge_count * sizeof(uint32_t));
        topo.edge_triangles = memory_allocate(heap, 2 * topo.edge_count * sizeof(uint32_t));
        has_memory = topo.edges && topo.edge_triangles &&
                     list_items(heap, topo.triangles, half_edge_count, 3, vertex_count,
                                &topo.vertex_triangles);
    }
    if (!has_memory) {
        topology_destroy(heap, &topo);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    /* Ends and triangles of each edge; the order of half-edges makes the triangles ascend. */
    for (size_t e = 0; e < 2 * topo.edge_count; e++) topo.edge_triangles[e] = TULLE_NONE;
    for (uint32_t h = 0; h < half_edge_count; h++) {
        size_t const first = 2 * (size_t)topo.triangle_edges[h], second = first + 1;
        topo.edges[first] = get_end(topo.triangles, h, false);
        topo.edges[second] = get_end(topo.triangles, h, true);
        if (topo.edge_triangles[first] == TULLE_NONE)
            topo.edge_triangles[first] = h / 3;
        else if (topo.edge_triangles[second] == TULLE_NONE)
            topo.edge_triangles[second] = h / 3;
    }
    *result = topo;
    return TULLE_OK;
}

tulle_status topology_build(memory *heap, const uint32_t *triangles, size_t triangle_count,
                            size_t vertex_count, topology *result) {
    tulle_status const status =
        topology_build_small(heap, triangles, triangle_count, vertex_count, result);
    if (status != TULLE_OK) return status;
    size_t const end_count = 2 * result->edge_count;
    result->edge_opposites = memory_allocate(heap, end_count * sizeof(uint32_t));
    if (!result->edge_opposites ||
        !list_items(heap, result->edges, end_count, 2, vertex_count, &result->vertex_edges) ||
        !list_items(heap, result->edges, end_count, 2, vertex_count, &result->vertex_neighbours)) {
        topology_destroy(heap, result);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    for (size_t k = 0; k < end_count; k++) {
        size_t const triangle = result->edge_triangles[k];
        result->edge_opposites[k] = TULLE_NONE;
        if (triangle == TULLE_NONE) continue;
        const uint32_t *const corners = result->triangles + 3 * triangle;
        const uint32_t *const ends = result->edges + 2 * (k / 2);
        /* The corner that is no end of the edge. The sum may wrap; the difference is right. */
        result->edge_opposites[k] = corners[0] + corners[1] + corners[2] - ends[0] - ends[1];
    }
    /* A neighbour is the other end of an edge. Sorted edges make neighbours ascend: smaller ones
     * come from edges that begin at them, larger ones from the vertex's own range. */
    adjacency *const neighbours = &result->vertex_neighbours;
    for (uint32_t v = 0; v < vertex_count; v++) {
        for (uint32_t k = neighbours->begin[v]; k < neighbours->begin[v + 1]; k++) {
            const uint32_t *const ends = result->edges + 2 * (size_t)neighbours->items[k];
            neighbours->items[k] = ends[0] == v ? ends[1] : ends[0];
        }
    }
    return TULLE_OK;
}

void topology_keep_corners(memory *heap, topology *topo) {
    memory_release(heap, topo->triangle_edges, 3 * topo->triangle_count * sizeof(uint32_t));
    memory_release(heap, topo->edge_triangles, 2 * topo->edge_count * sizeof(uint32_t));
    memory_release(heap, topo->edge_opposites, 2 * topo->edge_count * sizeof(uint32_t));
    topo->triangle_edges = topo->edge_triangles = topo->edge_opposites = NULL;
    adjacency *const lists[3] = {&topo->vertex_triangles, &topo->vertex_edges,
                                 &topo->vertex_neighbours};
    for (int k = 0; k < 3; k++) {
        memory_release(heap, lists[k]->begin, (lists[k]->count + 1) * sizeof(uint32_t));
        memory_release(heap, lists[k]->items, lists[k]->item_count * sizeof(uint32_t));
        *lists[k] = (adjacency){0};
    }
}

void topology_destroy(memory *heap, topology *topo) {
    topology_keep_corners(heap, topo);
    memory_release(heap, topo->triangles, 3 * topo->triangle_count * sizeof(uint32_t));
    memory_release(heap, topo->edges, 2 * topo->edge_count * sizeof(uint32_t));
    *topo = (topology){0};
}

void topology_count_edge_uses(const topology *topo, uint32_t *edge_use_counts) {
    for (size_t e = 0; e < topo->edge_count; e++) edge_use_counts[e] = 0;
    for (size_t h = 0; h < 3 * topo->triangle_count; h++)
        edge_use_counts[topo->triangle_edges[h]]++;
}
