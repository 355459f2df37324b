/* step/bodies/body_drive.h - control of bodies by the host within a substep: forces, locks and
 * drives (tulle/bodies.h). */
#ifndef TULLE_STEP_BODIES_BODY_DRIVE_H
#define TULLE_STEP_BODIES_BODY_DRIVE_H

#include "step/step_work.h"

/* Stops a body along its locked axes. */
void step_stop_locked(const step_model *model, size_t body, double *velocities);
/* If the body has locks or a drive, gives the scene's body a drive in the scratch arena and stops
 * motion along locked axes. False: no memory. */
bool step_prepare_drive(const step_model *model, motion_state *state, step_work *work, size_t body);
/* Gains, pushes and limits of a drive for the time [s] that forces act on u. */
void step_load_drive(const step_model *model, step_work *work, size_t body, double force_time);
/* Notes in state the force and torque of the drive in the substep. */
void step_note_drive(const step_model *model, motion_state *state, step_work *work, size_t body);
/* [J] Work of drives and of forces that the host added, in the solved substep. */
double step_measure_control_work(const step_model *model, motion_state *state, step_work *work);

#endif
