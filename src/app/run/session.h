/* app/run/session.h - a run under way: its scene, world, output directory, and what is shown of it.
 */
#ifndef TULLE_APP_RUN_SESSION_H
#define TULLE_APP_RUN_SESSION_H

#include "app/cli/progress_bar.h"
#include "app/commands.h"
#include "scene/scene.h"

#include "tulle_io/run.h"

#include <stdbool.h>

/* What the steps of this session came to. */
typedef struct run_totals {
    uint64_t steps;
    double seconds; /* in steps, by the wall clock */
    uint64_t most_contacts;
    uint64_t contacts;      /* sum over the steps */
    double smallest_gap;    /* [m] INFINITY: nothing came near */
    uint64_t ignored_pairs; /* after the last step */
    char message[512];      /* the first that the world had */
} run_totals;

typedef struct run_progress {
    progress_kind kind;
    progress_bar bar;
    double shown;      /* [s] of the clock: last time that a line was shown */
    double step_begin; /* [s] of the clock: start of the step that is under way */
} run_progress;

typedef struct run_options {
    const char *scene_path, *directory;
    const char *left_path; /* for pairs that intersect in a start that is refused; null: none */
    const char *from;      /* RUN or RUN:FRAME whose frames it begins with; null: none */
    uint32_t frame_count;  /* the start not counted */
    int threads;
    bool resumes, replaces, writes_vtp, records_debug, records_velocities;
    double checkpoint_seconds; /* between checkpoints; 0: by steps */
    uint64_t checkpoint_steps;
} run_options;

/* Room for what explains a frame; all null unless the run records it. */
typedef struct debug_record {
    size_t cloth_count;
    const double **velocities; /* of each body */
    uint32_t **labels;         /* of each body; null for obstacles */
    uint32_t *patch_counts;    /* of each body */
    tulle_run_debug debug;     /* the last frame that was filled in */
} debug_record;

typedef struct run_source run_source; /* the run that is gone on from, see from.c */

typedef struct run_session {
    run_options options;
    run_source *source; /* null: none */
    tulle_scene *scene;
    tulle_scene_world built;
    tulle_run_writer *writer;
    tulle_run_body *bodies; /* cloths, then obstacles */
    const double **positions, **velocities;
    int *is_present;
    size_t body_count;
    tulle_run_lag *lags; /* of the frame that was written last: lag_count, room for body_count */
    size_t lag_count;
    bool may_lag;                /* the last step had a lag */
    tulle_transform *transforms; /* of rigid bodies, in the order of bodies */
    debug_record debug;
    bool goes_on; /* from a checkpoint, so the world was not started */
    uint64_t wanted_steps;
    uint64_t checkpoint_step; /* of the newest checkpoint */
    double checkpoint_time;   /* [s] of the clock */
    run_totals totals;
    tulle_run_outcome outcome; /* of all steps of the run, those before a resume included */
    run_progress progress;
} run_session;

/* Steps until all frames are written, an error or an interrupt; writes frames, reports and
 * checkpoints, at the end a last checkpoint. TULLE_ERROR_INTERRUPTED when asked to stop. */
tulle_status run_step_to_end(run_session *session, tulle_error *error);
/* Writes the start as frame 0, or the frames of the source, and the first checkpoint. */
tulle_status run_write_start(run_session *session, tulle_error *error);

/* debug.c: room for the session's bodies; false when memory is short. */
bool debug_record_prepare(debug_record *record, const run_session *session);
/* Asks the world for what explains the frame it is at now. */
tulle_status debug_record_fill(debug_record *record, const run_session *session,
                               tulle_error *error);
void debug_record_release(debug_record *record);

/* from.c: opens options.from as the session's source and checks that it fits the scene, whose
 * bodies are described. */
tulle_status run_source_open(run_session *session, tulle_error *error);
/* Starts the world where the source's frame has it. */
tulle_status run_source_start(run_session *session, tulle_error *error);
/* Writes the source's frames up to that one, and the reports of their steps. */
tulle_status run_source_copy(run_session *session, tulle_error *error);
void run_source_close(run_source *source, size_t body_count);

/* lags.c: fills the session's lags for the world as it is, whose positions it has. */
tulle_status run_measure_lags(run_session *session, tulle_error *error);

/* left.c: a line of CSV for every pair of triangles that refused the start. */
tulle_status run_write_left(const run_session *session, tulle_error *error);

/* kind: "auto", "json" or "none". */
void progress_begin(run_progress *progress, const char *kind);
/* Before anything is written to the directory, which is the run's own from here on. goes_on: from a
 * checkpoint. */
void progress_show_begin(run_session *session, bool goes_on);
void progress_show_step(run_session *session, const tulle_step_report *report);
/* Within a step: shows one that takes long. */
void progress_show_step_under_way(run_session *session);
/* Before a round of untangling. */
void progress_show_untangling(run_session *session);
/* What the world says of the step: a line on standard error, by every kind. */
void progress_show_message(run_session *session, const tulle_step_report *report,
                           const char *message);
void progress_show_checkpoint(run_session *session);
/* Ends a bar's line. `outcome` is the name of a state of the run. */
void progress_end(run_session *session, const char *outcome);

#endif
