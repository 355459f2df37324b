/* geom/cut_polygon.h - cuts polygons into triangles that lie within them.
 *
 * Inputs: positions, and a polygon of n corners given as its fan: the n - 2 triangles around the
 * first corner. Outputs: n - 2 triangles of the same corners, in the place of the fan. A fan that
 * lies within its polygon and has no sliver stays as it is; this holds for triangles and nearly all
 * convex polygons. Every other polygon is cut: concave polygons, those with a corner on a straight
 * side, those with holes that a bridge joins to the rim. No triangle of the cut lacks area unless
 * the polygon has a side without length.
 *
 * A polygon that crosses itself keeps its fan. A polygon that is not flat is cut as seen along its
 * mean normal. Both are counted for the reader.
 *
 * The cut depends on the positions alone, by arithmetic in a fixed order.
 *
 * Based on: G. H. Meisters, "Polygons Have Ears", 1975, for the cut; C. L. Lawson, "Software for C1
 * Surface Interpolation", 1977, for the exchange of diagonals that makes its smallest angle as
 * large as possible. The signs are exact: geom/exact_predicates.h. */
#ifndef TULLE_GEOM_CUT_POLYGON_H
#define TULLE_GEOM_CUT_POLYGON_H

#include "base/memory.h"

#include <stdint.h>

enum {
    POLYGON_CORNER_LIMIT = 10000 /* of a polygon that is cut: the time grows with the square */
};

/* Zeroed but for its heap, path and place. */
typedef struct polygon_cutter {
    memory *heap;
    const char *path;  /* of the file, for errors */
    const char *place; /* what `number` counts: "line", "face" */
    uint64_t number;   /* of the polygon at hand */
    /* Polygons so far that are not flat, and those that cross themselves or have no area. */
    size_t bent_count, crossed_count;
    uint64_t first_bent, first_crossed; /* numbers */
    /* Of each corner of each triangle its number in the polygon; null where the fan stayed. */
    const uint32_t *corners;
    void *room; /* as large as the largest polygon so far needs */
    size_t room_size;
} polygon_cutter;

/* Cuts a polygon of triangle_count + 2 corners, whose fan `triangles` holds, in place. Errors leave
 * the fan: TULLE_ERROR_LIMIT for too many corners, TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status polygon_cut(polygon_cutter *cutter, const double *positions, uint32_t *triangles,
                         size_t triangle_count, tulle_error *error);
void polygon_cutter_destroy(polygon_cutter *cutter);

/* A polygon of more than three corners. */
typedef struct polygon_fan {
    size_t first;           /* triangle */
    uint32_t count, number; /* triangles; as of the cutter */
    bool is_turned;         /* written by polygons_cut */
} polygon_fan;

typedef struct polygon_list {
    const double *positions;
    uint32_t *triangles, *corner_uvs; /* of the whole mesh; the latter, one per corner, or null */
    polygon_fan *fans;
    size_t fan_count;
} polygon_list;

/* Cuts polygons, and moves the texture coordinates of their corners along. Polygons whose corners
 * lie in the same places, in the same or the opposite order, are cut along the same diagonals, so
 * that their triangles are duplicates. Errors as of polygon_cut. */
tulle_status polygons_cut(polygon_cutter *cutter, const polygon_list *list, tulle_error *error);

/* "2 polygons are not flat (the first in line 12), ..." to `text`; empty where there is nothing to
 * tell. */
void polygon_cutter_describe(const polygon_cutter *cutter, char *text, size_t size);

#endif
