/* io/run/run_writer.h - the writer of a run directory, shared by its making (run_create.c,
 * run_resume.c) and its use (run_write.c). */
#ifndef TULLE_IO_RUN_RUN_WRITER_H
#define TULLE_IO_RUN_RUN_WRITER_H

#include "io/run/run_checksums.h"
#include "io/run/run_debug.h"
#include "io/run/run_rounding.h"
#include "io/run/run_transforms.h"

#include "tulle_io/cache.h"

#define RUN_DEF_COOKIE UINT32_C(0x52756e31)

struct tulle_run_writer {
    memory heap;
    char directory[RUN_PATH_SIZE];
    int lock; /* descriptor of the locked directory, -1 if none */
    bool has_made_directory;
    run_record record;
    run_frames frames;
    run_log report_log, frames_log, bodies_log;
    debug_log debug;
    checksum_log checksums;
    ARRAY(char) notes; /* what a resume has to say, a line each, with a zero; empty: nothing */
    bool has_former_outcome;
    tulle_run_outcome former_outcome; /* in run.json of the run that is resumed */
    tulle_pc2_writer **caches;        /* of each body; null for static ones */
    uint32_t **triangles;             /* of each body, for VTP; null without VTP */
    run_rounding rounding;            /* judges frames before they are written */
    bool has_unflushed_files; /* other than caches and logs, written since the last checkpoint */
    char *line;               /* of frames.csv, run_frames_line_size bytes */
};

tulle_status run_writer_check_def(const tulle_run_def *def, tulle_error *error);
/* A writer in memory, of a checked def; no file is touched. */
tulle_status run_writer_make(const tulle_run_def *def, tulle_run_writer **result,
                             tulle_error *error);
/* Closes and releases everything; files stay as they are. Null is fine. */
void run_writer_destroy(tulle_run_writer *writer);
/* The same after a failure: removes the directory too, where the writer made it and it is empty. */
void run_writer_abandon(tulle_run_writer *writer);
/* Begins a new run in the writer's locked directory, whose contents are of `kind`. An error removes
 * the new files. */
tulle_status run_writer_begin(tulle_run_writer *writer, const tulle_run_def *def,
                              run_directory_kind kind, tulle_run_existing existing,
                              tulle_error *error);
/* Writes all PVD files; does nothing without VTP. */
tulle_status run_writer_write_collections(tulle_run_writer *writer, tulle_error *error);
/* Files that follow from the scene alone. */
typedef enum scene_file {
    SCENE_FILE_TEXT, /* scene.yaml, if there is a text; of body 0 */
    SCENE_FILE_MESH, /* a body's OBJ file */
    SCENE_FILE_VTP   /* that of a static body, if VTP is wanted */
} scene_file;
/* Its name; false where the run has none. */
bool run_writer_name_file(const tulle_run_writer *writer, scene_file kind, size_t body,
                          char name[RUN_PATH_SIZE]);
/* Writes it and prepares its line of checksums.csv; or, with `expected`, makes it again: to those
 * bytes or not at all. Does nothing where the run has none. */
tulle_status run_writer_write_file(tulle_run_writer *writer, const tulle_run_def *def,
                                   scene_file kind, size_t body, const file_sum *expected,
                                   tulle_error *error);
/* Appends lines for all that logs hold and checksums.csv does not cover. */
tulle_status run_writer_sum_logs(tulle_run_writer *writer, tulle_error *error);
/* The folder of VTP files, when they are wanted. */
tulle_status run_writer_make_vtp_folder(tulle_run_writer *writer, tulle_error *error);
tulle_status run_writer_write_record(tulle_run_writer *writer, tulle_error *error);

#endif
