/* app/mend/report.c - see report.h. */
#include "app/mend/report.h"

#include "app/cli/json_text.h"
#include "base/error.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- departures and accelerations ---- */

tulle_status mend_history_open(size_t vertex_count, mend_history *history, tulle_error *error) {
    *history = (mend_history){.vertex_count = vertex_count};
    bool has_room = true;
    for (size_t i = 0; i < HISTORY_FRAMES; i++) {
        history->given[i] = calloc(vertex_count, 3 * sizeof(double));
        history->mended[i] = calloc(vertex_count, 3 * sizeof(double));
        has_room = has_room && history->given[i] && history->mended[i];
    }
    return has_room ? TULLE_OK
                    : error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for %zu vertices",
                                vertex_count);
}

void mend_history_close(mend_history *history) {
    for (size_t i = 0; i < HISTORY_FRAMES; i++) {
        free(history->given[i]);
        free(history->mended[i]);
    }
    *history = (mend_history){0};
}

static bool is_away(const mend_history *history, size_t slot, size_t vertex) {
    return memcmp(history->given[slot] + 3 * vertex, history->mended[slot] + 3 * vertex,
                  3 * sizeof(double)) != 0;
}

/* `slots`: of this frame and those before. */
static void measure_acceleration(double *const frames[HISTORY_FRAMES], const size_t slots[3],
                                 size_t vertex, double acceleration[3]) {
    for (size_t k = 0; k < 3; k++) {
        size_t const i = 3 * vertex + k;
        acceleration[k] = frames[slots[0]][i] - 2.0 * frames[slots[1]][i] + frames[slots[2]][i];
    }
}

static double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static mend_accelerations measure_motion(const mend_history *history,
                                         double *const frames[HISTORY_FRAMES]) {
    size_t slots[HISTORY_FRAMES], count = 0, jitter_count = 0;
    double sum = 0.0, largest = 0.0, jitter_sum = 0.0;
    for (size_t i = 0; i < HISTORY_FRAMES; i++)
        slots[i] = (history->count + HISTORY_FRAMES - 1 - i) % HISTORY_FRAMES;
    for (size_t v = 0; v < history->vertex_count && history->count >= 3; v++) {
        bool const is_here = is_away(history, slots[0], v) || is_away(history, slots[1], v) ||
                             is_away(history, slots[2], v);
        double now[3], before[3];
        measure_acceleration(frames, slots, v, now);
        if (is_here) {
            sum += dot(now, now);
            largest = fmax(largest, dot(now, now));
            count++;
        }
        if (history->count < 4 || !(is_here || is_away(history, slots[3], v))) continue;
        measure_acceleration(frames, slots + 1, v, before);
        jitter_sum += fmax(0.0, -dot(now, before));
        jitter_count++;
    }
    double const none = (double)NAN;
    return (mend_accelerations){count > 0 ? sqrt(sum / (double)count) : none,
                                count > 0 ? sqrt(largest) : none,
                                jitter_count > 0 ? sqrt(jitter_sum / (double)jitter_count) : none};
}

void mend_history_add(mend_history *history, const double *given, const double *mended,
                      mend_row *row) {
    size_t const slot = history->count++ % HISTORY_FRAMES,
                 size = 3 * history->vertex_count * sizeof(double);
    memcpy(history->given[slot], given, size);
    memcpy(history->mended[slot], mended, size);
    row->away_count = 0;
    row->mean = row->largest = 0.0;
    row->vertex = TULLE_NONE;
    for (size_t v = 0; v < history->vertex_count; v++) {
        if (!is_away(history, slot, v)) continue;
        double sum = 0.0;
        for (size_t k = 3 * v; k < 3 * v + 3; k++)
            sum += (mended[k] - given[k]) * (mended[k] - given[k]);
        double const departure = sqrt(sum);
        row->away_count++;
        row->mean += departure / (double)history->vertex_count;
        if (row->vertex != TULLE_NONE && !(departure > row->largest)) continue;
        row->largest = departure;
        row->vertex = (uint32_t)v;
    }
    row->given = measure_motion(history, history->given);
    row->mended = measure_motion(history, history->mended);
}

