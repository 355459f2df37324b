/* app/cli/progress_bar.h - one line of a terminal, drawn over and over, that shows how far a long
 * piece of work is. Where standard error is no terminal nothing is shown. */
#ifndef TULLE_APP_CLI_PROGRESS_BAR_H
#define TULLE_APP_CLI_PROGRESS_BAR_H

#include <stdbool.h>
#include <stdint.h>

enum { PROGRESS_DURATION_SIZE = 32 };

/* What `--progress` chooses. */
typedef enum progress_kind {
    PROGRESS_NONE,
    PROGRESS_BAR,   /* one line of a terminal, drawn over and over */
    PROGRESS_LINES, /* a line now and then */
    PROGRESS_JSON   /* one JSON object a line */
} progress_kind;
extern const char *const progress_choices[]; /* of the option, which "auto" stands for */

typedef struct progress_bar {
    double begin, drawn; /* [s] of the clock: start of the work, last time the bar was drawn */
    bool is_terminal, is_drawn;
} progress_bar;

progress_bar progress_bar_begin(void);
/* What a value of the option, or null, means for standard error as it is. */
progress_kind progress_choose_kind(const char *choice, const progress_bar *bar);
/* Draws the bar with the printf text behind it, unless it was drawn a moment ago; the last time,
 * with done == count, always. */
void progress_bar_show(progress_bar *bar, uint64_t done, uint64_t count, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* Takes the bar away, so that other lines can be printed. */
void progress_bar_clear(progress_bar *bar);
/* Leaves the bar where it is and ends its line. */
void progress_bar_end(progress_bar *bar);

/* [s] that the rest takes at the pace since the beginning; 0 while nothing is done. */
double progress_bar_estimate_rest(const progress_bar *bar, uint64_t done, uint64_t count);
/* "0:41", "1:02:03". */
const char *progress_format_duration(double seconds, char text[PROGRESS_DURATION_SIZE]);

#endif
