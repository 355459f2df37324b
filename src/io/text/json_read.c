/* io/text/json_read.c - see json_read.h. Based on: RFC 8259, The JavaScript Object Notation (JSON)
 * data interchange format. */
#include "io/text/json_read.h"

#include "base/error.h"
#include "io/file_data.h"
#include "io/text/number.h"

#include <limits.h>
#include <string.h>

enum {
    VALUES_FREE = 1 << 16, /* so many values a text of any size may have, */
    BYTES_OF_VALUE = 3     /* and beyond them one in so many bytes */
};

typedef struct json_parser {
    json_document *document;
    text_cursor text;
    size_t strings_used;
} json_parser;

static tulle_status parse_value(json_parser *parser, size_t index, int depth, tulle_error *error);

/* The next character after blanks and line ends; 0 at the end. */
static char peek(json_parser *parser) {
    text_cursor *const text = &parser->text;
    for (; text->at < text->end; text->at++) {
        char const c = *text->at;
        if (c == '\n') {
            text->line_start = text->at + 1;
            if (text->line < INT_MAX) text->line++;
        } else if (c != ' ' && c != '\t' && c != '\r') {
            return c;
        }
    }
    return '\0';
}

static tulle_status expect(json_parser *parser, char wanted, tulle_error *error) {
    if (peek(parser) != wanted || parser->text.at == parser->text.end)
        return text_fail(&parser->text, NULL, error, "'%c' should be here", wanted);
    parser->text.at++;
    return TULLE_OK;
}

/* Makes room for all values at once: there are no more than commas and brackets that open. Refuses
 * a text that would take many times its bytes. */
static tulle_status reserve_values(json_parser *parser, tulle_error *error) {
    const text_cursor *const text = &parser->text;
    size_t count = 1;
    bool is_in_string = false;
    for (const char *at = text->at; at < text->end; at++) {
        if (*at == '"') is_in_string = !is_in_string;
        if (is_in_string && *at == '\\') at++;
        count += !is_in_string && (*at == ',' || *at == '[' || *at == '{');
    }
    size_t const length = (size_t)(text->end - text->at);
    if (count > VALUES_FREE + length / BYTES_OF_VALUE)
        return error_set_at(error, TULLE_ERROR_LIMIT, text->path, 0, 0,
                            "has about %zu values in %zu bytes of JSON text, which are too many",
                            count, length);
    json_document *const document = parser->document;
    return ARRAY_RESERVE(document->heap, &document->values, count)
               ? TULLE_OK
               : file_fail_memory(error, text->path);
}

/* Adds a value that begins here; false when memory is short. */
static bool add_value(json_parser *parser, size_t *index) {
    json_document *const document = parser->document;
    if (!ARRAY_RESERVE(document->heap, &document->values, 1)) return false;
    *index = document->values.count++;
    document->values.data[*index] = (json_value){
        .line = parser->text.line, .column = (int)(parser->text.at - parser->text.line_start) + 1};
    return true;
}

/* ---- strings ---- */

static void keep_byte(json_parser *parser, unsigned byte) {
    parser->document->strings[parser->strings_used++] = (char)byte;
}

/* Four hexadecimal digits; false for anything else. */
static bool parse_unit(json_parser *parser, uint32_t *unit) {
    uint64_t value = 0;
    if (parser->text.end - parser->text.at < 4 || !json_parse_hash(parser->text.at, 4, &value))
        return false;
    *unit = (uint32_t)value;
    parser->text.at += 4;
    return true;
}

/* What follows \u, as UTF-8; a pair of surrogates makes one character. */
static tulle_status parse_escaped_unit(json_parser *parser, tulle_error *error) {
    uint32_t code = 0;
    bool fine = parse_unit(parser, &code) && code != 0 && (code < 0xdc00 || code > 0xdfff);
    if (fine && code >= 0xd800 && code <= 0xdbff) {
        uint32_t low = 0;
        fine = parser->text.end - parser->text.at >= 2 && memcmp(parser->text.at, "\\u", 2) == 0;
        if (fine) parser->text.at += 2;
        fine = fine && parse_unit(parser, &low) && low >= 0xdc00 && low <= 0xdfff;
        code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
    }
    if (!fine)
        return text_fail(&parser->text, NULL, error,
                         "\\u needs four hexadecimal digits of a character that is not zero");
    if (code < 0x80) {
        keep_byte(parser, code);
    } else if (code < 0x800) {
        keep_byte(parser, 0xc0 | code >> 6);
        keep_byte(parser, 0x80 | (code & 0x3f));
    } else {
        if (code < 0x10000) {
            keep_byte(parser, 0xe0 | code >> 12);
        } else {
            keep_byte(parser, 0xf0 | code >> 18);
            keep_byte(parser, 0x80 | (code >> 12 & 0x3f));
        }
        keep_byte(parser, 0x80 | (code >> 6 & 0x3f));
        keep_byte(parser, 0x80 | (code & 0x3f));
    }
    return TULLE_OK;
}

/* What follows a backslash. */
static tulle_status parse_escape(json_parser *parser, tulle_error *error) {
    static const char letters[] = "\"\\/bfnrt";
    static const char meanings[] = "\"\\/\b\f\n\r\t";
    char const c = parser->text.at < parser->text.end ? *parser->text.at : '\0';
    const char *const letter = c ? strchr(letters, c) : NULL;
    if (!letter && c != 'u')
        return text_fail(&parser->text, NULL, error, "an unknown escape in a string");
    parser->text.at++;
    if (c == 'u') return parse_escaped_unit(parser, error);
    keep_byte(parser, (unsigned char)meanings[letter - letters]);
    return TULLE_OK;
}

