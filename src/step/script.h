/* step/script.h - scripted and given motion, and the affine maps of it. */
#ifndef TULLE_STEP_SCRIPT_H
#define TULLE_STEP_SCRIPT_H

#include "step/step_work.h"

/* Where obstacles and pins are to be at `end_time` (targets), and which vertices are pinned at
 * `time`. */
tulle_status step_script_targets(const step_model *model, step_work *work, double time,
                                 double end_time, tulle_error *error);
/* Where an obstacle that is added is at the time of `start`. */
tulle_status step_place_obstacle(const step_model *model, step_work *work, size_t index,
                                 double *positions, tulle_error *error);

/* Before the first substep; once targets are set; after a substep is accepted. The maps lie in the
 * scratch arena. */
tulle_status step_begin_carriers(const step_model *model, step_work *work);
void step_compute_carriers(const step_model *model, motion_state *state, step_work *work);
void step_follow_carriers(const step_model *model, step_work *work);

#endif
