/* app/mend/frames.h - an animation mended frame by frame, in two passes: cloth follows the given
 * way (follow.h), then what comes out of it evened out (even.h), which leaves the second pass
 * little to do. The second one is EVEN_REACH frames behind the first. */
#ifndef TULLE_APP_MEND_FRAMES_H
#define TULLE_APP_MEND_FRAMES_H

#include "app/mend/even.h"
#include "app/mend/follow.h"
#include "app/mend/report.h"

#include "tulle/check.h"

typedef struct mend_frames {
    mend_input *input;
    const mend_follow_options *options;
    bool judges_met;            /* what is left is judged with bodies as the cloth met them */
    mend_follow first, second;  /* the passes; second.now is what came out */
    mend_even even;             /* what the first one left */
    mend_row rows[EVEN_FRAMES]; /* of the last frames */
    bool is_given[EVEN_FRAMES]; /* that way is as given, and so was the first pass's */
    uint32_t done;              /* frames of the second pass */
    mend_history history;
    tulle_check_body *bodies; /* scratch: the cloth, then the bodies */
    double *way;              /* scratch: all vertices */
} mend_frames;

/* Keeps pointers to `input` and `options`. Release with mend_frames_close, also after a failure. */
tulle_status mend_frames_open(mend_input *input, const mend_follow_options *options,
                              mend_frames *frames, tulle_error *error);
void mend_frames_close(mend_frames *frames);

/* Makes the next frame; frames->second.now has it, *row what is told of it. Errors name file and
 * frame. */
tulle_status mend_frames_make(mend_frames *frames, mend_row *row, tulle_error *error);
/* Whether the cloth was once followed: what fails later is no matter of the input. */
bool mend_frames_are_running(const mend_frames *frames);

#endif
