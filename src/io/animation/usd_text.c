/* io/animation/usd_text.c - see usd_text.h.
 *
 * Based on: Pixar, Universal Scene Description, the grammar of the file format Usda. */
#define _POSIX_C_SOURCE 200809L
#include "io/animation/usd_text.h"

#include "base/error.h"
#include "io/file_data.h"
#include "io/text/number.h"
#include "io/text/text_cursor.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    WINDOW_SIZE = 1 << 15,   /* [bytes] */
    FIRST_PORTION = 1 << 12, /* [bytes] read after a jump; twice as many each time after that */
    BRACKET_DEPTH_MAX = 64,  /* of a value */
    WORD_LIMIT = 1 << 20,    /* [bytes] of a word that is kept; no name is longer */
    SHOWN_SIZE = 48          /* [bytes] of a word in a message */
};

/* ---- the window ---- */

static void read_more(usd_text *text) {
    size_t const rest = text->count - text->at;
    memmove(text->window, text->window + text->at, rest);
    text->window_offset += text->at;
    text->at = 0;
    text->count = rest;
    size_t const room = WINDOW_SIZE - rest;
    size_t const wanted = text->portion < room ? text->portion : room;
    ssize_t const got =
        file_read_at(text->file, text->window + rest, wanted, text->window_offset + rest);
    if (got < 0) text->code = errno;
    if (got > 0) text->count += (size_t)got;
    if (text->portion < WINDOW_SIZE) text->portion *= 2;
}

/* The byte `ahead` of the next one; -1 at the end. */
static int look(usd_text *text, size_t ahead) {
    if (text->at + ahead >= text->count && text->window_offset + text->at + ahead < text->size &&
        text->code == 0)
        read_more(text);
    return text->at + ahead < text->count ? text->window[text->at + ahead] : -1;
}

static int take(usd_text *text) {
    int const c = look(text, 0);
    if (c < 0) return c;
    text->at++;
    if (c == '\n') {
        if (text->line < INT_MAX) text->line++;
        text->line_start = text->window_offset + text->at;
    }
    return c;
}

static usd_place get_place(const usd_text *text) {
    uint64_t const offset = text->window_offset + text->at;
    uint64_t const column = offset - text->line_start + 1;
    return (usd_place){offset, text->line, column > INT_MAX ? INT_MAX : (int)column};
}

/* ---- errors ---- */

