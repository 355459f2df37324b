/* app/reproduce.h - `tulle reproduce`: what its parts share. A figure of the paper is a line of a
 * table (reproduce_figures.c): the runs that it is made of and the function that makes its files.
 * docs/experiments/paper.md describes every file.
 *
 * Functions that return int give an exit code of the program, and have printed what went wrong. */
#ifndef TULLE_APP_REPRODUCE_H
#define TULLE_APP_REPRODUCE_H

#include "app/cli/progress_bar.h"

#include "tulle/detect.h"
#include "tulle/run.h"

#include <stdbool.h>
#include <stdio.h>

enum {
    REPRODUCE_PATH_SIZE = 1024, /* [bytes], as the following */
    REPRODUCE_BUILD_SIZE = 17,
    REPRODUCE_CONDITIONS_SIZE = 9,
    REPRODUCE_MACHINE_SIZE = 128,
    REPRODUCE_RUNS_MAX = 64
};

/* A scene and the way of finding pairs that it is run with. */
typedef struct reproduce_run {
    const char *scene;  /* its file in the directory of scenes, without .yaml */
    const char *method; /* "paper", "bvox", "refit", "patches"; null: as the scene says */
} reproduce_run;

typedef struct reproduce {
    const char *directory;            /* of the results */
    char scenes[REPRODUCE_PATH_SIZE]; /* directory of the scene files */
    bool is_quick;
    const char *still_size;           /* of stills, as --size of `tulle render` takes it */
    int threads;                      /* 0: one per processor */
    char build[REPRODUCE_BUILD_SIZE]; /* hash of the program */
    char conditions[REPRODUCE_CONDITIONS_SIZE]; /* of build, threads and processor */
    bool is_lacking; /* something was asked for and could not be made: a scene file or gnuplot is
                        missing */
    bool has_told_gnuplot, has_told_pictures; /* that they are not there */
    size_t job, job_count;                    /* runs, to be made and judged */
    double work, work_done;                   /* of all these runs, see reproduce_weigh_run */
    progress_bar bar;
    uint64_t skipped;       /* parts of the work shown that were there already */
    double job_begin, told; /* [s] of the clock: of the first job, of the last line of progress */
} reproduce;

/* A table or a picture in the report, a file in the directory of the results. */
typedef struct reproduce_item {
    const char *file, *caption;
} reproduce_item;

enum { REPRODUCE_ITEMS_MAX = 10 };

typedef struct reproduce_figure {
    const char *name, *title;
    const reproduce_run *runs;
    size_t run_count;
    int (*make)(reproduce *self, const struct reproduce_figure *figure);
    const char *paper;                         /* HTML: what the paper shows */
    const char *ours;                          /* HTML: what is done here */
    const char *differences;                   /* HTML: what differs and why */
    reproduce_item items[REPRODUCE_ITEMS_MAX]; /* tables and plots; ends with a null file */
    bool has_stills;                           /* of all its runs */
} reproduce_figure;

/* ---- reproduce_figures.c ---- */

extern const reproduce_figure reproduce_figures[];
extern const size_t reproduce_figure_count;
/* Adds the runs of a figure that are not there yet; their number. */
size_t reproduce_add_runs(const reproduce_figure *figure,
                          const reproduce_run *runs[REPRODUCE_RUNS_MAX], size_t count);
/* Every run of any figure once; their number. */
size_t reproduce_list_runs(const reproduce_run *runs[REPRODUCE_RUNS_MAX]);

/* ---- reproduce_runs.c ---- */

/* Where the scenes are: `given`, or beside the program; prints what is missing. */
int reproduce_find_scenes(reproduce *self, const char *given);
/* Whether the scene's file is there. */
bool reproduce_has_scene(const reproduce *self, const reproduce_run *run);
/* What is left of it to be made, in steps times triangles of cloth times what a scene's step costs:
 * foretells the time. */
int reproduce_weigh_run(const reproduce *self, const reproduce_run *run, double *work);
/* Makes the run, or what is missing of it. */
int reproduce_make_run(reproduce *self, const reproduce_run *run);
/* "animation_1.paper". */
void reproduce_name_run(const reproduce_run *run, char name[REPRODUCE_PATH_SIZE]);
/* A path in the directory of the results; printf text. */
void reproduce_make_path(const reproduce *self, char path[REPRODUCE_PATH_SIZE], const char *format,
                         ...) __attribute__((format(printf, 3, 4)));
