/* tulle/attach.h - attachments: vertices of a cloth that are held at an obstacle, a rigid body,
 * another cloth or points in space, while the world runs.
 *
 * Examples are a cape on a skinned character, a towel in a gripper, a button, a cloth in the user's
 * hand. An attached vertex follows one triangle of its holder, the obstacle or the cloth that it is
 * attached to. It keeps its barycentric coordinates in that triangle and its height above it,
 * wherever the triangle goes and however it deforms.
 *
 * An attachment is part of the state: saved, loaded and in the hash. It acts from the next step on.
 * It ends when it is released or when one of its two sides is removed. It also ends when all its
 * vertices have broken off, and when the obstacle has left the scene for good. The promise holds as
 * everywhere: a vertex that would have to pass through a surface does not reach its place. See
 * docs/guide/embed.md. */
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
    const uint32_t *vertices;   /* vertex_count: vertices of the cloth, each once */
    size_t vertex_count;        /* length of `vertices` */
    tulle_obstacle_id obstacle; /* the holder: an obstacle or a rigid body */
    tulle_cloth_id other_cloth; /* the holder; may be `cloth` itself, as for a seam */
    /* [m] 3 * vertex_count, each -1e100 .. 1e100: points in space as holders */
    const double *points;
    /* vertex_count: triangles of the holder's mesh; null: each vertex is held at the nearest place
     * of the nearest triangle */
    const uint32_t *triangles;
    /* 3 * vertex_count, each -1e6 .. 1e6: barycentric coordinates of places in these triangles;
     * each three have the sum 1. Null if `triangles` is null. The next step pulls the vertices to
     * these places; each keeps its present height above the triangle. */
    const double *weights;
    /* [m] > 0 .. INFINITY, default INFINITY: vertices farther than this from the nearest triangle
     * are left out; INFINITY: no vertex is left out. Ignored if `triangles` or `points` are given.
     * */
    double max_distance;
    /* [N/m] > 0 .. INFINITY, default INFINITY: of the spring that holds each vertex, up to 1e12;
     * INFINITY: rigid. A rigid attachment to points or to an obstacle on a script is exact, as a
     * pin is. A rigid attachment to a body or to cloth gives a little: a few hundredths of the
     * stretch of the cloth around it. */
    double stiffness;
    /* [N] > 0 .. INFINITY, default INFINITY: a vertex that needs more breaks off; INFINITY: never
     * */
    double break_force;
    /* [s] any, default INFINITY: of the world, when it lets go; INFINITY: never */
    double release_time;
} tulle_attachment_def;
/* A rigid attachment that does not break; the caller fills in the rest. */
TULLE_API tulle_attachment_def tulle_attachment_def_default(void);

/* Attaches vertices from the next step on. Unless triangles or points are given, each vertex costs
 * one pass over the triangles of the holder. `id` gets the attachment's name. Before the start the
 * def is only kept; the start then reports its errors. The world must have TULLE_RESPONSE_COUPLED.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a stale id, a vertex that is not there, is given
 * twice, is held by a pin or rigidly by another attachment, an obstacle that is not in the scene,
 * values out of range, no vertex within max_distance), TULLE_ERROR_OUT_OF_MEMORY; nothing is
 * attached then. */
TULLE_API tulle_status tulle_world_attach(tulle_world *world, const tulle_attachment_def *def,
                                          tulle_attachment_id *id, tulle_error *error);

/* Moves the points of an attachment to points: 3 * `point_count` `points` [m], for the vertices of
 * the def in their order, also for vertices that broke off. Rigidly held vertices move there on
 * straight lines during the next step; springs pull there from its start on. After that the points
 * stay. Nothing happens if no vertex is held any more. Errors: TULLE_ERROR_INVALID_ARGUMENT (null,
 * a world that has not started, no such attachment, an attachment without points, another count,
 * numbers that are not finite or above 1e100); the points are then unchanged. */
TULLE_API tulle_status tulle_attachment_set_points(tulle_world *world, tulle_attachment_id id,
                                                   const double *points, size_t point_count,
                                                   tulle_error *error);

/* Releases all vertices. They keep their velocities. Nothing happens if all have broken off. Error:
 * TULLE_ERROR_INVALID_ARGUMENT (null, an id that the world never gave, a world that has not
 * started). */
TULLE_API tulle_status tulle_attachment_release(tulle_world *world, tulle_attachment_id id,
                                                tulle_error *error);

/* The state of an attachment. */
typedef struct tulle_attachment_report {
    size_t held_count;    /* vertices that it holds; 0 once it was released */
    double force[3];      /* [N] on the cloth in the last substep of the last step, all vertices */
    double largest_force; /* [N] on a single vertex */
} tulle_attachment_report;
/* Gives the state of an attachment. Forces are 0 before its first step and after
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
