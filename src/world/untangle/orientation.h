/* world/untangle/orientation.h - on which sides of a contact plane the features of a pair belong,
 * even if they have passed through each other. */
#ifndef TULLE_WORLD_UNTANGLE_ORIENTATION_H
#define TULLE_WORLD_UNTANGLE_ORIENTATION_H

#include "contact/contact_types.h"

/* Whether the first feature belongs on the side to which an axis points. */
typedef enum orientation {
    ORIENTATION_AGAINST = -1,
    ORIENTATION_UNDECIDED = 0,
    ORIENTATION_ALONG = 1
} orientation;

/* A pair and its normal, whose sign is asked for. */
typedef struct oriented_pair {
    feature_kind kind;
    feature_pair pair;
    vec3 axis;  /* unit: the normal or its opposite */
    vec3 point; /* [m] between the features */
} oriented_pair;

/* A vertex and the side of a triangle on which it belongs. */
typedef struct known_side {
    uint32_t vertex, triangle;
    vec3 normal; /* unit, to that side */
} known_side;

/* Sides that were decided before, on the heap. Zeroed is empty. */
typedef struct side_history {
    ARRAY(known_side) sides;
} side_history;

/* Adds a side. Fails only for want of memory; the history is then as it was. */
tulle_status remember_side(side_history *history, memory *heap, known_side side);
/* Makes the history ready for look-ups, after the last side was added: sorts the sides and leaves
 * one of each pair, or none where those of a pair contradict one another. */
void settle_history(side_history *history);

/* History of a vertex and a triangle: the settled side of the same pair. If there is none, the
 * vertex may have slid from a triangle nearby; then those of its triangles that share a corner with
 * this one decide by majority. */
orientation orient_by_history(const topology *topo, const side_history *history,
                              feature_pair vertex_triangle, vec3 axis);

/* Geometric correction: a vertex belongs on the side on which all its neighbours lie. Two edges are
 * decided if all vertices opposite the first lie on one side, and all opposite the second on the
 * other. positions [m]: 3 * vertex_count. */
orientation orient_by_neighbours(const topology *topo, const double *positions,
                                 const oriented_pair *question);

/* Verification: moves the first triangle by a small way along the axis and the second by the same
 * way back. Of +axis and -axis that one is right which makes the sum of the squared distances of
 * all six corners to the plane grow more. */
orientation orient_by_triangles(const topology *topo, const double *positions, uint32_t first,
                                uint32_t second, vec3 axis);

#endif
