/* app/check_run.h - judging every frame of a run directory. */
#ifndef TULLE_APP_CHECK_RUN_H
#define TULLE_APP_CHECK_RUN_H

#include "app/check_frame.h"

/* Judges the frames of the run in order, absent obstacles left out, prints each and adds them to
 * the totals; a bar on standard error if it is a terminal. Stops at the first frame that cannot be
 * read or judged, with the error filled in. */
tulle_status check_run_directory(const char *directory, int threads, const check_report *report,
                                 check_totals *totals, tulle_error *error);

#endif
