/* base/error.c - filling a tulle_error, names of statuses. */
#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const char *tulle_status_text(tulle_status status) {
    switch (status) {
    case TULLE_OK: return "no error";
    case TULLE_ERROR_INVALID_ARGUMENT: return "invalid argument";
    case TULLE_ERROR_OUT_OF_MEMORY: return "out of memory";
    case TULLE_ERROR_IO: return "file error";
    case TULLE_ERROR_DISK_FULL: return "disk full";
    case TULLE_ERROR_PARSE: return "malformed file";
    case TULLE_ERROR_INVALID_MESH: return "unusable mesh";
    case TULLE_ERROR_INTERSECTING_START: return "intersecting start";
    case TULLE_ERROR_PINCHED: return "cloth pinched between obstacles";
    case TULLE_ERROR_STEP_FAILED: return "step failed";
    case TULLE_ERROR_LIMIT: return "limit exceeded";
    case TULLE_ERROR_INTERRUPTED: return "interrupted";
    case TULLE_ERROR_UNSUPPORTED: return "unsupported";
    case TULLE_STATUS_COUNT: break;
    }
    return "unknown status";
}

/* Where in a file something is wrong. */
typedef struct place {
    const char *path;
    int line, column;
} place;

static void fill(tulle_error *error, tulle_status status, place at, const char *format,
                 va_list arguments) {
    if (!error) return;
    error->status = status;
    snprintf(error->file, sizeof error->file, "%s", at.path ? at.path : "");
    error->line = at.line;
    error->column = at.column;
    vsnprintf(error->message, sizeof error->message, format, arguments);
}

tulle_status error_set(tulle_error *error, tulle_status status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fill(error, status, (place){0}, format, arguments);
    va_end(arguments);
    return status;
}

tulle_status error_set_at(tulle_error *error, tulle_status status, const char *path, int line,
                          int column, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fill(error, status, (place){path, line, column}, format, arguments);
    va_end(arguments);
    return status;
}
