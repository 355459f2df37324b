/* app/cli/frame_range.h - which frames of a run, a point cache or a numbered sequence the options
 * `--frame N` and `--frames RANGE` name.
 *
 *   RANGE   N | A:B | A:B:STEP | all      B is the last frame that counts, not the one after it.
 *           A and B may be left out (`10:`, `:20`, `::5`): the first and the last frame there is.
 *           `last` may stand for a number. STEP 1 or more; by default every frame there is. */
#ifndef TULLE_APP_CLI_FRAME_RANGE_H
#define TULLE_APP_CLI_FRAME_RANGE_H

#include "tulle/base.h"

/* The frames first, first + step, ... up to last, which is one of them. */
typedef struct frame_range {
    uint32_t first, last, step;
} frame_range;

#define FRAME_RANGE_HELP                                                                           \
    "N, A:B or A:B:STEP, B included; A or B left out: to the end (default: all)"

/* All of the frames 0 .. frame_count - 1, frame_count > 0. */
frame_range frame_range_make(uint32_t frame_count);

/* Reads the values of --frame and --frames, each null when not given; none given: all frames
 * `available`. Every frame of the result is one of those. Errors: TULLE_ERROR_INVALID_ARGUMENT:
 * both are given, the text is no range, or a frame is not there. */
tulle_status frame_range_read(const char *frame, const char *frames, frame_range available,
                              frame_range *range, tulle_error *error);

/* How many frames it names, and the one of index `index` below that. */
uint32_t frame_range_get_count(frame_range range);
uint32_t frame_range_get(frame_range range, uint32_t index);

#endif
