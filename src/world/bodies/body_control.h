/* world/bodies/body_control.h - what the host has bodies do: forces, locks and drives
 * (tulle/bodies.h), as a substep takes them up. */
#ifndef TULLE_WORLD_BODIES_BODY_CONTROL_H
#define TULLE_WORLD_BODIES_BODY_CONTROL_H

#include "world/step/step.h"

/* Gives the scene's body its drive, in the scratch arena, where it has locks or a drive; stops what
 * moves along locked axes. False: no memory. */
bool world_prepare_drive(step_context *context, size_t body);
/* Gains, pushes and limits of a drive for the time [s] that forces act on u. */
void world_load_drive(const step_context *context, size_t body, double force_time);
/* Notes in context->state what the drive gave in the substep. */
void world_note_drive(const step_context *context, size_t body);
/* [J] Work of drives and of what the host added, in the substep as solved. */
double world_measure_control_work(const step_context *context);

#endif
