/* step/step.h - a step: the model and a state give a state that is proven free of intersection. */
#ifndef TULLE_STEP_STEP_H
#define TULLE_STEP_STEP_H

#include "step/step_work.h"

/* Makes `state`, which is a copy of work->start (undo.h), the state that is work->whole_step later.
 * If it fails, `state` is useless, and the caller undoes what the step has changed elsewhere. */
tulle_status step_run(const step_model *model, motion_state *state, step_work *work);

#endif
