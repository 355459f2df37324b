/* app/bench/compare.c - what got worse or changed between two tables of measures.
 *
 * Times are judged between equal processors only. A time is slower when even its minimum is above
 * the baseline's median by more than both spreads. It is faster when its median is below the
 * baseline's minimum by as much. Where other work ran on the machine, then or now, the clock says
 * little: only processor time is judged, and it must differ by a bound, too. Counts do not depend
 * on the machine: from the same state they must be the same. Instructions and memory may differ by
 * a small bound. */
#include "app/bench/bench.h"

#include <math.h>
#include <string.h>

/* Stages below this share of the step, before and now, are not judged: their times are those of the
 * clock and the caches. */
static const double LEAST_SHARE = 0.01;
/* [share] Other work on the machine changes the processor time of the same steps, through the
 * caches: 7 % was seen.
 */
static const double DISTURBED_BOUND = 0.25;
/* [share] The C library chooses code by the processor, which changes less; a change of our code
 * changes more. */
static const double INSTRUCTION_BOUND = 0.005;
static const double MEMORY_BOUND =
    0.05; /* growth of arrays by doubling is not to be flagged twice */

typedef struct comparison {
    const bench_rows *baseline, *rows;
    FILE *stream;
    bool judges_times, judges_instructions;
    size_t compared, slower, faster, changed, grown, without_baseline, other_inputs;
} comparison;

/* Whether both have the same text, and have one at all. */
static bool is_equal_text(const comparison *self, const bench_row *of, bench_kind kind,
                          const char *name) {
    const bench_row *const old = bench_rows_find_beside(self->baseline, of, kind, name);
    const bench_row *const now = bench_rows_find_beside(self->rows, of, kind, name);
    return old && now && strcmp(old->text, now->text) == 0;
}

static void tell(const comparison *self, const char *verdict, const bench_row *row,
                 const char *format, double old, double now) {
    char numbers[2][48];
    /* the formats are those of this file */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    snprintf(numbers[0], sizeof numbers[0], format, old);
    snprintf(numbers[1], sizeof numbers[1], format, now);
#pragma GCC diagnostic pop
    fprintf(self->stream, "%-8s %s %s, %d thread%s, %s: %s, was %s", verdict, row->scene, row->size,
            row->threads, row->threads == 1 ? "" : "s", row->name, numbers[1], numbers[0]);
    if (old > 0.0) fprintf(self->stream, ", %.3f times", now / old);
}

static bool is_worth_judging(const comparison *self, const bench_row *old, const bench_row *now) {
    const bench_row *const old_step =
        bench_rows_find_beside(self->baseline, old, BENCH_TIME, "step");
    const bench_row *const step = bench_rows_find_beside(self->rows, now, BENCH_TIME, "step");
    return (old_step && old->value >= LEAST_SHARE * old_step->value) ||
           (step && now->value >= LEAST_SHARE * step->value);
}

static void compare_times(comparison *self, const bench_row *old, const bench_row *now) {
    bool const is_busy = bench_rows_were_disturbed(self->baseline, old) ||
                         bench_rows_were_disturbed(self->rows, now);
    if (!self->judges_times || !is_worth_judging(self, old, now)) return;
    if (is_busy && strcmp(now->name, "step") == 0)
        fprintf(
            self->stream,
            "note:    %s %s, %d thread%s: other work ran beside; only processor time is compared\n",
            now->scene, now->size, now->threads, now->threads == 1 ? "" : "s");
    if (is_busy && strcmp(now->name, "processor") != 0) return;
    double const spreads =
        fmax(old->spread + now->spread, is_busy ? DISTURBED_BOUND * old->value : 0.0);
    bool const is_slower = now->minimum > old->value + spreads;
    bool const is_faster = now->value + spreads < old->minimum;
    self->compared++;
    self->slower += is_slower;
    self->faster += is_faster;
    if (!is_slower && !is_faster) return;
    tell(self, is_slower ? "slower:" : "faster:", now, "%.4g ms", 1e3 * old->value,
         1e3 * now->value);
    fprintf(self->stream, " (spreads %.2g and %.2g ms)\n", 1e3 * old->spread, 1e3 * now->spread);
}

