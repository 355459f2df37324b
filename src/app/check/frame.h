/* app/check/frame.h - one frame to be judged, and its verdict. */
#ifndef TULLE_APP_CHECK_FRAME_H
#define TULLE_APP_CHECK_FRAME_H

#include "app/cli/axes.h"

#include "tulle/check.h"
#include "tulle_io/run.h"

enum { CHECK_FRAME_OF_FILE = -1 }; /* `number` of a frame that is a mesh file */

/* One body of the frame has index i in bodies and names. All arrays are borrowed. */
typedef struct check_frame {
    const char *source; /* file or directory, as the user gave it */
    long number;        /* of the frame in a run or an animation, CHECK_FRAME_OF_FILE otherwise */
    double time;        /* [s] of such a frame; NaN: it has none */
    tulle_check_body *bodies;
    const char **names;
    size_t body_count;
    const axes_change *to_scene; /* of places that are told; null: as the positions are */
    const tulle_run_lag *lags;   /* of a frame in a run: what lags behind how it is drawn */
    const tulle_run_body_info *run_bodies; /* that these name */
    size_t lag_count;
    tulle_status status; /* of the judgement; result counts where it is TULLE_OK */
    tulle_check_result result;
    tulle_error error;
} check_frame;

/* Sums over the frames judged so far. */
typedef struct check_totals {
    uint64_t frame_count, bad_frame_count, intersection_count;
} check_totals;

/* How verdicts are written to standard output. */
typedef struct check_report {
    int is_json;
    long list_limit; /* pairs listed a frame; negative: all */
} check_report;

/* Judges `count` frames on `threads` threads: side by side, or, one frame alone, within it. */
void check_frames_judge(check_frame *frames, size_t count, int threads);

/* A place close to where two intersecting triangles meet: the centre of what their boxes have in
 * common. */
void check_compute_place(const tulle_check_body *bodies, const tulle_check_pair *pair,
                         double place[3]);

/* Prints the verdict of one frame and its pairs; adds it to the totals. */
void check_report_frame(const check_report *report, const check_frame *frame, check_totals *totals);
/* Prints the closing line. */
void check_report_totals(const check_report *report, const check_totals *totals);

#endif
