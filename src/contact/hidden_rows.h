/* contact/hidden_rows.h - rows with an obstacle that a nearer one makes idle. */
#ifndef TULLE_CONTACT_HIDDEN_ROWS_H
#define TULLE_CONTACT_HIDDEN_ROWS_H

#include "contact/pair_scan.h"

/* The plane of the nearest obstacle to a vertex of cloth or of a free body. */
typedef struct near_plane {
    double distance; /* [m] of the vertex from it; 0: there is none */
    size_t row;      /* that keeps the vertex above it */
    vec3 normal;     /* unit, towards the vertex */
    vec3 point;      /* [m] nearest to the vertex now ... */
    vec3 end;        /* [m] ... and where the obstacle takes it */
} near_plane;

/* Makes the row the plane of its vertex, if it is a vertex/triangle row of now with a scripted
 * obstacle, pushes that way and is nearer than what is there. `index` tells it from others; ends
 * [m]: predicted. */
void note_near_plane(const contact_scene *scene, const double *ends, const contact_row *row,
                     size_t index, near_plane *planes);

/* Whether the row's obstacle's feature lies behind the plane of a nearer one of the same vertices
 * of cloth or of a free body: that one keeps them away from it, too. Where an obstacle is flat a
 * row a vertex is left; where triangles or obstacles lie flush without sharing vertices, the rim of
 * the next one is no edge to stop at. The nearest row of a vertex is never hidden. Of the row only
 * kind, vertices and weights are read. */
bool row_is_hidden(const contact_scene *scene, const double *ends, const near_plane *planes,
                   const contact_row *row, size_t index);

#endif
