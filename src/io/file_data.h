/* io/file_data.h - a whole file in memory, messages for failed file calls, names that survive a
 * power failure. */
#ifndef TULLE_IO_FILE_DATA_H
#define TULLE_IO_FILE_DATA_H

#include "base/memory.h"

#include <sys/types.h>

typedef struct file_data {
    char *bytes; /* byte_count bytes and a final zero that does not count */
    size_t byte_count;
} file_data;

/* Reads the regular file `path` of at most byte_limit bytes (0: FILE_BYTE_LIMIT). Errors:
 * TULLE_ERROR_IO (also for a folder or a device), TULLE_ERROR_LIMIT, TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status file_load(memory *heap, const char *path, size_t byte_limit, file_data *data,
                       tulle_error *error);
void file_release(memory *heap, file_data *data);
/* Reads up to byte_count bytes at offset of an open file; the number read, less only at the file's
 * end, or -1 with errno. */
ssize_t file_read_at(int file, void *bytes, size_t byte_count, uint64_t offset);

/* [bytes] Largest file that is read whole: 16 GiB. */
#define FILE_BYTE_LIMIT ((size_t)1 << 34)

/* Fills error for a failed system call: status by `code` (an errno), message "<what>: <reason>". */
tulle_status file_fail(tulle_error *error, const char *path, int code, const char *what);
/* What is wrong with a scene where a run or a mesh belongs, with its path. */
#define FILE_SCENE_MESSAGE "is a scene, not a run: run it first: tulle run %s -o DIR; then name DIR"
/* Fills error for want of memory while the file is read: TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status file_fail_memory(tulle_error *error, const char *path);

/* Flushes the folder that holds `path` to disk, so that its name survives a power failure. 0, also
 * where the file system flushes no folders, or an errno. */
int file_sync_folder(const char *path);
/* Gives a written file its last name: flushes it to disk, renames it, flushes the folder. A file
 * that it replaces leaves it its permissions. 0 or an errno. */
int file_rename(const char *from, const char *to);

#endif
