/* app/reproduce_kept.h - rows that are measured one by one and kept in a file, so that work that
 * was cut off goes on where it was. The file begins with a head that tells under what the rows were
 * made; rows under another head are never given again. The file is always whole: it is replaced
 * under a temporary name, every few seconds and when asked. */
#ifndef TULLE_APP_REPRODUCE_KEPT_H
#define TULLE_APP_REPRODUCE_KEPT_H

#include "app/reproduce.h"

typedef struct reproduce_kept {
    char path[REPRODUCE_PATH_SIZE];
    char *text; /* the file's, ended by a zero; head first */
    size_t size, room, head_size;
    size_t next;  /* offset of the row behind the one found last: rows are asked for in order */
    double saved; /* [s] of the clock */
    bool is_changed;
} reproduce_kept;

/* Reads the rows of the file in the directory of the results, if it is there and has this head,
 * lines that end with a line feed. To be closed also after a failure. */
tulle_status reproduce_kept_open(const reproduce *self, const char *file, const char *head,
                                 reproduce_kept *kept, tulle_error *error);
/* What follows `key` in the row that begins with it, up to the line feed; null: there is none.
 * Lives until a row is added. */
const char *reproduce_kept_find(reproduce_kept *kept, const char *key);
/* Whether the row that `found` lies in ends `length` bytes on, not before and not after. */
bool reproduce_kept_is_end(const char *found, int length);
/* Adds a row: printf text, a line feed at its end. Saves when that was not done for some seconds.
 */
tulle_status reproduce_kept_add(reproduce_kept *kept, tulle_error *error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* Drops all rows. */
void reproduce_kept_forget(reproduce_kept *kept);
/* Writes the file, if rows were added. */
tulle_status reproduce_kept_save(reproduce_kept *kept, tulle_error *error);
/* Also of one that is zero. Does not save. */
void reproduce_kept_close(reproduce_kept *kept);

#endif
