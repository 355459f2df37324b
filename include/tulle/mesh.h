/* tulle/mesh.h - triangle meshes that own their memory, and their validation. */
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
 * not initialised. Errors: TULLE_ERROR_INVALID_ARGUMENT (null), TULLE_ERROR_LIMIT (more than 2^31 -
 * 1 of either), TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_mesh_create(size_t vertex_count, size_t triangle_count,
                                         tulle_mesh *mesh, tulle_error *error);
/* Releases the arrays and zeroes the struct. Null and empty meshes are fine. */
TULLE_API void tulle_mesh_destroy(tulle_mesh *mesh);
/* The mesh as a borrowed view. Null gives an empty view. */
TULLE_API tulle_mesh_view tulle_mesh_get_view(const tulle_mesh *mesh);

/* Moves every vertex x to translation + R (scale * x). `scale`: a factor for each axis, not 0;
 * `rotation`: R as a unit quaternion w, x, y, z; `translation`: [m]. If one of the four is null,
 * the mesh stays as it is. If the product of the factors is negative, the mesh is mirrored. The
 * last two corners of each triangle then change places, so that outer sides stay outer sides. */
TULLE_API void tulle_mesh_transform(tulle_mesh *mesh, const double scale[3],
                                    const double rotation[4], const double translation[3]);

/* What a mesh is used for. */
typedef enum tulle_mesh_role {
    /* an oriented 2-manifold, with or without boundary, in any number of pieces */
    TULLE_MESH_ROLE_CLOTH,
    TULLE_MESH_ROLE_OBSTACLE, /* any set of triangles that have an area */
    /* an obstacle whose vertices move separately: its triangles may lose their area at times */
    TULLE_MESH_ROLE_DEFORMING
} tulle_mesh_role;

/* Refuses a mesh that cannot be simulated. The message names the first fault, with its index and
 * coordinates, and how many there are. All meshes: no triangles, NaN or infinite coordinates,
 * indices out of range, a triangle that uses a vertex twice, duplicate triangles. All but deforming
 * obstacles: triangles that have no area or are needle-thin (height under 1e-9 of the longest
 * edge). Cloth: edges with more than two triangles, neighbours with opposite orientation,
 * unreferenced vertices; vertices whose triangles do not form one fan; triangles lower than four
 * steps of float at half the mesh's size. The distance from the origin does not matter here: the
 * start of a world judges cloth at its place. Errors: TULLE_ERROR_INVALID_MESH,
 * TULLE_ERROR_INVALID_ARGUMENT (an array of the view is null, no such role), TULLE_ERROR_LIMIT
 * (more than 2^31 - 1 vertices or triangles), TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_mesh_validate(tulle_mesh_view mesh, tulle_mesh_role role,
                                           tulle_error *error);

/* Where the parts of a mesh stand in the text file it was read from. */
typedef struct tulle_mesh_lines {
    const uint32_t *vertices;  /* line of each vertex, from 1; null: not known */
    const uint32_t *triangles; /* line of each triangle, from 1; null: not known */
} tulle_mesh_lines;
/* As tulle_mesh_validate. The message also gives the lines of the vertices and triangles that it
 * names, and error->line is the line of the first fault. */
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
/* Keeps only the first of triangles with the same three corners, in any order. `lines`: null, or an
 * entry for each triangle, which moves with its triangle. Errors: TULLE_ERROR_OUT_OF_MEMORY (the
 * mesh is as before), TULLE_ERROR_INVALID_ARGUMENT (a mesh, triangles or `duplicates` that are
 * null). */
TULLE_API tulle_status tulle_mesh_drop_duplicates(tulle_mesh *mesh, uint32_t *lines,
                                                  tulle_mesh_duplicates *duplicates,
                                                  tulle_error *error);

