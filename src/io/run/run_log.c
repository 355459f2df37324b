/* io/run/run_log.c - see run_log.h. */
#define _POSIX_C_SOURCE 200809L
#include "io/run/run_log.h"

#include "base/error.h"
#include "io/file_data.h"
#include "io/output_file.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* The directory may come from a stranger, and a link in it may lead anywhere. */
static const int open_flags = O_WRONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;

static void keep_path(run_log *log, const char *path) {
    size_t const length = strlen(path);
    memcpy(log->path, path, length < RUN_PATH_SIZE ? length + 1 : 1);
    log->file = -1;
    log->size = 0;
    run_log_mark_summed(log);
}

tulle_status run_log_create(run_log *log, const char *path, const char *heading, size_t length,
                            tulle_error *error) {
    keep_path(log, path);
    log->file = open(path, open_flags | O_CREAT | O_TRUNC, 0666);
    if (log->file < 0) return file_fail(error, path, errno, "cannot be written");
    return run_log_append(log, heading, length, error);
}

tulle_status run_log_resume(run_log *log, const char *path, uint64_t size, tulle_error *error) {
    keep_path(log, path);
    log->file = open(path, open_flags);
    if (log->file < 0) return file_fail(error, path, errno, "cannot be opened");
    struct stat facts;
    if (fstat(log->file, &facts) != 0) return file_fail(error, path, errno, "cannot be examined");
    if ((uint64_t)facts.st_size < size)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "has %lld bytes, but the checkpoint knows of %llu",
                            (long long)facts.st_size, (unsigned long long)size);
    if (ftruncate(log->file, (off_t)size) != 0)
        return file_fail(error, path, errno, "cannot be cut back");
    log->size = size;
    run_log_mark_summed(log);
    return TULLE_OK;
}

tulle_status run_log_append(run_log *log, const char *line, size_t length, tulle_error *error) {
    int const code = file_write_at(log->file, line, length, log->size);
    if (code) {
        if (ftruncate(log->file, (off_t)log->size) != 0)
            return file_fail(error, log->path, code, "cannot be written, nor cut back");
        return file_fail(error, log->path, code, "cannot be written");
    }
    log->size += length;
    hash_stream_add(&log->unsummed, line, length);
    return TULLE_OK;
}

void run_log_cut(run_log *log) {
    if (log->file < 0 || log->summed >= log->size) return;
    log->size = log->summed; /* what is appended next goes here, cut off or not */
    run_log_mark_summed(log);
    if (ftruncate(log->file, (off_t)log->size) != 0) return;
}

file_sum run_log_get_sum(const run_log *log, const char *text, size_t length) {
    hash_stream hash = log->unsummed;
    hash_stream_add(&hash, text, length);
    return (file_sum){
        .begin = log->summed, .end = log->size + length, .hash = hash_stream_get(&hash)};
}

void run_log_mark_summed(run_log *log) {
    log->summed = log->size;
    log->unsummed = hash_stream_make(FILE_SUM_SEED);
}

tulle_status run_log_sync(run_log *log, tulle_error *error) {
    if (log->file < 0 || fsync(log->file) == 0) return TULLE_OK;
    return file_fail(error, log->path, errno, "cannot be written");
}

void run_log_close(run_log *log) {
    if (log->file >= 0) close(log->file);
    log->file = -1;
}
