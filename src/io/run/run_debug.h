/* io/run/run_debug.h - debug.bin of a run: what explains each frame beyond positions. A head, then
 * one block for each frame, one behind the other; src/io/run/FORMAT.md has the bytes.
 *
 * Blocks are found by walking from header to header. A header has a hash of its own, so that a
 * damaged size is noticed before it leads astray; the payload has another. */
#ifndef TULLE_IO_RUN_RUN_DEBUG_H
#define TULLE_IO_RUN_RUN_DEBUG_H

#include "base/arena.h"
#include "io/run/run_log.h"

/* ---- writing ---- */

typedef struct debug_log {
    memory *heap;
    run_log log;               /* file -1: the run records none */
    ARRAY(unsigned char) room; /* for one block, kept from frame to frame */
} debug_log;

debug_log debug_log_make(memory *heap);
/* A new file with its head. */
tulle_status debug_log_create(debug_log *writer, const char *directory, tulle_error *error);
/* Appends the block of a frame. debug may be null: nothing is known. On failure the file is as
 * before. Errors: INVALID_ARGUMENT (arrays that are missing, indices or labels out of range),
 * OUT_OF_MEMORY, IO, DISK_FULL. */
tulle_status debug_log_append(debug_log *writer, const run_record *record, uint32_t frame,
                              const tulle_run_debug *debug, tulle_error *error);
void debug_log_close(debug_log *writer);

/* ---- reading ---- */

typedef struct debug_file {
    memory *heap;
    char path[RUN_PATH_SIZE];
    int file;               /* -1: not open */
    ARRAY(uint64_t) begins; /* [bytes] of the blocks that were walked over */
    uint64_t next;          /* [bytes] end of the last of them */
} debug_file;

/* Opens DIRECTORY/debug.bin and checks its head. */
tulle_status debug_file_open(debug_file *file, memory *heap, const char *directory,
                             tulle_error *error);
/* Finds the first `frame_count` blocks; file->next is then the end of the last. PARSE: the file
 * ends before, or a header was changed. */
tulle_status debug_file_walk(debug_file *file, uint32_t frame_count, tulle_error *error);
/* Reads a frame of a run with these bodies; *debug null: nothing is known. Arrays are from
 * `scratch`. */
tulle_status debug_file_read(debug_file *file, const run_record *record, uint32_t frame,
                             arena *scratch, const tulle_run_debug **debug, tulle_error *error);
void debug_file_close(debug_file *file);

#endif
