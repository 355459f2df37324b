/* step/bodies/body_drive.h - what the host has bodies do: forces, locks and drives
 * (tulle/bodies.h), as a substep takes them up. */
#ifndef TULLE_STEP_BODIES_BODY_DRIVE_H
#define TULLE_STEP_BODIES_BODY_DRIVE_H

#include "step/step_work.h"

/* Stops a body along what is locked. */
void step_stop_locked(const step_model *model, size_t body, double *velocities);
/* Gives the scene's body its drive, in the scratch arena, where it has locks or a drive; stops what
 * moves along locked axes. False: no memory. */
bool step_prepare_drive(const step_model *model, motion_state *state, step_work *work, size_t body);
/* Gains, pushes and limits of a drive for the time [s] that forces act on u. */
void step_load_drive(const step_model *model, step_work *work, size_t body, double force_time);
/* Notes in state what the drive gave in the substep. */
void step_note_drive(const step_model *model, motion_state *state, step_work *work, size_t body);
/* [J] Work of drives and of what the host added, in the substep as solved. */
double step_measure_control_work(const step_model *model, motion_state *state, step_work *work);

#endif
