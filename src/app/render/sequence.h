/* app/render/sequence.h - the pictures of all chosen frames: written, reused from a former call, or
 * put together to a film. */
#ifndef TULLE_APP_RENDER_SEQUENCE_H
#define TULLE_APP_RENDER_SEQUENCE_H

#include "app/cli/numbered_files.h"
#include "app/render/sight.h"

/* Where pictures go. */
typedef struct picture_target {
    picture_kind kind;
    char path[NUMBERED_PATH_SIZE];    /* of the still or the film, or the series' pattern */
    char folder[NUMBERED_PATH_SIZE];  /* of a film's frames while it is made */
    char pattern[NUMBERED_PATH_SIZE]; /* of the frames' files; not of a still */
    name_pattern names;
    double frame_rate; /* [1/s] of a film */
    double speed;      /* of a film, as a multiple of real time */
} picture_target;

/* What the options and the run come to, checked: the place can be written, and a film can be made.
 * Nothing is left there. Errors: TULLE_ERROR_INVALID_ARGUMENT, TULLE_ERROR_IO,
 * TULLE_ERROR_UNSUPPORTED. */
tulle_status picture_target_choose(const picture_options *options, const picture_run *run,
                                   picture_target *target, tulle_error *error);

/* What came of it. */
typedef struct picture_totals {
    uint32_t frame_count, made_count, reused_count;
    double seconds;        /* of tracing */
    bool is_begun;         /* something was written */
    char subdivided[1024]; /* about the subdivided surfaces; empty without */
    bool is_intersecting;  /* a subdivided frame intersects */
    picture_sight sight;
} picture_totals;

/* Makes and writes everything. TULLE_ERROR_INTERRUPTED when asked to stop: frames that are whole
 * are kept. */
tulle_status picture_make_all(picture_run *run, const picture_target *target,
                              picture_totals *totals, tulle_error *error);

#endif
