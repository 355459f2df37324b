/* validation_progress.h - how far a run is: on a terminal one line that is drawn over and over,
 * else a line of JSON a minute and one at the end of an experiment; and the wish to be
 * interrupted. */
#ifndef TULLE_TEST_VALIDATION_PROGRESS_H
#define TULLE_TEST_VALIDATION_PROGRESS_H

#include "app/cli/progress_bar.h"

#include <stddef.h>

typedef struct validation_progress {
    progress_bar bar;                    /* of the experiment */
    double last;                         /* [s] of the clock: the last line of JSON */
    uint64_t done, planned;              /* steps of the experiment; planned: 0 where nobody told */
    size_t experiment, experiment_count; /* the first is 1 */
} validation_progress;

/* Before an experiment, after each of its steps, and after it. */
void validation_progress_start(validation_progress *progress, const char *name);
void validation_progress_step(validation_progress *progress, const char *name);
void validation_progress_end(validation_progress *progress, const char *name, size_t rows,
                             size_t off);

/* From now on an interrupt (SIGINT, SIGTERM) is a wish that is told by the second function; a
 * second one ends the program. */
void validation_catch_interrupts(void);
bool validation_is_interrupted(void);

#endif
