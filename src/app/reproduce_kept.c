/* app/reproduce_kept.c - see reproduce_kept.h. */
#include "app/reproduce_kept.h"

#include "app/cli/whole_file.h"
#include "base/error.h"
#include "base/timer.h"

#include "tulle/io.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { ROOM_FIRST = 4096, ROW_SIZE = 1024 /* [bytes] */ };
static const double SAVE_INTERVAL = 5.0; /* [s] what a killed program loses at most */

static tulle_status append(reproduce_kept *kept, const char *text, tulle_error *error) {
    size_t const length = strlen(text);
    if (kept->size + length + 1 > kept->room) {
        size_t const room = 2 * (kept->size + length) + ROOM_FIRST;
        char *const grown = realloc(kept->text, room);
        if (!grown) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for rows");
        kept->text = grown;
        kept->room = room;
    }
    memcpy(kept->text + kept->size, text, length + 1);
    kept->size += length;
    return TULLE_OK;
}

tulle_status reproduce_kept_open(const reproduce *self, const char *file, const char *head,
                                 reproduce_kept *kept, tulle_error *error) {
    *kept = (reproduce_kept){.saved = timer_now(), .head_size = strlen(head)};
    reproduce_make_path(self, kept->path, "%s", file);
    char *bytes = NULL;
    size_t count = 0;
    bool const is_there = whole_file_read(kept->path, &bytes, &count, NULL) == TULLE_OK;
    /* reading ends the bytes with a zero; a file that holds another one is none of ours */
    bool const is_ours = is_there && strlen(bytes) == count && count >= kept->head_size &&
                         bytes[count - 1] == '\n' && memcmp(bytes, head, kept->head_size) == 0;
    tulle_status const status = append(kept, is_ours ? bytes : head, error);
    kept->next = kept->head_size;
    free(bytes);
    return status;
}

/* The offset of the row that begins with the key, in [from, to); `to` without one. */
static size_t find_row(const reproduce_kept *kept, const char *key, size_t from, size_t to) {
    size_t const length = strlen(key);
    while (from < to && strncmp(kept->text + from, key, length) != 0)
        from += strcspn(kept->text + from, "\n") + 1;
    return from < to ? from : to;
}

const char *reproduce_kept_find(reproduce_kept *kept, const char *key) {
    size_t row = find_row(kept, key, kept->next, kept->size);
    if (row == kept->size) {
        row = find_row(kept, key, kept->head_size, kept->next);
        if (row == kept->next) return NULL;
    }
    kept->next = row + strcspn(kept->text + row, "\n") + 1;
    return kept->text + row + strlen(key);
}

bool reproduce_kept_is_end(const char *found, int length) {
    return length >= 0 && strcspn(found, "\n") == (size_t)length;
}

tulle_status reproduce_kept_add(reproduce_kept *kept, tulle_error *error, const char *format, ...) {
    char row[ROW_SIZE];
    va_list arguments;
    va_start(arguments, format);
    int const length = vsnprintf(row, sizeof row, format, arguments);
    va_end(arguments);
    if (length < 0 || length >= ROW_SIZE)
        return error_set(error, TULLE_ERROR_LIMIT, "a row of %s is longer than %d bytes",
                         kept->path, ROW_SIZE - 1);
    tulle_status status = append(kept, row, error);
    kept->is_changed = true;
    if (status == TULLE_OK && timer_now() - kept->saved > SAVE_INTERVAL)
        status = reproduce_kept_save(kept, error);
    return status;
}

void reproduce_kept_forget(reproduce_kept *kept) {
    kept->is_changed |= kept->size > kept->head_size;
    kept->size = kept->next = kept->head_size;
    kept->text[kept->size] = '\0';
}

tulle_status reproduce_kept_save(reproduce_kept *kept, tulle_error *error) {
    if (!kept->is_changed) return TULLE_OK;
    tulle_status const status = tulle_file_write(kept->path, kept->text, kept->size, error);
    kept->is_changed = status != TULLE_OK;
    kept->saved = timer_now();
    return status;
}

void reproduce_kept_close(reproduce_kept *kept) {
    free(kept->text);
    *kept = (reproduce_kept){0};
}
