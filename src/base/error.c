/* base/error.c - filling a tulle_error. */
#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>

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
