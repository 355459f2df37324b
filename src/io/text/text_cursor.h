/* io/text/text_cursor.h - walks the words and lines of a text in memory and knows where it is. A
 * line ends with \n, \r\n, \r or the end of the text. */
#ifndef TULLE_IO_TEXT_TEXT_CURSOR_H
#define TULLE_IO_TEXT_TEXT_CURSOR_H

#include "tulle/base.h"

#include <stdbool.h>

typedef struct text_cursor {
    const char *path; /* for messages */
    const char *at, *end;
    const char *line_start;
    int line;         /* 1-based */
    bool joins_lines; /* a backslash at the end of a line continues it (OBJ) */
} text_cursor;

/* A word: text without blanks. */
typedef struct text_word {
    const char *text;
    size_t length; /* 0: there is no more word on the line */
} text_word;

/* Whether a file is text in UTF-16, by its mark or by the zeros of its first two letters. */
static inline bool text_is_utf16(const char *bytes, size_t count) {
    if (count < 4) return false;
    unsigned char const first = (unsigned char)bytes[0], second = (unsigned char)bytes[1];
    if ((first == 0xff && second == 0xfe) || (first == 0xfe && second == 0xff)) return true;
    return (first == 0) != (second == 0) && (bytes[2] == 0) == (first == 0) &&
           (bytes[3] == 0) == (second == 0);
}
#define TEXT_UTF16_MESSAGE "is text in UTF-16, which is not read: save it as UTF-8"

text_cursor text_cursor_make(const char *path, const char *text, size_t length);

/* The next word of this line; stays at the end of the line when there is none. */
text_word text_take_word(text_cursor *cursor);
/* Skips what is left of the line and its end. False at the end of the text. */
bool text_next_line(text_cursor *cursor);
/* Skips blank lines and blanks. False at the end of the text. */
bool text_skip_blank_lines(text_cursor *cursor);
bool text_word_is(text_word word, const char *expected);

/* The next word of this line as a number; `what` names it in the message. Not finite or missing is
 * TULLE_ERROR_PARSE. */
tulle_status text_take_double(text_cursor *cursor, const char *what, double *value,
                              tulle_error *error);
/* An error at `place` (within the current line; null: where the cursor is). */
tulle_status text_fail(const text_cursor *cursor, const char *place, tulle_error *error,
                       const char *format, ...) __attribute__((format(printf, 4, 5)));

/* A word for a message: at most 40 bytes, unprintable ones as '?'. */
enum { TEXT_SHOWN_SIZE = 48 };
const char *text_show_word(text_word word, char shown[TEXT_SHOWN_SIZE]);

#endif
