/* app/view/series.h - what the steps came to, along the time: columns of report.csv, kept in single
 * precision for plots, and told as the least and greatest of so many buckets. */
#ifndef TULLE_APP_VIEW_SERIES_H
#define TULLE_APP_VIEW_SERIES_H

#include "app/view/buffer.h"
#include "base/memory.h"

#include "tulle/world.h"

typedef struct view_document view_document;

enum {
    SERIES_PLAIN = 16, /* columns beside the times of stages */
    SERIES_COUNT = SERIES_PLAIN + TULLE_STAGE_COUNT,
    SERIES_BUCKET_MAX = 4096,
    SERIES_STEP_MAX = 1 << 16 /* of a live scene; then the older half is thinned out */
};

typedef struct series_row {
    uint64_t step; /* steps made */
    float values[SERIES_COUNT];
} series_row;

/* Rows by ascending step. */
typedef struct series_table {
    memory heap;
    ARRAY(series_row) rows;
} series_table;

series_row series_make_row(const tulle_step_report *report);
/* Adds a row behind the others; rows of later steps go first, as after a rewind. Keeps at most
 * SERIES_STEP_MAX rows where `is_bounded`. */
void series_add(series_table *table, const series_row *row, bool is_bounded);
void series_clear(series_table *table);

/* SERIES_COUNT for a name that is none. */
int series_find(const char *name);
void series_write_names(const view_document *document, view_buffer *buffer);

typedef struct series_request {
    uint64_t columns;  /* as bits */
    uint64_t from, to; /* steps, both included */
    uint32_t buckets;
} series_request;
/* Members of the answer: names, steps, low, high. */
void series_write(const series_table *table, series_request request, view_buffer *buffer);

#endif
