/* tulle/query.h - questions to a world. Which surface does a ray hit? Which point is nearest? Which
 * triangles lie in a box or cross a mesh? Positions, normals, forces and strains are copied in the
 * form that a host wants. Filters choose which objects collide.
 *
 * Queries see the accepted state and the objects that are present in it. They change neither the
 * state nor its hash nor any later step. They use a tree of boxes over each object. The boxes fit
 * one state. The first query after a step or a load fits them again, at the cost of one pass over
 * all vertices; so does tulle_world_update_queries. The very first query builds the trees. After
 * that, the time of a query grows with the logarithm of the number of triangles and with the number
 * of results. docs/guide/embed.md has times, and examples/pick_and_drag.c is a whole program.
 *
 * Threads: one thread at a time may use a world, queries included, with one exception. After
 * tulle_world_update_queries, any number of threads may call these at the same time:
 * tulle_world_cast_ray, tulle_world_find_closest_point, tulle_world_find_box_overlaps,
 * tulle_world_find_mesh_overlaps and all functions that take a const tulle_world. Any other call
 * ends this.  */
#ifndef TULLE_QUERY_H
#define TULLE_QUERY_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- objects ---- */

/* What an object is. */
typedef enum tulle_object_kind {
    TULLE_OBJECT_NONE,    /* no object */
    TULLE_OBJECT_CLOTH,   /* a cloth */
    TULLE_OBJECT_OBSTACLE /* an obstacle or a rigid body */
} tulle_object_kind;
/* Names a cloth or an obstacle of a world. All zero names none. */
typedef struct tulle_object_id {
    tulle_object_kind kind; /* cloth or obstacle: the kind of the id below */
    uint32_t index;         /* of tulle_cloth_id or tulle_obstacle_id */
    uint32_t generation;    /* of that id */
} tulle_object_id;
/* The cloth as an object. */
TULLE_API tulle_object_id tulle_object_from_cloth(tulle_cloth_id id);
/* The obstacle as an object. */
TULLE_API tulle_object_id tulle_object_from_obstacle(tulle_obstacle_id id);
/* The object that tulle_contact and tulle_intersection call by this number: cloths come first, then
 * obstacles, each in the order of adding. None for a number that is too high, and for null. */
TULLE_API tulle_object_id tulle_world_get_object(const tulle_world *world, uint32_t number);

/* How much there is in a world. */
typedef struct tulle_counts {
    size_t cloths;             /* number of cloths */
    size_t obstacles;          /* number of obstacles, rigid bodies among them */
    size_t cloth_vertices;     /* of all cloths together */
    size_t cloth_triangles;    /* of all cloths together */
    size_t obstacle_vertices;  /* of all obstacles together */
    size_t obstacle_triangles; /* of all obstacles together */
} tulle_counts;
/* Counts the objects of a world, also those that are absent now. All zero for null. */
TULLE_API tulle_counts tulle_world_get_counts(const tulle_world *world);

/* What an object is made of. */
typedef struct tulle_object_info {
    const char *name;      /* as its def said, else "cloth 0", "obstacle 0" and so on */
    size_t vertex_count;   /* of its mesh */
    size_t triangle_count; /* of its mesh */
    /* 3 * triangle_count vertex numbers of the object, owned by the world */
    const uint32_t *triangles;
    uint32_t category; /* as set by tulle_object_set_filter */
    uint32_t mask;     /* as set by tulle_object_set_filter */
    /* 1: an obstacle that never moves: no script, no frames, no drive, not a rigid body */
    int is_static;
} tulle_object_info;
/* Describes an object. All zero for null and for a stale id. */
TULLE_API tulle_object_info tulle_object_get_info(const tulle_world *world, tulle_object_id id);

/* Keeps `user_data`, a pointer of the host, with an object. It does not belong to the state, and
 * the world does not use it. Error: TULLE_ERROR_INVALID_ARGUMENT (null world, a stale id). */
TULLE_API tulle_status tulle_object_set_user_data(tulle_world *world, tulle_object_id id,
                                                  void *user_data, tulle_error *error);
/* The pointer that was set, null before; null for a null world and a stale id. */
TULLE_API void *tulle_object_get_user_data(const tulle_world *world, tulle_object_id id);

/* ---- rays, points and boxes ---- */

