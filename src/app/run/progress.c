/* app/run/progress.c - shows on standard error how far a run is: a bar with the time left, contacts
 * and smallest gap on a terminal; lines every ten seconds elsewhere; or JSON lines. */
#include "app/cli/json_text.h"
#include "app/commands.h"
#include "app/run/session.h"
#include "base/timer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { FACTS_SIZE = 160 /* [bytes] */ };
static const double LINE_INTERVAL = 10.0; /* [s] a log of a long run stays readable */
static const double JSON_INTERVAL =
    1.0; /* [s] between two lines about untangling or about a long step */
static const double LONG_STEP =
    3.0; /* [s] a step that takes longer is shown while it is under way */
static const double MILLIMETRES_PER_METRE = 1000.0;

void progress_begin(run_progress *progress, const char *kind) {
    *progress = (run_progress){.bar = progress_bar_begin(), .shown = timer_now()};
    progress->kind = progress_choose_kind(kind, &progress->bar);
}

/* [s] that the rest takes at the pace of this session. */
static double estimate_rest(const run_session *session, uint64_t steps_done) {
    uint64_t const left =
        session->wanted_steps > steps_done ? session->wanted_steps - steps_done : 0;
    uint64_t const done = session->totals.steps;
    return progress_bar_estimate_rest(&session->progress.bar, done, done + left);
}

static void format_gap(double gap, char text[32]) {
    if (isfinite(gap))
        snprintf(text, 32, "%.3g mm", gap * MILLIMETRES_PER_METRE);
    else
        snprintf(text, 32, "none near");
}

/* "frame 3/120  2 %  rest 0:41  1234 contacts  gap 0.31 mm" */
static const char *format_facts(const run_session *session, const tulle_step_report *report,
                                char text[FACTS_SIZE]) {
    uint64_t const done = report->step + 1;
    uint32_t const steps_per_frame = tulle_scene_get_steps_per_frame(session->scene);
    char rest[PROGRESS_DURATION_SIZE], gap[32];
    progress_format_duration(estimate_rest(session, done), rest);
    format_gap(report->smallest_gap, gap);
    snprintf(text, FACTS_SIZE, "frame %llu/%u  %.0f %%  rest %s  %llu contacts  gap %s",
             (unsigned long long)(done / steps_per_frame), session->options.frame_count,
             100.0 * (double)done / (double)session->wanted_steps, rest,
             (unsigned long long)report->contacts, gap);
    return text;
}

/* `,"KEY":VALUE` */
static void print_json_number(const char *key, double value) {
    fprintf(stderr, ",\"%s\":", key);
    json_print_double(stderr, value);
}

