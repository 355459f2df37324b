/* io/run/run_reader.h - the reader of a run directory, shared by what hands out its contents
 * (run_reader.c) and what finds damage in it (run_damage.c). */
#ifndef TULLE_IO_RUN_RUN_READER_H
#define TULLE_IO_RUN_RUN_READER_H

#include "io/run/run_checkpoint.h"
#include "io/run/run_checksums.h"
#include "io/run/run_debug.h"
#include "io/run/run_report.h"

#include "tulle_io/mesh_files.h"

struct tulle_run_reader {
    memory heap;
    char directory[RUN_PATH_SIZE];
    run_record record;
    run_frames frames;
    checksums sums;
    bool has_checkpoint;          /* there is a whole one */
    checkpoint_record checkpoint; /* when has_checkpoint; without the state's bytes */
    file_data scene;
    tulle_run_info info;
    tulle_run_body_info *bodies;
    tulle_mesh *meshes;              /* of each body, empty until asked for */
    run_report_rows reports;         /* empty until asked for */
    debug_file debug;                /* not open until asked for */
    arena debug_arrays;              /* of the last frame that was asked for */
    ARRAY(tulle_run_damage) damages; /* empty until asked for */
    arena damage_texts;
    bool lacks_memory; /* for damages */
};

/* Reads checksums.csv, as far as the run's end or its newest checkpoint says that it should go. */
tulle_status run_reader_read_checksums(tulle_run_reader *reader, tulle_error *error);
/* Reads frames.csv and compares it with its checksums. Frames that nobody has promised, as after a
 * loss of power, may be missing. */
tulle_status run_reader_read_frames(tulle_run_reader *reader, tulle_error *error);
/* Compares one file of the run. */
tulle_status run_reader_check_file(const tulle_run_reader *reader, const char *name,
                                   tulle_error *error);
/* What a call that read something returns. Where it failed and checksums.csv does not begin with
 * the lines that were read when the run was opened, another process is to blame, and the error says
 * so. For whoever takes something away from a run cuts those lines first. */
tulle_status run_reader_blame(const tulle_run_reader *reader, tulle_status status,
                              tulle_error *error);
/* Frames that should be there whatever happened. */
uint32_t run_reader_get_promised_count(const tulle_run_reader *reader);

#endif
