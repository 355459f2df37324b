/* app/cli/whole_file.c - see whole_file.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/cli/whole_file.h"

#include "base/error.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const long long SIZE_LIMIT = 1LL << 34; /* [bytes] */

static tulle_status fail(const char *path, int code, tulle_error *error) {
    return error_set_at(error, code == ENOMEM ? TULLE_ERROR_OUT_OF_MEMORY : TULLE_ERROR_IO, path, 0,
                        0, "cannot be read: %s", strerror(code));
}

static tulle_status read_stream(FILE *file, const char *path, char **bytes, size_t *byte_count,
                                tulle_error *error) {
    struct stat facts;
    if (fstat(fileno(file), &facts) != 0) return fail(path, errno, error);
    if (!S_ISREG(facts.st_mode))
        return error_set_at(error, TULLE_ERROR_IO, path, 0, 0, "is no file with contents");
    if (facts.st_size > SIZE_LIMIT)
        return error_set_at(error, TULLE_ERROR_LIMIT, path, 0, 0,
                            "has %lld bytes; the most that can be read is %lld",
                            (long long)facts.st_size, SIZE_LIMIT);
    size_t const size = (size_t)facts.st_size;
    char *const made = malloc(size + 1);
    if (!made) return fail(path, ENOMEM, error);
    size_t const count = fread(made, 1, size, file);
    if (count < size) {
        int const code = ferror(file) ? errno : EIO;
        free(made);
        return fail(path, code, error);
    }
    made[size] = '\0';
    *bytes = made;
    *byte_count = size;
    return TULLE_OK;
}

tulle_status whole_file_read(const char *path, char **bytes, size_t *byte_count,
                             tulle_error *error) {
    FILE *const file = fopen(path, "rb");
    if (!file) return fail(path, errno, error);
    tulle_status const status = read_stream(file, path, bytes, byte_count, error);
    fclose(file);
    return status;
}
