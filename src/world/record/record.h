/* world/record/record.h - what the calls of a host do for a recording (tulle/record.h). A world
 * that is not recorded has a null `recording`: callers look at that first. */
#ifndef TULLE_WORLD_RECORD_RECORD_H
#define TULLE_WORLD_RECORD_RECORD_H

#include "world/record/recorded_call.h"
#include "world/world_state.h"

/* Records a call that has succeeded, or what came up within one. Where that fails the recording
 * ends here, and world_check_recording refuses what comes. */
void world_record(tulle_world *world, const recorded_call *call);
/* The same in a world that may not be recorded: of these members of recorded_call; RECORD_ID gives
 * those of an object. */
#define WORLD_RECORD(world, ...)                                                                   \
    do {                                                                                           \
        if ((world)->recording) world_record((world), &(recorded_call){__VA_ARGS__});              \
    } while (0)
#define RECORD_ID(id) .ids = {(id).index}, .generations = {(id).generation}

/* Records a frame of a sequence that a step or a start has read; see frame_listener. */
void world_record_frame(void *context, size_t obstacle, uint32_t frame, const double *positions,
                        tulle_status status);

/* An error where a recording has ended because a block could not be written. */
tulle_status world_check_recording(const tulle_world *world, tulle_error *error);

/* Records a start, step or load that is about to run; an error refuses it. Then its result. */
tulle_status world_begin_call(tulle_world *world, const recorded_call *call, tulle_error *error);
void world_end_call(tulle_world *world, tulle_status status);

/* Ends the recording and lets go of it. */
void world_end_recording(tulle_world *world);

#endif
