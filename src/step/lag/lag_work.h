/* step/lag/lag_work.h - what a step holds of lagging surfaces (lag.h). */
#ifndef TULLE_STEP_LAG_LAG_WORK_H
#define TULLE_STEP_LAG_LAG_WORK_H

#include "base/memory.h"
#include "math/vec3.h"

#include <stdbool.h>

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

/* A place around which what deforms stands still in a step that was pinched there. */
typedef struct still_place {
    vec3 position; /* [m] */
    double radius; /* [m] */
} still_place;
enum { STILL_PLACES = 16, STILL_TRIES = 24 };

typedef struct lag_work {
    double *lagging; /* [m] all vertices: where lagging surfaces are to be at the end of the step;
                        null: as drawn */
    double *drawn;   /* [m] where they are drawn */
    still_place still[STILL_PLACES];
    size_t still_count;
    room_list places;
} lag_work;

#endif