/* The directory of the run within that of the results. */
void reproduce_find_run(const reproduce *self, const reproduce_run *run,
                        char path[REPRODUCE_PATH_SIZE]);
/* Whether it is there with at least two frames. */
bool reproduce_has_run(const reproduce *self, const reproduce_run *run);
/* The reports of the steps, as tulle_run_reader_get_reports gives them; an error too where they are
 * fewer than the steps that the frames tell of. */
tulle_status reproduce_get_reports(tulle_run_reader *reader, const tulle_step_report **reports,
                                   size_t *count, tulle_error *error);
/* Whether they are there; says so where not. */
bool reproduce_has_reports(const reproduce *self, const reproduce_run *run);
/* [m] the contact distance that the scene's world works with. */
tulle_status reproduce_find_distance(const reproduce *self, const reproduce_run *run,
                                     double *distance, tulle_error *error);

/* ---- reproduce_conditions.c: under what things are measured ---- */

/* Sets self->build and self->conditions and writes down what the latter stands for. */
int reproduce_find_conditions(reproduce *self);
/* As the system names it, without commas. */
void reproduce_find_processor(char name[REPRODUCE_MACHINE_SIZE]);
/* Writes down that the run begins or goes on under self's conditions. */
tulle_status reproduce_note_run(const reproduce *self, const reproduce_run *run, bool begins,
                                tulle_error *error);
/* The conditions of all steps of the run; "mixed" or "unknown". */
void reproduce_read_conditions(const reproduce *self, const reproduce_run *run,
                               char conditions[REPRODUCE_CONDITIONS_SIZE]);

/* ---- reproduce_scenes.c: what --quick makes coarser ---- */

typedef struct reproduce_quick {
    const char *scene;
    long frames;
    const char *overrides[10]; /* as --set takes them; ends with null */
} reproduce_quick;
/* About what a step takes for each triangle of cloth [us]: foretells the time. */
double reproduce_get_cost(const char *scene);
/* Null for a scene that the table does not name. */
const reproduce_quick *reproduce_find_quick(const char *scene);

enum { REPRODUCE_STILLS = 3 /* of a run */ };
/* Where in a run its stills are: shares of its frames, ascending. */
const double *reproduce_find_still_places(const char *scene);

typedef struct reproduce_shared {
    const char *scene, *file; /* the file's name without .yaml */
    const char *override;     /* as --set takes it, or null */
} reproduce_shared;
/* The file that stands in for a scene without one of its own; null: none does. */
const reproduce_shared *reproduce_find_shared(const char *scene);

/* ---- reproduce_judge.c ---- */

/* Sums over the frames of a run and over the reports of its steps. */
typedef struct reproduce_verdict {
    uint32_t frame_count, bad_frame_count;
    uint64_t intersection_count;
    size_t cloth_vertices, cloth_triangles, obstacle_vertices, obstacle_triangles, step_count;
    bool has_reports; /* of all steps; without them the sums over the steps are 0 */
    double simulated_seconds, step_seconds;
    uint64_t contacts, rescues; /* sums over the steps */
    double time_step;           /* [s] */
    char state[16];             /* of the run */
    char conditions[REPRODUCE_CONDITIONS_SIZE];
} reproduce_verdict;

/* Judges every frame of the run, unless that was done, and writes judged/RUN.csv. */
int reproduce_judge(reproduce *self, const reproduce_run *run);
/* What was found; false where the run is not there or not judged. */
bool reproduce_read_verdict(const reproduce *self, const reproduce_run *run,
                            reproduce_verdict *verdict);
/* Writes runs.csv, a line for every run that is there. */
int reproduce_write_runs(reproduce *self);

/* ---- reproduce_output.c ---- */

/* A table on its way to a file, which appears whole or not at all. */
typedef struct reproduce_table {
    char *bytes;
    size_t byte_count;
    FILE *stream; /* null: no memory, and nothing more is to be done */
} reproduce_table;
bool reproduce_table_begin(reproduce_table *table);
/* Writes the file in the directory of the results. */
int reproduce_table_end(const reproduce *self, reproduce_table *table, const char *file);
/* Frees it, and no file appears; also of one that is zero or that was ended. */
void reproduce_table_discard(reproduce_table *table);
/* Writes the file if `code`, what came of making its rows, is fine, else discards it; the code, or
 * that of writing. */
