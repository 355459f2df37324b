/* step/step.h - a step: the model and a state give a state that is proven free of intersection.
 *
 * A step works on a copy of the state, all or nothing. */
#ifndef TULLE_STEP_STEP_H
#define TULLE_STEP_STEP_H

#include "step/step_work.h"

/* Makes the copy of work->start on which the step works. Sets *has_appeared if an obstacle may have
 * appeared since the state before; then the copy must be judged. TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status step_copy_start(const step_model *model, motion_state *target, step_work *work,
                             bool *has_appeared);
/* Undoes what a step changed outside its copy. */
void step_undo(const step_model *model, step_work *work);

/* Keeps the patches as they are now, for step_restore_patches: a step that fails leaves none of
 * its changes. */
tulle_status step_keep_patches(step_work *work);
void step_restore_patches(step_work *work);

/* Makes `state`, which is a copy of work->start, the state that is work->whole_step later.
 * If it fails, `state` is useless, and the caller undoes what the step has changed elsewhere. */
tulle_status step_run(const step_model *model, motion_state *state, step_work *work);

#endif
