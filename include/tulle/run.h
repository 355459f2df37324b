/* tulle/run.h - the directory that a run leaves: written frame by frame, read back whole or cut
 * short. docs/guide/formats.md describes every file in it.
 *
 * Killed at any moment, the directory stays readable up to its last whole frame, and the run can go
 * on from its last checkpoint. */
#ifndef TULLE_RUN_H
#define TULLE_RUN_H

#include "tulle/base.h"
#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum tulle_run_state {
    TULLE_RUN_RUNNING, /* still going on, or killed */
    TULLE_RUN_FINISHED,
    TULLE_RUN_INTERRUPTED,
    TULLE_RUN_FAILED
} tulle_run_state;
/* "running", "finished", "interrupted", "failed"; null out of range. */
TULLE_API const char *tulle_run_state_name(tulle_run_state state);

/* A cloth or an obstacle of the run. */
typedef struct tulle_run_body {
    const char *name; /* unique; letters, digits, '-', '_' and '.' stay as they are in file names */
    tulle_mesh_view mesh; /* as the OBJ file holds it: start positions */
    int is_obstacle;
    int is_static;  /* 1: never moves, has no point cache */
    int is_dynamic; /* 1: an obstacle that is a rigid body: meets other obstacles too */
} tulle_run_body;

/* ---- writing ---- */

typedef struct tulle_run_def {
    uint32_t cookie;
    const char *directory;  /* made when missing; its parent must exist */
    const char *scene_path; /* as the user gave it, for the record */
    const char *scene_text; /* written to scene.yaml; null: none */
    uint64_t scene_hash;    /* a resumed run must have the same */
    uint64_t seed;
    double time_step;         /* [s] > 0 */
    uint32_t steps_per_frame; /* >= 1 */
    uint32_t frame_count;     /* frames wanted, the start (frame 0) not counted */
    int threads;              /* for the record */
    int writes_vtp;           /* also a VTP file a frame and moving body, and a PVD file a body */
    int records_debug;        /* also debug.bin: tulle_run_debug of each frame */
    const tulle_world_detection *detection; /* for the record; null: not said */
    int has_response;                       /* 1: response and motion_space are for the record */
    tulle_response response;
    tulle_motion_space motion_space;
    const tulle_untangle_report *untangle; /* for the record; null: not said */
    const tulle_run_body *bodies;          /* cloths first, then obstacles, as in the world */
    size_t body_count;
} tulle_run_def;
TULLE_API tulle_run_def tulle_run_def_default(void);

/* What explains a frame, beyond positions: velocities, contacts and patches. Bodies count as in the
 * run, cloths first, then obstacles, which is how tulle_contact names objects. */
typedef struct tulle_run_debug {
    const double *const *velocities; /* [m/s] of each body, 3 * vertex_count; null for static
                                        bodies. Stored as float */
    const tulle_contact *contacts;   /* real numbers are stored as float */
    size_t contact_count;
    const uint32_t *const *patch_labels; /* of each cloth, triangle_count labels as from
                                            tulle_cloth_get_patches; null for obstacles */
    const uint32_t *patch_counts;        /* of each body; 0 for obstacles */
} tulle_run_debug;

/* One frame, given to the writer. */
typedef struct tulle_run_frame {
    double time; /* [s] */
    uint64_t step;
    uint64_t state_hash;
    const double *const *positions; /* [m] of each body, 3 * vertex_count; null allowed for static
                                       ones */
    const double *const
        *velocities;              /* [m/s] of each body or null; the whole may be null; for VTP */
    const int *is_present;        /* of each body; null: all are */
    const tulle_run_debug *debug; /* kept when the run records_debug; null: nothing is known */
    const tulle_transform *transforms; /* of each body that is_dynamic, in the order of bodies; may
                                          be null when there is none */
} tulle_run_frame;

/* State of the world between two steps, to go on from. */
typedef struct tulle_run_checkpoint {
    void *bytes; /* from tulle_world_save_state */
    size_t byte_count;
    uint64_t step; /* steps done */
    double time;   /* [s] */
    uint64_t state_hash;
    uint32_t frame_count; /* frames in the directory, the start counted */
} tulle_run_checkpoint;

typedef struct tulle_run_writer tulle_run_writer;

/* What to do with a directory that holds something. */
typedef enum tulle_run_existing {
    TULLE_RUN_REFUSE, /* an error unless it is missing or empty */
    TULLE_RUN_REPLACE /* the files of a former run are removed, others stay; an error if it holds
                         something and no run */
} tulle_run_existing;

/* Makes the directory with everything but frames. On failure what was made is removed again.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (also: the directory is not empty), TULLE_ERROR_IO,
 * TULLE_ERROR_DISK_FULL, TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_run_create(const tulle_run_def *def, tulle_run_existing existing,
                                        tulle_run_writer **writer, tulle_error *error);
/* Opens the directory of a run that was cut short, or finished and is to be made longer, cuts all
 * files back to its newest whole checkpoint and gives that. Release it with
 * tulle_run_free_checkpoint. `def` must describe the same scene and bodies. A directory that is
 * missing, empty or was killed before its first checkpoint: the run starts anew, as by
 * tulle_run_create, and checkpoint->bytes is null. */
TULLE_API tulle_status tulle_run_resume(const tulle_run_def *def, tulle_run_writer **writer,
                                        tulle_run_checkpoint *checkpoint, tulle_error *error);
/* Whether the directory holds a run with a checkpoint, usable or not: then tulle_run_resume goes on
 * from it or fails. */
