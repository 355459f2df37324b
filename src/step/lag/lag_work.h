/* step/lag/lag_work.h - what a step holds of obstacles that lag (lag.h), and of its pinch
 * (pinch.h). */
#ifndef TULLE_STEP_LAG_LAG_WORK_H
#define TULLE_STEP_LAG_LAG_WORK_H

#include "base/memory.h"
#include "contact/commit/commit_safely.h"
#include "step/findings.h"
#include "step/motion_state.h"

/* A point of a surface: weighted mean of vertices in the world's numbering. */
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

/* Vertices at which a step was blocked or tears cloth. */
typedef struct blocked_place {
    bool is_pair;         /* the vertices are a pair that blocked */
    uint32_t vertices[4]; /* of cloth, but in a pair */
    uint32_t surface;     /* a cloth, or the surface of the first vertex */
    vec3 position;        /* [m] of one of them */
} blocked_place;

typedef struct lag_work {
    double *lagging; /* [m] all vertices: where what is led is to be at the end of the step */
    double *drawn;   /* [m] where it is drawn */
    uint8_t *is_led; /* per surface: the above counts, and not the script. Null: for none */
    room_list places;

    int level; /* how often the step was pinched */
    still_place still[STILL_PLACES];
    size_t still_count;
    commit_report blocked;       /* the last commit of the step that named a blocking pair */
    blocked_place torn_place;    /* where the step tears squeezed cloth */
    step_finding finding;        /* of the pinch found last, or of the lag */
    step_finding freed;          /* what is held back no more */
    uint8_t *is_near, *is_freed; /* marks of these findings */
} lag_work;

#endif
