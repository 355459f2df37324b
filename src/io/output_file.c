/* io/output_file.c - see output_file.h. */
#define _XOPEN_SOURCE 700
#include "io/output_file.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/memory.h"
#include "io/file_data.h"
#include "io/text/number.h"
#include "io/unflushed.h"

#include "tulle_io/mesh_files.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    BUFFER_SIZE = 1 << 16,  /* [bytes] gathered before a write */
    TEMPORARY_ROOM = 40,    /* [bytes] that a temporary name is longer than its target */
    TEMPORARY_TRIES = 1000, /* leftovers of killed processes with the same number to step around */
    FILE_MODE = 0666        /* cut by the user's umask */
};

struct output_file {
    memory heap;
    char *names; /* target, then the temporary name, in one block */
    size_t names_size;
    const char *target, *temporary; /* temporary null: written directly */
    int file;
    int is_flushed;
    int failure;      /* errno of the first failed write, 0 if none */
    hash_stream hash; /* of what left the buffer */
    uint64_t size;    /* [bytes] of the same */
    size_t used;
    char buffer[BUFFER_SIZE];
};

int file_write_at(int file, const void *bytes, size_t byte_count, uint64_t offset) {
    const char *cursor = bytes;
    while (byte_count > 0) {
        ssize_t const count = pwrite(file, cursor, byte_count, (off_t)offset);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return errno;
        if (count == 0) return ENOSPC;
        cursor += count;
        byte_count -= (size_t)count;
        offset += (uint64_t)count;
    }
    return 0;
}

static void destroy(output_file *output) {
    memory heap = output->heap;
    if (output->file >= 0) close(output->file);
    memory_release(&heap, output->names, output->names_size);
    memory_release(&heap, output, sizeof *output);
}

/* Opens a temporary name that nobody uses. 0 or an errno. */
static int open_temporary(output_file *output, char *temporary, size_t size) {
    for (int try = 0; try < TEMPORARY_TRIES; try++) {
        snprintf(temporary, size, "%s.%ld-%d.tmp", output->target, (long)getpid(), try);
        output->file = open(temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, FILE_MODE);
        if (output->file >= 0) {
            output->temporary = temporary;
            return 0;
        }
        if (errno != EEXIST) return errno;
    }
    return EEXIST;
}

/* Stores the target's name, of the file itself where `path` is a link to follow. False: no memory.
 */
static int store_names(output_file *output, const char *path, int follows_links) {
    char resolved[PATH_MAX];
    const char *const target =
        follows_links && realpath(path, resolved) ? resolved : path; /* or not there yet */
    size_t const length = strlen(target) + 1;
    output->names_size = 2 * length + TEMPORARY_ROOM;
    output->names = memory_allocate(&output->heap, output->names_size);
    if (output->names) memcpy(output->names, target, length);
    output->target = output->names;
    return output->names != NULL;
}

/* A file that is replaced keeps its permissions, as one that is written over would. */
static int open_target(output_file *output, int follows_links) {
    struct stat facts;
    bool const is_there = follows_links && stat(output->target, &facts) == 0;
    if (is_there && !S_ISREG(facts.st_mode)) {
        output->file = open(output->target, O_WRONLY | O_CLOEXEC);
        return output->file < 0 ? errno : 0;
    }
    size_t const length = strlen(output->target) + 1;
    int const code = open_temporary(output, output->names + length, output->names_size - length);
    if (code == 0 && is_there) (void)fchmod(output->file, facts.st_mode & 0777);
    return code;
}

static tulle_status open_output(const char *path, int follows_links, int is_flushed,
                                output_file **result, tulle_error *error) {
    *result = NULL;
    memory heap = memory_default();
    output_file *const output = memory_allocate(&heap, sizeof *output);
    if (!output) return file_fail(error, path, ENOMEM, "cannot be written");
    output->names = NULL;
    output->names_size = 0;
    output->temporary = NULL;
    output->file = -1;
    output->is_flushed = is_flushed;
    output->failure = 0;
    output->hash = hash_stream_make(FILE_SUM_SEED);
    output->size = 0;
    output->used = 0;
    output->heap = heap;
    int const code =
        store_names(output, path, follows_links) ? open_target(output, follows_links) : ENOMEM;
    if (code) {
        destroy(output);
        return file_fail(error, path, code, "cannot be written");
    }
    *result = output;
    return TULLE_OK;
}

tulle_status output_open(const char *path, output_file **output, tulle_error *error) {
    return open_output(path, 1, 1, output, error);
}

