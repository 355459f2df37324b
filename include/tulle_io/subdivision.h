/* tulle_io/subdivision.h - smooth subdivision of triangle meshes by Loop's scheme. */
#ifndef TULLE_IO_SUBDIVISION_H
#define TULLE_IO_SUBDIVISION_H

#include "tulle/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Settings of a Loop subdivision. Made by tulle_subdivision_def_default. docs/method/subdivision.md
 * has the rules. */
typedef struct tulle_subdivision_def {
    uint32_t cookie; /* set by tulle_subdivision_def_default, checked on use */
    int levels;      /* 1 .. TULLE_SUBDIVISION_LEVELS_MAX; each makes four triangles of one */
    /* [rad] > 0: edges whose two triangles' normals differ by more are creases, which stay sharp;
     * default INFINITY: only the edges below */
    double crease_angle;
    /* [rad] > 0: a vertex at which a border or a crease turns by more is a corner, which stays in
     * its place; default 75 degrees (a square's corners stay, a regular pentagon is rounded);
     * INFINITY: borders are rounded everywhere */
    double corner_angle;
    const uint32_t *crease_edges; /* 2 * crease_edge_count: vertices; further creases */
    size_t crease_edge_count;     /* length of `crease_edges` in edges */
    int is_limit; /* not 0 (default): resulting vertices lie on the limit surface; 0: they are the
                     vertices of the last control mesh, a little outside of it */
} tulle_subdivision_def;

/* Most levels of a subdivision. */
#define TULLE_SUBDIVISION_LEVELS_MAX 6
/* Most triangles of a result; making its operator takes some 2.5 GB. */
#define TULLE_SUBDIVISION_TRIANGLES_MAX (1 << 24)

/* Two levels, no creases by angle, corners from 75 degrees on, vertices on the limit surface. */
TULLE_API tulle_subdivision_def tulle_subdivision_def_default(void);

/* Turns values at the vertices of one mesh into values at the vertices of the subdivided mesh.
 * Depends on the triangles and on which edges and vertices are sharp, so one operator serves all
 * frames of a sequence. Immutable: any number of threads may use one. */
typedef struct tulle_subdivision tulle_subdivision;

/* Makes the operator; release with tulle_subdivision_destroy. The angles of the def are measured in
 * mesh.positions (give the rest shape of cloth, so that its folds do not count as creases).
 * Borders, edges of three or more triangles, and edges whose two triangles have opposite
 * orientation are always sharp. Vertices of three or more sharp edges, and vertices where several
 * fans meet, are always corners. Vertices without triangles stay where they are. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, a def field out of range, a crease edge that no triangle
 * has), TULLE_ERROR_INVALID_MESH (indices out of range, coordinates not finite, a triangle that
 * uses a vertex twice), TULLE_ERROR_LIMIT (more than TULLE_SUBDIVISION_TRIANGLES_MAX triangles or
 * 2^31 - 1 vertices in the result), TULLE_ERROR_OUT_OF_MEMORY; *subdivision is then null. */
TULLE_API tulle_status tulle_subdivision_create(tulle_mesh_view mesh,
                                                const tulle_subdivision_def *def,
                                                tulle_subdivision **subdivision,
                                                tulle_error *error);
TULLE_API void tulle_subdivision_destroy(tulle_subdivision *subdivision); /* null is fine */

/* Number of vertices of the result. The vertices of the mesh come first, under their own numbers.
 * 0 for null. */
TULLE_API size_t tulle_subdivision_get_vertex_count(const tulle_subdivision *subdivision);
/* Number of triangles of the result; 0 for null. */
TULLE_API size_t tulle_subdivision_get_triangle_count(const tulle_subdivision *subdivision);
/* Triangles of the result: 3 * triangle_count vertex indices, oriented as in the mesh; owned by the
 * operator. Null for null. */
TULLE_API const uint32_t *tulle_subdivision_get_triangles(const tulle_subdivision *subdivision);
/* The triangle of the mesh that a triangle of the result is a part of; TULLE_NONE out of range and
 * for null. */
TULLE_API uint32_t tulle_subdivision_get_parent_triangle(const tulle_subdivision *subdivision,
                                                         uint32_t triangle);

/* values: component_count (1 .. 16) doubles for each vertex of the mesh. They may be positions (3)
 * or anything else to be smoothed alike, such as texture coordinates and colours. result: as many
 * for each vertex of the subdivided mesh; must not overlap values. Every result is a sum of values
 * whose weights sum to one, with the same bits on every call. Errors: TULLE_ERROR_INVALID_ARGUMENT
 * (null, component_count), TULLE_ERROR_OUT_OF_MEMORY (scratch). */
TULLE_API tulle_status tulle_subdivision_apply(const tulle_subdivision *subdivision,
                                               const double *values, size_t component_count,
                                               double *result, tulle_error *error);
/* The whole subdivided mesh for the given positions, 3 for each vertex of the mesh; release it with
 * tulle_mesh_destroy. Errors as of tulle_subdivision_apply. */
TULLE_API tulle_status tulle_subdivision_make_mesh(const tulle_subdivision *subdivision,
                                                   const double *positions, tulle_mesh *mesh,
                                                   tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