/* Marks with 1 each triangle that has no area, is needle-thin or uses a vertex twice, as
 * tulle_mesh_validate refuses them, and with 0 all others. `marks`: triangle_count bytes. `count`,
 * which may be null: how many there are. Errors: TULLE_ERROR_INVALID_MESH (an index out of range),
 * TULLE_ERROR_INVALID_ARGUMENT (null), TULLE_ERROR_LIMIT (more than 2^31 - 1 vertices or
 * triangles). */
TULLE_API tulle_status tulle_mesh_find_degenerate(tulle_mesh_view mesh, uint8_t *marks,
                                                  size_t *count, tulle_error *error);
/* Drops the marked triangles; the vertices stay. `marks`: triangle_count bytes. `lines`: null, or
 * an entry for each triangle, which moves with its triangle. Errors: TULLE_ERROR_OUT_OF_MEMORY (the
 * mesh is as before), TULLE_ERROR_INVALID_ARGUMENT (a mesh, triangles or marks that are null). */
TULLE_API tulle_status tulle_mesh_drop_marked(tulle_mesh *mesh, const uint8_t *marks,
                                              uint32_t *lines, tulle_error *error);

/* What tulle_mesh_repair does. */
typedef enum tulle_repair {
    TULLE_REPAIR_DEGENERATE, /* a triangle without area was dropped, a needle closed */
    TULLE_REPAIR_DUPLICATE,  /* a triangle with the same corners as another one was dropped */
    TULLE_REPAIR_JOINED,     /* a boundary vertex was joined with one in the same place */
    TULLE_REPAIR_T_JUNCTION, /* a boundary edge was split at a vertex that lay on it */
    TULLE_REPAIR_EDGE,       /* an edge had three triangles or more; two stay joined there */
    TULLE_REPAIR_CUT,        /* a fan of triangles got a vertex of its own, a little inwards */
    TULLE_REPAIR_TURNED,     /* a triangle was turned over */
    TULLE_REPAIR_LOOSE,      /* a vertex that no triangle has was left out */
    TULLE_REPAIR_COUNT       /* how many kinds there are */
} tulle_repair;
/* How often each repair was done, and where first. */
typedef struct tulle_mesh_repairs {
    size_t counts[TULLE_REPAIR_COUNT];     /* by tulle_repair */
    double places[3 * TULLE_REPAIR_COUNT]; /* [m] of the first of each kind */
} tulle_mesh_repairs;
/* Makes a mesh fit for cloth:
 * - drops triangles without area and duplicates;
 * - joins boundary vertices in the same place;
 * - splits boundary edges at vertices of other boundaries that lie on them;
 * - cuts edges with three or more triangles and vertices with several fans (bow ties);
 * - turns triangles to the side of most triangles of their piece;
 * - leaves out vertices without a triangle.
 *
 * Numbers of vertices and triangles change. `tolerance` [m], 0 or more: the largest distance of
 * boundaries that are joined; at an edge at least 1e-9 of its length counts. Touching surfaces
 * intersect, so a part that is cut off moves inwards: by a hundredth of its shortest edge there, at
 * least twice the tolerance. A surface with only one side (a Möbius strip) keeps it, and moved
 * vertices may cause intersections: check with tulle_mesh_validate and tulle_check_intersections. A
 * second call does nothing if edges are far longer than the tolerance. The result may be empty.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (null, the tolerance), TULLE_ERROR_INVALID_MESH (an index
 * out of range, a coordinate that is not finite), TULLE_ERROR_LIMIT, TULLE_ERROR_OUT_OF_MEMORY; the
 * mesh is then as before. */
TULLE_API tulle_status tulle_mesh_repair(tulle_mesh *mesh, double tolerance,
                                         tulle_mesh_repairs *repairs, tulle_error *error);

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
 * TULLE_ERROR_INVALID_ARGUMENT (null), TULLE_ERROR_LIMIT (more than 2^31 - 1 vertices or
 * triangles), TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_mesh_get_info(tulle_mesh_view mesh, tulle_mesh_info *info,
                                           tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
