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

/* For each vertex, the ascending items that name it: item k names keys[stride * k] ... */
static void fill_adjacency(const uint32_t *keys, size_t key_count, uint32_t stride,
                           adjacency *lists) {
    memset(lists->begin, 0, (lists->count + 1) * sizeof *lists->begin);
    for (size_t k = 0; k < key_count; k++) lists->begin[keys[k] + 1]++;
    for (size_t v = 0; v < lists->count; v++) lists->begin[v + 1] += lists->begin[v];
    for (size_t k = 0; k < key_count; k++)
        lists->items[lists->begin[keys[k]]++] = (uint32_t)(k / stride);
    /* Filling moved each begin to its end: shift back by one. */
    for (size_t v = lists->count; v > 0; v--) lists->begin[v] = lists->begin[v - 1];
    lists->begin[0] = 0;
}

static bool create_adjacency(memory *heap, size_t count, size_t item_count, adjacency *lists) {
    lists->count = count;
    lists->item_count = item_count;
    lists->begin = memory_allocate(heap, (count + 1) * sizeof(uint32_t));
    lists->items = memory_allocate(heap, item_count * sizeof(uint32_t));
    return lists->begin && lists->items;
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

/* Everything that hangs on the numbered edges; is_small: see topology_build_small. */
static bool fill_topology(memory *heap, topology *topo, bool is_small) {
    size_t const edge_count = topo->edge_count, vertex_count = topo->vertex_count;
    topo->edges = memory_allocate(heap, 2 * edge_count * sizeof(uint32_t));
    topo->edge_triangles = memory_allocate(heap, 2 * edge_count * sizeof(uint32_t));
    if (!topo->edges || !topo->edge_triangles ||
        !create_adjacency(heap, vertex_count, 3 * topo->triangle_count, &topo->vertex_triangles))
        return false;
    if (!is_small) {
        topo->edge_opposites = memory_allocate(heap, 2 * edge_count * sizeof(uint32_t));
        if (!topo->edge_opposites ||
            !create_adjacency(heap, vertex_count, 2 * edge_count, &topo->vertex_edges) ||
            !create_adjacency(heap, vertex_count, 2 * edge_count, &topo->vertex_neighbours))
            return false;
    }

    /* Ends, triangles and opposite corners of each edge; triangle order makes the triangles ascend.
     */
    for (size_t e = 0; e < 2 * edge_count; e++) {
        topo->edge_triangles[e] = TULLE_NONE;
        if (topo->edge_opposites) topo->edge_opposites[e] = TULLE_NONE;
    }
    for (uint32_t h = 0; h < 3 * topo->triangle_count; h++) {
        size_t const e = topo->triangle_edges[h];
        size_t slot = 2 * e;
        if (topo->edge_triangles[slot] != TULLE_NONE) slot++;
        topo->edges[2 * e] = get_end(topo->triangles, h, false);
        topo->edges[2 * e + 1] = get_end(topo->triangles, h, true);
        if (topo->edge_triangles[slot] != TULLE_NONE) continue;
        uint32_t const opposite = h % 3 == 0 ? h + 2 : h - 1;
        topo->edge_triangles[slot] = h / 3;
        if (topo->edge_opposites) topo->edge_opposites[slot] = topo->triangles[opposite];
    }
    fill_adjacency(topo->triangles, 3 * topo->triangle_count, 3, &topo->vertex_triangles);
    if (is_small) return true;
    fill_adjacency(topo->edges, 2 * edge_count, 2, &topo->vertex_edges);

    /* The other end of each vertex's edges. Sorted edges make these ascend: smaller neighbours come
     * from edges that begin at them, larger ones from the vertex's own range. */
    adjacency *const lists = &topo->vertex_neighbours;
    memcpy(lists->begin, topo->vertex_edges.begin, (lists->count + 1) * sizeof *lists->begin);
    for (uint32_t v = 0; v < lists->count; v++) {
        for (uint32_t k = lists->begin[v]; k < lists->begin[v + 1]; k++) {
            const uint32_t *const edge = topo->edges + 2 * (size_t)topo->vertex_edges.items[k];
            lists->items[k] = edge[0] == v ? edge[1] : edge[0];
        }
    }
    return true;
}

static tulle_status build(memory *heap, const uint32_t *triangles, topology topo, bool is_small,
                          topology *result) {
    size_t const triangle_count = topo.triangle_count;
    *result = (topology){0};
    /* Half-edges and edges are numbered with 32 bits. */
    if (triangle_count > (TULLE_NONE - 1) / 3 || topo.vertex_count > TULLE_NONE - 1)
        return TULLE_ERROR_LIMIT;
    topo.triangles = memory_allocate(heap, 3 * triangle_count * sizeof(uint32_t));
    topo.triangle_edges = memory_allocate(heap, 3 * triangle_count * sizeof(uint32_t));
    bool has_memory = topo.triangles && topo.triangle_edges;
    if (has_memory) {
        if (triangle_count > 0)
            memcpy(topo.triangles, triangles, 3 * triangle_count * sizeof *triangles);
        has_memory = number_edges(heap, &topo) && fill_topology(heap, &topo, is_small);
    }
    if (!has_memory) {
        topology_destroy(heap, &topo);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    *result = topo;
    return TULLE_OK;
}

tulle_status topology_build(memory *heap, const uint32_t *triangles, size_t triangle_count,
                            size_t vertex_count, topology *result) {
    topology const empty = {.vertex_count = vertex_count, .triangle_count = triangle_count};
    return build(heap, triangles, empty, false, result);
}

tulle_status topology_build_small(memory *heap, const uint32_t *triangles, size_t triangle_count,
                                  size_t vertex_count, topology *result) {
    topology const empty = {.vertex_count = vertex_count, .triangle_count = triangle_count};
    return build(heap, triangles, empty, true, result);
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
