/* app/run_progress.c - shows on standard error how far a run is: a bar with the time left, contacts
 * and smallest gap on a terminal; lines every ten seconds elsewhere; or JSON lines. */
#define _POSIX_C_SOURCE 200809L
#include "app/run_session.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { BAR_WIDTH = 24 /* [characters] */ };
static const double BAR_INTERVAL = 0.1;   /* [s] as often as an eye follows */
static const double LINE_INTERVAL = 10.0; /* [s] a log of a long run stays readable */
static const double MILLIMETRES_PER_METRE = 1000.0;

double run_clock(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void progress_begin(run_progress *progress, const char *kind) {
    *progress = (run_progress){.begin = run_clock()};
    progress->shown = progress->begin;
    if (strcmp(kind, "json") == 0)
        progress->kind = PROGRESS_JSON;
    else if (strcmp(kind, "auto") == 0)
        progress->kind = isatty(STDERR_FILENO) ? PROGRESS_BAR : PROGRESS_LINES;
}

/* [s] that the rest takes at the pace so far. */
static double estimate_rest(const run_session *session, uint64_t steps_done) {
    double const elapsed = run_clock() - session->progress.begin;
    uint64_t const left =
        session->wanted_steps > steps_done ? session->wanted_steps - steps_done : 0;
    uint64_t const done = session->totals.steps;
    return done > 0 ? elapsed / (double)done * (double)left : 0.0;
}

static void format_duration(double seconds, char text[32]) {
    double const capped = fmin(seconds, 3.6e8);
    long const total = (long)(capped + 0.5);
    if (total >= 3600)
        snprintf(text, 32, "%ld:%02ld:%02ld", total / 3600, total / 60 % 60, total % 60);
    else
        snprintf(text, 32, "%ld:%02ld", total / 60, total % 60);
}

static void format_gap(double gap, char text[32]) {
    if (isfinite(gap))
        snprintf(text, 32, "%.3g mm", gap * MILLIMETRES_PER_METRE);
    else
        snprintf(text, 32, "none near");
}

/* "frame 3/120  2 %  rest 0:41  1234 contacts  gap 0.31 mm" */
static void print_facts(const run_session *session, const tulle_step_report *report) {
    uint64_t const done = report->step + 1;
    uint32_t const steps_per_frame = scene_get_steps_per_frame(session->scene);
    char rest[32], gap[32];
    format_duration(estimate_rest(session, done), rest);
    format_gap(report->smallest_gap, gap);
    fprintf(stderr, "frame %llu/%u  %.0f %%  rest %s  %llu contacts  gap %s",
            (unsigned long long)(done / steps_per_frame), session->options.frame_count,
            100.0 * (double)done / (double)session->wanted_steps, rest,
            (unsigned long long)report->contacts, gap);
}

static void draw_bar(const run_session *session, const tulle_step_report *report) {
    char bar[BAR_WIDTH + 1];
    double const share = (double)(report->step + 1) / (double)session->wanted_steps;
    for (int i = 0; i < BAR_WIDTH; i++) bar[i] = i < (int)(share * BAR_WIDTH) ? '#' : '.';
    bar[BAR_WIDTH] = '\0';
    fprintf(stderr, "\r[%s] ", bar);
    print_facts(session, report);
    fputs("\033[K", stderr); /* clears the rest of the line */
    fflush(stderr);
}

/* A number, or null where JSON has none. */
static void print_json_number(const char *key, double value) {
    if (isfinite(value))
        fprintf(stderr, ",\"%s\":%.17g", key, value);
    else
        fprintf(stderr, ",\"%s\":null", key);
}

static void print_json_step(const run_session *session, const tulle_step_report *report) {
    uint64_t const done = report->step + 1;
    fprintf(stderr, "{\"event\":\"step\",\"step\":%llu,\"steps\":%llu,\"frame\":%llu,\"frames\":%u",
            (unsigned long long)done, (unsigned long long)session->wanted_steps,
            (unsigned long long)(done / scene_get_steps_per_frame(session->scene)),
            session->options.frame_count);
    print_json_number("time", report->time);
    print_json_number("seconds", report->total_seconds);
    print_json_number("rest_seconds", estimate_rest(session, done));
    fprintf(stderr, ",\"contacts\":%llu", (unsigned long long)report->contacts);
    print_json_number("smallest_gap", report->smallest_gap);
    fprintf(stderr, ",\"rescues\":%llu,\"substeps\":%u}\n",
            (unsigned long long)(report->rescue_impact_zones + report->rescue_component_scalings +
                                 report->rescue_global_scalings),
            report->substeps);
    fflush(stderr);
}

void progress_show_step(run_session *session, const tulle_step_report *report) {
    run_progress *const progress = &session->progress;
    double const now = run_clock();
    bool const is_last = report->step + 1 >= session->wanted_steps;
    if (progress->kind == PROGRESS_JSON) print_json_step(session, report);
    if (progress->kind == PROGRESS_BAR && (is_last || now - progress->shown >= BAR_INTERVAL)) {
        draw_bar(session, report);
        progress->has_line = true;
        progress->shown = now;
    }
    if (progress->kind == PROGRESS_LINES && now - progress->shown >= LINE_INTERVAL) {
        print_facts(session, report);
        fputc('\n', stderr);
        progress->shown = now;
    }
}

void progress_show_checkpoint(run_session *session) {
    if (session->progress.kind != PROGRESS_JSON) return;
    fprintf(stderr, "{\"event\":\"checkpoint\",\"step\":%llu}\n",
            (unsigned long long)session->checkpoint_step);
    fflush(stderr);
}

void progress_end(run_session *session, const char *outcome) {
    if (session->progress.has_line) fputc('\n', stderr);
    session->progress.has_line = false;
    if (session->progress.kind != PROGRESS_JSON) return;
    fprintf(stderr,
            "{\"event\":\"end\",\"state\":\"%s\",\"frames\":%u,\"state_hash\":\"%016llx\"}\n",
            outcome, tulle_run_get_frame_count(session->writer),
            (unsigned long long)tulle_world_get_state_hash(session->built.world));
    fflush(stderr);
}
