/* io/run/run_log.h - a file that grows by whole lines or blocks: report.csv, frames.csv,
 * bodies.csv and debug.bin. */
#ifndef TULLE_IO_RUN_RUN_LOG_H
#define TULLE_IO_RUN_RUN_LOG_H

#include "base/hash.h"
#include "io/output_file.h"
#include "io/run/run_directory.h"

typedef struct run_log {
    char path[RUN_PATH_SIZE];
    int file;             /* -1: not open */
    uint64_t size;        /* [bytes] of whole lines or blocks */
    uint64_t summed;      /* [bytes] of the beginning that checksums.csv covers */
    hash_stream unsummed; /* of the bytes behind that */
} run_log;

/* A new file with one line. */
tulle_status run_log_create(run_log *log, const char *path, const char *heading, size_t length,
                            tulle_error *error);
/* An existing file, cut back to `size` bytes. */
tulle_status run_log_resume(run_log *log, const char *path, uint64_t size, tulle_error *error);
/* On failure the file is as before. */
tulle_status run_log_append(run_log *log, const char *line, size_t length, tulle_error *error);
/* Cuts off again what run_log_mark_summed has not seen; best effort on a disk that fails. */
void run_log_cut(run_log *log);
/* What was appended since run_log_mark_summed, and `length` bytes of text that follow. */
file_sum run_log_get_sum(const run_log *log, const char *text, size_t length);
/* All that the file holds is covered by checksums.csv. */
void run_log_mark_summed(run_log *log);
tulle_status run_log_sync(run_log *log, tulle_error *error);
void run_log_close(run_log *log);

#endif
