/* app/view/source_run.h - a run directory as something to look at: any frame of it, what explains
 * it, its reports; one that is under way is followed. */
#ifndef TULLE_APP_VIEW_SOURCE_RUN_H
#define TULLE_APP_VIEW_SOURCE_RUN_H

#include "app/view/frame.h"
#include "app/view/series.h"

#include "tulle_io/run.h"

typedef struct view_run {
    const char *path;
    tulle_run_reader *reader;
    const tulle_run_info *info;
    double *scratch; /* 3 * most vertices of a body */
    size_t scratch_count;
    series_table series;
    bool has_series;
    tulle_run_debug debug; /* of the frame that was read last, where has_read_debug */
    bool has_read_debug;
} view_run;

/* Opens the run and fills the document. view_run_close also after a failure. */
tulle_status view_run_open(view_run *run, const char *path, view_document *document,
                           tulle_error *error);
void view_run_close(view_run *run);
view_progress view_run_get_progress(const view_run *run);
/* Reads a frame with those of the asked overlays that it can give at once. */
tulle_status view_run_read(view_run *run, const view_document *document, uint32_t number,
                           unsigned overlays, view_frame *frame, tulle_error *error);
/* Looks whether a run under way has grown or ended; whether something changed. */
bool view_run_follow(view_run *run);
/* The reports of all steps, for plots. */
tulle_status view_run_read_series(view_run *run, tulle_error *error);

#endif
