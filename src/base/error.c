/* base/error.c - filling a tulle_error. */
#include "base/error.h"

#include <stdarg.h>
#include <stdio.h>

tulle_status error_set(tulle_error *error, tulle_status status, const char *format, ...) {
    if (!error) return status;
    error->status = status;
    error->file[0] = '\0';
    error->line = error->column = 0;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->message, sizeof error->message, format, arguments);
    va_end(arguments);
    return status;
}

tulle_status error_set_at(tulle_error *error, tulle_status status, const char *path, int line,
                          int column, const char *format, ...) {
    if (!error) return status;
    error->status = status;
    snprintf(error->file, sizeof error->file, "%s", path ? path : "");
    error->line = line;
    error->column = column;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->message, sizeof error->message, format, arguments);
    va_end(arguments);
    return status;
}