void mend_summary_add(mend_summary *summary, const mend_row *row) {
    summary->away_frames += row->away_count > 0;
    summary->bad_before += row->before.own + row->before.bodies > 0;
    summary->bad_after += row->after.own + row->after.bodies > 0;
    summary->crossing_frames += row->outcome.crosses;
    summary->lagging_frames += row->outcome.lag > 0.0;
    if (row->before.own > summary->before.own) summary->before.own = row->before.own;
    if (row->before.bodies > summary->before.bodies) summary->before.bodies = row->before.bodies;
    if (row->after.own > summary->after.own) summary->after.own = row->after.own;
    if (row->after.bodies > summary->after.bodies) summary->after.bodies = row->after.bodies;
    if (summary->frame_count++ == 0 || row->largest > summary->worst.largest) summary->worst = *row;
    if (isfinite(row->given.mean)) {
        summary->acceleration_frames++;
        summary->given2 += row->given.mean * row->given.mean;
        summary->mended2 += row->mended.mean * row->mended.mean;
        summary->given_most = fmax(summary->given_most, row->given.largest);
        summary->mended_most = fmax(summary->mended_most, row->mended.largest);
    }
    if (isfinite(row->given.jitter)) {
        summary->jitter_frames++;
        summary->given_jitter2 += row->given.jitter * row->given.jitter;
        summary->mended_jitter2 += row->mended.jitter * row->mended.jitter;
    }
    summary->lag = fmax(summary->lag, row->outcome.lag);
    summary->seconds += row->seconds;
    summary->slowest = fmax(summary->slowest, row->seconds);
}

static double get_mean(double sum2, uint32_t count) {
    return count > 0 ? sqrt(sum2 / (double)count) : (double)NAN;
}

/* ---- texts ---- */

void mend_report_begin_csv(FILE *file) {
    fputs("frame,own_before,bodies_before,own_after,bodies_after,away,mean_departure,largest_"
          "departure,vertex,given_acceleration,mended_acceleration,given_acceleration_largest,"
          "mended_acceleration_largest,given_jitter,mended_jitter,lag,moves,crosses,seconds\n",
          file);
}

static void print_number(FILE *file, double value) {
    if (isfinite(value))
        fprintf(file, ",%.9g", value);
    else
        fputc(',', file);
}

void mend_report_add_csv(FILE *file, const mend_row *row) {
    fprintf(file, "%" PRIu32 ",%zu,%zu,%zu,%zu,%zu", row->frame, row->before.own,
            row->before.bodies, row->after.own, row->after.bodies, row->away_count);
    print_number(file, row->mean);
    print_number(file, row->largest);
    if (row->vertex == TULLE_NONE)
        fputc(',', file);
    else
        fprintf(file, ",%" PRIu32, row->vertex);
    double const values[] = {row->given.mean,     row->mended.mean,  row->given.largest,
                             row->mended.largest, row->given.jitter, row->mended.jitter,
                             row->outcome.lag};
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) print_number(file, values[i]);
    fprintf(file, ",%" PRIu32 ",%d,%.3f\n", row->outcome.moves, row->outcome.crosses, row->seconds);
}

static void print_member(const char *name, double value) {
    printf(",\"%s\":", name);
    json_print_double(stdout, value);
}

static void print_pairs_json(const mend_pairs *before, const mend_pairs *after) {
    printf(",\"own_before\":%zu,\"bodies_before\":%zu,\"own_after\":%zu,\"bodies_after\":%zu",
           before->own, before->bodies, after->own, after->bodies);
}

static void print_vertex_json(uint32_t vertex) {
    if (vertex == TULLE_NONE)
        fputs(",\"vertex\":null", stdout);
    else
        printf(",\"vertex\":%" PRIu32, vertex);
}

