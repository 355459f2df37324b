/* geom/mesh_indices.h - whether the triangles of a mesh name its vertices. */
#ifndef TULLE_GEOM_MESH_INDICES_H
#define TULLE_GEOM_MESH_INDICES_H

#include "tulle/base.h"

/* Most vertices, and most triangles, of a mesh. */
#define MESH_COUNT_MAX ((size_t)INT32_MAX)

/* TULLE_ERROR_INVALID_MESH names the first triangle with an index that is not below vertex_count;
 * also refuses null arrays (INVALID_ARGUMENT) and counts over MESH_COUNT_MAX (LIMIT). */
tulle_status mesh_check_indices(tulle_mesh_view mesh, tulle_error *error);

#endif
