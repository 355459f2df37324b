/* app/check/subdivided_check.c - see subdivided_check.h. */
#include "app/check/subdivided_check.h"

#include "app/check/frame.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Appends to a text that is cut where it is full. */
static void append(char text[SUBDIVIDED_TEXT_SIZE], const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static void append(char text[SUBDIVIDED_TEXT_SIZE], const char *format, ...) {
    size_t const length = strlen(text);
    va_list values;
    va_start(values, format);
    (void)vsnprintf(text + length, SUBDIVIDED_TEXT_SIZE - length, format, values);
    va_end(values);
}

static const char *get_plural(size_t count) { return count == 1 ? "" : "s"; }

/* Counts the pairs of triangles of the first few pairs of bodies. */
static void sort_by_bodies(const tulle_check_result *result, subdivided_verdict *verdict) {
    for (size_t i = 0; i < result->pair_count; i++) {
        const tulle_check_pair *const pair = &result->pairs[i];
        size_t at = 0;
        while (at < verdict->body_pair_count && (verdict->body_pairs[at].body_a != pair->body_a ||
                                                 verdict->body_pairs[at].body_b != pair->body_b))
            at++;
        if (at == SUBDIVIDED_LIST_MAX) continue;
        if (at == verdict->body_pair_count)
            verdict->body_pairs[verdict->body_pair_count++] =
                (subdivided_body_pair){pair->body_a, pair->body_b, 0};
        verdict->body_pairs[at].pair_count++;
    }
}

/* ": sheet with itself 8, sheet with spike 4, others 2" */
static void describe_bodies(const subdivided_frame *frame, subdivided_verdict *verdict) {
    size_t rest = verdict->pair_count;
    for (size_t i = 0; i < verdict->body_pair_count; i++) {
        const subdivided_body_pair *const pair = &verdict->body_pairs[i];
        append(verdict->text, "%s%s with %s", i == 0 ? ": " : ", ", frame->names[pair->body_a],
               pair->body_a == pair->body_b ? "itself" : frame->names[pair->body_b]);
        if (pair->pair_count < verdict->pair_count) append(verdict->text, " %zu", pair->pair_count);
        rest -= pair->pair_count;
    }
    if (rest > 0) append(verdict->text, ", others %zu", rest);
}

static void describe(const subdivided_frame *frame, subdivided_verdict *verdict) {
    if (frame->number != SUBDIVIDED_NO_FRAME) append(verdict->text, "frame %ld: ", frame->number);
    append(verdict->text, "the subdivided surface intersects in %zu pair%s of triangles",
           verdict->pair_count, get_plural(verdict->pair_count));
    describe_bodies(frame, verdict);
    double place[3];
    check_compute_place(frame->bodies, &verdict->pairs[0], place);
    append(verdict->text, "; the first near (%.6g, %.6g, %.6g)", place[0], place[1], place[2]);
    if (frame->simulated && verdict->simulated_pair_count == 0)
        append(verdict->text, "; the simulated surface does not intersect");
    else if (frame->simulated)
        append(verdict->text, "; the simulated surface intersects in %zu pair%s",
               verdict->simulated_pair_count, get_plural(verdict->simulated_pair_count));
}

static tulle_status count_simulated(const subdivided_frame *frame, int threads,
                                    subdivided_verdict *verdict, tulle_error *error) {
    tulle_check_result result;
    if (!frame->simulated) return TULLE_OK;
    tulle_status const status =
        tulle_check_intersections(frame->simulated, frame->body_count, threads, &result, error);
    if (status != TULLE_OK) return status;
    verdict->simulated_pair_count = result.pair_count;
    tulle_check_result_destroy(&result);
    return TULLE_OK;
}

tulle_status subdivided_check_frame(const subdivided_frame *frame, int threads,
                                    subdivided_verdict *verdict, tulle_error *error) {
    *verdict = (subdivided_verdict){0};
    tulle_check_result result;
    tulle_status status =
        tulle_check_intersections(frame->bodies, frame->body_count, threads, &result, error);
    if (status != TULLE_OK) return status;
    subdivided_verdict found = {.pair_count = result.pair_count};
    if (result.pair_count > 0) status = count_simulated(frame, threads, &found, error);
    if (result.pair_count > 0 && status == TULLE_OK) {
        while (found.listed_count < SUBDIVIDED_LIST_MAX && found.listed_count < result.pair_count) {
            found.pairs[found.listed_count] = result.pairs[found.listed_count];
            found.listed_count++;
        }
        sort_by_bodies(&result, &found);
        describe(frame, &found);
    }
    tulle_check_result_destroy(&result);
    if (status == TULLE_OK) *verdict = found;
    return status;
}

void subdivided_totals_add(subdivided_totals *totals, const subdivided_verdict *verdict) {
    totals->frame_count++;
    totals->pair_count += verdict->pair_count;
    if (verdict->pair_count == 0) return;
    if (totals->bad_frame_count++ == 0) (void)strcpy(totals->first_text, verdict->text);
}

void subdivided_totals_describe(const subdivided_totals *totals, char text[SUBDIVIDED_TEXT_SIZE]) {
    text[0] = '\0';
    if (totals->frame_count == 1 && totals->bad_frame_count == 1)
        append(text, "%s", totals->first_text);
    else if (totals->bad_frame_count > 0)
        append(text,
               "the subdivided surface intersects in %zu of %zu frames, %zu pairs of triangles in "
               "all; %s",
               totals->bad_frame_count, totals->frame_count, totals->pair_count,
               totals->first_text);
    else
        append(text, "the subdivided surface does not intersect (%zu frame%s judged)",
               totals->frame_count, get_plural(totals->frame_count));
}
