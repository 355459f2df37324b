/* geom/topology.c - see topology.h. Half-edges (triangle * 3 + corner) are sorted by their larger
 * and then, stably, by their smaller vertex with two counting sorts, O(triangles + vertices); equal
 * neighbours in that order are one edge. Stability makes every list ascending. */
#include "geom/topology.h"

#include <string.h>

static uint32_t next_corner(uint32_t half_edge) {
    return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
}

static uint32_t opposite_corner(uint32_t half_edge) {
    return half_edge % 3 == 0 ? half_edge + 2 : half_edge - 1;
}

static uint32_t *new_indices(memory *heap, size_t count) {
    return memory_allocate(heap, count * sizeof(uint32_t));
}

static void release_indices(memory *heap, uint32_t *indices, size_t count) {
    memory_release(heap, indices, count * sizeof(uint32_t));
}

static uint32_t get_end(const uint32_t *triangles, uint32_t half_edge, bool is_larger) {
    uint32_t const a = triangles[half_edge], b = triangles[next_corner(half_edge)];
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

/* Numbers the edges in sorted order and fills triangle_edges; returns how many there are. */
static size_t number_edges(topology *topo, const uint32_t *sorted) {
    size_t count = 0;
    uint32_t low_prev = 0, high_prev = 0;
    for (size_t k = 0; k < 3 * topo->triangle_count; k++) {
        uint32_t const low = get_end(topo->triangles, sorted[k], false);
        uint32_t const high = get_end(topo->triangles, sorted[k], true);
        if (k == 0 || low != low_prev || high != high_prev) count++;
        topo->triangle_edges[sorted[k]] = (uint32_t)(count - 1);
        low_prev = low;
        high_prev = high;
    }
    return count;
}

/* Ends, triangles and opposite corners of each edge; triangle order makes the triangles ascend. */
static void fill_edges(topology *topo) {
    for (size_t e = 0; e < 2 * topo->edge_count; e++) {
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
        topo->edge_triangles[slot] = h / 3;
        if (topo->edge_opposites) topo->edge_opposites[slot] = topo->triangles[opposite_corner(h)];
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

/* The other end of each vertex's edges. Sorted edges make these ascend: smaller neighbours come
 * from edges that begin at them, larger ones from the vertex's own range. */
static void fill_neighbours(topology *topo) {
    adjacency *const lists = &topo->vertex_neighbours;
    memcpy(lists->begin, topo->vertex_edges.begin, (lists->count + 1) * sizeof *lists->begin);
    for (uint32_t v = 0; v < lists->count; v++) {
        for (uint32_t k = lists->begin[v]; k < lists->begin[v + 1]; k++) {
            const uint32_t *const edge = topo->edges + 2 * (size_t)topo->vertex_edges.items[k];
            lists->items[k] = edge[0] == v ? edge[1] : edge[0];
        }
    }
}

static bool create_adjacency(memory *heap, size_t count, size_t item_count, adjacency *lists) {
    lists->count = count;
    lists->item_count = item_count;
    lists->begin = new_indices(heap, count + 1);
    lists->items = new_indices(heap, item_count);
    return lists->begin && lists->items;
}

static void destroy_adjacency(memory *heap, adjacency *lists) {
    if (lists->begin) release_indices(heap, lists->begin, lists->count + 1);
    if (lists->items) release_indices(heap, lists->items, lists->item_count);
    *lists = (adjacency){0};
}

/* Sorts and numbers the half-edges with scratch memory of its own. */
static bool find_edges(memory *heap, topology *topo) {
    size_t const half_edge_count = 3 * topo->triangle_count;
    uint32_t *const counts = new_indices(heap, topo->vertex_count + 1);
    uint32_t *const by_larger = new_indices(heap, half_edge_count);
    uint32_t *const sorted = new_indices(heap, half_edge_count);
    bool const has_memory = counts && by_larger && sorted;
    if (has_memory) {
        sort_half_edges(topo, NULL, true, counts, by_larger);
        sort_half_edges(topo, by_larger, false, counts, sorted);
        topo->edge_count = number_edges(topo, sorted);
    }
    if (sorted) release_indices(heap, sorted, half_edge_count);
    if (by_larger) release_indices(heap, by_larger, half_edge_count);
    if (counts) release_indices(heap, counts, topo->vertex_count + 1);
    return has_memory;
}

/* Everything that hangs on the numbered edges; is_small: see topology_build_small. */
static bool fill_topology(memory *heap, topology *topo, bool is_small) {
    size_t const edge_count = topo->edge_count, vertex_count = topo->vertex_count;
    topo->edges = new_indices(heap, 2 * edge_count);
    topo->edge_triangles = new_indices(heap, 2 * edge_count);
    if (!topo->edges || !topo->edge_triangles ||
        !create_adjacency(heap, vertex_count, 3 * topo->triangle_count, &topo->vertex_triangles))
        return false;
    if (!is_small) {
        topo->edge_opposites = new_indices(heap, 2 * edge_count);
        if (!topo->edge_opposites ||
            !create_adjacency(heap, vertex_count, 2 * edge_count, &topo->vertex_edges) ||
            !create_adjacency(heap, vertex_count, 2 * edge_count, &topo->vertex_neighbours))
            return false;
    }
    fill_edges(topo);
    fill_adjacency(topo->triangles, 3 * topo->triangle_count, 3, &topo->vertex_triangles);
    if (is_small) return true;
    fill_adjacency(topo->edges, 2 * edge_count, 2, &topo->vertex_edges);
    fill_neighbours(topo);
    return true;
}

static tulle_status build(memory *heap, const uint32_t *triangles, topology topo, bool is_small,
                          topology *result) {
    size_t const triangle_count = topo.triangle_count;
    *result = (topology){0};
    /* Half-edges and edges are numbered with 32 bits. */
    if (triangle_count > (TULLE_NONE - 1) / 3 || topo.vertex_count > TULLE_NONE - 1)
        return TULLE_ERROR_LIMIT;
    topo.triangles = new_indices(heap, 3 * triangle_count);
    topo.triangle_edges = new_indices(heap, 3 * triangle_count);
    bool has_memory = topo.triangles && topo.triangle_edges;
    if (has_memory) {
        if (triangle_count > 0)
            memcpy(topo.triangles, triangles, 3 * triangle_count * sizeof *triangles);
        has_memory = find_edges(heap, &topo) && fill_topology(heap, &topo, is_small);
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
    if (topo->triangle_edges) release_indices(heap, topo->triangle_edges, 3 * topo->triangle_count);
    if (topo->edge_triangles) release_indices(heap, topo->edge_triangles, 2 * topo->edge_count);
    if (topo->edge_opposites) release_indices(heap, topo->edge_opposites, 2 * topo->edge_count);
    topo->triangle_edges = topo->edge_triangles = topo->edge_opposites = NULL;
    destroy_adjacency(heap, &topo->vertex_triangles);
    destroy_adjacency(heap, &topo->vertex_edges);
    destroy_adjacency(heap, &topo->vertex_neighbours);
}

void topology_destroy(memory *heap, topology *topo) {
    topology_keep_corners(heap, topo);
    if (topo->triangles) release_indices(heap, topo->triangles, 3 * topo->triangle_count);
    if (topo->edges) release_indices(heap, topo->edges, 2 * topo->edge_count);
    *topo = (topology){0};
}
