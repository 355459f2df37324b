/* contact/rows/normal_cones.h - the directions in which a feature can be touched. */
#ifndef TULLE_CONTACT_ROWS_NORMAL_CONES_H
#define TULLE_CONTACT_ROWS_NORMAL_CONES_H

#include "contact/contact_types.h"

/* A weight below this is zero: the nearest point is on the rim. */
static const double RIM_WEIGHT = 1e-9;

/* Where on its triangle a vertex/triangle row touches. */
typedef enum rim_part { RIM_INSIDE, RIM_EDGE, RIM_VERTEX } rim_part;

/* Sets *feature to the edge or the vertex of the triangle that the row touches, if any. */
rim_part find_rim_part(const topology *topo, const contact_row *row, uint32_t *feature);

/* `normal`, or one near to it in the normal cone of the row's feature that is not of cloth, at time
 * `time` along x0 -> x1. Inside a flat that cone is a single direction: what is nearest to an edge
 * or a vertex there is pushed the same way as what is nearest to a triangle. In a hollow: the mean
 * normal of the feature's triangles. Unit, or zero where these cancel. */
vec3 fit_normal_to_cone(const contact_scene *scene, const double *x1, const contact_row *row,
                        vec3 normal, double time);

#endif