/* A string with its quotes. The decoded text is never longer than the text with its quotes. */
static tulle_status parse_string(json_parser *parser, const char **string, tulle_error *error) {
    tulle_status status = expect(parser, '"', error);
    *string = parser->document->strings + parser->strings_used;
    while (!status) {
        if (parser->text.at == parser->text.end || (unsigned char)*parser->text.at < 0x20)
            return text_fail(&parser->text, NULL, error, "a string is not closed on its line");
        char const c = *parser->text.at++;
        if (c == '"') {
            keep_byte(parser, '\0');
            return TULLE_OK;
        }
        if (c == '\\')
            status = parse_escape(parser, error);
        else
            keep_byte(parser, (unsigned char)c);
    }
    return status;
}

/* ---- numbers and words ---- */

static bool is_json_number(const char *text, size_t length) {
    if (length > 0 && *text == '-') text++, length--;
    if (length == 0 || *text < '0' || *text > '9') return false;
    if (length > 1 && text[0] == '0' && text[1] >= '0' && text[1] <= '9') return false;
    const char *const point = memchr(text, '.', length);
    return !point || (point + 1 < text + length && point[1] >= '0' && point[1] <= '9');
}

static tulle_status parse_word(json_parser *parser, json_value *value, tulle_error *error) {
    static const char *const words[] = {"null", "false", "true"};
    const char *const begin = parser->text.at;
    const char *end = begin;
    while (end < parser->text.end && *end != '\0' &&
           (strchr("+-.", *end) || (*end >= '0' && *end <= '9') ||
            ((*end | 0x20) >= 'a' && (*end | 0x20) <= 'z')))
        end++;
    text_word const word = {begin, (size_t)(end - begin)};
    parser->text.at = end;
    for (int i = 0; i < 3; i++) {
        if (!text_word_is(word, words[i])) continue;
        value->type = i == 0 ? JSON_NULL : JSON_BOOL;
        value->number = i == 2;
        return TULLE_OK;
    }
    value->type = JSON_NUMBER;
    if (is_json_number(word.text, word.length) &&
        number_parse_double(word.text, word.length, &value->number) == NUMBER_READ)
        return TULLE_OK;
    char shown[TEXT_SHOWN_SIZE];
    return text_fail(&parser->text, begin, error, "\"%s\" should be a value",
                     text_show_word(word, shown));
}

/* ---- arrays and objects ---- */

static tulle_status check_key(const json_parser *parser, size_t parent, const char *key,
                              tulle_error *error) {
    const json_document *const document = parser->document;
    if (document->values.data[parent].count == JSON_MEMBER_MAX)
        return text_fail(&parser->text, NULL, error, "an object has more than %d members",
                         JSON_MEMBER_MAX);
    if (json_find(document, &document->values.data[parent], key))
        return text_fail(&parser->text, NULL, error, "key \"%.40s\" is given twice", key);
    return TULLE_OK;
}

/* One item of `parent`, after item `last` (0: the first). */
static tulle_status parse_item(json_parser *parser, size_t parent, size_t *last, int depth,
                               tulle_error *error) {
    const char *key = NULL;
    if (parser->document->values.data[parent].type == JSON_OBJECT) {
        tulle_status status = parse_string(parser, &key, error);
        if (!status) status = check_key(parser, parent, key, error);
        if (!status) status = expect(parser, ':', error);
        if (status) return status;
    }
    peek(parser);
    size_t index = 0;
    if (!add_value(parser, &index)) return file_fail_memory(error, parser->text.path);
    json_value *const values = parser->document->values.data;
    values[index].key = key;
    if (*last)
        values[*last].next = index;
    else
        values[parent].first = index;
    values[parent].count++;
    *last = index;
    return parse_value(parser, index, depth + 1, error);
}

static tulle_status parse_items(json_parser *parser, size_t parent, char end, int depth,
                                tulle_error *error) {
    if (depth == JSON_DEPTH_MAX)
        return text_fail(&parser->text, NULL, error, "is nested more than %d deep", JSON_DEPTH_MAX);
    parser->text.at++;
    if (peek(parser) == end) {
        parser->text.at++;
        return TULLE_OK;
    }
    for (size_t last = 0;;) {
        tulle_status const status = parse_item(parser, parent, &last, depth, error);
        if (status) return status;
        if (peek(parser) != ',') return expect(parser, end, error);
        parser->text.at++;
    }
}

static tulle_status parse_value(json_parser *parser, size_t index, int depth, tulle_error *error) {
    json_value *const value = &parser->document->values.data[index];
    switch (peek(parser)) {
    case '{': value->type = JSON_OBJECT; return parse_items(parser, index, '}', depth, error);
    case '[': value->type = JSON_ARRAY; return parse_items(parser, index, ']', depth, error);
    case '"': value->type = JSON_STRING; return parse_string(parser, &value->string, error);
    default: return parse_word(parser, value, error);
    }
}

tulle_status json_read(memory *heap, const char *path, const char *text, size_t length,
                       json_document *document, tulle_error *error) {
    *document = (json_document){.heap = heap, .path = path, .strings_size = length + 1};
    json_parser parser = {.document = document, .text = text_cursor_make(path, text, length)};
    document->strings = memory_allocate(heap, document->strings_size);
    size_t root = 0;
    peek(&parser);
    tulle_status status =
        document->strings ? reserve_values(&parser, error) : file_fail_memory(error, path);
    if (!status && !add_value(&parser, &root)) status = file_fail_memory(error, parser.text.path);
    if (!status) status = parse_value(&parser, root, 0, error);
    if (!status) {
        peek(&parser);
        if (parser.text.at < parser.text.end)
            status = text_fail(&parser.text, NULL, error, "nothing should follow the value");
    }
    if (status) json_destroy(document);
    return status;
}
