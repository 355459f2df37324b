/* io/output_file.h - a file that appears whole or not at all. Bytes go through a buffer to a
 * temporary file in the target's folder; output_commit flushes it to disk and renames it. A target
 * that exists and is no regular file (a device, a pipe) is written directly. */
#ifndef TULLE_IO_OUTPUT_FILE_H
#define TULLE_IO_OUTPUT_FILE_H

#include "tulle/base.h"

#include <stdbool.h>

typedef struct output_file output_file;

/* The hashes of sums begin here. From HASH_SEED on, a block that holds the hash of its own first
 * bytes would bring the sum to 0 there. */
#define FILE_SUM_SEED UINT64_C(0x9e3779b97f4a7c15)

/* What a piece of a file holds. */
typedef struct file_sum {
    uint64_t begin, end; /* [bytes] */
    uint64_t hash;       /* of them, from FILE_SUM_SEED on */
    bool is_expected;    /* of a file that is to be written: see output_commit_summed */
} file_sum;

tulle_status output_open(const char *path, output_file **output, tulle_error *error);
/* For a file of a run, whose directory may come from a stranger: a target that is a link is
 * replaced, and what the link leads to stays as it is. */
tulle_status output_open_inside(const char *path, output_file **output, tulle_error *error);
/* The same, for files that are flushed to disk together later. */
tulle_status output_open_unflushed(const char *path, output_file **output, tulle_error *error);

/* A failed write is remembered and reported by output_commit; later writes do nothing. */
void output_write(output_file *output, const void *bytes, size_t byte_count);
void output_text(output_file *output, const char *text);
/* As number_format_double. */
void output_double(output_file *output, double value);
void output_unsigned(output_file *output, uint64_t value);

/* Writes and flushes to disk what came so far, under the temporary name. On failure `output` is to
 * be discarded. */
tulle_status output_flush(output_file *output, tulle_error *error);
/* Makes the file appear and releases `output`; on failure the target is as it was. It may be there
 * whole after a failure, if all that failed is to flush its name to disk. */
tulle_status output_commit(output_file *output, tulle_error *error);
/* As output_commit. `sum` (may be null) gets the sum of the written bytes; if sum->is_expected, the
 * file appears only if its bytes have this sum, else TULLE_ERROR_PARSE. */
tulle_status output_commit_summed(output_file *output, file_sum *sum, tulle_error *error);
/* Hash of the bytes so far, from FILE_SUM_SEED on. */
uint64_t output_get_hash(const output_file *output);
/* Removes the written file and releases `output`; null is fine. */
void output_discard(output_file *output);

/* Writes all bytes at `offset` of an open file; 0 or an errno. */
int file_write_at(int file, const void *bytes, size_t byte_count, uint64_t offset);

#endif
