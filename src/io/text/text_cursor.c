/* io/text/text_cursor.c - see text_cursor.h. */
#include "io/text/text_cursor.h"

#include "base/error.h"
#include "io/text/number.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { SHOWN_MAX = 40 }; /* [bytes] of a word that a message repeats */

text_cursor text_cursor_make(const char *path, const char *text, size_t length) {
    return (text_cursor){
        .path = path, .at = text, .end = text + length, .line_start = text, .line = 1};
}

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
static bool is_line_end(char c) { return c == '\n' || c == '\r'; }

static void step_over_line_end(text_cursor *cursor) {
    if (*cursor->at == '\r' && cursor->at + 1 < cursor->end && cursor->at[1] == '\n') cursor->at++;
    cursor->at++;
    cursor->line_start = cursor->at;
    if (cursor->line < INT_MAX) cursor->line++;
}

/* Whether the cursor is at a backslash that continues the line. */
static bool is_at_join(const text_cursor *cursor) {
    return cursor->joins_lines && *cursor->at == '\\' &&
           (cursor->at + 1 == cursor->end || is_line_end(cursor->at[1]));
}

static void skip_blanks(text_cursor *cursor) {
    while (cursor->at < cursor->end) {
        if (is_at_join(cursor)) {
            cursor->at++;
            if (cursor->at < cursor->end) step_over_line_end(cursor);
        } else if (is_blank(*cursor->at)) {
            cursor->at++;
        } else {
            break;
        }
    }
}

text_word text_take_word(text_cursor *cursor) {
    skip_blanks(cursor);
    text_word word = {.text = cursor->at};
    while (cursor->at < cursor->end && !is_blank(*cursor->at) && !is_line_end(*cursor->at) &&
           !is_at_join(cursor))
        cursor->at++;
    word.length = (size_t)(cursor->at - word.text);
    return word;
}

bool text_next_line(text_cursor *cursor) {
    while (cursor->at < cursor->end && !is_line_end(*cursor->at)) {
        bool const joins = is_at_join(cursor);
        cursor->at++;
        if (joins && cursor->at < cursor->end) step_over_line_end(cursor);
    }
    if (cursor->at < cursor->end) step_over_line_end(cursor);
    return cursor->at < cursor->end;
}

bool text_skip_blank_lines(text_cursor *cursor) {
    skip_blanks(cursor);
    while (cursor->at < cursor->end && is_line_end(*cursor->at)) {
        step_over_line_end(cursor);
        skip_blanks(cursor);
    }
    return cursor->at < cursor->end;
}

bool text_word_is(text_word word, const char *expected) {
    return word.length == strlen(expected) && memcmp(word.text, expected, word.length) == 0;
}

const char *text_show_word(text_word word, char shown[TEXT_SHOWN_SIZE]) {
    size_t const length = word.length < SHOWN_MAX ? word.length : SHOWN_MAX;
    for (size_t i = 0; i < length; i++) {
        char const c = word.text[i];
        shown[i] = c >= ' ' && c <= '~' ? c : '?';
    }
    memcpy(shown + length, word.length > SHOWN_MAX ? "..." : "", word.length > SHOWN_MAX ? 4 : 1);
    return shown;
}

tulle_status text_fail(const text_cursor *cursor, const char *place, tulle_error *error,
                       const char *format, ...) {
    char message[sizeof((tulle_error *)0)->message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    ptrdiff_t const column = (place ? place : cursor->at) - cursor->line_start + 1;
    return error_set_at(error, TULLE_ERROR_PARSE, cursor->path, cursor->line,
                        column < 1         ? 1
                        : column > INT_MAX ? INT_MAX
                                           : (int)column,
                        "%s", message);
}

tulle_status text_take_double(text_cursor *cursor, const char *what, double *value,
                              tulle_error *error) {
    text_word const word = text_take_word(cursor);
    if (word.length == 0) return text_fail(cursor, NULL, error, "%s is missing", what);
    char shown[TEXT_SHOWN_SIZE];
    switch (number_parse_double(word.text, word.length, value)) {
    case NUMBER_READ: return TULLE_OK;
    case NUMBER_OUT_OF_RANGE:
        return text_fail(cursor, word.text, error, "%s: \"%s\" is too large for a number", what,
                         text_show_word(word, shown));
    case NUMBER_MALFORMED: break;
    }
    return text_fail(cursor, word.text, error, "%s: \"%s\" should be a finite number", what,
                     text_show_word(word, shown));
}
