/* app/check/slots.h - judges frames in order: they are read one after the other into slots, judged
 * side by side, and printed in order. */
#ifndef TULLE_APP_CHECK_SLOTS_H
#define TULLE_APP_CHECK_SLOTS_H

#include "app/check/frame.h"
#include "app/cli/frame_progress.h"
#include "app/cli/frame_range.h"

/* Fills frames[slot] with frame `number`. */
typedef tulle_status (*check_frame_reader)(void *context, size_t slot, uint32_t number,
                                           tulle_error *error);

typedef struct check_slots {
    const char *source; /* for messages: what the frames are of */
    check_frame *frames;
    size_t count;
    int threads;
    check_frame_reader read;
    void *context;
    frame_progress progress;
} check_slots;

/* How many frames are judged side by side by so many threads. */
size_t check_slots_count(frame_range range, int threads);

/* Judges the frames of the range, prints each and adds them to the totals; a bar on standard error
 * if it is a terminal, a line every ten seconds elsewhere, nothing there with JSON on standard
 * output. Stops at the first frame that cannot be read or judged. */
tulle_status check_slots_judge(check_slots *slots, frame_range range, const check_report *report,
                               check_totals *totals, tulle_error *error);

#endif
