/* io/file_data.c - see file_data.h. */
#define _XOPEN_SOURCE 700
#include "io/file_data.h"

#include "base/error.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* [bytes] One read call; some systems refuse more than 2 GiB at once. */
static const size_t read_size_limit = (size_t)1 << 30;

tulle_status file_fail(tulle_error *error, const char *path, int code, const char *what) {
    char reason[256] = "";
    if (strerror_r(code, reason, sizeof reason) != 0) reason[0] = '\0';
    tulle_status status = TULLE_ERROR_IO;
    if (code == ENOSPC || code == EDQUOT) status = TULLE_ERROR_DISK_FULL;
    if (code == ENOMEM) status = TULLE_ERROR_OUT_OF_MEMORY;
    return error_set_at(error, status, path[0] ? path : "\"\"", 0, 0, "%s: %s", what, reason);
}

tulle_status file_fail_memory(tulle_error *error, const char *path) {
    return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, path, 0, 0,
                        "out of memory while it was read");
}

static tulle_status fail_irregular(const char *path, tulle_error *error) {
    return error_set_at(error, TULLE_ERROR_IO, path, 0, 0,
                        "is not a regular file; copy its contents into one first");
}

/* Size of the open file, which must be a regular one. */
static tulle_status measure(int file, const char *path, size_t byte_limit, size_t *size,
                            tulle_error *error) {
    struct stat facts;
    if (fstat(file, &facts) != 0) return file_fail(error, path, errno, "cannot be examined");
    if (S_ISDIR(facts.st_mode))
        return error_set_at(error, TULLE_ERROR_IO, path, 0, 0, "is a directory, not a file");
    if (!S_ISREG(facts.st_mode)) return fail_irregular(path, error);
    if ((uintmax_t)facts.st_size > byte_limit)
        return error_set_at(error, TULLE_ERROR_LIMIT, path, 0, 0,
                            "has %lld bytes; at most %zu can be read", (long long)facts.st_size,
                            byte_limit);
    *size = (size_t)facts.st_size;
    return TULLE_OK;
}

/* Reads up to `size` bytes; the file may have become shorter meanwhile. */
static tulle_status read_all(int file, const char *path, char *bytes, size_t size, size_t *done,
                             tulle_error *error) {
    *done = 0;
    while (*done < size) {
        size_t const wanted = size - *done < read_size_limit ? size - *done : read_size_limit;
        ssize_t const count = read(file, bytes + *done, wanted);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return file_fail(error, path, errno, "cannot be read");
        if (count == 0) break;
        *done += (size_t)count;
    }
    return TULLE_OK;
}

static tulle_status load_open_file(memory *heap, int file, const char *path, size_t byte_limit,
                                   file_data *data, tulle_error *error) {
    size_t size = 0;
    tulle_status status = measure(file, path, byte_limit, &size, error);
    if (status) return status;
    char *const bytes = memory_allocate(heap, size + 1);
    if (!bytes)
        return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, path, 0, 0,
                            "out of memory for its %zu bytes", size);
    size_t done = 0;
    status = read_all(file, path, bytes, size, &done, error);
    if (!status && done < size)
        status = error_set_at(error, TULLE_ERROR_IO, path, 0, 0,
                              "became shorter while it was read (%zu of %zu bytes)", done, size);
    if (status) {
        memory_release(heap, bytes, size + 1);
        return status;
    }
    bytes[size] = '\0';
    *data = (file_data){.bytes = bytes, .byte_count = size};
    return TULLE_OK;
}

tulle_status file_load(memory *heap, const char *path, size_t byte_limit, file_data *data,
                       tulle_error *error) {
    *data = (file_data){0};
    if (byte_limit == 0) byte_limit = FILE_BYTE_LIMIT;
    /* Without O_NONBLOCK, opening a pipe that nobody writes to would wait for ever. */
    int const file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0 && errno == ENXIO) return fail_irregular(path, error); /* a socket */
    if (file < 0) return file_fail(error, path, errno, "cannot be opened");
    tulle_status const status = load_open_file(heap, file, path, byte_limit, data, error);
    close(file);
    return status;
}

ssize_t file_read_at(int file, void *bytes, size_t byte_count, uint64_t offset) {
    size_t done = 0;
    while (done < byte_count) {
        ssize_t const count =
            pread(file, (char *)bytes + done, byte_count - done, (off_t)(offset + done));
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return -1;
        if (count == 0) break;
        done += (size_t)count;
    }
    return (ssize_t)done;
}

void file_release(memory *heap, file_data *data) {
    if (data->bytes) memory_release(heap, data->bytes, data->byte_count + 1);
    *data = (file_data){0};
}

int file_sync_folder(const char *path) {
    char folder_path[PATH_MAX];
    if (strlen(path) >= sizeof folder_path) return ENAMETOOLONG;
    strcpy(folder_path, path);
    char *const slash = strrchr(folder_path, '/');
    if (slash) slash[slash == folder_path ? 1 : 0] = '\0';
    int const folder = open(slash ? folder_path : ".", O_RDONLY | O_CLOEXEC | O_DIRECTORY);
    /* A folder may be written to and not be read; some file systems flush no folders. */
    if (folder < 0) return errno == EACCES ? 0 : errno;
    int code = fsync(folder) == 0 ? 0 : errno;
    if (code == EINVAL || code == EBADF) code = 0;
    close(folder);
    return code;
}

int file_rename(const char *from, const char *to) {
    int const file = open(from, O_RDONLY | O_CLOEXEC);
    struct stat facts;
    if (file >= 0 && stat(to, &facts) == 0 && S_ISREG(facts.st_mode))
        (void)fchmod(file, facts.st_mode & 0777);
    int code = file < 0 || fsync(file) != 0 ? errno : 0;
    if (file >= 0) close(file);
    if (!code && rename(from, to) != 0) code = errno;
    return code ? code : file_sync_folder(to);
}