TULLE_API int tulle_run_has_checkpoint(const char *directory);
TULLE_API void tulle_run_free_checkpoint(tulle_run_checkpoint *checkpoint);

/* Appends a frame. On failure (a full disk) the frames before it stay whole. */
TULLE_API tulle_status tulle_run_write_frame(tulle_run_writer *writer, const tulle_run_frame *frame,
                                             tulle_error *error);
/* Appends a line to report.csv. */
TULLE_API tulle_status tulle_run_write_report(tulle_run_writer *writer,
                                              const tulle_step_report *report, tulle_error *error);
/* Flushes all files to disk, then replaces the checkpoint; the one before stays as a second
 * generation. checkpoint->frame_count is filled in by the writer. */
TULLE_API tulle_status tulle_run_write_checkpoint(tulle_run_writer *writer,
                                                  const tulle_run_checkpoint *checkpoint,
                                                  tulle_error *error);
/* Frames in the directory, the start counted. */
TULLE_API uint32_t tulle_run_get_frame_count(const tulle_run_writer *writer);
/* Records how the run ended (message may be null) and releases the writer, also on failure. */
TULLE_API tulle_status tulle_run_close(tulle_run_writer *writer, tulle_run_state state,
                                       const char *message, tulle_error *error);

/* ---- reading ---- */

typedef struct tulle_run_body_info {
    const char *name;
    const char *mesh_file,
        *cache_file; /* within the directory; cache_file null for static bodies */
    int is_obstacle, is_static;
    uint32_t vertex_count, triangle_count;
    int is_dynamic; /* as in tulle_run_body */
} tulle_run_body_info;

/* A run directory as it is; strings and arrays live until tulle_run_reader_close. */
typedef struct tulle_run_info {
    const char *version;    /* of the program that wrote it */
    const char *scene_path; /* as the user gave it */
    const char *scene_text; /* null: none recorded */
    uint64_t scene_hash, seed;
    double time_step; /* [s] */
    uint32_t steps_per_frame;
    uint32_t wanted_frame_count; /* the start not counted */
    uint32_t frame_count;        /* whole frames, the start counted */
    tulle_run_state state;
    const char *message; /* of the end; empty if none */
    const tulle_run_body_info *bodies;
    size_t body_count;
    uint64_t checkpoint_step; /* of the newest whole checkpoint */
    int has_checkpoint;
    const tulle_world_detection *detection; /* null: not recorded */
    int has_response;                       /* 0: not recorded */
    tulle_response response;
    tulle_motion_space motion_space; /* of TULLE_RESPONSE_PAPER */
    int has_debug;                   /* 1: the run records tulle_run_debug of its frames */
    uint64_t debug_byte_count;       /* [bytes] of debug.bin; 0 without */
} tulle_run_info;

typedef struct tulle_run_reader tulle_run_reader;

/* Whether the path is a directory with a run.json. */
TULLE_API int tulle_run_is_directory(const char *path);
/* Opens a run directory; runs that go on or were killed are read up to their last whole frame.
 * Errors: TULLE_ERROR_IO, TULLE_ERROR_PARSE, TULLE_ERROR_OUT_OF_MEMORY, TULLE_ERROR_LIMIT. */
TULLE_API tulle_status tulle_run_reader_open(const char *directory, tulle_run_reader **reader,
                                             tulle_error *error);
TULLE_API void tulle_run_reader_close(tulle_run_reader *reader);
TULLE_API const tulle_run_info *tulle_run_reader_get_info(const tulle_run_reader *reader);
/* The body's mesh as its OBJ file holds it; lives until the reader is closed. */
TULLE_API tulle_status tulle_run_reader_get_mesh(tulle_run_reader *reader, size_t body,
                                                 tulle_mesh_view *mesh, tulle_error *error);
/* Time, step and state hash of a frame; frame < frame_count. Any pointer may be null. */
TULLE_API tulle_status tulle_run_reader_get_frame(const tulle_run_reader *reader, uint32_t frame,
                                                  double *time, uint64_t *step,
                                                  uint64_t *state_hash);
/* 1 while the body is in the scene at that frame. */
TULLE_API int tulle_run_reader_is_present(const tulle_run_reader *reader, uint32_t frame,
                                          size_t body);
/* Positions of a body at a frame, 3 * vertex_count [m]: from its point cache (float), or, for a
 * static body, of its OBJ file. */
TULLE_API tulle_status tulle_run_reader_read_positions(tulle_run_reader *reader, uint32_t frame,
                                                       size_t body, double *positions,
                                                       tulle_error *error);
/* What explains a frame; lives until the next call or until the reader is closed. *debug is null
 * when the writer knew nothing of the frame. Errors: INVALID_ARGUMENT (no such frame, or a run
 * without debug records), IO, PARSE (cut short or changed: names debug.bin and the byte),
 * OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_run_reader_read_debug(tulle_run_reader *reader, uint32_t frame,
                                                   const tulle_run_debug **debug,
                                                   tulle_error *error);

/* Step reports of the run, one a step, as report.csv holds them; a last line that was cut short is
 * left out. Numbers that are empty in the file are NAN, an empty smallest_gap is INFINITY. They
 * live until the reader is closed. Errors: TULLE_ERROR_IO, TULLE_ERROR_PARSE with line and column,
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_run_reader_get_reports(tulle_run_reader *reader,
                                                    const tulle_step_report **reports,
                                                    size_t *count, tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
