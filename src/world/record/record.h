/* world/record/record.h - what the calls of a host do for a recording (tulle/record.h). A world
 * that is not recorded has a null `recording`: callers look at that first. */
#ifndef TULLE_WORLD_RECORD_RECORD_H
#define TULLE_WORLD_RECORD_RECORD_H

#include "world/record/recorded_call.h"
#include "world/world_state.h"

/* Records a call that has succeeded, or what came up within one. Where that fails the recording
 * ends here, and world_check_recording refuses what comes. */
void world_record(tulle_world *world, const recorded_call *call);

/* An error where a recording has ended because a block could not be written. */
tulle_status world_check_recording(const tulle_world *world, tulle_error *error);

/* Records a start, a step or a load that is about to run; an error refuses it. Then what it came
 * to.
 */
tulle_status world_begin_call(tulle_world *world, const recorded_call *call, tulle_error *error);
void world_end_call(tulle_world *world, tulle_status status);

/* Ends the recording and lets go of it. */
void world_end_recording(tulle_world *world);

#endif