tulle_status output_open_inside(const char *path, output_file **output, tulle_error *error) {
    return open_output(path, 0, 1, output, error);
}

tulle_status output_open_unflushed(const char *path, output_file **output, tulle_error *error) {
    return open_output(path, 0, 0, output, error);
}

/* Writes in sequence; devices and pipes know no offsets. */
static int write_through(output_file *output, const char *bytes, size_t byte_count) {
    while (byte_count > 0) {
        ssize_t const count = write(output->file, bytes, byte_count);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return errno;
        bytes += count;
        byte_count -= (size_t)count;
    }
    return 0;
}

/* Sends bytes out and counts them. */
static void send_out(output_file *output, const void *bytes, size_t byte_count) {
    if (!output->failure) output->failure = write_through(output, bytes, byte_count);
    hash_stream_add(&output->hash, bytes, byte_count);
    output->size += byte_count;
}

static void flush(output_file *output) {
    send_out(output, output->buffer, output->used);
    output->used = 0;
}

void output_write(output_file *output, const void *bytes, size_t byte_count) {
    if (byte_count > BUFFER_SIZE - output->used) flush(output);
    if (byte_count > BUFFER_SIZE) {
        send_out(output, bytes, byte_count);
        return;
    }
    if (byte_count > 0) memcpy(output->buffer + output->used, bytes, byte_count);
    output->used += byte_count;
}

void output_text(output_file *output, const char *text) {
    output_write(output, text, strlen(text));
}

void output_double(output_file *output, double value) {
    char text[NUMBER_TEXT_SIZE];
    output_write(output, text, number_format_double(value, text));
}

void output_unsigned(output_file *output, uint64_t value) {
    char text[24];
    int const length = snprintf(text, sizeof text, "%llu", (unsigned long long)value);
    output_write(output, text, (size_t)length);
}

/* Everything to disk; 0 or an errno. */
static int sync_all(output_file *output) {
    flush(output);
    if (output->failure) return output->failure;
    if (output->temporary && output->is_flushed && fsync(output->file) != 0) return errno;
    return 0;
}

tulle_status output_flush(output_file *output, tulle_error *error) {
    int const code = sync_all(output);
    return code ? file_fail(error, output->target, code, "cannot be written") : TULLE_OK;
}

/* Everything to disk, then the new name. 0 or an errno. */
static int finish(output_file *output) {
    int const code = sync_all(output);
    if (code) return code;
    int const file = output->file;
    output->file = -1;
    if (close(file) != 0) return errno;
    if (output->temporary && rename(output->temporary, output->target) != 0) return errno;
    return 0;
}

uint64_t output_get_hash(const output_file *output) {
    hash_stream hash = output->hash;
    hash_stream_add(&hash, output->buffer, output->used);
    return hash_stream_get(&hash);
}

tulle_status output_commit_summed(output_file *output, file_sum *sum, tulle_error *error) {
    if (!sum) return output_commit(output, error);
    file_sum const made = {.end = output->size + output->used, .hash = output_get_hash(output)};
    if (sum->is_expected && (sum->end != made.end || sum->hash != made.hash)) {
        error_set_at(error, TULLE_ERROR_PARSE, output->target, 0, 0,
                     "is damaged and cannot be made again to the same bytes");
        output_discard(output);
        return TULLE_ERROR_PARSE;
    }
    *sum = made;
    return output_commit(output, error);
}

tulle_status output_commit(output_file *output, tulle_error *error) {
    int const code = finish(output);
    if (code) {
        tulle_status const status = file_fail(error, output->target, code, "cannot be written");
        output_discard(output);
        return status;
    }
    tulle_status status = TULLE_OK;
    int const folder_code =
        output->temporary && output->is_flushed ? file_sync_folder(output->target) : 0;
    if (folder_code)
        status =
            file_fail(error, output->target, folder_code, "its name cannot be flushed to disk");
    destroy(output);
    return status;
}

void output_discard(output_file *output) {
    if (!output) return;
    if (output->temporary) unlink(output->temporary);
    destroy(output);
}

tulle_status tulle_file_write(const char *path, const void *bytes, size_t byte_count,
                              tulle_error *error) {
    if (!path || (byte_count > 0 && !bytes))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "path and bytes may not be null");
    output_file *output = NULL;
    tulle_status const status = output_open(path, &output, error);
    if (status) return status;
    output_write(output, bytes, byte_count);
    return output_commit(output, error);
}
