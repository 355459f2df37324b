/* app/cli/progress_bar.c - see progress_bar.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/cli/progress_bar.h"

#include "base/timer.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { BAR_WIDTH = 24 /* [characters] */ };
static const double BAR_INTERVAL = 0.1; /* [s] between two pictures of the bar: calm, yet alive */

progress_bar progress_bar_begin(void) {
    return (progress_bar){.begin = timer_now(), .is_terminal = isatty(STDERR_FILENO) != 0};
}

const char *const progress_choices[] = {"auto", "json", "none", NULL};

progress_kind progress_choose_kind(const char *choice, const progress_bar *bar) {
    if (choice && strcmp(choice, "json") == 0) return PROGRESS_JSON;
    if (choice && strcmp(choice, "none") == 0) return PROGRESS_NONE;
    return bar->is_terminal ? PROGRESS_BAR : PROGRESS_LINES;
}

void progress_bar_show(progress_bar *bar, uint64_t done, uint64_t count, const char *format, ...) {
    double const now = timer_now();
    if (!bar->is_terminal || (done < count && bar->is_drawn && now - bar->drawn < BAR_INTERVAL))
        return;
    char picture[BAR_WIDTH + 1];
    double const share = count > 0 && done < count ? (double)done / (double)count : 1.0;
    size_t const filled = (size_t)(share * BAR_WIDTH);
    memset(picture, '#', filled);
    memset(picture + filled, '.', BAR_WIDTH - filled);
    picture[BAR_WIDTH] = '\0';
    fprintf(stderr, "\r[%s] ", picture);
    va_list arguments;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputs("\033[K", stderr); /* clears the rest of the line */
    fflush(stderr);
    bar->is_drawn = true;
    bar->drawn = now;
}

void progress_bar_clear(progress_bar *bar) {
    if (bar->is_drawn) fputs("\r\033[K", stderr);
    bar->is_drawn = false;
}

void progress_bar_end(progress_bar *bar) {
    if (bar->is_drawn) fputc('\n', stderr);
    bar->is_drawn = false;
}

double progress_bar_estimate_rest(const progress_bar *bar, uint64_t done, uint64_t count) {
    if (done == 0 || done >= count) return 0.0;
    return (timer_now() - bar->begin) / (double)done * (double)(count - done);
}

const char *progress_format_duration(double seconds, char text[PROGRESS_DURATION_SIZE]) {
    long const total = (long)(fmin(seconds, 3.6e8) + 0.5);
    if (total >= 3600)
        snprintf(text, PROGRESS_DURATION_SIZE, "%ld:%02ld:%02ld", total / 3600, total / 60 % 60,
                 total % 60);
    else
        snprintf(text, PROGRESS_DURATION_SIZE, "%ld:%02ld", total / 60, total % 60);
    return text;
}
