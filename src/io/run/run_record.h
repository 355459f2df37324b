/* io/run/run_record.h - what run.json and frames.csv say, in memory, and the names of a run's
 * files. */
#ifndef TULLE_IO_RUN_RUN_RECORD_H
#define TULLE_IO_RUN_RUN_RECORD_H

#include "base/memory.h"
#include "io/file_data.h"
#include "io/text/json_read.h"
#include "io/text/json_write.h"
#include "io/text/text_cursor.h"

#include "tulle_io/run.h"

/* Files of every run directory. */
#define RUN_FILE_RECORD "run.json"
#define RUN_FILE_SCENE "scene.yaml"
#define RUN_FILE_FRAMES "frames.csv"
#define RUN_FILE_REPORT "report.csv"
#define RUN_FILE_CHECKPOINT "checkpoint.bin"
#define RUN_FILE_CHECKPOINT_BEFORE "checkpoint.previous.bin"
#define RUN_FILE_CHECKSUMS "checksums.csv"
#define RUN_FILE_DEBUG "debug.bin"   /* of runs that record it */
#define RUN_FILE_BODIES "bodies.csv" /* of runs with rigid bodies */
#define RUN_FOLDER_VTP "vtp"

enum {
    RUN_STEM_SIZE = 120, /* [bytes] of a body's file names without extension, with the zero */
    RUN_BODY_MAX = 100000
};

/* A body as run.json describes it. Texts are in the record's pool, by offset. */
typedef struct run_body_record {
    size_t name, mesh_file, cache_file; /* cache_file: the empty text for static bodies */
    int is_obstacle, is_static;
    uint32_t vertex_count, triangle_count;
    int is_dynamic;
} run_body_record;

/* Place behind whole lines of checksums.csv. */
typedef struct checksum_mark {
    uint64_t size;  /* [bytes] */
    uint64_t chain; /* of the line before */
} checksum_mark;

/* What debug.bin keeps of each frame; RUN_KEEPS_NOTHING: there is none. */
typedef enum run_kept { RUN_KEEPS_NOTHING, RUN_KEEPS_DEBUG, RUN_KEEPS_VELOCITIES } run_kept;

typedef struct run_record {
    memory *heap;
    ARRAY(char) pool; /* texts, each with its zero; offset 0 is the empty text */
    ARRAY(run_body_record) bodies;
    size_t version, scene_path, message;
    uint64_t scene_hash, seed;
    double time_step;
    uint32_t steps_per_frame, wanted_frame_count, threads;
    int has_scene_text, writes_vtp;
    run_kept kept;            /* in debug.bin */
    bool has_end;             /* the run was closed in good order */
    checksum_mark end;        /* when has_end: of the whole checksums.csv */
    bool has_checkpoint;      /* when has_end: there is a checkpoint */
    uint64_t checkpoint_step; /* when has_checkpoint: of the newest */
    tulle_run_state state;
    bool has_detection;
    tulle_world_detection detection; /* when has_detection */
    bool has_response;
    tulle_response response;
    tulle_motion_space motion_space;
    bool has_untangle;
    tulle_untangle_report untangle; /* when has_untangle */
    bool has_outcome;
    tulle_run_outcome outcome; /* when has_outcome */
} run_record;

run_record run_record_make(memory *heap);
void run_record_destroy(run_record *record);
const char *run_record_text(const run_record *record, size_t text);
/* Copies a text into the pool. False when memory is short. */
bool run_record_keep(run_record *record, const char *text, size_t *kept);

/* Describes the run of a def: bodies get file names made from their names, unique in any case. */
tulle_status run_record_describe(run_record *record, const tulle_run_def *def, tulle_error *error);
/* Whether two records are of the same scene and bodies; else an error that says what differs. */
tulle_status run_record_compare(const run_record *old, const run_record *new, const char *path,
                                tulle_error *error);
tulle_status run_record_write(const run_record *record, const char *path, tulle_error *error);
tulle_status run_record_read(run_record *record, const char *path, tulle_error *error);

/* run_detection.c: the member "detection" of run.json, when it is known. */
void run_detection_write(json_writer *writer, const run_record *record);
tulle_status run_detection_read(run_record *record, const json_document *document,
                                const json_value *root, tulle_error *error);
/* The same for "untangle", what untangling the start came to; only there when it did something. */
void run_untangle_write(json_writer *writer, const run_record *record);
tulle_status run_untangle_read(run_record *record, const json_document *document,
                               const json_value *root, tulle_error *error);
/* run_outcome.c: the same for "outcome", how the steps went. Reading comes after the bodies. */
void run_outcome_write(json_writer *writer, const run_record *record);
tulle_status run_outcome_read(run_record *record, const json_document *document,
                              const json_value *root, tulle_error *error);
/* The same for "response" and "motion_space". */
void run_response_write(json_writer *writer, const run_record *record);
tulle_status run_response_read(run_record *record, const json_document *document,
                               const json_value *root, tulle_error *error);

/* run_seal.c: the member "checksums", once the run is closed. */
void run_end_write(json_writer *writer, const run_record *record);
tulle_status run_end_read(run_record *record, const json_document *document, const json_value *root,
                          tulle_error *error);
/* Compares a run.json with the checksum at its end; *has_seal: it has one. */
tulle_status run_seal_check(const char *path, const file_data *data, bool *has_seal,
                            tulle_error *error);

/* ---- frames.csv ---- */

typedef struct run_frame_line {
    double time;
    uint64_t step, state_hash;
    size_t first_absent, absent_count; /* in run_frames.absent */
    size_t first_lag, lag_count;       /* in run_frames.lags */
} run_frame_line;

typedef struct run_frames {
    memory *heap;
    ARRAY(run_frame_line) lines;
    ARRAY(uint32_t) absent;    /* bodies that are not there, in order within a frame */
    ARRAY(tulle_run_lag) lags; /* by body within a frame */
} run_frames;

#define RUN_FRAMES_HEADING "frame,time,step,state_hash,absent,lags\n"

void run_frames_destroy(run_frames *frames);
/* False when memory is short; the table is then as before. */
bool run_frames_add(run_frames *frames, const tulle_run_frame *frame, size_t body_count);
/* Drops the lines from count on. */
void run_frames_truncate(run_frames *frames, size_t count);
bool run_frames_is_present(const run_frames *frames, size_t frame, size_t body);
/* The last line as text; returns its length, or 0 when it does not fit. */
size_t run_frames_format_last(const run_frames *frames, char *text, size_t size);
/* [bytes] that run_frames_format_last needs at most. */
size_t run_frames_line_size(size_t body_count);
/* Reads the file; a last line without its end is left out. A missing file has no frames. */
tulle_status run_frames_read(run_frames *frames, memory *heap, const char *path, size_t body_count,
                             tulle_error *error);

#endif
