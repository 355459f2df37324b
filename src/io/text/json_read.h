/* io/text/json_read.h - reads JSON text into a table of values. Strict: RFC 8259 and nothing more,
 * keys unique in their object, at most JSON_DEPTH_MAX deep and JSON_MEMBER_MAX members an object.
 */
#ifndef TULLE_IO_TEXT_JSON_READ_H
#define TULLE_IO_TEXT_JSON_READ_H

#include "base/memory.h"
#include "io/text/text_cursor.h"

enum {
    JSON_DEPTH_MAX = 32,
    JSON_MEMBER_MAX = 256 /* keys are looked up one by one */
};

typedef enum json_type {
    JSON_NULL,
    JSON_BOOL,
    JSON_NUMBER,
    JSON_STRING,
    JSON_ARRAY,
    JSON_OBJECT
} json_type;

typedef struct json_value {
    json_type type;
    const char *key;     /* of a member of an object, else null */
    const char *string;  /* JSON_STRING: decoded, ends with a zero and holds no other */
    double number;       /* JSON_NUMBER; JSON_BOOL: 0 or 1 */
    size_t next;         /* index of the next item of the same parent; 0: none */
    size_t first, count; /* JSON_ARRAY, JSON_OBJECT: items; first is 0 when there are none */
    int line, column;
} json_value;

typedef struct json_document {
    memory *heap;
    const char *path;
    char *strings; /* decoded strings, in the order of the text */
    size_t strings_size;
    ARRAY(json_value) values; /* the first is the whole */
} json_document;

/* `path` is for messages and must live as long as the document. Errors: TULLE_ERROR_PARSE with line
 * and column, TULLE_ERROR_LIMIT (far too many values for the length), TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status json_read(memory *heap, const char *path, const char *text, size_t length,
                       json_document *document, tulle_error *error);
void json_destroy(json_document *document);

const json_value *json_get_root(const json_document *document);
/* First item of an array or object, and the one after an item; null: none. */
const json_value *json_get_first(const json_document *document, const json_value *parent);
const json_value *json_get_next(const json_document *document, const json_value *item);
/* The member of that key; null when there is none or object is none. */
const json_value *json_find(const json_document *document, const json_value *object,
                            const char *key);

/* Members that must be there and of the right type: else TULLE_ERROR_PARSE that names the key. */
tulle_status json_take_member(const json_document *document, const json_value *object,
                              const char *key, json_type type, const json_value **member,
                              tulle_error *error);
tulle_status json_take_string(const json_document *document, const json_value *object,
                              const char *key, const char **text, tulle_error *error);
tulle_status json_take_double(const json_document *document, const json_value *object,
                              const char *key, double *value, tulle_error *error);
/* A whole number from 0 to UINT32_MAX. */
tulle_status json_take_whole(const json_document *document, const json_value *object,
                             const char *key, uint32_t *value, tulle_error *error);
/* A whole number that a double holds exactly, from 0 to 2^53 - 1. */
tulle_status json_take_count(const json_document *document, const json_value *object,
                             const char *key, uint64_t *value, tulle_error *error);
tulle_status json_take_bool(const json_document *document, const json_value *object,
                            const char *key, int *value, tulle_error *error);
/* A string of 16 hexadecimal digits. */
tulle_status json_take_hash(const json_document *document, const json_value *object,
                            const char *key, uint64_t *value, tulle_error *error);
/* A member of an object that is a member of a struct. */
typedef struct json_field {
    const char *key;
    enum { JSON_DOUBLE, JSON_COUNT, JSON_WHOLE, JSON_FLAG, JSON_HASH } kind; /* as json_take_... */
    size_t offset;
} json_field;
tulle_status json_take_fields(const json_document *document, const json_value *object,
                              const json_field *fields, size_t count, void *target,
                              tulle_error *error);
/* An error at the place of a value. */
tulle_status json_fail(const json_document *document, const json_value *place, tulle_error *error,
                       const char *format, ...) __attribute__((format(printf, 4, 5)));
/* Reads 1 to 16 hexadecimal digits; false for anything else. */
bool json_parse_hash(const char *text, size_t length, uint64_t *value);

#endif
