/* tulle_io/run.h - the directory of a run: a writer that appends frame by frame, and a reader.
 * docs/guide/run_directory.md describes every file in it.
 *
 * If a run is killed at any moment, its directory can be read up to the last whole frame, and the
 * run can be resumed from its last checkpoint. */
#ifndef TULLE_IO_RUN_H
#define TULLE_IO_RUN_H

#include "tulle/base.h"
#include "tulle/paper.h"
#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How far a run has come. */
typedef enum tulle_run_state {
    TULLE_RUN_RUNNING,     /* still running, or killed */
    TULLE_RUN_FINISHED,    /* all frames are written */
    TULLE_RUN_INTERRUPTED, /* stopped on request; can be resumed */
    TULLE_RUN_FAILED       /* ended by an error */
} tulle_run_state;
/* "running", "finished", "interrupted" or "failed"; static. Null out of range. */
TULLE_API const char *tulle_run_state_name(tulle_run_state state);

/* A cloth or an obstacle of the run. */
typedef struct tulle_run_body {
    /* unique, UTF-8; in file names letters a to z, digits, '-', '_' and '.' stay as they are */
    const char *name;
    tulle_mesh_view mesh; /* start positions, written as an OBJ file */
    int is_obstacle;      /* 0: cloth */
    int is_static;        /* 1: never moves, has no point cache */
    int is_dynamic;       /* 1: a rigid body, an obstacle that collides with other obstacles too */
} tulle_run_body;

/* ---- writing ---- */

/* A run to write. Made by tulle_run_def_default. "For the record" marks values that are only
 * written to run.json. */
typedef struct tulle_run_def {
    uint32_t cookie;          /* set by tulle_run_def_default, checked on use */
    const char *directory;    /* made when missing; its parent must exist */
    const char *scene_path;   /* as the user gave it, for the record */
    const char *scene_text;   /* written to scene.yaml; null: none */
    uint64_t scene_hash;      /* a resumed run must have the same hash */
    uint64_t seed;            /* of the scene, for the record */
    double time_step;         /* [s] > 0 */
    uint32_t steps_per_frame; /* >= 1 */
    uint32_t frame_count;     /* frames wanted, the start (frame 0) not counted */
    int threads;              /* for the record */
    int writes_vtp;           /* also a VTP file a frame and moving body, and a PVD file a body */
    int records_debug;        /* also debug.bin: tulle_run_debug of each frame */
    int records_velocities;   /* debug.bin with velocities alone, unless records_debug */
    const tulle_world_detection *detection; /* for the record; null: not said */
    int has_response;                       /* 1: response and motion_space are given */
    tulle_response response;                /* for the record */
    tulle_motion_space motion_space;        /* for the record */
    const tulle_untangle_report *untangle;  /* for the record; null: not said */
    const tulle_run_body *bodies;           /* cloths first, then obstacles, as in the world */
    size_t body_count;                      /* length of `bodies` */
} tulle_run_def;
/* A run without a directory, bodies or frames; the caller fills them in. */
TULLE_API tulle_run_def tulle_run_def_default(void);

/* Further data of a frame: velocities, contacts and patches. Bodies are in the order of the run,
 * cloths first, then obstacles, as tulle_contact numbers objects. */
typedef struct tulle_run_debug {
    const double *const *velocities; /* [m/s] of each body, 3 * vertex_count; null for static
                                        bodies. Stored as float */
    /* If only velocities are kept, the rest is not written, and is null or 0 when read. */
    const tulle_contact *contacts;       /* real numbers are stored as float */
    size_t contact_count;                /* length of `contacts` */
    const uint32_t *const *patch_labels; /* of each cloth, triangle_count labels as from
                                            tulle_cloth_get_patches; null for obstacles */
    const uint32_t *patch_counts;        /* of each body; 0 for obstacles */
} tulle_run_debug;

/* An obstacle that lags behind its frames where it leaves cloth no room (TULLE_ON_PINCH_LAG). Its
 * positions are the lagging surface, which cloth meets. */
typedef struct tulle_run_lag {
    uint32_t body;            /* index of the bodies */
    uint32_t vertex;          /* the vertex that lags most */
    double lag;               /* [m] of that vertex, > 0 */
    uint64_t drawn_crossings; /* pairs of triangles of cloth and of the surface as its frames have
                                 it */
} tulle_run_lag;