/* A straight line from one point to another, for tulle_world_cast_ray. */
typedef struct tulle_ray {
    double from[3]; /* [m] each coordinate -1e100 .. 1e100 */
    double to[3];   /* [m] each coordinate -1e100 .. 1e100; not equal to `from` */
    /* only objects with a category in this mask are seen; 0: all objects */
    uint32_t mask;
    /* 1: triangles are seen only from the front, from where they look counterclockwise */
    int skips_back_faces;
} tulle_ray;

/* A place on a surface that a query found. */
typedef struct tulle_hit {
    tulle_object_id object; /* TULLE_OBJECT_NONE: nothing was found, and all else is zero */
    uint32_t triangle;      /* of the object */
    double weights[3];      /* of its corners, each 0 .. 1; their sum is 1 */
    double position[3];     /* [m] the sum of the corners times their weights */
    double normal[3];       /* unit, of the triangle's front; zero if it has no area */
    double distance;        /* [m] from the start of the ray, or from the given point */
} tulle_hit;

/* Finds the first triangle that a ray meets, both ends of the ray included. This is decided exactly
 * on the given numbers: a ray never slips between two triangles that share an edge or a corner, and
 * a corner that it just touches is met. A ray does not meet a triangle without area, nor a triangle
 * in whose plane it runs. If it meets several triangles at one place, as on an edge, one of them is
 * given. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a world that has not started, numbers out of
 * range, `from` equal to `to`), TULLE_ERROR_OUT_OF_MEMORY (where boxes are made first); `hit` is
 * all zero then. */
TULLE_API tulle_status tulle_world_cast_ray(tulle_world *world, const tulle_ray *ray,
                                            tulle_hit *hit, tulle_error *error);

/* Finds the place on any surface that is nearest to `point` [m] and at most `max_distance` [m] away
 * (>= 0; INFINITY: anywhere). `mask` as in tulle_ray. If several triangles share the place, one of
 * them is given. Errors as of tulle_world_cast_ray. */
TULLE_API tulle_status tulle_world_find_closest_point(tulle_world *world, const double point[3],
                                                      double max_distance, uint32_t mask,
                                                      tulle_hit *hit, tulle_error *error);

/* A triangle that a query found. */
typedef struct tulle_found_triangle {
    tulle_object_id object; /* whose it is */
    uint32_t triangle;      /* of the object */
    uint32_t other;         /* triangle of the given mesh; 0 for a box */
} tulle_found_triangle;
/* Where found triangles go, and how many there are. */
typedef struct tulle_found {
    tulle_found_triangle *triangles; /* memory of the caller; null is fine with capacity 0 */
    size_t capacity;                 /* triangles that it has room for */
    /* number of all found triangles. If it is at most `capacity`, `triangles` has all of them, in
     * order; else it has some of them: ask again with more room. */
    size_t count;
} tulle_found;
/* Finds all triangles that have a point in common with the box from `low` to `high` [m], its faces
 * included; both may be equal along an axis. The test is exact. `found` gets them ordered by
 * object, then by number. `mask` as in tulle_ray. Errors as of tulle_world_cast_ray, and if `low`
 * is above `high`; the count is 0 then. */
TULLE_API tulle_status tulle_world_find_box_overlaps(tulle_world *world, const double low[3],
                                                     const double high[3], uint32_t mask,
                                                     tulle_found *found, tulle_error *error);
/* Finds all pairs of a triangle of the world and a triangle of `mesh` that have a point in common,
 * exactly as tulle_check_intersections judges two bodies. `found` gets them ordered by the triangle
 * of `mesh`, then by object and number. Triangles that lie wholly inside the mesh are not found.
 * `mask` as in tulle_ray. Errors as of tulle_world_cast_ray, and TULLE_ERROR_INVALID_MESH (a vertex
 * number out of range, a coordinate that is not finite or above 1e100); the count is 0 then. */
TULLE_API tulle_status tulle_world_find_mesh_overlaps(tulle_world *world, tulle_mesh_view mesh,
                                                      uint32_t mask, tulle_found *found,
                                                      tulle_error *error);
