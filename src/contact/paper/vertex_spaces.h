/* contact/paper/vertex_spaces.h - the motion spaces of the vertices of one step, from its rows. */
#ifndef TULLE_CONTACT_PAPER_VERTEX_SPACES_H
#define TULLE_CONTACT_PAPER_VERTEX_SPACES_H

#include "contact/contact_types.h"
#include "contact/paper/motion_space.h"

/* How the two sides of a row would move together if they met without bounce. */
typedef struct shared_motion {
    vec3 velocity;      /* [m/s] of the contact point */
    double first_share; /* part of a relative velocity that the first side takes; 1 if the second
                           side is an obstacle */
} shared_motion;

/* The rows of each vertex, in scratch. Only cloth vertices that can move have entries. */
typedef struct vertex_spaces {
    const contact_scene *scene;
    const row_list *list;
    tulle_motion_space kind;
    uint32_t *begin;       /* cloth_vertex_count + 1: where the entries of each vertex begin */
    uint32_t *entries;     /* 4 * row + corner, in the order of the rows */
    shared_motion *shared; /* of each row */
    half_space *planes;    /* of each entry; make_vertex_space fills those of its vertex */
} vertex_spaces;

/* Spaces of the kind that scene->paper names. `velocities` [m/s] of all vertices give the motion of
 * the planes. False when memory is short. The rows must neither move nor grow while the spaces are
 * used. */
bool vertex_spaces_make(vertex_spaces *spaces, const contact_scene *scene, const row_list *list,
                        const double *velocities);

/* Whether an entry's row takes part. */
typedef bool (*entry_filter)(const void *context, uint32_t vertex, const contact_row *row);
typedef struct space_choice {
    entry_filter filter; /* null: all rows */
    const void *context;
    bool is_closed; /* the sides may not approach, whatever the gap: in their shared motion offsets
                       are 0 */
} space_choice;

/* Where a vertex may move, seen from the frame of the touched surface. */
typedef struct vertex_space {
    motion_space space;
    vec3 reference; /* [m/s] velocity of the frame */
} vertex_space;

/* cone: the planes of the rows stand still in space, and so does the frame.
 * polyhedral: each plane moves as both sides of its row would move together. It leaves room for the
 * approach down to the contact distance, and for the distance by which a corner lies behind the
 * contact point. The velocity of the frame is the mean of theirs. May run for several vertices at
 * once. */
vertex_space make_vertex_space(const vertex_spaces *spaces, uint32_t vertex, space_choice choice);

/* The row whose plane this velocity, as seen from the frame, misses by most; null: it misses none.
 * `space` was made with the same choice, and no other for this vertex since. */
const contact_row *find_pressed_row(const vertex_spaces *spaces, uint32_t vertex,
                                    const vertex_space *space, space_choice choice, vec3 velocity);

#endif