int reproduce_table_finish(const reproduce *self, reproduce_table *table, const char *file,
                           int code);
/* Prints an error with its file; the exit code. */
int reproduce_fail(const tulle_error *error);

/* Says that a job begins: a line, or JSON where standard error is no terminal. */
void reproduce_show_job(reproduce *self, const char *name, const char *what);
void reproduce_begin_work(reproduce *self);
/* One of the parts of the work was there: the time left is that of the others. */
void reproduce_skip_work(reproduce *self);
/* How far a piece of work is: a bar with the time left, or now and then a line of JSON. */
void reproduce_show_work(reproduce *self, const char *name, uint64_t done, uint64_t count);
void reproduce_end_work(reproduce *self);

/* ---- reproduce_frames.c: recorded frames as the detector takes them ---- */

typedef struct reproduce_frames {
    tulle_run_reader *reader;
    const tulle_run_info *info;
    size_t *bodies; /* in the run, of each surface */
    tulle_detect_surface *surfaces;
    size_t surface_count, vertex_count, triangle_count;
    uint32_t *triangles;
    double *rest, *start, *end; /* [m] 3 * vertex_count */
    double distance;            /* [m] of contact */
} reproduce_frames;
/* Cloths, and with obstacles also those that are there from the first frame to the last. To be
 * closed also after a failure. */
tulle_status reproduce_frames_open(const reproduce *self, const reproduce_run *run,
                                   bool has_obstacles, reproduce_frames *frames,
                                   tulle_error *error);
/* start: the frame before `frame`; end: `frame`. */
tulle_status reproduce_frames_read(reproduce_frames *frames, uint32_t frame, tulle_error *error);
/* A def of the frames: self's threads, the contact distance as separation. */
tulle_detect_def reproduce_frames_get_def(const reproduce *self, const reproduce_frames *frames);
void reproduce_frames_close(reproduce_frames *frames);
/* The paper's rules for patches, which prove nothing, at its best angle; or ours. */
tulle_detect_def reproduce_use_paper_rules(tulle_detect_def def, double angle);
tulle_detect_def reproduce_use_proof(tulle_detect_def def, double angle);

/* Frames that are looked at: every stride-th from 1 on, so that there are at most `most`. */
uint32_t reproduce_find_stride(uint32_t frame_count, uint32_t most);
/* How many those are. */
uint32_t reproduce_count_looks(uint32_t frame_count, uint32_t most);
enum { REPRODUCE_TEXT_SIZE = 512 };
/* Which frames these are and the contact distance, on one line. */
void reproduce_frames_describe(const reproduce_frames *frames, char text[REPRODUCE_TEXT_SIZE]);

/* ---- the figures ---- */

int reproduce_counterexamples(reproduce *self, const reproduce_figure *figure);
/* figure->runs: each animation by paper, bvox, refit and patches. */
int reproduce_table1(reproduce *self, const reproduce_figure *figure);
/* figure->runs: example one with low and with high friction. */
int reproduce_fig7(reproduce *self, const reproduce_figure *figure);
/* figure->runs: example one with low and with high friction. */
int reproduce_fig6(reproduce *self, const reproduce_figure *figure);

/* ---- reproduce_stills.c ---- */

/* Stills of all runs that are there. */
int reproduce_stills(reproduce *self, const reproduce_figure *figure);
/* Which frames are shown; false without any. */
bool reproduce_find_stills(const reproduce *self, const reproduce_run *run,
                           uint32_t frames[REPRODUCE_STILLS]);
/* Whether these are the bytes of a PNG from its head to its end. */
bool reproduce_is_whole_picture(const char *bytes, size_t count);
/* The picture's name in the directory of the results. */
void reproduce_name_still(const reproduce_run *run, uint32_t frame, char file[REPRODUCE_PATH_SIZE]);

/* ---- reproduce_report.c ---- */

/* Writes report.html of all that the directory of the results holds. */
int reproduce_write_report(reproduce *self);

#endif
