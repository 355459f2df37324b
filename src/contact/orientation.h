/* contact/orientation.h - on which side of a contact plane a pair's features belong, also where
 * they have already passed through each other. */
#ifndef TULLE_CONTACT_ORIENTATION_H
#define TULLE_CONTACT_ORIENTATION_H

#include "contact/contact_store.h"

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

/* The side that the store remembers: of the same pair, else of a contact of the same first feature
 * with a second one that shares a vertex (sliding from triangle to triangle or edge to edge). */
orientation orient_by_history(const topology *topo, const contact_store *store,
                              const oriented_pair *question);

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

/* The first of these rules that decides; triangles are one of each feature. */
orientation orient_pair(const topology *topo, const double *positions, const contact_store *store,
                        const oriented_pair *question);

#endif
