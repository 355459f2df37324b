/* io/output_file.h - a file that appears whole or not at all. Bytes go through a buffer to a
 * temporary file in the target's folder; output_commit flushes it to disk and renames it. A target
 * that exists and is no regular file (a device, a pipe) is written directly. */
#ifndef TULLE_IO_OUTPUT_FILE_H
#define TULLE_IO_OUTPUT_FILE_H

#include "tulle/base.h"

typedef struct output_file output_file;

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
/* Removes what was written and releases `output`; null is fine. */
void output_discard(output_file *output);

/* Writes all bytes at `offset` of an open file; 0 or an errno. */
int file_write_at(int file, const void *bytes, size_t byte_count, uint64_t offset);

#endif
