/* contact/rows/hidden_rows.h - rows against an obstacle that are not needed, because a nearer row
 * of the same vertices keeps them away from it. */
#ifndef TULLE_CONTACT_ROWS_HIDDEN_ROWS_H
#define TULLE_CONTACT_ROWS_HIDDEN_ROWS_H

#include "contact/pairs/pair_scan.h"

/* The plane of an obstacle near a vertex of cloth or of a free body. */
typedef struct near_plane {
    double distance; /* [m] of the vertex from it; 0: there is none */
    vec3 normal;     /* unit, towards the vertex */
    vec3 point;      /* [m] of the obstacle, nearest to the vertex at the start */
    vec3 end;        /* [m] where the obstacle takes that point */
} near_plane;

/* The planes of rows, and for each vertex the row whose plane is nearest to it. */
typedef struct near_planes {
    near_plane *of_rows; /* null: no row is hidden */
    uint32_t *nearest;   /* of each vertex: a row, or TULLE_NONE */
} near_planes;

/* Sets the plane of a row. Only a vertex/triangle row has one, made for the start, between a vertex
 * that moves and a scripted obstacle, that pushes along the shortest line. ends [m]: predicted
 * positions. */
void make_near_plane(const contact_scene *scene, const double *ends, const contact_row *row,
                     near_plane *plane);

/* Whether the obstacle's feature of the row lies behind the planes that are nearest to its vertices
 * of cloth or of a free body. Rows that keep the vertices in front of these planes keep them away
 * from the feature, too. So each vertex has one row on a flat obstacle, and nothing stops at the
 * rim of a triangle that lies flush with its neighbour without sharing vertices. The nearest row of
 * a vertex is never hidden. Of the row only kind, vertices, weights and is_old are read; `index` is
 * its number. */
bool row_is_hidden(const contact_scene *scene, const double *ends, const near_planes *planes,
                   const contact_row *row, size_t index);

#endif