static void compare_counts(comparison *self, const bench_row *old, const bench_row *now) {
    self->compared++;
    if (now->kind == BENCH_HASH) {
        if (strcmp(old->text, now->text) == 0) return;
        self->changed++;
        fprintf(self->stream, "%-8s %s %s, %d thread%s: the steps end in another state\n",
                "changed:", now->scene, now->size, now->threads, now->threads == 1 ? "" : "s");
    } else if (old->value < now->value || old->value > now->value) {
        self->changed++;
        tell(self, "changed:", now, "%.0f", old->value, now->value);
        fputc('\n', self->stream);
    }
}

static void compare_bounded(comparison *self, const bench_row *old, const bench_row *now,
                            double bound) {
    self->compared++;
    bool const has_grown = now->value > old->value * (1.0 + bound);
    bool const has_shrunk = now->value < old->value * (1.0 - bound);
    self->grown += has_grown;
    self->faster += has_shrunk;
    if (!has_grown && !has_shrunk) return;
    tell(self, has_grown ? "more:" : "less:", now,
         now->kind == BENCH_INSTRUCTIONS ? "%.0f instructions" : "%.0f", old->value, now->value);
    fputc('\n', self->stream);
}

static void compare_row(comparison *self, const bench_row *now) {
    const bench_row *const old = bench_rows_find(self->baseline, now);
    bool const has_same_input = is_equal_text(self, now, BENCH_HASH, "start");
    bool const is_start = now->kind == BENCH_HASH && strcmp(now->name, "start") == 0;
    bool const is_first = now->kind == BENCH_TIME && strcmp(now->name, "step") == 0;
    if (now->kind == BENCH_ABOUT) return;
    if (!old) {
        self->without_baseline += is_first;
        return;
    }
    if (is_start && !has_same_input) {
        self->other_inputs++;
        fprintf(self->stream,
                "note:    %s %s, %d thread%s: starts from another state than the baseline did; its "
                "counts and instructions are not compared\n",
                now->scene, now->size, now->threads, now->threads == 1 ? "" : "s");
    }
    if (now->kind == BENCH_TIME) compare_times(self, old, now);
    if (now->kind == BENCH_MEMORY) compare_bounded(self, old, now, MEMORY_BOUND);
    if (!has_same_input || is_start) return;
    if (now->kind == BENCH_COUNT || now->kind == BENCH_HASH) compare_counts(self, old, now);
    if (now->kind == BENCH_INSTRUCTIONS && self->judges_instructions)
        compare_bounded(self, old, now, INSTRUCTION_BOUND);
}

/* What cannot be judged between these two. */
static void tell_conditions(comparison *self) {
    bench_row const about = {.kind = BENCH_ABOUT};
    self->judges_times = is_equal_text(self, &about, BENCH_ABOUT, "processor");
    self->judges_instructions = is_equal_text(self, &about, BENCH_ABOUT, "compiler");
    if (!self->judges_times)
        fputs("note:    the baseline was measured on another processor; times are not compared\n",
              self->stream);
    if (!self->judges_instructions)
        fputs(
            "note:    the baseline was built by another compiler; instructions are not compared\n",
            self->stream);
}

bench_verdict bench_compare(const bench_rows *baseline, const bench_rows *rows, FILE *stream) {
    comparison self = {.baseline = baseline, .rows = rows, .stream = stream};
    tell_conditions(&self);
    for (size_t i = 0; i < rows->count; i++) compare_row(&self, &rows->items[i]);
    if (self.without_baseline > 0)
        fprintf(stream, "note:    %zu cases are not in the baseline\n", self.without_baseline);
    fprintf(stream,
            "compared %zu measures: %zu slower, %zu changed, %zu more of instructions or memory; "
            "%zu faster or less\n",
            self.compared, self.slower, self.changed, self.grown, self.faster);
    return (bench_verdict){.compared = self.compared,
                           .worse = self.slower + self.changed + self.grown};
}
