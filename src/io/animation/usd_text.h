/* io/animation/usd_text.h - the words of a USD file in its text form. The file is read through a
 * window, so its size does not matter; a place in it can be read again. */
#ifndef TULLE_IO_ANIMATION_USD_TEXT_H
#define TULLE_IO_ANIMATION_USD_TEXT_H

#include "base/memory.h"

typedef enum usd_kind {
    USD_END,    /* of the file */
    USD_NAME,   /* letters, digits, _ and : */
    USD_NUMBER, /* also -inf; inf and nan are names */
    USD_STRING, /* of any of the four kinds of quotes, decoded */
    USD_ASSET,  /* between @ or @@@ */
    USD_PATH,   /* between < and > */
    USD_SIGN    /* any other character */
} usd_kind;

typedef struct usd_place {
    uint64_t offset; /* [bytes] */
    int line, column;
} usd_place;

typedef struct usd_text {
    memory *heap;
    const char *path; /* for messages; must live as long */
    int file;
    uint64_t size;         /* [bytes] of the file */
    unsigned char *window; /* what has been read of it */
    uint64_t window_offset, line_start;
    size_t at, count; /* in the window */
    size_t portion;   /* [bytes] to read next */
    int line;
    int code; /* errno of a read that failed; 0: none */
    /* The word at hand. */
    usd_kind kind;
    char sign;        /* USD_SIGN */
    ARRAY(char) word; /* ends with a zero */
    double number;    /* USD_NUMBER */
    usd_place place;  /* where it begins */
} usd_text;

/* Opens a file and reads its first word. Release with usd_text_close, also after a failure. */
tulle_status usd_text_open(memory *heap, const char *path, usd_text *text, tulle_error *error);
void usd_text_close(usd_text *text);

/* Goes on to the next word. */
tulle_status usd_text_next(usd_text *text, tulle_error *error);
/* Goes to a place at which a word begins, and reads it. */
tulle_status usd_text_seek(usd_text *text, usd_place place, tulle_error *error);
/* Passes over the value that begins with the word at hand. */
tulle_status usd_text_skip(usd_text *text, tulle_error *error);

bool usd_text_is_sign(const usd_text *text, char sign);
bool usd_text_is_name(const usd_text *text, const char *name);
/* Passes over a sign that must be there. */
tulle_status usd_text_expect(usd_text *text, char sign, tulle_error *error);

/* Elements of `width` numbers each, and room for them. */
typedef struct usd_numbers {
    size_t width;
    double *values; /* room for `room` elements */
    size_t room;
} usd_numbers;

/* Reads the value at a place: an array of elements, or one element; an element of 16 numbers is in
 * rows. *count: elements that are there. Those that have room are stored. */
tulle_status usd_text_read(usd_text *text, usd_place place, usd_numbers numbers, size_t *count,
                           tulle_error *error);

/* An error at a place. */
tulle_status usd_text_fail(const usd_text *text, usd_place place, tulle_error *error,
                           const char *format, ...) __attribute__((format(printf, 4, 5)));
/* "should be WHAT" at the word at hand. */
tulle_status usd_text_fail_word(const usd_text *text, const char *what, tulle_error *error);

#endif