/* One frame, given to the writer. */
typedef struct tulle_run_frame {
    double time;         /* [s] */
    uint64_t step;       /* steps done */
    uint64_t state_hash; /* of the world, see tulle_world_get_state_hash */
    /* [m] of each body, 3 * vertex_count; null is allowed for static bodies */
    const double *const *positions;
    /* [m/s] of each body, 3 * vertex_count, or null; the whole may be null; for VTP files */
    const double *const *velocities;
    const int *is_present; /* of each body; null: all are */
    /* kept when the run records_debug or records_velocities; null: nothing is known */
    const tulle_run_debug *debug;
    const tulle_transform *transforms; /* of each body that is_dynamic, in the order of bodies; may
                                          be null when there is none */
    const tulle_run_lag *lags;         /* lag_count, by ascending body; null: none lags */
    size_t lag_count;                  /* at most one for each body */
} tulle_run_frame;

/* State of the world between two steps, from which a run can be resumed. */
typedef struct tulle_run_checkpoint {
    void *bytes;          /* from tulle_world_save_state */
    size_t byte_count;    /* length of `bytes` */
    uint64_t step;        /* steps done */
    double time;          /* [s] */
    uint64_t state_hash;  /* of the world, see tulle_world_get_state_hash */
    uint32_t frame_count; /* frames in the directory, the start counted */
} tulle_run_checkpoint;

/* A run being written. Made by tulle_run_create or tulle_run_resume, released by tulle_run_close.
 */
typedef struct tulle_run_writer tulle_run_writer;

/* What to do with a directory that holds something. */
typedef enum tulle_run_existing {
    TULLE_RUN_REFUSE, /* an error unless it is missing or empty */
    TULLE_RUN_REPLACE /* the files of a former run are removed, others stay; an error if it holds
                         something and no run */
} tulle_run_existing;

/* Makes the directory with everything but frames, and `*writer`, which is null after an error. The
 * writer keeps the directory locked. After an error the new files are removed again. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, also an array of a mesh; a value of the def; the directory is
 * not empty), TULLE_ERROR_IO (also: another process writes there, or a file of the run would be a
 * symbolic link), TULLE_ERROR_DISK_FULL, TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_run_create(const tulle_run_def *def, tulle_run_existing existing,
                                        tulle_run_writer **writer, tulle_error *error);
/* Resumes a run that was cut short, or a finished run that is to become longer. `def` must describe
 * the same scene and bodies. All files are compared with their checksums up to the newest
 * checkpoint. If a file is damaged, the checkpoint before it is used. If that is not possible, the
 * call is refused, the message names the file and the frame, and nothing is changed. Meshes and
 * scene.yaml are made again from `def`. All files are then cut back to this checkpoint. Release
 * `checkpoint` with tulle_run_free_checkpoint. `*writer` is null after an error. If the directory
 * is missing or empty, or the run was killed before its first checkpoint, the run starts from the
 * beginning. Then checkpoint->bytes is null. A run with more frames than def->frame_count wants
 * stays as it is; a note says so. Errors as of tulle_run_create, and TULLE_ERROR_PARSE (also: a
 * file is damaged or missing). */
TULLE_API tulle_status tulle_run_resume(const tulle_run_def *def, tulle_run_writer **writer,
                                        tulle_run_checkpoint *checkpoint, tulle_error *error);
/* The damage that tulle_run_resume found and repaired, a line for each, without a line end after
 * the last; empty: none. Lives as long as the writer. */
TULLE_API const char *tulle_run_get_notes(const tulle_run_writer *writer);
/* 1 if `directory` holds a run with a checkpoint, usable or not. tulle_run_resume then uses it or
 * fails. 0 for null. */
TULLE_API int tulle_run_has_checkpoint(const char *directory);
/* Frees the bytes of a checkpoint from tulle_run_resume, and zeroes it. Null is fine. */
TULLE_API void tulle_run_free_checkpoint(tulle_run_checkpoint *checkpoint);

