/* detect/surface_set.h - what detection works on: moving triangle surfaces in flat arrays.
 *
 * All surfaces share one numbering of vertices, edges and triangles; each surface owns a contiguous
 * range of each. During a step vertex i moves along x0[i] + t (x1[i] - x0[i]), t in [0, 1]. */
#ifndef TULLE_DETECT_SURFACE_SET_H
#define TULLE_DETECT_SURFACE_SET_H

#include "geom/distance.h"
#include "geom/topology.h"

#include <stdbool.h>

typedef struct surface_range {
    uint32_t vertex_begin, vertex_end;
    uint32_t edge_begin, edge_end;
    uint32_t triangle_begin, triangle_end;
    bool is_obstacle;  /* obstacles meet neither themselves nor one another, but see is_body */
    bool is_present;   /* absent surfaces meet nothing */
    bool ignores_self; /* its features do not meet one another; obstacles' never do */
    bool is_static; /* x0 == x1 == the positions of the last call: its tree need not be refitted */
    bool is_body;   /* of obstacles: meets all others */
    bool is_asleep; /* of bodies and cloth: meets only cloth and bodies that are awake */
    bool is_in_pieces; /* of cloth: its triangles do not all hang together. The detector does not
                          read it */
} surface_range;

typedef struct surface_set {
    const topology *topo; /* of all surfaces together */
    const surface_range *surfaces;
    size_t surface_count;
    const unsigned char *collides; /* surface_count^2, row-major, symmetric: which surfaces meet,
                                      besides what the ranges exclude; null: all */
} surface_set;

/* Whether something else than a script may move a surface. */
static inline bool surface_is_awake(const surface_range *range) {
    return !range->is_asleep && (!range->is_obstacle || range->is_body);
}

/* Whether features of two surfaces, or of one surface twice, are paired where both are present. */
static inline bool surfaces_may_meet(const surface_set *set, size_t a, size_t b) {
    const surface_range *const first = &set->surfaces[a], *const second = &set->surfaces[b];
    if (!surface_is_awake(first) && !surface_is_awake(second)) return false;
    if (a == b && (first->is_obstacle || first->ignores_self)) return false;
    return !set->collides || set->collides[a * set->surface_count + b];
}

/* Whether features of a surface are paired with one another. */
static inline bool surface_meets_itself(const surface_set *set, size_t surface) {
    return set->surfaces[surface].is_present && surfaces_may_meet(set, surface, surface);
}

/* Vertex `first` and triangle `second`, or edges first < second (of one surface; across surfaces
 * the surface of lower index comes first, which is the same since ranges ascend). */
typedef struct feature_pair {
    uint32_t first, second;
} feature_pair;

/* Candidates, each pair once, sorted by (first, second) where nothing else is said. Owned by the
 * caller's heap; grows, never drops. */
typedef struct pair_list {
    ARRAY(feature_pair) vertex_triangle;
    ARRAY(feature_pair) edge_edge;
} pair_list;

/* Vertex indices of the four points of a pair. */
static inline void feature_pair_vertices(const topology *topo, feature_kind kind, feature_pair pair,
                                         uint32_t vertices[4]) {
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        vertices[0] = pair.first;
        for (int k = 0; k < 3; k++)
            vertices[1 + k] = topo->triangles[3 * (size_t)pair.second + (size_t)k];
    } else {
        vertices[0] = topo->edges[2 * (size_t)pair.first];
        vertices[1] = topo->edges[2 * (size_t)pair.first + 1];
        vertices[2] = topo->edges[2 * (size_t)pair.second];
        vertices[3] = topo->edges[2 * (size_t)pair.second + 1];
    }
}

#endif
