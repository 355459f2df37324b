/* app/check/run.h - judging every frame of a run directory. */
#ifndef TULLE_APP_CHECK_RUN_H
#define TULLE_APP_CHECK_RUN_H

#include "app/check/frame.h"

/* Which frames of a run are judged, and by how many threads. */
typedef struct check_run_choice {
    const char *frames; /* as frame_range_read takes --frames; null: all */
    int threads;
} check_run_choice;

/* Judges the frames of the run in order, absent obstacles left out, prints each and adds them to
 * the totals; a bar on standard error if it is a terminal. Stops at the first frame that cannot be
 * read or judged, with the error filled in. Before, all files of the run are compared with their
 * checksums, unless some frames only are chosen. */
tulle_status check_run_directory(const char *directory, check_run_choice choice,
                                 const check_report *report, check_totals *totals,
                                 tulle_error *error);

#endif
