/* tulle/attach.h - attachments: vertices of a cloth that are held at an obstacle, a rigid body,
 * another cloth or points in space, while the world runs.
 *
 * A cape on a skinned character, a towel in a gripper, a button, a cloth in the user's hand. A
 * vertex keeps its place over one triangle of what it is attached to, wherever that triangle goes
 * and however it deforms: barycentric coordinates in its plane and the height over it.
 *
 * An attachment is part of the state: saved, loaded and in the hash. It acts from the next step on,
 * until it is released, its vertices have broken off, the obstacle leaves the scene for good or one
 * of its sides is removed. The promise holds as everywhere: a vertex that would have to pass
 * through something does not get there. docs/guide/embed.md tells more. */
#ifndef TULLE_ATTACH_H
#define TULLE_ATTACH_H

#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Names an attachment of a world. 0 names none. */
typedef uint32_t tulle_attachment_id;

/* An attachment to make. Made by tulle_attachment_def_default. tulle_world_attach copies all
 * arrays. Either `obstacle` or `other_cloth` or `points` is given. */
typedef struct tulle_attachment_def {
    uint32_t cookie;            /* set by tulle_attachment_def_default, checked on use */
    tulle_cloth_id cloth;       /* whose vertices are attached */
    const uint32_t *vertices;   /* vertex_count vertices of the cloth, each once */
    size_t vertex_count;        /* length of `vertices` */
    tulle_obstacle_id obstacle; /* that holds them: an obstacle or a rigid body */
    tulle_cloth_id other_cloth; /* that holds them; may be `cloth` itself, as for a seam */
    const double *points;       /* [m] 3 * vertex_count: points in space that hold them */
    /* vertex_count triangles of what holds them, in its mesh; null: the nearest one of each vertex,
     * at its own place */
    const uint32_t *triangles;
    /* 3 * vertex_count barycentric coordinates of the places in these triangles, each three of them
     * with sum 1; null where `triangles` are. Vertices are drawn there in the next step, at the
     * height over the triangle that they have. */
    const double *weights;
    /* [m] > 0: vertices farther than this from the nearest triangle are left out; INFINITY, the
     * default: none. Without meaning where `triangles` or `points` are given. */
    double max_distance;
    /* [N/m] > 0 of the spring that holds each vertex, up to 1e12; INFINITY, the default: rigid. To
     * obstacles on a script and to points a rigid attachment is exact, as a pin is; to bodies and
     * cloth it gives by some hundredths of what the cloth beside it stretches. */
    double stiffness;
    double break_force;  /* [N] > 0: a vertex held by more breaks off; INFINITY, the default: not */
    double release_time; /* [s] of the world, when it lets go; INFINITY, the default: never */
} tulle_attachment_def;
/* A rigid attachment to nothing yet, that does not break. */
TULLE_API tulle_attachment_def tulle_attachment_def_default(void);

/* Attaches vertices from the next step on. Costs one pass over the triangles of what holds them for
 * each vertex, unless triangles or points are given. `id` gets the attachment's name. Before the
 * start the def is kept, and what the start does not have is its error. The world must have
 * TULLE_RESPONSE_COUPLED. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a vertex that is
 * not there, is given twice, is held by a pin or rigidly by another attachment, an obstacle that is
 * not in the scene, values out of range, no vertex within max_distance),
 * TULLE_ERROR_OUT_OF_MEMORY; nothing is attached then. */
TULLE_API tulle_status tulle_world_attach(tulle_world *world, const tulle_attachment_def *def,
                                          tulle_attachment_id *id, tulle_error *error);

/* Moves the points of an attachment to points: 3 * `point_count` `points` [m], for the vertices of
 * the def in their order, those that broke off included. Rigid ones go there on straight lines
 * during the next step; springs pull there from its start on. The points stay there then. Nothing
 * happens where no vertex is held any more. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a world
 * that has not started, no such attachment, one to no points, another count, numbers that are not
 * finite or above 1e100); nothing has moved then. */
TULLE_API tulle_status tulle_attachment_set_points(tulle_world *world, tulle_attachment_id id,
                                                   const double *points, size_t point_count,
                                                   tulle_error *error);

/* Lets go of all vertices. They keep their velocities. Nothing happens where all have broken off.
 * Error: TULLE_ERROR_INVALID_ARGUMENT (null, an id that the world never gave, a world that has not
 * started). */
TULLE_API tulle_status tulle_attachment_release(tulle_world *world, tulle_attachment_id id,
                                                tulle_error *error);

/* How an attachment stands. */
typedef struct tulle_attachment_report {
    size_t held_count;    /* vertices that it holds; 0 once it was released */
    double force[3];      /* [N] on the cloth in the last substep of the last step, all vertices */
    double largest_force; /* [N] on a single vertex */
} tulle_attachment_report;
/* Tells how an attachment stands. Forces are 0 before its first step and after
 * tulle_world_load_state. All zero for null and for an id that the world never gave. */
TULLE_API tulle_attachment_report tulle_attachment_get_report(const tulle_world *world,
                                                              tulle_attachment_id id);
/* 1 while the attachment holds `vertex` of its cloth; 0 else, and for null. */
TULLE_API int tulle_attachment_holds(const tulle_world *world, tulle_attachment_id id,
                                     uint32_t vertex);

#ifdef __cplusplus
}
#endif
#endif
