/* detect/impact/pair_batch.h - candidate pairs on their way from the trees to whoever tests them:
 * they come in batches while they are in the cache, and are never all stored.
 *
 * A pair is a pair of slots: features in the order of the tree's leaves. The tables lead from slots
 * to features, corners and positions. */
#ifndef TULLE_DETECT_IMPACT_PAIR_BATCH_H
#define TULLE_DETECT_IMPACT_PAIR_BATCH_H

#include "detect/surface_set.h"

enum { PAIR_BATCH_SIZE = 2048 };

/* Start and end of one vertex, one cache line. */
typedef struct vertex_record {
    double start[4], end[4]; /* [m] x, y, z and 0; as given, to the bit */
} vertex_record;

/* The same in box coordinates, rounded: half a line. */
typedef struct vertex_point {
    float start[4], end[4];
} vertex_point;

/* Valid from one build_trees to the next. Slots are numbered through all surfaces. */
typedef struct pair_tables {
    const uint32_t *vertex_features, *edge_features, *triangle_features; /* slot -> feature */
    const uint32_t *vertex_corners;                                      /* slot -> record */
    const uint32_t *edge_corners;                                        /* 2 a slot */
    const uint32_t *triangle_corners;                                    /* 3 a slot */
    const vertex_record *records; /* 64-byte aligned; or null */
    const vertex_point *points;   /* of the same; or null */
    double point_scale;           /* box coordinates a metre */
    double largest_point;         /* of all coordinates of points */
} pair_tables;

/* Pairs of one kind: vertex slots and triangle slots, or two edge slots in either order. */
typedef struct pair_batch {
    feature_kind kind;
    size_t count;
    uint32_t first[PAIR_BATCH_SIZE], second[PAIR_BATCH_SIZE];
} pair_batch;

/* Takes the pairs of a batch; worker: which thread calls, 0 .. threads - 1. A worker's calls follow
 * one another; what it is given depends on the threads, so results must not depend on the order. */
typedef void (*pair_consumer)(void *context, const pair_tables *tables, const pair_batch *batch,
                              int worker);

/* The features of a pair, edges in ascending order. */
static inline feature_pair pair_batch_get(const pair_tables *tables, const pair_batch *batch,
                                          size_t index) {
    uint32_t const first = batch->first[index], second = batch->second[index];
    if (batch->kind == FEATURE_VERTEX_TRIANGLE)
        return (feature_pair){tables->vertex_features[first], tables->triangle_features[second]};
    uint32_t const a = tables->edge_features[first], b = tables->edge_features[second];
    return a < b ? (feature_pair){a, b} : (feature_pair){b, a};
}

#endif
