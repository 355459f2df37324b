/* app/check/report.c - the verdicts of `tulle check` as text or as JSON lines, and the judging of
 * frames side by side. See frame.h. */
#include "app/check/frame.h"
#include "app/cli/json_text.h"
#include "app/commands.h"
#include "base/parallel.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

typedef struct judge_context {
    check_frame *frames;
    int threads_per_frame;
} judge_context;

static void judge_frame(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    (void)worker;
    const judge_context *const judge = context;
    for (size_t i = begin; i < end; i++) {
        check_frame *const frame = &judge->frames[i];
        frame->status =
            tulle_check_intersections(frame->bodies, frame->body_count, judge->threads_per_frame,
                                      &frame->result, &frame->error);
    }
}

void check_frames_judge(check_frame *frames, size_t count, int threads) {
    judge_context context = {frames, count > 1 ? 1 : threads};
    parallel_for(count, 1, threads, judge_frame, &context);
}

static const double *get_corner(const tulle_check_body *body, uint32_t triangle, size_t corner) {
    return body->mesh.positions + 3 * (size_t)body->mesh.triangles[3 * (size_t)triangle + corner];
}

void check_compute_place(const tulle_check_body *bodies_of_frame, const tulle_check_pair *pair,
                         double place[3]) {
    const tulle_check_body *const bodies[2] = {&bodies_of_frame[pair->body_a],
                                               &bodies_of_frame[pair->body_b]};
    uint32_t const triangles[2] = {pair->triangle_a, pair->triangle_b};
    for (int axis = 0; axis < 3; axis++) {
        double lows[2], highs[2];
        for (int side = 0; side < 2; side++) {
            lows[side] = highs[side] = get_corner(bodies[side], triangles[side], 0)[axis];
            for (size_t corner = 1; corner < 3; corner++) {
                double const x = get_corner(bodies[side], triangles[side], corner)[axis];
                if (x < lows[side]) lows[side] = x;
                if (x > highs[side]) highs[side] = x;
            }
        }
        double const low = lows[0] > lows[1] ? lows[0] : lows[1];
        double const high = highs[0] < highs[1] ? highs[0] : highs[1];
        place[axis] = 0.5 * low + 0.5 * high;
    }
}

static void print_pair_json(const check_frame *frame, const tulle_check_pair *pair) {
    double place[3];
    check_compute_place(frame->bodies, pair, place);
    if (frame->to_scene) axes_apply(frame->to_scene, place, 1);
    fputs("{\"a\":", stdout);
    json_print_text(stdout, frame->names[pair->body_a]);
    printf(",\"triangle_a\":%" PRIu32 ",\"b\":", pair->triangle_a);
    json_print_text(stdout, frame->names[pair->body_b]);
    printf(",\"triangle_b\":%" PRIu32 ",\"near\":", pair->triangle_b);
    for (int axis = 0; axis < 3; axis++) {
        putchar(axis == 0 ? '[' : ',');
        json_print_double(stdout, place[axis]);
    }
    fputs("]}", stdout);
}

static void print_pair_text(const check_frame *frame, const tulle_check_pair *pair) {
    double place[3];
    check_compute_place(frame->bodies, pair, place);
    if (frame->to_scene) axes_apply(frame->to_scene, place, 1);
    app_print_names(
        stdout, "  %s triangle %" PRIu32 " and %s triangle %" PRIu32 " near (%.6g, %.6g, %.6g)\n",
        frame->names[pair->body_a], pair->triangle_a, frame->names[pair->body_b], pair->triangle_b,
        place[0], place[1], place[2]);
}

static size_t get_listed_count(const check_report *report, const check_frame *frame) {
    size_t const count = frame->result.pair_count;
    return report->list_limit < 0 || count <= (size_t)report->list_limit
               ? count
               : (size_t)report->list_limit;
}

/* What lags, and what the drawn surfaces cross: no part of the verdict. */
static void print_lags_json(const check_frame *frame) {
    fputs(",\"lags\":[", stdout);
    for (size_t i = 0; i < frame->lag_count; i++) {
        const tulle_run_lag *const lag = &frame->lags[i];
        fputs(i > 0 ? ",{\"body\":" : "{\"body\":", stdout);
        json_print_text(stdout, frame->run_bodies[lag->body].name);
        printf(",\"vertex\":%" PRIu32 ",\"lag\":", lag->vertex);
        json_print_double(stdout, lag->lag);
        printf(",\"drawn_crossings\":%" PRIu64 "}", lag->drawn_crossings);
    }
    fputs("]", stdout);
}

static void print_lags_text(const check_frame *frame) {
    for (size_t i = 0; i < frame->lag_count; i++) {
        const tulle_run_lag *const lag = &frame->lags[i];
        app_print_names(stdout,
                        "  apart: %s lags behind its frames by %.3g mm at vertex %" PRIu32
                        "; as drawn it crosses cloth in %" PRIu64 " pair%s\n",
                        frame->run_bodies[lag->body].name, 1000.0 * lag->lag, lag->vertex,
                        lag->drawn_crossings, lag->drawn_crossings == 1 ? "" : "s");
    }
}

static void print_frame_json(const check_report *report, const check_frame *frame) {
    fputs("{\"source\":", stdout);
    json_print_text(stdout, frame->source);
    if (frame->number != CHECK_FRAME_OF_FILE) {
        printf(",\"frame\":%ld,\"time\":", frame->number);
        json_print_double(stdout, frame->time);
    }
    printf(",\"intersections\":%zu,\"pairs\":[", frame->result.pair_count);
    for (size_t i = 0; i < get_listed_count(report, frame); i++) {
        if (i > 0) putchar(',');
        print_pair_json(frame, &frame->result.pairs[i]);
    }
    fputs("]", stdout);
    if (frame->lag_count > 0) print_lags_json(frame);
    fputs("}\n", stdout);
}

static void print_frame_text(const check_report *report, const check_frame *frame) {
    size_t const count = frame->result.pair_count, listed = get_listed_count(report, frame);
    if (frame->number == CHECK_FRAME_OF_FILE)
        app_print_names(stdout, "%s: ", frame->source);
    else if (isnan(frame->time))
        app_print_names(stdout, "%s frame %ld: ", frame->source, frame->number);
    else
        app_print_names(stdout, "%s frame %ld (%.6g s): ", frame->source, frame->number,
                        frame->time);
    printf("%zu intersection%s\n", count, count == 1 ? "" : "s");
    for (size_t i = 0; i < listed; i++) print_pair_text(frame, &frame->result.pairs[i]);
    if (listed > 0 && listed < count) printf("  and %zu more\n", count - listed);
    print_lags_text(frame);
}

void check_report_frame(const check_report *report, const check_frame *frame,
                        check_totals *totals) {
    totals->frame_count++;
    totals->bad_frame_count += frame->result.pair_count > 0;
    totals->intersection_count += frame->result.pair_count;
    if (report->is_json)
        print_frame_json(report, frame);
    else
        print_frame_text(report, frame);
}

void check_report_totals(const check_report *report, const check_totals *totals) {
    if (report->is_json)
        printf("{\"frames\":%" PRIu64 ",\"frames_with_intersections\":%" PRIu64
               ",\"intersections\":%" PRIu64 "}\n",
               totals->frame_count, totals->bad_frame_count, totals->intersection_count);
    else if (totals->intersection_count == 0)
        printf("0 intersections in %" PRIu64 " frames\n", totals->frame_count);
    else
        printf("%" PRIu64 " intersections in %" PRIu64 " of %" PRIu64 " frames\n",
               totals->intersection_count, totals->bad_frame_count, totals->frame_count);
}
