/* contact/rows/normal_cones.h - the normal cone of a feature: the directions from which a nearest
 * point can touch it. */
#ifndef TULLE_CONTACT_ROWS_NORMAL_CONES_H
#define TULLE_CONTACT_ROWS_NORMAL_CONES_H

#include "contact/contact_types.h"

/* A weight below this is zero: the nearest point is on the rim. */
static const double RIM_WEIGHT = 1e-9;

/* Where on its triangle a vertex/triangle row touches. */
typedef enum rim_part { RIM_INSIDE, RIM_EDGE, RIM_VERTEX } rim_part;

/* Sets *feature to the edge or the vertex of the triangle that the row touches, if any. */
rim_part find_rim_part(const topology *topo, const contact_row *row, uint32_t *feature);

/* The mean normal of a vertex's triangles, each weighted by its area, at time `time` along
 * x0 -> x1. Unit, or zero where they cancel. */
vec3 compute_vertex_normal(const contact_scene *scene, const double *x1, double time,
                           uint32_t vertex);

/* A direction near `normal` in which the row's feature that is not of cloth can be touched, at time
 * `time` along x0 -> x1; `normal` itself if it can. A flat can be touched in one direction only,
 * even if an edge or a vertex of it is nearest. A hollow edge or vertex gives the mean normal of
 * its triangles. Unit, or zero where these cancel. */
vec3 fit_normal_to_cone(const contact_scene *scene, const double *x1, const contact_row *row,
                        vec3 normal, double time);

#endif
