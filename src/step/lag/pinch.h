/* step/lag/pinch.h - what happens when obstacles or pins leave cloth or bodies no room. */
#ifndef TULLE_STEP_LAG_PINCH_H
#define TULLE_STEP_LAG_PINCH_H

#include "step/step_work.h"

/* Whether obstacles or pins still follow their script, so that they may be what blocks. */
bool step_is_script_moving(const step_model *model, motion_state *state, step_work *work);
/* Cloth and bodies stand still for the rest of the step. */
void step_stand_still(const step_model *model, motion_state *state);
/* Whether the step, done and measured, tears cloth between obstacles that come nearer to each
 * other; where, into torn_place. */
bool step_tears_squeezed(const step_model *model, motion_state *state, step_work *work);
/* Whether a step that is stuck is worth another try with more lag at once: what blocked it lags.
 * Else shorter substeps come first. */
bool step_waits_at_once(const step_model *model, motion_state *state, step_work *work);
/* What to do when the step is pinched or torn; see tulle_on_pinch. OK means: undo the step and make
 * it anew. */
tulle_status step_handle_pinch(const step_model *model, motion_state *state, step_work *work,
                               bool is_torn);
/* At the end of a step: notes what begins to be held back and what no more is. */
void step_end_pinch(const step_model *model, motion_state *state, step_work *work);

#endif
