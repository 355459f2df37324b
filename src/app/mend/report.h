/* app/mend/report.h - what `tulle mend` says of each frame and of all. Lengths are in the files'
 * unit. */
#ifndef TULLE_APP_MEND_REPORT_H
#define TULLE_APP_MEND_REPORT_H

#include "app/mend/follow.h"

#include <stdio.h>

/* Pairs of triangles that intersect. */
typedef struct mend_pairs {
    size_t own;    /* of the cloth with itself */
    size_t bodies; /* of the cloth with bodies */
} mend_pairs;

/* Second differences a of three frames, per frame^2; NaN where there are none. */
typedef struct mend_accelerations {
    double mean; /* root of the mean square */
    double largest;
    /* root of the mean of max(0, -a b), b the acceleration of the frame before: what turns round
     * from frame to frame. Of a stop, an impact or a swing it is 0, of a tremble of amplitude A, 4
     * A */
    double jitter;
} mend_accelerations;

typedef struct mend_row {
    uint32_t frame; /* its number in the file */
    mend_pairs before, after;
    size_t away_count;    /* vertices that are not where they were given */
    double mean, largest; /* departure over all vertices of the cloth */
    uint32_t vertex;      /* with the largest; TULLE_NONE: none is away */
    /* at the vertices that are away in this frame or one of the two before; jitter: or the three */
    mend_accelerations given, mended;
    mend_outcome outcome;
    double seconds;
} mend_row;

/* Over all frames. */
typedef struct mend_summary {
    uint32_t frame_count, away_frames, bad_before, bad_after, crossing_frames, lagging_frames;
    mend_pairs before, after;             /* the most of a frame */
    mend_row worst;                       /* the frame with the largest departure */
    double given2, mended2;               /* sums of squares of the frames' mean accelerations */
    double given_jitter2, mended_jitter2; /* of their jitters */
    double given_most, mended_most;
    uint32_t acceleration_frames, jitter_frames;
    double lag, seconds, slowest;
} mend_summary;

enum { HISTORY_FRAMES = 4 };

/* The last frames of the cloth, given and mended. */
typedef struct mend_history {
    size_t vertex_count;
    uint32_t count; /* frames seen */
    double *given[HISTORY_FRAMES], *mended[HISTORY_FRAMES];
} mend_history;

tulle_status mend_history_open(size_t vertex_count, mend_history *history, tulle_error *error);
void mend_history_close(mend_history *history);
/* Adds a frame and fills departures and accelerations of its row. */
void mend_history_add(mend_history *history, const double *given, const double *mended,
                      mend_row *row);

void mend_summary_add(mend_summary *summary, const mend_row *row);

void mend_report_begin_csv(FILE *file);
void mend_report_add_csv(FILE *file, const mend_row *row);
/* A line for a frame, a line at the end. */
void mend_report_print_row_json(const mend_row *row);
void mend_report_print_summary_json(const mend_summary *summary);
void mend_report_print_summary(const mend_summary *summary);

#endif
