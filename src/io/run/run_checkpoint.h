/* io/run/run_checkpoint.h - checkpoint files: a header with magic, version, counters and a hash of
 * all, then the bytes of the world's state. Two generations are kept. */
#ifndef TULLE_IO_RUN_RUN_CHECKPOINT_H
#define TULLE_IO_RUN_RUN_CHECKPOINT_H

#include "base/memory.h"

#include "io/run/run_record.h"

/* A checkpoint and how far the run's other files were when it was made. */
typedef struct checkpoint_record {
    tulle_run_checkpoint state; /* bytes: from memory_allocate, when read */
    uint64_t scene_hash;
    uint64_t report_size, frames_size; /* [bytes] of report.csv and frames.csv */
    checksum_mark checksums;           /* of checksums.csv */
} checkpoint_record;

/* Writes the record as the directory's newest checkpoint; the newest so far becomes the one before.
 */
tulle_status checkpoint_write(const char *directory, const checkpoint_record *record,
                              tulle_error *error);
/* Reads one file. Errors: TULLE_ERROR_IO, TULLE_ERROR_PARSE (cut short, changed),
 * TULLE_ERROR_LIMIT, TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status checkpoint_read(memory *heap, const char *path, checkpoint_record *record,
                             tulle_error *error);
void checkpoint_release(memory *heap, checkpoint_record *record);

#endif
