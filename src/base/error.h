/* base/error.h - filling a tulle_error. */
#ifndef TULLE_BASE_ERROR_H
#define TULLE_BASE_ERROR_H

#include "tulle/base.h"

/* Fills `error` (may be null) with status and a printf message, clears file, line and column;
 * returns status. */
tulle_status error_set(tulle_error *error, tulle_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The same with a place: path (may be null), 1-based line and column or 0. */
tulle_status error_set_at(tulle_error *error, tulle_status status, const char *path, int line,
                          int column, const char *format, ...)
    __attribute__((format(printf, 6, 7)));

#endif
