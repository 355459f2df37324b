/* tulle/mesh.h - triangle meshes that own their memory, validation, and smooth subdivision. */
#ifndef TULLE_MESH_H
#define TULLE_MESH_H

#include "tulle/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A triangle mesh that owns its arrays. Release with tulle_mesh_destroy. A zeroed struct is an
 * empty mesh. */
typedef struct tulle_mesh {
    double *positions;     /* [m], 3 * vertex_count */
    size_t vertex_count;   /* number of vertices */
    uint32_t *triangles;   /* 3 * triangle_count vertex indices, counterclockwise from outside */
    size_t triangle_count; /* number of triangles */
} tulle_mesh;

/* Makes a mesh with room for `vertex_count` vertices and `triangle_count` triangles; the arrays are
 * not initialised. Errors: TULLE_ERROR_LIMIT (over 2^31 - 1 of either), TULLE_ERROR_OUT_OF_MEMORY.
 */
TULLE_API tulle_status tulle_mesh_create(size_t vertex_count, size_t triangle_count,
                                         tulle_mesh *mesh, tulle_error *error);
/* Releases the arrays and zeroes the struct. Null and empty meshes are fine. */
TULLE_API void tulle_mesh_destroy(tulle_mesh *mesh);
/* The mesh as a borrowed view. */
TULLE_API tulle_mesh_view tulle_mesh_get_view(const tulle_mesh *mesh);

/* Moves every vertex x to translation + R (scale * x). `scale`: a factor > 0 for each axis;
 * `rotation`: R as a unit quaternion w, x, y, z; `translation`: [m]. */
TULLE_API void tulle_mesh_transform(tulle_mesh *mesh, const double scale[3],
                                    const double rotation[4], const double translation[3]);

/* What a mesh is used for. */
typedef enum tulle_mesh_role {
    /* an oriented 2-manifold, with or without boundary, in any number of pieces */
    TULLE_MESH_ROLE_CLOTH,
    TULLE_MESH_ROLE_OBSTACLE /* any set of triangles that have an area */
} tulle_mesh_role;

/* Refuses a mesh that cannot be simulated. The message names the first offender, with its index and
 * coordinates, and how many there are. Refused are: no triangles, NaN or infinite coordinates,
 * indices out of range, a triangle that uses a vertex twice, zero-area or needle-thin triangles
 * (height under 1e-9 of the longest edge), duplicate triangles, and for cloth: edges with more than
 * two triangles, neighbours with opposite orientation, vertices whose triangles do not form one
 * fan, unreferenced vertices. Errors: TULLE_ERROR_INVALID_MESH, TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_mesh_validate(tulle_mesh_view mesh, tulle_mesh_role role,
                                           tulle_error *error);

/* Where the parts of a mesh stand in the text file it was read from. */
typedef struct tulle_mesh_lines {
    const uint32_t *vertices;  /* line of each vertex, from 1; null: not known */
    const uint32_t *triangles; /* line of each triangle, from 1; null: not known */
} tulle_mesh_lines;
/* As tulle_mesh_validate. The message also names the lines of the vertices and triangles it speaks
 * of, and error->line is that of the first offender. */
TULLE_API tulle_status tulle_mesh_validate_lines(tulle_mesh_view mesh, tulle_mesh_role role,
                                                 tulle_mesh_lines lines, tulle_error *error);

/* What tulle_mesh_drop_duplicates found. */
typedef struct tulle_mesh_duplicates {
    size_t count;      /* triangles that were dropped */
    uint32_t dropped;  /* the first of them, by its number before */
    uint32_t original; /* the triangle with the same corners that was kept, by its number before */
    uint32_t dropped_line;  /* the entry of `lines` for `dropped`; 0 where lines are null */
    uint32_t original_line; /* the entry of `lines` for `original`; 0 where lines are null */
} tulle_mesh_duplicates;
/* Of triangles with the same three corners, in whatever order, only the first is kept. `lines`: an
 * entry for each triangle that is moved along with it, or null. Errors: TULLE_ERROR_OUT_OF_MEMORY
 * (the mesh is as before), TULLE_ERROR_INVALID_ARGUMENT. */
TULLE_API tulle_status tulle_mesh_drop_duplicates(tulle_mesh *mesh, uint32_t *lines,
                                                  tulle_mesh_duplicates *duplicates,
                                                  tulle_error *error);

