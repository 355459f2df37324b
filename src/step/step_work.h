/* step/step_work.h - what a step works with and needs not keep: trees, patches, pairs, rows, the
 * linear system, scratch memory. It may be dropped between two steps. */
#ifndef TULLE_STEP_STEP_WORK_H
#define TULLE_STEP_STEP_WORK_H

#include "base/arena.h"
#include "base/stop.h"
#include "contact/contact_types.h"
#include "detect/patches/kept_patches.h"
#include "detect/trees/broad_phase.h"
#include "dynamics/compute_forces.h"
#include "math/nested_aggregates.h"
#include "tulle/world.h"

/* A point of a surface that is no cloth: weighted mean of vertices in the world's numbering. */
typedef struct room_side {
    uint32_t vertices[3];
    double weights[3];
    bool may_lag;
} room_side;

/* Two sides that face each other with cloth between: normal . (second - first) is to be at least
 * `room`. */
typedef struct room_place {
    room_side sides[2]; /* the first may lag */
    vec3 normal;        /* unit, from the first to the second */
    double room;        /* [m] */
    double share;       /* of what is missing, that the first side gives */
} room_place;
typedef ARRAY(room_place) room_list;

typedef struct step_work {
    int threads;
    const tulle_tasks *tasks;     /* of the host, or null: threads of the library */
    stop_poll stop;               /* of the caller */
    tulle_step_progress progress; /* of the step that is under way */
    arena scratch;

    linear_system system;
    nested_aggregates *aggregates; /* preconditioner of the solve; null for small cloth */
    broad_phase *broad;
    kept_patches *patches;   /* null for methods without */
    patch_rules patch_rules; /* set by the start, but for keeps_all */
    double hold_reach;       /* [m] with which patches hold for the paths of stages 8 and 9 */

    /* of the step that runs, or ran last */
    double step_end;               /* [s] time at its end */
    uint8_t *is_fixed;             /* cloth vertices: pinned */
    double *active_inverse_masses; /* [1/kg] 0 where pinned */
    double *targets;               /* [m] where scripted vertices go */
    pair_list pairs;
    ARRAY(unsigned char) kept_patch_bytes; /* the patches at its start */
    room_list places;

    /* of the substep that runs, or ran last */
    row_list rows;
    /* cloth vertices and triangles of sleepers; null where none may sleep */
    uint8_t *idle_vertices, *idle_triangles;
    size_t idle_vertex_count, idle_triangle_count;
} step_work;

#endif
