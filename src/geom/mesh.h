/* geom/mesh.h - the checks and counts behind tulle/mesh.h with scratch memory from a given heap,
 * and the fans of triangles around vertices that they share. */
#ifndef TULLE_GEOM_MESH_H
#define TULLE_GEOM_MESH_H

#include "geom/mesh_indices.h"
#include "geom/topology.h"
#include "tulle/mesh.h"

/* [of the longest edge] A triangle with a smaller height has no usable normal: its coordinates'
 * own rounding, 1e-16 of a mesh 1e5 edges wide, would turn it by a tenth of a radian. */
static const double THIN_TRIANGLE_RATIO = 1e-9;

/* As tulle_mesh_validate_lines and tulle_mesh_get_info. */
tulle_status mesh_validate(memory *heap, tulle_mesh_view mesh, tulle_mesh_role role,
                           tulle_mesh_lines lines, tulle_error *error);
tulle_status mesh_get_info(memory *heap, tulle_mesh_view mesh, tulle_mesh_info *info,
                           tulle_error *error);

/* Of each triangle that has the same three corners as one of a lower number: the lowest such
 * number; of all others TULLE_NONE. `originals` has room for each triangle. False when memory is
 * short. */
bool mesh_find_duplicates(memory *heap, tulle_mesh_view mesh, uint32_t *originals,
                          size_t *duplicate_count);

/* Height over the longest edge divided by that edge: sqrt(3)/2 for an equilateral triangle, 0
 * without area. Safe from overflow and underflow for coordinates under 1e300. */
double triangle_get_height_ratio(const double *positions, const uint32_t corners[3]);

/* Joins the corners (3 * triangle + k) of one vertex that meet across an edge with exactly two
 * triangles; each remaining set is one fan. edge_use_counts: triangles on each edge. */
void mesh_join_fans(const topology *topo, const uint32_t *edge_use_counts, uint32_t *fans);

#endif
