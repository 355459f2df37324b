/* step/stretch.h - how far a substep would stretch edges and yarns. */
#ifndef TULLE_STEP_STRETCH_H
#define TULLE_STEP_STRETCH_H

#include "step/step_work.h"

/* A torn edge is longer than this times its rest length. */
static const double TORN_STRETCH = 4.0;

/* Whether edges, or yarns of woven cloth, grow by more than `most` times the limit from the start
 * of the substep to sub.end. Then the solve has not carried a hard landing into the cloth: vertices
 * stop while their neighbours fly on. */
tulle_status step_judge_stretch(const step_model *model, motion_state *state, step_work *work,
                                double most, bool *stretches);
/* Whether an edge jumps to more than four times its rest length, which cloth never does. */
bool step_is_torn(const step_model *model, const motion_state *state, const step_work *work);

#endif