/* Counts and quality of a mesh, for reports. Needs valid indices; otherwise any triangle soup. */
typedef struct tulle_mesh_info {
    size_t vertex_count;              /* number of vertices */
    size_t triangle_count;            /* number of triangles */
    size_t edge_count;                /* number of edges */
    size_t boundary_edge_count;       /* edges with one triangle */
    size_t boundary_loop_count;       /* closed loops of boundary edges */
    size_t nonmanifold_edge_count;    /* edges with three or more triangles */
    size_t unreferenced_vertex_count; /* vertices without a triangle */
    size_t degenerate_triangle_count; /* repeated vertex or zero area */
    size_t component_count;           /* edge-connected pieces, of triangles */
    long euler_characteristic;        /* V - E + F over referenced vertices */
    double bounds_min[3];             /* [m] lowest corner */
    double bounds_max[3];             /* [m] highest corner */
    double area;                      /* [m^2] */
    double edge_length_min;           /* [m] shortest edge */
    double edge_length_mean;          /* [m] mean over all edges */
    double edge_length_max;           /* [m] longest edge */
    double angle_min;                 /* [rad] smallest corner angle */
} tulle_mesh_info;
/* Measures a mesh. Errors: TULLE_ERROR_INVALID_MESH (an index out of range),
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_mesh_get_info(tulle_mesh_view mesh, tulle_mesh_info *info,
                                           tulle_error *error);

/* Settings of a Loop subdivision. Made by tulle_subdivision_def_default. docs/method/subdivision.md
 * tells the rules. */
typedef struct tulle_subdivision_def {
    uint32_t cookie; /* set by tulle_subdivision_def_default, checked on use */
    int levels;      /* 1 .. TULLE_SUBDIVISION_LEVELS_MAX; each makes four triangles of one */
    /* [rad] > 0: edges whose two triangles' normals differ by more are creases, which stay sharp;
     * default INFINITY: only the edges below */
    double crease_angle;
    /* [rad] > 0: where a border or a crease turns by more, its vertex is a corner, which stays
     * where it is; default 75 degrees (a square's corners stay, a regular pentagon is rounded);
     * INFINITY: borders are rounded everywhere */
    double corner_angle;
    const uint32_t *crease_edges; /* further creases: 2 * crease_edge_count vertices of the mesh */
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
 * mesh.positions (give the rest shape of cloth, so that folds are no creases). Always sharp are
 * borders, edges of three or more triangles, and edges whose two triangles have opposite
 * orientation; always corners are vertices of three or more sharp edges, or in which several fans
 * meet. Vertices without triangles stay where they are. Errors: TULLE_ERROR_INVALID_ARGUMENT (a def
 * field out of range, a crease edge that no triangle has), TULLE_ERROR_INVALID_MESH (indices out of
 * range, coordinates not finite, a triangle that uses a vertex twice), TULLE_ERROR_LIMIT (result
 * over TULLE_SUBDIVISION_TRIANGLES_MAX triangles or 2^31 - 1 vertices), TULLE_ERROR_OUT_OF_MEMORY;
 * *subdivision is then null. */
TULLE_API tulle_status tulle_subdivision_create(tulle_mesh_view mesh,
                                                const tulle_subdivision_def *def,
                                                tulle_subdivision **subdivision,
                                                tulle_error *error);
TULLE_API void tulle_subdivision_destroy(tulle_subdivision *subdivision); /* null is fine */

/* Number of vertices of the result. The vertices of the mesh come first, under their own numbers.
 */
TULLE_API size_t tulle_subdivision_get_vertex_count(const tulle_subdivision *subdivision);
/* Number of triangles of the result. */
TULLE_API size_t tulle_subdivision_get_triangle_count(const tulle_subdivision *subdivision);
/* Triangles of the result: 3 * triangle_count vertex indices, oriented as those of the mesh; owned
 * by the operator. */
TULLE_API const uint32_t *tulle_subdivision_get_triangles(const tulle_subdivision *subdivision);
/* The triangle of the mesh that a triangle of the result is a part of. */
TULLE_API uint32_t tulle_subdivision_get_parent_triangle(const tulle_subdivision *subdivision,
                                                         uint32_t triangle);

/* values: component_count (1 .. 16) doubles for each vertex of the mesh: positions (3), or anything
 * else to be smoothed alike, such as texture coordinates and colours. result: the same for each
 * vertex of the subdivided mesh; must not overlap values. Every result is a sum of values
 * whose weights sum to one, with the same bits on every call. Errors: TULLE_ERROR_INVALID_ARGUMENT,
 * TULLE_ERROR_OUT_OF_MEMORY (scratch). */
TULLE_API tulle_status tulle_subdivision_apply(const tulle_subdivision *subdivision,
                                               const double *values, size_t component_count,
                                               double *result, tulle_error *error);
/* The whole subdivided mesh for the given positions, 3 for each vertex of the mesh. */
TULLE_API tulle_status tulle_subdivision_make_mesh(const tulle_subdivision *subdivision,
                                                   const double *positions, tulle_mesh *mesh,
                                                   tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
