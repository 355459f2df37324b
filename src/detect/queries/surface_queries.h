/* detect/queries/surface_queries.h - the first triangle on a ray, and the point of a surface that
 * is nearest to a place. Each is made once and put to the trees of all surfaces that count
 * (query_tree_visit); then it holds the answer. */
#ifndef TULLE_DETECT_QUERIES_SURFACE_QUERIES_H
#define TULLE_DETECT_QUERIES_SURFACE_QUERIES_H

#include "detect/queries/query_trees.h"

/* What was found. */
typedef struct surface_hit {
    uint32_t triangle; /* TULLE_NONE: nothing */
    double weights[3]; /* of its corners: not negative, their sum is 1 but for rounding */
    vec3 position;     /* [m] */
    double distance;   /* [m] */
} surface_hit;

typedef struct ray_query {
    tree_query query; /* its reach: the part of the way at which the hit lies */
    const uint32_t *corners;
    const double *positions;
    double from[3], to[3];     /* [m] */
    double low[3], high[3];    /* [m] the box of the way */
    double way[3], inv_way[3]; /* [m], [1/m]; inv_way 0: too short to divide by */
    double unit[3];            /* the direction */
    double length;             /* [m] */
    bool skips_back_faces;
    surface_hit hit;
} ray_query;
ray_query ray_query_make(const uint32_t *corners, const double *positions, const double from[3],
                         const double to[3], bool skips_back_faces);

typedef struct nearest_query {
    tree_query query; /* its reach: [m^2] the squared distance, widened against rounding */
    const uint32_t *corners;
    const double *positions;
    vec3 point;     /* [m] */
    double nearest; /* [m^2] */
    surface_hit hit;
} nearest_query;
/* max_distance [m] may be INFINITY. */
nearest_query nearest_query_make(const uint32_t *corners, const double *positions, vec3 point,
                                 double max_distance);

#endif