static void print_json_step(const run_session *session, const tulle_step_report *report) {
    uint64_t const done = report->step + 1;
    fprintf(stderr, "{\"event\":\"step\",\"step\":%llu,\"steps\":%llu,\"frame\":%llu,\"frames\":%u",
            (unsigned long long)done, (unsigned long long)session->wanted_steps,
            (unsigned long long)(done / tulle_scene_get_steps_per_frame(session->scene)),
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

void progress_show_begin(run_session *session, bool goes_on) {
    if (session->progress.kind != PROGRESS_JSON) return;
    fprintf(stderr, "{\"event\":\"begin\",\"goes_on\":%s,\"step\":%llu,\"steps\":%llu}\n",
            goes_on ? "true" : "false", (unsigned long long)session->checkpoint_step,
            (unsigned long long)session->wanted_steps);
    fflush(stderr);
}

void progress_show_step(run_session *session, const tulle_step_report *report) {
    run_progress *const progress = &session->progress;
    char facts[FACTS_SIZE];
    if (progress->kind == PROGRESS_JSON) print_json_step(session, report);
    if (progress->kind == PROGRESS_BAR)
        progress_bar_show(&progress->bar, report->step + 1, session->wanted_steps, "%s",
                          format_facts(session, report, facts));
    if (progress->kind == PROGRESS_LINES && timer_now() - progress->shown >= LINE_INTERVAL) {
        fprintf(stderr, "%s\n", format_facts(session, report, facts));
        progress->shown = timer_now();
    }
}

void progress_show_step_under_way(run_session *session) {
    run_progress *const progress = &session->progress;
    if (progress->kind == PROGRESS_NONE) return; /* asked in each iteration of a solve */
    double const now = timer_now(), seconds = now - progress->step_begin;
    bool const is_json = progress->kind == PROGRESS_JSON;
    if (seconds < LONG_STEP) return;
    tulle_step_progress const under_way = tulle_world_get_step_progress(session->built.world);
    unsigned long long const step = (unsigned long long)under_way.step + 1;
    if (progress->kind == PROGRESS_BAR)
        progress_bar_show(&progress->bar, under_way.step, session->wanted_steps,
                          "step %llu under way for %.0f s: substep %u, %.0f %% of its time", step,
                          seconds, under_way.substep, 100.0 * under_way.share);
    if (progress->kind == PROGRESS_BAR ||
        now - progress->shown < (is_json ? JSON_INTERVAL : LINE_INTERVAL))
        return;
    fprintf(stderr,
            is_json ? "{\"event\":\"substep\",\"step\":%llu,\"seconds\":%.3f,\"substep\":%u,"
                      "\"share\":%.6f}\n"
                    : "step %llu under way for %.0f s: substep %u, %.3g of its time\n",
            step, seconds, under_way.substep, under_way.share);
    fflush(stderr);
    progress->shown = now;
}

void progress_show_untangling(run_session *session) {
    run_progress *const progress = &session->progress;
    tulle_untangle_report const report = tulle_world_get_untangle_report(session->built.world);
    bool const is_json = progress->kind == PROGRESS_JSON;
    double const interval = !is_json ? LINE_INTERVAL : report.rounds > 0 ? JSON_INTERVAL : 0.0;
    if (progress->kind == PROGRESS_BAR)
        progress_bar_show(&progress->bar, report.intersections - report.left, report.intersections,
                          "untangling: %llu pairs left, round %u", (unsigned long long)report.left,
                          report.rounds);
    if (progress->kind == PROGRESS_BAR || progress->kind == PROGRESS_NONE ||
        timer_now() - progress->shown < interval)
        return;
    fprintf(stderr,
            is_json ? "{\"event\":\"untangle\",\"round\":%u,\"left\":%llu,\"intersections\":%llu}\n"
                    : "untangling: round %u, %llu of %llu pairs left\n",
            report.rounds, (unsigned long long)report.left,
            (unsigned long long)report.intersections);
    fflush(stderr);
    progress->shown = timer_now();
}

void progress_show_message(run_session *session, const tulle_step_report *report,
                           const char *message) {
    run_progress *const progress = &session->progress;
    if (progress->kind == PROGRESS_JSON) {
        fprintf(stderr, "{\"event\":\"message\",\"step\":%llu",
                (unsigned long long)report->step + 1);
        print_json_number("time", report->time);
        fputs(",\"message\":", stderr);
        json_print_text(stderr, message);
        fputs("}\n", stderr);
        fflush(stderr);
        return;
    }
    progress_bar_clear(&progress->bar);
    app_print_message("run", "%s", message);
}

void progress_show_checkpoint(run_session *session) {
    if (session->progress.kind != PROGRESS_JSON) return;
    fprintf(stderr, "{\"event\":\"checkpoint\",\"step\":%llu}\n",
            (unsigned long long)session->checkpoint_step);
    fflush(stderr);
}

void progress_end(run_session *session, const char *outcome) {
    progress_bar_end(&session->progress.bar);
    if (session->progress.kind != PROGRESS_JSON) return;
    fprintf(stderr,
            "{\"event\":\"end\",\"state\":\"%s\",\"frames\":%u,\"state_hash\":\"%016llx\"}\n",
            outcome, tulle_run_get_frame_count(session->writer),
            (unsigned long long)tulle_world_get_state_hash(session->built.world));
    fflush(stderr);
}
