/* step/lag/room.h - places where an obstacle that lags closes on cloth, and the room that the cloth
 * needs there. */
#ifndef TULLE_STEP_LAG_ROOM_H
#define TULLE_STEP_LAG_ROOM_H

#include "step/step_work.h"

/* Two sides of cloth face each other when the cosine between their directions is under this. */
static const double OPPOSED_COSINE = -0.5;

/* [m] The point of a side where the vertices are at `positions`. */
static inline vec3 get_side_point(const room_side *side, const double *positions) {
    vec3 point = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        point = vec3_add_scaled(point, vec3_load(positions, side->vertices[k]), side->weights[k]);
    return point;
}

/* Fits the trees of queries to work->start. TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status step_update_queries(const step_model *model, step_work *work);

/* Finds the places at the start of the step, from the contacts of cloth with what lags, and, once
 * the step was tried, from the rows that it met. reach [m]: sides farther from each other do not
 * matter. `ends`: [m] all vertices at the end of the step, as drawn. TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status step_find_room(const step_model *model, step_work *work, const double *ends,
                            double reach, room_list *places);

/* Moves `ends` of vertices that lag until all places have their room, as far as that can be. A
 * point goes with what is near it on its surface, so that the surface stays smooth, or with all
 * that is rigid. TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status step_make_room(const step_model *model, step_work *work, const room_list *places,
                            double *ends);

#endif
