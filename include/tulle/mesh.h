/* tulle/mesh.h - triangle meshes that own their memory, validation, and generated shapes. */
#ifndef TULLE_MESH_H
#define TULLE_MESH_H

#include "tulle/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A triangle mesh that owns its arrays. Release with tulle_mesh_destroy. A zeroed struct is an
 * empty mesh. */
typedef struct tulle_mesh {
    double *positions; /* [m], 3 * vertex_count */
    size_t vertex_count;
    uint32_t *triangles; /* 3 * triangle_count */
    size_t triangle_count;
} tulle_mesh;

/* Makes a mesh with uninitialised arrays of the given sizes. Limit: 2^31 - 1 each
 * (TULLE_ERROR_LIMIT). */
TULLE_API tulle_status tulle_mesh_create(size_t vertex_count, size_t triangle_count,
                                         tulle_mesh *mesh, tulle_error *error);
/* Releases the arrays and zeroes the struct. Null and empty meshes are fine. */
TULLE_API void tulle_mesh_destroy(tulle_mesh *mesh);
/* The mesh as a borrowed view. */
TULLE_API tulle_mesh_view tulle_mesh_get_view(const tulle_mesh *mesh);

/* Applies x -> translation + R * (scale * x), R from unit quaternion rotation (w, x, y, z). scale:
 * per axis, > 0. */
TULLE_API void tulle_mesh_transform(tulle_mesh *mesh, const double scale[3],
                                    const double rotation[4], const double translation[3]);

/* What a mesh is to be used for: cloth must be an oriented 2-manifold (with or without boundary,
 * any number of pieces); an obstacle may be any set of non-degenerate triangles. */
typedef enum tulle_mesh_role { TULLE_MESH_ROLE_CLOTH, TULLE_MESH_ROLE_OBSTACLE } tulle_mesh_role;

/* Refuses meshes that cannot be simulated, naming the first offender (index, coordinates) and how
 * many there are: no triangles, NaN or infinite coordinates, indices out of range, a triangle that
 * uses a vertex twice, zero-area or needle-thin triangles (height under 1e-9 of the longest edge),
 * duplicate triangles, and for cloth: edges with more than two triangles, neighbours with opposite
 * orientation, vertices whose triangles do not form one fan, unreferenced vertices. Errors:
 * TULLE_ERROR_INVALID_MESH, TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_mesh_validate(tulle_mesh_view mesh, tulle_mesh_role role,
                                           tulle_error *error);

/* Counts and quality of a mesh, for reports. Needs valid indices; otherwise any triangle soup. */
typedef struct tulle_mesh_info {
    size_t vertex_count, triangle_count, edge_count;
    size_t boundary_edge_count;    /* edges with one triangle */
    size_t boundary_loop_count;    /* closed loops of boundary edges */
    size_t nonmanifold_edge_count; /* edges with three or more triangles */
    size_t unreferenced_vertex_count;
    size_t degenerate_triangle_count;    /* repeated vertex or zero area */
    size_t component_count;              /* edge-connected pieces, of triangles */
    long euler_characteristic;           /* V - E + F over referenced vertices */
    double bounds_min[3], bounds_max[3]; /* [m] */
    double area;                         /* [m^2] */
    double edge_length_min, edge_length_mean, edge_length_max; /* [m] */
    double angle_min;                                          /* [rad] smallest corner angle */
} tulle_mesh_info;
TULLE_API tulle_status tulle_mesh_get_info(tulle_mesh_view mesh, tulle_mesh_info *info,
                                           tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