/* Appends a frame. After an error, such as a full disk, the frames before it are still whole. Point
 * caches hold floats. Nothing intersects before rounding. If rounding to float would lead a surface
 * through another or itself, the frame is refused: TULLE_ERROR_LIMIT, which names the vertex.
 * Errors: TULLE_ERROR_INVALID_ARGUMENT (null, also an array that the frame needs; a coordinate that
 * float cannot hold), TULLE_ERROR_LIMIT, TULLE_ERROR_IO, TULLE_ERROR_DISK_FULL,
 * TULLE_ERROR_OUT_OF_MEMORY. TULLE_ERROR_IO also if the directory was moved, removed or replaced:
 * then no frame and no checkpoint is written, and tulle_run_close does not change run.json. */
TULLE_API tulle_status tulle_run_write_frame(tulle_run_writer *writer, const tulle_run_frame *frame,
                                             tulle_error *error);
/* Appends a line to report.csv. Errors: TULLE_ERROR_INVALID_ARGUMENT (null), TULLE_ERROR_IO,
 * TULLE_ERROR_DISK_FULL. */
TULLE_API tulle_status tulle_run_write_report(tulle_run_writer *writer,
                                              const tulle_step_report *report, tulle_error *error);
/* Flushes all files to disk, then writes the checkpoint. The one before stays as a second
 * generation. The writer fills in the frame count itself. Errors: TULLE_ERROR_INVALID_ARGUMENT
 * (null, or without bytes), TULLE_ERROR_IO, TULLE_ERROR_DISK_FULL, TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_run_write_checkpoint(tulle_run_writer *writer,
                                                  const tulle_run_checkpoint *checkpoint,
                                                  tulle_error *error);
/* Number of frames in the directory, the start counted; 0 for null. */
TULLE_API uint32_t tulle_run_get_frame_count(const tulle_run_writer *writer);
/* How the steps of a run went: facts that a user should know about the result. A zeroed struct has
 * no steps. */
typedef struct tulle_run_outcome {
    uint64_t steps;               /* steps made */
    uint64_t unconverged_steps;   /* steps in which a solve stopped at its limit of iterations */
    double worst_residual;        /* largest relative residual of those steps; 0: none */
    double worst_residual_time;   /* [s] of that step's end */
    double largest_stretch;       /* largest edge length over rest length, at the end of a step */
    double largest_stretch_time;  /* [s] of that step's end */
    int has_stretch_place;        /* 0: the place of the largest stretch is not known */
    uint32_t stretch_body;        /* the cloth, an index of the bodies; where has_stretch_place */
    uint32_t stretch_vertices[2]; /* ends of the edge in that cloth; where has_stretch_place */
    double stretch_position[3];   /* [m] middle of the edge; where has_stretch_place */
    uint64_t cut_steps;           /* steps that took more than one substep */
    uint32_t most_substeps;       /* most substeps of a step */
    uint64_t rescues;             /* of all kinds and steps, see tulle_step_report */
    uint64_t pinched_steps;       /* steps in which cloth was pinched between obstacles */
    uint64_t overstretched_steps; /* steps in which a yarn was beyond the limit of its material */
    uint64_t most_overstretched;  /* most triangles with such a yarn, at the end of a step */
    double largest_lag;           /* [m] by which an obstacle lagged behind its frames */
    double largest_lag_time;      /* [s] of that step's end */
} tulle_run_outcome;
/* Adds a step by its report, without the place of the stretch: see tulle_run_outcome_place. Nothing
 * happens if one of the two is null. */
TULLE_API void tulle_run_outcome_add(tulle_run_outcome *outcome, const tulle_step_report *report);
/* Adds the place of the largest stretch. Call it right after adding the step that has this stretch.
 * `body`: the cloth's index among the bodies of the run. Nothing happens if a pointer is null. */
TULLE_API void tulle_run_outcome_place(tulle_run_outcome *outcome, const tulle_stretch *stretch,
                                       uint32_t body);
/* Describes in words what went wrong, a line for each, without a line end after the last; if
 * nothing did, in a single line. `body_name` is the name of stretch_body; null: not known.
 * `failure` says why the run ended early; null: it did not. At most `size` bytes of `text` are
 * written, with the terminating zero; none where `text` is null or `size` is 0. A null outcome
 * gives an empty text. */
TULLE_API void tulle_run_outcome_describe(const tulle_run_outcome *outcome, const char *body_name,
                                          const char *failure, char *text, size_t size);
