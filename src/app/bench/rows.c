/* app/bench/rows.c - see rows.h. */
#include "app/bench/rows.h"

#include "base/sort.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Time of the clock over processor time; undisturbed, system calls and page faults take a few per
 * cent. */
static const double MOST_WAITING = 1.1;

static bool is_same(const bench_row *a, const bench_row *b) {
    return a->kind == b->kind && a->threads == b->threads && strcmp(a->scene, b->scene) == 0 &&
           strcmp(a->size, b->size) == 0 && strcmp(a->name, b->name) == 0;
}

const bench_row *bench_rows_find(const bench_rows *rows, const bench_row *key) {
    for (size_t i = 0; i < rows->count; i++)
        if (is_same(&rows->items[i], key)) return &rows->items[i];
    return NULL;
}

const bench_row *bench_rows_find_beside(const bench_rows *rows, const bench_row *of,
                                        bench_kind kind, const char *name) {
    bench_row key = *of;
    key.kind = kind;
    snprintf(key.name, sizeof key.name, "%s", name);
    return bench_rows_find(rows, &key);
}

bool bench_rows_put(bench_rows *rows, const bench_row *row) {
    const bench_row *const old = bench_rows_find(rows, row);
    if (old) {
        rows->items[old - rows->items] = *row;
        return true;
    }
    if (rows->count == rows->capacity) {
        size_t const capacity = rows->capacity ? 2 * rows->capacity : 256;
        bench_row *const items = realloc(rows->items, capacity * sizeof *items);
        if (!items) return false;
        rows->items = items;
        rows->capacity = capacity;
    }
    rows->items[rows->count++] = *row;
    return true;
}

void bench_rows_destroy(bench_rows *rows) {
    free(rows->items);
    *rows = (bench_rows){0};
}

bool bench_rows_were_disturbed(const bench_rows *rows, const bench_row *of) {
    bench_row key = *of;
    key.threads = 1;
    const bench_row *const wall = bench_rows_find_beside(rows, &key, BENCH_TIME, "step");
    const bench_row *const used = bench_rows_find_beside(rows, &key, BENCH_TIME, "processor");
    return wall && used && wall->minimum > MOST_WAITING * used->minimum;
}

/* Of sorted samples. */
static double compute_median(const double *samples, size_t count) {
    return 0.5 * (samples[(count - 1) / 2] + samples[count / 2]);
}

void bench_row_summarize(bench_row *row, double *samples, size_t count) {
    qsort(samples, count, sizeof *samples, compare_doubles);
    row->value = compute_median(samples, count);
    row->minimum = samples[0];
    for (size_t i = 0; i < count; i++) samples[i] = fabs(samples[i] - row->value);
    qsort(samples, count, sizeof *samples, compare_doubles);
    row->spread = compute_median(samples, count);
}
