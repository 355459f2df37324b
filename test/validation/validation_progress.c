/* validation_progress.c - see validation_progress.h. */
#define _POSIX_C_SOURCE 200809L
#include "validation/validation_progress.h"

#include "base/timer.h"

#include <signal.h>
#include <stddef.h>
#include <stdio.h>

static const double BETWEEN_LINES = 60.0; /* [s] of lines of JSON: rare, yet a sign of life */

static volatile sig_atomic_t is_interrupted;

static void take_interrupt(int signal_number) {
    (void)signal_number;
    is_interrupted = 1;
}

void validation_catch_interrupts(void) {
    struct sigaction action = {.sa_handler = take_interrupt, .sa_flags = (int)SA_RESETHAND};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

bool validation_is_interrupted(void) { return is_interrupted != 0; }

void validation_progress_start(validation_progress *progress, const char *name) {
    size_t const experiment = progress->experiment + 1, count = progress->experiment_count;
    *progress = (validation_progress){.bar = progress_bar_begin(),
                                      .last = timer_now(),
                                      .experiment = experiment,
                                      .experiment_count = count};
    progress_bar_show(&progress->bar, 0, 1, "%zu of %zu  %s", experiment, count, name);
}

void validation_progress_step(validation_progress *progress, const char *name) {
    uint64_t const done = ++progress->done, planned = progress->planned;
    bool const is_planned = planned > done;
    unsigned long long const shown = done, all = planned;
    double const rest = progress_bar_estimate_rest(&progress->bar, done, planned);
    if (progress->bar.is_terminal) {
        char text[PROGRESS_DURATION_SIZE];
        if (is_planned)
            progress_bar_show(&progress->bar, done, planned,
                              "%zu of %zu  %s  step %llu of %llu  rest %s", progress->experiment,
                              progress->experiment_count, name, shown, all,
                              progress_format_duration(rest, text));
        else
            progress_bar_show(&progress->bar, 0, 1, "%zu of %zu  %s  step %llu",
                              progress->experiment, progress->experiment_count, name, shown);
        return;
    }
    double const now = timer_now();
    if (now - progress->last < BETWEEN_LINES) return;
    progress->last = now;
    fprintf(stderr, "{\"experiment\": \"%s\", \"seconds\": %.0f, \"step\": %llu", name,
            now - progress->bar.begin, shown);
    if (is_planned) fprintf(stderr, ", \"steps\": %llu, \"rest_seconds\": %.0f", all, rest);
    fprintf(stderr, "}\n");
}

void validation_progress_end(validation_progress *progress, const char *name, size_t rows,
                             size_t off) {
    double const seconds = timer_now() - progress->bar.begin;
    if (!progress->bar.is_terminal) {
        fprintf(stderr,
                "{\"experiment\": \"%s\", \"seconds\": %.1f, \"rows\": %zu, \"off\": %zu}\n", name,
                seconds, rows, off);
        return;
    }
    progress_bar_clear(&progress->bar);
    fprintf(stderr, "%-28s %7.1f s  %zu rows", name, seconds, rows);
    if (off > 0) fprintf(stderr, ", %zu OFF", off);
    fprintf(stderr, "\n");
}