/* The outcome that the run had on record when tulle_run_resume took it over; null: none. Lives as
 * long as the writer. */
TULLE_API const tulle_run_outcome *tulle_run_get_former_outcome(const tulle_run_writer *writer);
/* Records the outcome so far; tulle_run_close writes it to run.json. Nothing happens if one of the
 * two is null. */
TULLE_API void tulle_run_set_outcome(tulle_run_writer *writer, const tulle_run_outcome *outcome);

/* Records how the run ended, with `message` (may be null), and releases the writer, also when it
 * fails. A null writer is fine. Errors: TULLE_ERROR_INVALID_ARGUMENT (no such state: the run is
 * left as TULLE_RUN_RUNNING), TULLE_ERROR_IO, TULLE_ERROR_DISK_FULL, TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_run_close(tulle_run_writer *writer, tulle_run_state state,
                                       const char *message, tulle_error *error);

/* ---- reading ---- */

/* A cloth or an obstacle of a run that is read. */
typedef struct tulle_run_body_info {
    const char *name;        /* as in tulle_run_body */
    const char *mesh_file;   /* OBJ file, within the directory */
    const char *cache_file;  /* PC2 file, within the directory; null for static bodies */
    int is_obstacle;         /* as in tulle_run_body */
    int is_static;           /* as in tulle_run_body */
    uint32_t vertex_count;   /* of the mesh */
    uint32_t triangle_count; /* of the mesh */
    int is_dynamic;          /* as in tulle_run_body */
} tulle_run_body_info;

/* What a run directory holds. Strings and arrays live until tulle_run_reader_close. */
typedef struct tulle_run_info {
    const char *version;                    /* of the program that wrote it */
    const char *scene_path;                 /* as the user gave it */
    const char *scene_text;                 /* as the file is now; null: none recorded */
    uint64_t scene_hash;                    /* as in tulle_run_def */
    uint64_t seed;                          /* as in tulle_run_def */
    double time_step;                       /* [s] */
    uint32_t steps_per_frame;               /* as in tulle_run_def */
    uint32_t wanted_frame_count;            /* the start not counted */
    uint32_t frame_count;                   /* whole frames, the start counted */
    tulle_run_state state;                  /* how far it has come */
    const char *message;                    /* of the end; empty if none */
    const tulle_run_body_info *bodies;      /* cloths first, then obstacles */
    size_t body_count;                      /* length of `bodies` */
    uint64_t checkpoint_step;               /* steps done at the newest whole checkpoint */
    int has_checkpoint;                     /* 1: there is a whole checkpoint */
    const tulle_world_detection *detection; /* null: not recorded */
    int has_response;                       /* 0: response and motion_space are not recorded */
    tulle_response response;                /* how the run answered contact */
    tulle_motion_space motion_space;        /* of TULLE_RESPONSE_PAPER */
    const tulle_run_outcome *outcome;       /* how its steps went; null: not recorded */
    int has_debug;                          /* 1: the run records tulle_run_debug of its frames */
    int has_velocities;        /* 1: the run records velocities, alone or with the rest */
    uint64_t debug_byte_count; /* [bytes] of debug.bin; 0 without */
} tulle_run_info;

/* A run directory that is read. Made by tulle_run_reader_open, released by tulle_run_reader_close.
 */
typedef struct tulle_run_reader tulle_run_reader;

/* 1 if `path` is a directory with a run.json; 0 for null. */
TULLE_API int tulle_run_is_directory(const char *path);
/* Opens `directory` and makes `*reader`, which is null after an error. A run that still runs or was
 * killed is read up to its last whole frame. Everything that is read, now and later, is compared
 * with its checksum: TULLE_ERROR_PARSE says which file and frame are damaged. Another process may
 * write the run meanwhile. If it removes data that is read later, the error is TULLE_ERROR_IO and
 * says so; then open the run again. Errors: TULLE_ERROR_INVALID_ARGUMENT (null, a path that is too
 * long), TULLE_ERROR_IO, TULLE_ERROR_PARSE, TULLE_ERROR_OUT_OF_MEMORY, TULLE_ERROR_LIMIT. */
TULLE_API tulle_status tulle_run_reader_open(const char *directory, tulle_run_reader **reader,
                                             tulle_error *error);
