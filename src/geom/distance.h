/* geom/distance.h - closest points of vertex and triangle, and of two edges. Robust for degenerate
 * and parallel input. Based on: Ericson, Real-Time Collision Detection, 2005, 5.1. */
#ifndef TULLE_GEOM_DISTANCE_H
#define TULLE_GEOM_DISTANCE_H

#include "math/vec3.h"

typedef enum feature_kind {
    FEATURE_VERTEX_TRIANGLE, /* four points: vertex, triangle corners */
    FEATURE_EDGE_EDGE        /* four points: first edge's ends, second edge's ends */
} feature_kind;

/* The closest points of a pair. With signed weights w the vector from the second feature to the
 * first is difference = sum w[i] p[i]; vertex/triangle: w = (1, -b0, -b1, -b2); edge/edge: w =
 * (1-s, s, -(1-t), -t). */
typedef struct closest_points {
    double weights[4];
    vec3 difference;  /* [m] */
    double distance2; /* [m^2] |difference|^2 */
} closest_points;

closest_points closest_vertex_triangle(const vec3 points[4]);
closest_points closest_edge_edge(const vec3 points[4]);
closest_points closest_of_pair(feature_kind kind, const vec3 points[4]);

/* Where the normal equations are used; whoever computes eight pairs at once must decide alike.
 *
 * [squared sine, or (height / longest edge)^2] Directions are well apart above this: the equations
 * then lose a factor of 20 of the 2e-16 that doubles give. */
static const double SOUND_RATIO = 0.05;
/* [m^4] Determinants below this may have lost digits to underflow. */
static const double DETERMINANT_MIN = 1e-280;

#endif
