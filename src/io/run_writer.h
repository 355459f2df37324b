/* io/run_writer.h - the writer of a run directory, shared by its making (run_create.c) and its use
 * (run_write.c). */
#ifndef TULLE_IO_RUN_WRITER_H
#define TULLE_IO_RUN_WRITER_H

#include "io/run_debug.h"

#include "tulle/io.h"

#define RUN_DEF_COOKIE UINT32_C(0x52756e31)

struct tulle_run_writer {
    memory heap;
    char directory[RUN_PATH_SIZE];
    int lock; /* descriptor of the locked directory, -1 if none */
    run_record record;
    run_frames frames;
    run_log report_log, frames_log;
    debug_log debug;
    tulle_pc2_writer **caches; /* of each body; null for static ones */
    uint32_t **triangles;      /* of each body, for VTP; null without VTP */
    bool has_unflushed_files;  /* beside the caches and logs, since the last checkpoint */
    char *line;                /* of frames.csv, run_frames_line_size bytes */
};

/* Closes and releases everything; files stay as they are. Null is fine. */
void run_writer_destroy(tulle_run_writer *writer);
/* Writes all PVD files; does nothing without VTP. */
tulle_status run_writer_write_collections(tulle_run_writer *writer, tulle_error *error);
tulle_status run_writer_write_record(tulle_run_writer *writer, tulle_error *error);

#endif
