/* app/cli/frame_progress.c - see frame_progress.h. */
#include "app/cli/frame_progress.h"

#include "app/cli/json_text.h"
#include "app/commands.h"
#include "base/timer.h"

#include <stdio.h>

/* [s] between two lines: a log stays readable, a program is told in time. */
static const double LINE_INTERVAL = 10.0, JSON_INTERVAL = 0.1;

frame_progress frame_progress_begin(const char *command, const char *kind) {
    frame_progress progress = {.command = command, .bar = progress_bar_begin()};
    progress.kind = progress_choose_kind(kind, &progress.bar);
    progress.shown = progress.bar.begin;
    return progress;
}

static void begin_json(frame_progress *progress, uint64_t count) {
    if (progress->kind != PROGRESS_JSON || progress->has_begun) return;
    fprintf(stderr, "{\"event\":\"begin\",\"count\":%llu}\n", (unsigned long long)count);
    progress->has_begun = true;
}

void frame_progress_show(frame_progress *progress, uint64_t done, uint64_t count) {
    double const interval = progress->kind == PROGRESS_JSON ? JSON_INTERVAL : LINE_INTERVAL;
    double const now = timer_now();
    double const rest = progress_bar_estimate_rest(&progress->bar, done, count);
    char text[PROGRESS_DURATION_SIZE];
    if (progress->kind == PROGRESS_NONE) return;
    progress_format_duration(rest, text);
    if (progress->kind == PROGRESS_BAR) {
        if (count > 1)
            progress_bar_show(&progress->bar, done, count, "frames: %.0f %%  rest %s",
                              100.0 * (double)done / (double)count, text);
        return;
    }
    begin_json(progress, count);
    bool const is_last = progress->kind == PROGRESS_JSON && done == count;
    if (!is_last && now - progress->shown < interval) return;
    progress->shown = now;
    if (progress->kind == PROGRESS_LINES) {
        fprintf(stderr, "frames: %.0f %%  rest %s\n", 100.0 * (double)done / (double)count, text);
        return;
    }
    fprintf(stderr, "{\"event\":\"frames\",\"done\":%llu,\"count\":%llu,\"rest_seconds\":",
            (unsigned long long)done, (unsigned long long)count);
    json_print_double(stderr, rest);
    fputs("}\n", stderr);
    fflush(stderr);
}

void frame_progress_say(frame_progress *progress, const char *message) {
    frame_progress_clear(progress);
    if (progress->kind != PROGRESS_JSON) {
        app_print_message(progress->command, "%s", message);
        return;
    }
    fputs("{\"event\":\"message\",\"message\":", stderr);
    json_print_text(stderr, message);
    fputs("}\n", stderr);
    fflush(stderr);
}

void frame_progress_clear(frame_progress *progress) { progress_bar_clear(&progress->bar); }

void frame_progress_end(frame_progress *progress, tulle_status status) {
    frame_progress_clear(progress);
    if (progress->kind != PROGRESS_JSON) return;
    fprintf(stderr, "{\"event\":\"end\",\"state\":\"%s\"}\n",
            status == TULLE_OK                  ? "finished"
            : status == TULLE_ERROR_INTERRUPTED ? "interrupted"
                                                : "failed");
}
