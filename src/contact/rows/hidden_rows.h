/* contact/rows/hidden_rows.h - rows with an obstacle that a nearer one makes idle. */
#ifndef TULLE_CONTACT_ROWS_HIDDEN_ROWS_H
#define TULLE_CONTACT_ROWS_HIDDEN_ROWS_H

#include "contact/pairs/pair_scan.h"

/* The plane of an obstacle near a vertex of cloth or of a free body. */
typedef struct near_plane {
    double distance; /* [m] of the vertex from it; 0: there is none */
    vec3 normal;     /* unit, towards the vertex */
    vec3 point;      /* [m] nearest to the vertex at the start ... */
    vec3 end;        /* [m] ... and where the obstacle takes it */
} near_plane;

/* The planes of rows, and which of them is that of the nearest obstacle to each vertex. */
typedef struct near_planes {
    near_plane *of_rows; /* null: no row is hidden */
    uint32_t *nearest;   /* of each vertex: a row, or TULLE_NONE */
} near_planes;

/* Sets the plane of a row. There is one for a vertex/triangle row of the start with a scripted
 * obstacle that pushes along the shortest way. ends [m]: predicted. */
void make_near_plane(const contact_scene *scene, const double *ends, const contact_row *row,
                     near_plane *plane);

/* Whether the row's obstacle's feature lies behind the plane of a nearer one of the same vertices
 * of cloth or of a free body: that one keeps them away from it, too. Where an obstacle is flat a
 * row a vertex is left; where triangles or obstacles lie flush without sharing vertices, the rim of
 * the next one is no edge to stop at. The nearest row of a vertex is never hidden. Of the row only
 * kind, vertices, weights and is_old are read; `index` tells it from others. */
bool row_is_hidden(const contact_scene *scene, const double *ends, const near_planes *planes,
                   const contact_row *row, size_t index);

#endif
