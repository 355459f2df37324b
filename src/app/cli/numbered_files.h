/* app/cli/numbered_files.h - files that differ by a number in their names: frame_0000.obj,
 * frame_0001.obj ... A pattern names them: its last part holds one %d, or %04d for a number of at
 * least four digits with zeros in front; or, of files that are there, one * for any digits. */
#ifndef TULLE_APP_CLI_NUMBERED_FILES_H
#define TULLE_APP_CLI_NUMBERED_FILES_H

#include "app/cli/frame_range.h"

#include <stdbool.h>
#include <stddef.h>

enum {
    NUMBERED_PATH_SIZE = 4096, /* [bytes] of a path */
    NUMBERED_DIGITS = 9,       /* most digits of a number, and widest %0Nd */
    NUMBERED_NUMBER_MAX = 999999999
};

/* A pattern taken apart; borrows its text. */
typedef struct name_pattern {
    const char *text;   /* as given */
    size_t head_length; /* bytes before the number */
    const char *tail;   /* behind it */
    int width;          /* least digits */
    bool is_any;        /* the number is a * */
} name_pattern;

/* Whether the last part of the path holds a % or a *, so that it is meant as a pattern. */
bool name_pattern_is_meant(const char *path);
/* Takes a pattern apart. Errors: TULLE_ERROR_INVALID_ARGUMENT. */
tulle_status name_pattern_read(const char *text, name_pattern *pattern, tulle_error *error);
/* Writes the name of a file. False when it does not fit. Not for patterns with *. */
bool name_pattern_format(const name_pattern *pattern, uint32_t number,
                         char path[NUMBERED_PATH_SIZE]);

/* The files of a pattern that are there, by their numbers. */
typedef struct numbered_file {
    uint32_t number;
    char *name; /* in the folder */
} numbered_file;
typedef struct numbered_files {
    char folder[NUMBERED_PATH_SIZE]; /* with the / behind it, or empty */
    numbered_file *files;            /* sorted by number, count >= 1 */
    size_t count;
    frame_range range; /* from the first to the last in the widest steps that meet all of them */
    bool has_gaps;     /* the range names numbers that no file has */
    uint32_t gap;      /* the first of them */
} numbered_files;

/* Finds them. Errors: TULLE_ERROR_IO, TULLE_ERROR_INVALID_ARGUMENT (no file, or two of the same
 * number), TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status numbered_files_find(const name_pattern *pattern, numbered_files *found,
                                 tulle_error *error);
void numbered_files_destroy(numbered_files *found);
/* Writes the path of a number's file. False when there is none. */
bool numbered_files_get_path(const numbered_files *found, uint32_t number,
                             char path[NUMBERED_PATH_SIZE]);

#endif
