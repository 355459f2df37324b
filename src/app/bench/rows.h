/* app/bench/rows.h - measures as rows of a table, in memory and as CSV. */
#ifndef TULLE_APP_BENCH_ROWS_H
#define TULLE_APP_BENCH_ROWS_H

#include "tulle/base.h"

#include <stdbool.h>

enum { BENCH_NAME_SIZE = 32, BENCH_TEXT_SIZE = 96 };

typedef enum bench_kind {
    BENCH_ABOUT,        /* a text about program or machine; belongs to no tulle_scene */
    BENCH_TIME,         /* [s] a step: median, least and spread over the repeats */
    BENCH_COUNT,        /* sum over the timed steps, or a size of the tulle_scene */
    BENCH_MEMORY,       /* [bytes] or calls of the allocator */
    BENCH_HASH,         /* of a state, as text */
    BENCH_INSTRUCTIONS, /* of all timed steps */
    BENCH_KIND_COUNT
} bench_kind;

typedef struct bench_row {
    char scene[BENCH_NAME_SIZE], size[BENCH_NAME_SIZE]; /* empty: about no tulle_scene */
    int threads;                                        /* 0: about no tulle_scene */
    bench_kind kind;
    char name[BENCH_NAME_SIZE];
    char text[BENCH_TEXT_SIZE]; /* value of BENCH_ABOUT and BENCH_HASH */
    double value;               /* of the others; the median of BENCH_TIME */
    double minimum, spread;     /* of BENCH_TIME; spread: median distance from the median */
} bench_row;

typedef struct bench_rows {
    bench_row *items;
    size_t count, capacity;
} bench_rows;

/* The row of the same scene, size, threads, kind and name; null if there is none. */
const bench_row *bench_rows_find(const bench_rows *rows, const bench_row *key);
/* The row of the same scene, size and threads as `of`, with another kind and name; or null. */
const bench_row *bench_rows_find_beside(const bench_rows *rows, const bench_row *of,
                                        bench_kind kind, const char *name);
/* Appends a row, or replaces the one that bench_rows_find would give; false: memory is short. */
bool bench_rows_put(bench_rows *rows, const bench_row *row);
void bench_rows_destroy(bench_rows *rows);

/* Fills in median, minimum and spread of `count` samples, which are sorted; count >= 1. */
void bench_row_summarize(bench_row *row, double *samples, size_t count);

/* Whether other work ran beside the case of a row: the fastest step on one thread took over 1.1
 * times its processor time. False where the case was not measured on one thread. */
bool bench_rows_were_disturbed(const bench_rows *rows, const bench_row *of);

/* Adds the rows of a file. Errors name file and line: TULLE_ERROR_IO, TULLE_ERROR_PARSE,
 * TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status bench_csv_read(const char *path, bench_rows *rows, tulle_error *error);
/* Writes all rows to a temporary file and renames it, so that the file is whole at any time. */
tulle_status bench_csv_write(const char *path, const bench_rows *rows, tulle_error *error);
/* Whether the file could be written, before the work is done for it. */
tulle_status bench_csv_check(const char *path, tulle_error *error);

#endif