/* A file of a run that is not as the run wrote it. */
typedef struct tulle_run_damage {
    const char *file;    /* within the directory */
    int64_t frame;       /* the first frame that is damaged; -1: no frame in particular */
    const char *message; /* what is wrong; names the frame */
} tulle_run_damage;
/* Compares every file of the run with its checksums, and gives `*count` damages, one for each file
 * that has some. They live until the reader is closed. Reads all of the run. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT, TULLE_ERROR_IO (another process changed the run),
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_run_reader_find_damage(tulle_run_reader *reader,
                                                    const tulle_run_damage **damages, size_t *count,
                                                    tulle_error *error);
/* Releases a reader and everything that it handed out. Null is fine. */
TULLE_API void tulle_run_reader_close(tulle_run_reader *reader);
/* What the directory holds; owned by the reader. Null for null. */
TULLE_API const tulle_run_info *tulle_run_reader_get_info(const tulle_run_reader *reader);
/* Gives the mesh of body number `body` as its OBJ file holds it; owned by the reader. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, no such body), TULLE_ERROR_IO, TULLE_ERROR_PARSE,
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_run_reader_get_mesh(tulle_run_reader *reader, size_t body,
                                                 tulle_mesh_view *mesh, tulle_error *error);
/* Gives `*time` [s], `*step` and `*state_hash` of frame number `frame`, 0 .. frame_count - 1. Any
 * of the three may be null. Error: TULLE_ERROR_INVALID_ARGUMENT (a null reader, no such frame). */
TULLE_API tulle_status tulle_run_reader_get_frame(const tulle_run_reader *reader, uint32_t frame,
                                                  double *time, uint64_t *step,
                                                  uint64_t *state_hash);
/* 1 if body number `body` is in the scene at frame number `frame`; 0 for a null reader and where
 * there is no such body or frame. */
TULLE_API int tulle_run_reader_is_present(const tulle_run_reader *reader, uint32_t frame,
                                          size_t body);
/* Gives the obstacles that lag in frame number `frame`: `*count` of them in `*lags`, by ascending
 * body, which live as long as the reader. Error: TULLE_ERROR_INVALID_ARGUMENT (null, no
 * such frame). */
TULLE_API tulle_status tulle_run_reader_get_lags(const tulle_run_reader *reader, uint32_t frame,
                                                 const tulle_run_lag **lags, size_t *count);
/* Fills `positions`, 3 * vertex_count [m], of body number `body` at frame number `frame`: from its
 * point cache, which holds floats, or from the OBJ file of a static body. Errors as of
 * tulle_run_reader_get_mesh. */
TULLE_API tulle_status tulle_run_reader_read_positions(tulle_run_reader *reader, uint32_t frame,
                                                       size_t body, double *positions,
                                                       tulle_error *error);
/* Fills `transforms`, one for each body that is_dynamic in the order of bodies, at frame number
 * `frame`; `inertia` is zero, because runs do not keep it. Errors: TULLE_ERROR_UNSUPPORTED (the
 * run does not have them), and as of tulle_run_reader_get_mesh. */
TULLE_API tulle_status tulle_run_reader_read_transforms(tulle_run_reader *reader, uint32_t frame,
                                                        tulle_transform *transforms,
                                                        tulle_error *error);
/* Gives the further data of frame number `frame`. `*debug` lives until the next call or until the
 * reader is closed. It is null if the writer had no such data for the frame. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null, no such frame, or a run that keeps no velocities),
 * TULLE_ERROR_IO, TULLE_ERROR_PARSE (cut short or changed: names debug.bin and the byte),
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_run_reader_read_debug(tulle_run_reader *reader, uint32_t frame,
                                                   const tulle_run_debug **debug,
                                                   tulle_error *error);

/* Gives the step reports of the run, `*count` of them, one for each step, as report.csv holds them.
 * A last line that was cut short is left out. A number that is empty in the file is NAN, an empty
 * smallest_gap is INFINITY. They live until the reader is closed. Errors:
 * TULLE_ERROR_INVALID_ARGUMENT (null), TULLE_ERROR_IO, TULLE_ERROR_PARSE with line and column,
 * TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_run_reader_get_reports(tulle_run_reader *reader,
                                                    const tulle_step_report **reports,
                                                    size_t *count, tulle_error *error);

#ifdef __cplusplus
}
#endif
#endif