tulle_status usd_text_fail(const usd_text *text, usd_place place, tulle_error *error,
                           const char *format, ...) {
    char message[sizeof((tulle_error *)0)->message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return error_set_at(error, TULLE_ERROR_PARSE, text->path, place.line, place.column, "%s",
                        message);
}

tulle_status usd_text_fail_word(const usd_text *text, const char *what, tulle_error *error) {
    char shown[SHOWN_SIZE];
    size_t length = 0;
    for (; length < text->word.count && length + 1 < sizeof shown; length++) {
        char const c = text->word.data[length];
        shown[length] = c >= ' ' && c <= '~' ? c : '?';
    }
    shown[length] = '\0';
    if (text->kind == USD_END)
        return usd_text_fail(text, text->place, error, "the file ends where %s should be", what);
    return usd_text_fail(text, text->place, error, "\"%s\" should be %s", shown, what);
}

/* ---- words ---- */

static tulle_status keep(usd_text *text, int c, tulle_error *error) {
    if (text->word.count >= WORD_LIMIT)
        return usd_text_fail(text, text->place, error, "the text that begins here is too long");
    if (text->word.count + 2 > text->word.capacity && !ARRAY_RESERVE(text->heap, &text->word, 2))
        return file_fail_memory(error, text->path);
    text->word.data[text->word.count++] = (char)c;
    text->word.data[text->word.count] = '\0';
    return TULLE_OK;
}

static bool is_letter(int c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c >= 0x80;
}
static bool is_digit(int c) { return c >= '0' && c <= '9'; }

static int get_hex(int c) {
    if (is_digit(c)) return c - '0';
    c |= 0x20;
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* Passes over blanks, ends of lines and comments. */
static void skip_blanks(usd_text *text) {
    for (;;) {
        int const c = look(text, 0);
        bool const is_line =
            c == '#' || (c == '/' && look(text, 1) == '/'); /* a comment to the end of the line */
        if (c == ' ' || c == '\t' || c == '\r' || c == '\n') {
            take(text);
        } else if (is_line) {
            while (look(text, 0) >= 0 && look(text, 0) != '\n') take(text);
        } else if (c == '/' && look(text, 1) == '*') {
            take(text);
            take(text);
            while (look(text, 0) >= 0 && !(look(text, 0) == '*' && look(text, 1) == '/'))
                take(text);
            take(text);
            take(text);
        } else {
            return;
        }
    }
}

/* Takes what follows a backslash; -1: nothing. */
static int take_escaped(usd_text *text) {
    int const c = take(text);
    static const char from[] = "abfnrtv", to[] = "\a\b\f\n\r\t\v";
    const char *const found = c > 0 ? strchr(from, c) : NULL;
    if (found) return to[found - from];
    int value = 0;
    if (c == 'x' && get_hex(look(text, 0)) >= 0) {
        for (int i = 0; i < 2 && get_hex(look(text, 0)) >= 0; i++)
            value = 16 * value + get_hex(take(text));
        return value;
    }
    if (c < '0' || c > '7') return c;
    value = c - '0';
    for (int i = 0; i < 2 && look(text, 0) >= '0' && look(text, 0) <= '7'; i++)
        value = 8 * value + (take(text) - '0');
    return value & 0xff;
}

/* Takes a string in quotes; keeps it where it is wanted. */
static tulle_status take_string(usd_text *text, bool is_kept, tulle_error *error) {
    usd_place const place = get_place(text);
    int const quote = take(text);
    bool const is_long = look(text, 0) == quote && look(text, 1) == quote;
    if (is_long) {
        take(text);
        take(text);
    }
    for (;;) {
        int c = look(text, 0);
        if (c == quote && (!is_long || (look(text, 1) == quote && look(text, 2) == quote))) break;
        if (c < 0 || (!is_long && (c == '\n' || c == '\r')))
            return usd_text_fail(text, place, error, "the text that begins here has no end");
        c = take(text);
        if (c == '\\') c = take_escaped(text);
        tulle_status const status = is_kept && c > 0 ? keep(text, c, error) : TULLE_OK;
        if (status) return status;
    }
    for (int i = 0; i < (is_long ? 3 : 1); i++) take(text);
    return TULLE_OK;
}

/* Takes what stands between @ and @, or @@@ and @@@. */
static tulle_status take_asset(usd_text *text, bool is_kept, tulle_error *error) {
    usd_place const place = get_place(text);
    take(text);
    bool const is_long = look(text, 0) == '@' && look(text, 1) == '@';
    if (is_long) {
        take(text);
        take(text);
    }
    for (;;) {
        int const c = look(text, 0);
        if (c == '@' && (!is_long || (look(text, 1) == '@' && look(text, 2) == '@'))) break;
        if (c < 0 || c == '\n')
            return usd_text_fail(text, place, error, "the file's name that begins here has no end");
        take(text);
        tulle_status const status = is_kept ? keep(text, c, error) : TULLE_OK;
        if (status) return status;
    }
    for (int i = 0; i < (is_long ? 3 : 1); i++) take(text);
    /* Of @@@@, one @ more belongs to the name. */
    while (is_long && look(text, 0) == '@') take(text);
    return TULLE_OK;
}

static tulle_status take_path(usd_text *text, tulle_error *error) {
    take(text);
    tulle_status status = TULLE_OK;
    while (look(text, 0) != '>' && status == TULLE_OK) {
        if (look(text, 0) < 0 || look(text, 0) == '\n')
            return usd_text_fail(text, text->place, error, "the path that begins here has no end");
        status = keep(text, take(text), error);
    }
    take(text);
    return status;
}

static tulle_status take_number(usd_text *text, tulle_error *error) {
    tulle_status status = TULLE_OK;
    int before = 0;
    for (int c = look(text, 0); status == TULLE_OK; c = look(text, 0)) {
        bool const is_sign = (c == '-' || c == '+') && (before == 0 || (before | 0x20) == 'e');
        if (!is_sign && !is_digit(c) && c != '.' && !(before != 0 && is_letter(c))) break;
        before = take(text);
        status = keep(text, before, error);
    }
    if (status) return status;
    const char *const word = text->word.data;
    text->kind = USD_NUMBER;
    if (strcmp(word, "-inf") == 0 || strcmp(word, "+inf") == 0) {
        text->number = word[0] == '-' ? -(double)INFINITY : (double)INFINITY;
        return TULLE_OK;
    }
    switch (number_parse_double(word, text->word.count, &text->number)) {
    case NUMBER_READ: return TULLE_OK;
    case NUMBER_OUT_OF_RANGE: return usd_text_fail_word(text, "smaller: it is too large", error);
    default: return usd_text_fail_word(text, "a number", error);
    }
}

static tulle_status take_word(usd_text *text, tulle_error *error) {
    int c = look(text, 0);
    if (c < 0) {
        text->kind = USD_END;
        return text->code ? file_fail(error, text->path, text->code, "cannot be read") : TULLE_OK;
    }
    if (c == '"' || c == '\'') {
        text->kind = USD_STRING;
        return take_string(text, true, error);
    }
    if (c == '@') {
        text->kind = USD_ASSET;
        return take_asset(text, true, error);
    }
    if (c == '<') {
        text->kind = USD_PATH;
        return take_path(text, error);
    }
    if (is_digit(c) || c == '-' || c == '+') return take_number(text, error);
    if (c == '.' && is_digit(look(text, 1))) return take_number(text, error);
    if (!is_letter(c)) {
        text->kind = USD_SIGN;
        text->sign = (char)take(text);
        return keep(text, c, error);
    }
    text->kind = USD_NAME;
    tulle_status status = TULLE_OK;
    while ((is_letter(c) || is_digit(c) || c == ':') && status == TULLE_OK) {
        status = keep(text, take(text), error);
        c = look(text, 0);
    }
    return status;
}

tulle_status usd_text_next(usd_text *text, tulle_error *error) {
    skip_blanks(text);
    text->place = get_place(text);
    text->word.count = 0;
    text->word.data[0] = '\0';
    return take_word(text, error);
}

tulle_status usd_text_seek(usd_text *text, usd_place place, tulle_error *error) {
    if (place.offset >= text->window_offset && place.offset <= text->window_offset + text->count) {
        text->at = (size_t)(place.offset - text->window_offset);
    } else {
        text->window_offset = place.offset;
        text->at = text->count = 0;
        text->portion = FIRST_PORTION;
    }
    text->line = place.line;
    text->line_start = place.offset + 1 - (uint64_t)place.column;
    return usd_text_next(text, error);
}

bool usd_text_is_sign(const usd_text *text, char sign) {
    return text->kind == USD_SIGN && text->sign == sign;
}

bool usd_text_is_name(const usd_text *text, const char *name) {
    return text->kind == USD_NAME && strcmp(text->word.data, name) == 0;
}

tulle_status usd_text_expect(usd_text *text, char sign, tulle_error *error) {
    char const what[] = {'"', sign, '"', '\0'};
    if (!usd_text_is_sign(text, sign)) return usd_text_fail_word(text, what, error);
    return usd_text_next(text, error);
}

/* ---- values ---- */

/* Passes over all up to the bracket that closes the one before, without making words of it. */
static tulle_status skip_brackets(usd_text *text, char first, tulle_error *error) {
    static const char opening[] = "([{", closing[] = ")]}";
    usd_place const place = text->place;
    char expected[BRACKET_DEPTH_MAX];
    int depth = 0;
    expected[depth++] = closing[strchr(opening, first) - opening];
    while (depth > 0) {
        int const c = look(text, 0);
        tulle_status status = TULLE_OK;
        if (c < 0)
            return text->code ? file_fail(error, text->path, text->code, "cannot be read")
                              : usd_text_fail(text, place, error,
                                              "the bracket that opens here is not closed");
        if (c == '"' || c == '\'') {
            status = take_string(text, false, error);
        } else if (c == '@') {
            status = take_asset(text, false, error);
        } else if (c == '#' || c == '/') {
            skip_blanks(text);
            if (look(text, 0) == '/') take(text);
        } else {
            usd_place const here = get_place(text);
            const char *const open = c > 0 ? strchr(opening, c) : NULL;
            take(text);
            if (open && depth == BRACKET_DEPTH_MAX)
                status = usd_text_fail(text, here, error, "more than %d brackets in each other",
                                       BRACKET_DEPTH_MAX);
            else if (open)
                expected[depth++] = closing[open - opening];
            else if ((c == ')' || c == ']' || c == '}') && c != expected[--depth])
                status =
                    usd_text_fail(text, here, error, "\"%c\" should be \"%c\"", c, expected[depth]);
        }
        if (status) return status;
    }
    return TULLE_OK;
}

tulle_status usd_text_skip(usd_text *text, tulle_error *error) {
    tulle_status status = TULLE_OK;
    if (text->kind == USD_END) return usd_text_fail_word(text, "a value", error);
    if (text->kind == USD_SIGN) {
        if (!strchr("([{", text->sign)) return usd_text_fail_word(text, "a value", error);
        status = skip_brackets(text, text->sign, error);
    }
    bool const is_asset = text->kind == USD_ASSET;
    if (status == TULLE_OK) status = usd_text_next(text, error);
    /* A reference names a file and a prim in it. */
    if (status == TULLE_OK && is_asset && text->kind == USD_PATH)
        status = usd_text_next(text, error);
    return status;
}

static tulle_status read_number(usd_text *text, double *value, tulle_error *error) {
    if (text->kind == USD_NUMBER && isfinite(text->number))
        *value = text->number;
    else if (usd_text_is_name(text, "true") || usd_text_is_name(text, "false"))
        *value = text->word.data[0] == 't';
    else
        return usd_text_fail_word(text, "a finite number", error);
    return usd_text_next(text, error);
}

static tulle_status read_tuple(usd_text *text, size_t width, double *values, tulle_error *error) {
    tulle_status status = usd_text_expect(text, '(', error);
    for (size_t i = 0; i < width && status == TULLE_OK; i++) {
        if (i > 0) status = usd_text_expect(text, ',', error);
        if (status == TULLE_OK) status = read_number(text, values + i, error);
    }
    return status == TULLE_OK ? usd_text_expect(text, ')', error) : status;
}

static tulle_status read_element(usd_text *text, size_t width, double *values, tulle_error *error) {
    if (width == 1) return read_number(text, values, error);
    if (width < 16) return read_tuple(text, width, values, error);
    tulle_status status = usd_text_expect(text, '(', error);
    for (size_t row = 0; row < 4 && status == TULLE_OK; row++) {
        if (row > 0) status = usd_text_expect(text, ',', error);
        if (status == TULLE_OK) status = read_tuple(text, 4, values + 4 * row, error);
    }
    return status == TULLE_OK ? usd_text_expect(text, ')', error) : status;
}

tulle_status usd_text_read(usd_text *text, usd_place place, usd_numbers numbers, size_t *count,
                           tulle_error *error) {
    *count = 0;
    tulle_status status = usd_text_seek(text, place, error);
    bool const is_array = status == TULLE_OK && usd_text_is_sign(text, '[');
    if (is_array) status = usd_text_next(text, error);
    while (status == TULLE_OK && !(is_array && usd_text_is_sign(text, ']'))) {
        double element[16];
        status = read_element(text, numbers.width, element, error);
        if (status) return status;
        if (*count < numbers.room)
            memcpy(numbers.values + *count * numbers.width, element,
                   numbers.width * sizeof(double));
        ++*count;
        if (!is_array) break;
        if (!usd_text_is_sign(text, ']')) status = usd_text_expect(text, ',', error);
    }
    return status;
}

/* ---- the file ---- */

tulle_status usd_text_open(memory *heap, const char *path, usd_text *text, tulle_error *error) {
    *text = (usd_text){.heap = heap, .path = path, .line = 1, .portion = FIRST_PORTION};
    struct stat facts;
    text->file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (text->file < 0) return file_fail(error, path, errno, "cannot be opened");
    if (fstat(text->file, &facts) != 0) return file_fail(error, path, errno, "cannot be examined");
    if (!S_ISREG(facts.st_mode))
        return error_set_at(error, TULLE_ERROR_IO, path, 0, 0, "is not a regular file");
    text->size = (uint64_t)facts.st_size;
    text->window = memory_allocate(heap, WINDOW_SIZE);
    if (!text->window || !ARRAY_RESERVE(heap, &text->word, 64))
        return file_fail_memory(error, path);
    char magic[10] = {0};
    ssize_t const got = file_read_at(text->file, magic, 9, 0);
    if (got < 0) return file_fail(error, path, errno, "cannot be read");
    if (memcmp(magic, "PXR-USDC", 8) == 0)
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
                            "is in USD's binary form; write it in the text form (usda)");
    if (text_is_utf16(magic, sizeof magic))
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0, TEXT_UTF16_MESSAGE);
    if (memcmp(magic, "#usda 1.", 8) != 0)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 1, 1,
                            "should begin with \"#usda 1.0\"");
    return usd_text_next(text, error);
}

void usd_text_close(usd_text *text) {
    if (!text->heap) return;
    if (text->file >= 0) close(text->file);
    memory_release(text->heap, text->window, text->window ? WINDOW_SIZE : 0);
    ARRAY_FREE(text->heap, &text->word);
    *text = (usd_text){0};
}
