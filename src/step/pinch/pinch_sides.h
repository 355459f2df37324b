/* step/pinch/pinch_sides.h - where cloth is pinched, and what is around that place. */
#ifndef TULLE_STEP_PINCH_PINCH_SIDES_H
#define TULLE_STEP_PINCH_PINCH_SIDES_H

#include "step/step_work.h"

/* What an obstacle does at the place. */
typedef struct pinch_side {
    bool is_near;       /* it touches the cloth there */
    bool has_direction; /* else its contacts there face each other */
    vec3 direction;     /* unit: where it pushes the cloth */
    uint32_t points[4]; /* vertices whose weighted mean is its point nearest to the cloth */
    double weights[4];
    double gap;       /* [m] there */
    double load;      /* [N s] sum of what its rows at the place push with */
    size_t row_count; /* of those rows */
} pinch_side;

/* The place of the pair that blocked the step last. */
blocked_place step_find_blocked_place(const step_model *model, motion_state *state,
                                      step_work *work);

/* Fills `sides`, one an obstacle, zeroed before, from the rows of the last substep. */
void step_measure_pinch_sides(const step_model *model, step_work *work, const blocked_place *place,
                              pinch_side *sides);

#endif
