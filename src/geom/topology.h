/* geom/topology.h - edges and adjacency of a triangle set; for any triangle soup with valid
 * indices. */
#ifndef TULLE_GEOM_TOPOLOGY_H
#define TULLE_GEOM_TOPOLOGY_H

#include "base/memory.h"

/* Compressed lists: entries of item i are items[begin[i]] .. items[begin[i + 1] - 1], ascending. */
typedef struct adjacency {
    uint32_t *begin; /* count + 1 */
    uint32_t *items;
    size_t count, item_count;
} adjacency;

typedef struct topology {
    size_t vertex_count, triangle_count, edge_count;
    uint32_t *triangles; /* 3 * triangle_count, a copy of the input */
    uint32_t *edges; /* 2 * edge_count, smaller vertex first, sorted; so edges of a vertex range are
                        a range */
    uint32_t *triangle_edges; /* 3 * triangle_count: edge k joins corners k and (k + 1) % 3 */
    uint32_t *edge_triangles; /* 2 * edge_count: the first two triangles, ascending; TULLE_NONE
                                 where there is none */
    uint32_t *edge_opposites; /* 2 * edge_count: corner of edge_triangles off the edge; TULLE_NONE
                                 where there is none */
    adjacency vertex_triangles, vertex_edges, vertex_neighbours;
} topology;

/* Half-edges and edges are numbered with 32 bits. So a topology has at most so many triangles. */
enum { TOPOLOGY_TRIANGLES_MAX = (TULLE_NONE - 1) / 3 };

/* Builds all of it. Indices must be < vertex_count and the corners of each triangle distinct.
 * TULLE_ERROR_LIMIT where there are too many triangles or vertices. */
tulle_status topology_build(memory *heap, const uint32_t *triangles, size_t triangle_count,
                            size_t vertex_count, topology *result);
/* Without edge_opposites, vertex_edges and vertex_neighbours, which are null: 40 bytes a triangle
 * less. */
tulle_status topology_build_small(memory *heap, const uint32_t *triangles, size_t triangle_count,
                                  size_t vertex_count, topology *result);
/* Frees all but triangles and edges; the rest is null from then on. */
void topology_keep_corners(memory *heap, topology *topo);
void topology_destroy(memory *heap, topology *topo);

/* How many triangles each edge has: edge_count numbers. */
void topology_count_edge_uses(const topology *topo, uint32_t *edge_use_counts);

#endif
