/* io/run/run_checksums.h - checksums.csv of a run: what its files hold, as hashes of pieces that
 * lie one behind the other. A line has the file, the frame that the piece is of (empty: of none),
 * its first byte and the one behind its last, the hash, and a hash of all lines so far.
 *
 * The lines of a frame are appended at once, before its line of frames.csv, which they cover too.
 */
#ifndef TULLE_IO_RUN_RUN_CHECKSUMS_H
#define TULLE_IO_RUN_RUN_CHECKSUMS_H

#include "io/file_data.h"
#include "io/run/run_log.h"

enum { CHECKSUM_NO_FRAME = -1 };

/* ---- writing ---- */

typedef struct checksum_log {
    run_log log;
    checksum_mark mark; /* of the file */
    ARRAY(char) lines;  /* not yet appended */
    uint64_t chain;     /* behind them */
    bool lacks_memory;  /* for lines since the last append */
} checksum_log;

/* A new DIRECTORY/checksums.csv without lines. */
tulle_status checksum_log_create(checksum_log *sums, const char *directory, tulle_error *error);
/* That of a run that is resumed, cut back to the mark. */
tulle_status checksum_log_resume(checksum_log *sums, const char *directory, checksum_mark mark,
                                 tulle_error *error);
/* Prepares the line of a piece. */
void checksum_log_add(checksum_log *sums, memory *heap, const char *name, int64_t frame,
                      const file_sum *sum);
/* Appends the prepared lines. On failure the file is as before, and the lines are forgotten.
 * Errors: OUT_OF_MEMORY, IO, DISK_FULL. */
tulle_status checksum_log_append(checksum_log *sums, tulle_error *error);
void checksum_log_forget(checksum_log *sums);
/* Forgets the prepared lines and cuts off those behind the mark; best effort on a disk that fails.
 */
void checksum_log_cut(checksum_log *sums, checksum_mark mark);
void checksum_log_close(checksum_log *sums, memory *heap);

/* ---- reading ---- */

typedef struct checksum_line {
    uint64_t name_hash;
    const char *name;
    int64_t frame; /* or CHECKSUM_NO_FRAME */
    file_sum sum;
    uint32_t number; /* of the line */
} checksum_line;

typedef struct checksums {
    memory *heap;
    file_data text;
    ARRAY(checksum_line) lines; /* of each file in order; of two for the same piece the later one */
    checksum_mark mark;         /* of the lines that were read */
    uint32_t frame_count;       /* frames whose lines are all there */
    bool is_complete; /* files that grow should end where their lines end; false unless set */
} checksums;

/* Reads DIRECTORY/checksums.csv: up to the mark, or, where it is null, all whole lines. Errors:
 * TULLE_ERROR_PARSE with the line that is not as it was written, TULLE_ERROR_IO,
 * TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status checksums_read(checksums *sums, memory *heap, const char *directory,
                            const checksum_mark *mark, tulle_error *error);
void checksums_release(checksums *sums);
/* The line of the piece that begins there; null: there is none. */
const checksum_line *checksums_find(const checksums *sums, const char *name, uint64_t begin);

/* Told of the first damage of a file, `error`; its frame, or CHECKSUM_NO_FRAME. */
typedef void checksum_handler(void *context, const char *name, int64_t frame,
                              const tulle_error *error);
/* Compares one file with its lines, those of frames before frame_limit. A file without lines is
 * fine. Errors: TULLE_ERROR_IO, TULLE_ERROR_PARSE (names the frame). */
tulle_status checksums_check_file(const checksums *sums, const char *directory, const char *name,
                                  uint32_t frame_limit, tulle_error *error);
/* The same for all files that have lines. */
void checksums_check_files(const checksums *sums, const char *directory, uint32_t frame_limit,
                           checksum_handler *handler, void *context);
/* [bytes] of the file that lines cover. */
uint64_t checksums_get_end(const checksums *sums, const char *name);
/* The error of bytes that are not as they were written. */
tulle_status checksum_fail(const char *path, int64_t frame, const file_sum *sum,
                           tulle_error *error);

#endif