/* Fits the boxes of queries to the present state, if they do not fit it already. Queries do so by
 * themselves. Call it before queries from several threads, or to choose when the time is spent.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a world that has not started),
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_world_update_queries(tulle_world *world, tulle_error *error);

/* Copies those contacts of tulle_world_get_contacts that one object has, in the same order.
 * `*count` gets their number; `contacts` gets the first `capacity` of them, and may be null if
 * `capacity` is 0. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id),
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_object_copy_contacts(tulle_world *world, tulle_object_id id,
                                                  tulle_contact *contacts, size_t capacity,
                                                  size_t *count, tulle_error *error);

/* ---- values of vertices and triangles ---- */

/* What tulle_object_copy_values copies: three numbers for each vertex or triangle. */
typedef enum tulle_values {
    TULLE_VALUES_POSITIONS,  /* [m] of vertices */
    TULLE_VALUES_VELOCITIES, /* [m/s] of vertices; of an obstacle on a script the mean over a step
                              */
    /* of vertices: the unit normal of the front: the mean over the triangles of the vertex,
     * weighted by area; zero if they cancel or if there is no triangle */
    TULLE_VALUES_NORMALS,
    /* [N] on vertices: the mean force of all contacts over the last substep of the last accepted
     * step. It is summed in the number type of the target. Zero before the first step, after a
     * load, and between sleeping objects. Restitution adds nothing to it. */
    TULLE_VALUES_CONTACT_FORCES,
    /* of triangles of woven cloth: strain of the warp, strain of the weft, and shear, as in
     * tulle_material. The strain of a yarn is its length divided by its rest length, minus 1. */
    TULLE_VALUES_STRAINS,
    /* [m] of vertices: of an obstacle the positions in its frames, behind which it may lag
     * (TULLE_ON_PINCH_LAG); else the positions */
    TULLE_VALUES_DRAWN_POSITIONS
} tulle_values;
/* The type of the numbers that are copied. */
typedef enum tulle_number_type {
    TULLE_NUMBER_DOUBLE, /* 64 bits */
    TULLE_NUMBER_FLOAT   /* 32 bits, rounded to the nearest; infinite if too large */
} tulle_number_type;
/* Where values are copied to: memory of the caller. */
typedef struct tulle_target {
    void *data;             /* the first number goes here, at any address */
    size_t size;            /* [bytes] of the memory from there on */
    size_t stride;          /* [bytes] from one vertex or triangle to the next; 0: no gap */
    tulle_number_type type; /* of the numbers */
} tulle_target;
/* Copies values of all vertices, or triangles, of a cloth or an obstacle. The gaps of the stride
 * are not written. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a world that has not
 * started, an unknown choice, a stride smaller than three numbers, too little memory, strains of an
 * obstacle or of cloth made of springs). After an error nothing is written. */
TULLE_API tulle_status tulle_object_copy_values(const tulle_world *world, tulle_object_id id,
                                                tulle_values values, const tulle_target *target,
                                                tulle_error *error);

/* ---- which objects collide ---- */

/* Sets the categories of an object, a set of bits (default 1), and its `mask`, the categories that
 * it collides with (default all bits). Two objects collide if each has a category in the mask of
 * the other. Only before the start. Cloth collides with itself whatever its mask. Two obstacles
 * never collide unless one is a rigid body.
 *
 * The promise covers the pairs of objects that collide. The others pass through each other, at the
 * start and later: no contact, no judgement, no untangling. A saved state loads only into a world
 * that excludes the same pairs. Error: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a world that
 * has started). */
TULLE_API tulle_status tulle_object_set_filter(tulle_world *world, tulle_object_id id,
                                               uint32_t category, uint32_t mask,
                                               tulle_error *error);
/* Asks the host whether two objects may collide; 0: they may not. It is asked only for pairs that
 * the filters let collide, once for each pair: by tulle_world_start, or when one of the two is
 * added later, in the thread of that call. `context` comes from tulle_world_set_pair_filter. `a` is
 * a cloth if one of the two is; otherwise `a` is the object that was added first. The function may
 * call functions that take a const tulle_world. */
typedef int (*tulle_pair_filter)(void *context, const tulle_world *world, tulle_object_id a,
                                 tulle_object_id b);
/* Sets the function that tulle_world_start asks, and the `context` that it gets; null: none. Its
 * answers hold for the life of the world. A saved state loads only into a world with the same
 * answers. Error: TULLE_ERROR_INVALID_ARGUMENT (null world, a world that has started). */
TULLE_API tulle_status tulle_world_set_pair_filter(tulle_world *world, tulle_pair_filter filter,
                                                   void *context, tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
