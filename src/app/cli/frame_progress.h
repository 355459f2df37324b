/* app/cli/frame_progress.h - shows on standard error how far work on frames is, as `--progress`
 * says: a bar on a terminal and a line every ten seconds elsewhere, JSON lines, or nothing. A frame
 * may be read several times; each reading counts. */
#ifndef TULLE_APP_CLI_FRAME_PROGRESS_H
#define TULLE_APP_CLI_FRAME_PROGRESS_H

#include "app/cli/progress_bar.h"

#include "tulle/base.h"

typedef struct frame_progress {
    const char *command;
    progress_kind kind;
    progress_bar bar;
    double shown; /* [s] of the clock: last time that a line was shown */
    bool has_begun;
} frame_progress;

/* kind: "auto", "json" or "none"; null as "auto". */
frame_progress frame_progress_begin(const char *command, const char *kind);
/* So many of `count` readings are done. */
void frame_progress_show(frame_progress *progress, uint64_t done, uint64_t count);
/* Says something of the work, a sentence without a full stop or newline. */
void frame_progress_say(frame_progress *progress, const char *message);
/* Takes the bar away. */
void frame_progress_clear(frame_progress *progress);
/* The last line, by the status of the work. */
void frame_progress_end(frame_progress *progress, tulle_status status);

#endif
