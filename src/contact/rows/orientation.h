/* contact/rows/orientation.h - on which side of a contact plane a pair's features belong, also
 * where they have already passed through each other. */
#ifndef TULLE_CONTACT_ROWS_ORIENTATION_H
#define TULLE_CONTACT_ROWS_ORIENTATION_H

#include "contact/contact_types.h"

/* Whether the first feature belongs on the side to which an axis points. */
typedef enum orientation {
    ORIENTATION_AGAINST = -1,
    ORIENTATION_UNDECIDED = 0,
    ORIENTATION_ALONG = 1
} orientation;

/* A pair and a line on which its normal lies. `point` lies between the features. */
typedef struct oriented_pair {
    feature_kind kind;
    feature_pair pair;
    vec3 axis;  /* unit */
    vec3 point; /* [m] */
} oriented_pair;

/* A vertex and the side of a triangle on which it belongs. */
typedef struct known_side {
    uint32_t vertex, triangle;
    vec3 normal; /* unit, to that side */
} known_side;

/* Sides that were decided before. Zeroed is empty. */
typedef struct side_history {
    ARRAY(known_side) sides;
} side_history;

/* Adds a side. Fails only for want of memory; the history is then as it was. */
tulle_status remember_side(side_history *history, memory *heap, known_side side);
/* After the last one was added: sorts them for look-ups and leaves one of each pair, none where
 * those of a pair contradict one another. */
void settle_history(side_history *history);
void side_history_destroy(side_history *history, memory *heap);

/* History of a vertex and a triangle: the settled side of the same pair, else what most of the
 * vertex's triangles that share a corner with this one say (it slid from one to the other). */
orientation orient_by_history(const topology *topo, const side_history *history,
                              feature_pair vertex_triangle, vec3 axis);

/* Geometric correction: a vertex comes from the side on which all its neighbours lie; of two edges,
 * the vertices opposite the first lie on one side and those opposite the second on the other.
 * Positions [m]: 3 * vertex_count. */
orientation orient_by_neighbours(const topology *topo, const double *positions,
                                 const oriented_pair *question);

/* Verification: of +axis and -axis the one along which moving the first triangle forth and the
 * second back by the same small way makes the sum of the squared distances of all six corners to
 * the plane grow more. */
orientation orient_by_triangles(const topology *topo, const double *positions, uint32_t first,
                                uint32_t second, vec3 axis);

#endif