void mend_report_print_row_json(const mend_row *row) {
    printf("{\"frame\":%" PRIu32, row->frame);
    print_pairs_json(&row->before, &row->after);
    printf(",\"away\":%zu", row->away_count);
    print_member("mean_departure", row->mean);
    print_member("largest_departure", row->largest);
    print_vertex_json(row->vertex);
    print_member("given_acceleration", row->given.mean);
    print_member("mended_acceleration", row->mended.mean);
    print_member("given_acceleration_largest", row->given.largest);
    print_member("mended_acceleration_largest", row->mended.largest);
    print_member("given_jitter", row->given.jitter);
    print_member("mended_jitter", row->mended.jitter);
    print_member("lag", row->outcome.lag);
    printf(",\"moves\":%" PRIu32 ",\"crosses\":%s", row->outcome.moves,
           row->outcome.crosses ? "true" : "false");
    print_member("seconds", row->seconds);
    puts("}");
    fflush(stdout);
}

void mend_report_print_summary_json(const mend_summary *summary) {
    printf("{\"frames\":%" PRIu32 ",\"frames_away\":%" PRIu32 ",\"bad_frames_before\":%" PRIu32
           ",\"bad_frames_after\":%" PRIu32,
           summary->frame_count, summary->away_frames, summary->bad_before, summary->bad_after);
    print_pairs_json(&summary->before, &summary->after);
    print_member("largest_departure", summary->worst.largest);
    printf(",\"worst_frame\":%" PRIu32, summary->worst.frame);
    print_vertex_json(summary->worst.vertex);
    print_member("given_acceleration", get_mean(summary->given2, summary->acceleration_frames));
    print_member("mended_acceleration", get_mean(summary->mended2, summary->acceleration_frames));
    print_member("given_jitter", get_mean(summary->given_jitter2, summary->jitter_frames));
    print_member("mended_jitter", get_mean(summary->mended_jitter2, summary->jitter_frames));
    printf(",\"frames_crossing\":%" PRIu32 ",\"frames_lagging\":%" PRIu32, summary->crossing_frames,
           summary->lagging_frames);
    print_member("lag", summary->lag);
    print_member("seconds", summary->seconds);
    puts("}");
}

static void print_pairs(const char *label, const mend_pairs *pairs, uint32_t bad_frames) {
    printf("  %-11s %zu pairs of the cloth with itself, %zu with bodies, at most in a frame; in "
           "%" PRIu32 " frame%s\n",
           label, pairs->own, pairs->bodies, bad_frames, bad_frames == 1 ? "" : "s");
}

void mend_report_print_summary(const mend_summary *summary) {
    print_pairs("before", &summary->before, summary->bad_before);
    print_pairs("after", &summary->after, summary->bad_after);
    if (summary->away_frames == 0)
        printf("  %-11s none; all %" PRIu32 " frames are as they were given\n", "departure",
               summary->frame_count);
    else
        printf("  %-11s at most %.3g, at vertex %" PRIu32 " in frame %" PRIu32 "; %" PRIu32
               " of %" PRIu32 " frames are not as they were given\n",
               "departure", summary->worst.largest, summary->worst.vertex, summary->worst.frame,
               summary->away_frames, summary->frame_count);
    if (summary->acceleration_frames > 0)
        printf("  %-11s %.3g a frame^2 where the cloth departs, given %.3g; at most %.3g, given "
               "%.3g\n",
               "acceleration", get_mean(summary->mended2, summary->acceleration_frames),
               get_mean(summary->given2, summary->acceleration_frames), summary->mended_most,
               summary->given_most);
    if (summary->jitter_frames > 0)
        printf("  %-11s %.3g a frame^2 of it turns round from frame to frame, given %.3g\n",
               "jitter", get_mean(summary->mended_jitter2, summary->jitter_frames),
               get_mean(summary->given_jitter2, summary->jitter_frames));
    if (summary->lagging_frames > 0)
        printf("  %-11s in %" PRIu32
               " frame%s bodies leave the cloth no room: it meets bodies that lag by %.3g\n",
               "pinched", summary->lagging_frames, summary->lagging_frames == 1 ? "" : "s",
               summary->lag);
    if (summary->crossing_frames > 0)
        printf("  %-11s into %" PRIu32 " frame%s the straight motion crosses something\n",
               "on the way", summary->crossing_frames, summary->crossing_frames == 1 ? "" : "s");
    printf("  %-11s %.3g s, %.3g s a frame, at most %.3g s\n", "time", summary->seconds,
           summary->seconds / (double)summary->frame_count, summary->slowest);
}
