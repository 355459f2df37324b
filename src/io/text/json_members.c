/* io/text/json_members.c - finds members of JSON objects and checks their types; see json_read.h.
 */
#include "base/error.h"
#include "io/text/json_read.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void json_destroy(json_document *document) {
    memory_release(document->heap, document->strings, document->strings_size);
    ARRAY_FREE(document->heap, &document->values);
    *document = (json_document){0};
}

const json_value *json_get_root(const json_document *document) { return document->values.data; }

const json_value *json_get_first(const json_document *document, const json_value *parent) {
    return parent->first ? &document->values.data[parent->first] : NULL;
}

const json_value *json_get_next(const json_document *document, const json_value *item) {
    return item->next ? &document->values.data[item->next] : NULL;
}

const json_value *json_find(const json_document *document, const json_value *object,
                            const char *key) {
    if (object->type != JSON_OBJECT) return NULL;
    for (const json_value *item = json_get_first(document, object); item;
         item = json_get_next(document, item))
        if (strcmp(item->key, key) == 0) return item;
    return NULL;
}

tulle_status json_fail(const json_document *document, const json_value *place, tulle_error *error,
                       const char *format, ...) {
    char message[sizeof((tulle_error *)0)->message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return error_set_at(error, TULLE_ERROR_PARSE, document->path, place->line, place->column, "%s",
                        message);
}

tulle_status json_take_member(const json_document *document, const json_value *object,
                              const char *key, json_type type, const json_value **member,
                              tulle_error *error) {
    static const char *const names[] = {"null",   "true or false", "a number",
                                        "a text", "an array",      "an object"};
    *member = json_find(document, object, key);
    if (!*member) return json_fail(document, object, error, "key \"%s\" is missing", key);
    if ((*member)->type != type)
        return json_fail(document, *member, error, "\"%s\" should be %s", key, names[type]);
    return TULLE_OK;
}

tulle_status json_take_string(const json_document *document, const json_value *object,
                              const char *key, const char **text, tulle_error *error) {
    const json_value *member = NULL;
    tulle_status const status =
        json_take_member(document, object, key, JSON_STRING, &member, error);
    if (!status) *text = member->string;
    return status;
}

tulle_status json_take_double(const json_document *document, const json_value *object,
                              const char *key, double *value, tulle_error *error) {
    const json_value *member = NULL;
    tulle_status const status =
        json_take_member(document, object, key, JSON_NUMBER, &member, error);
    if (!status) *value = member->number;
    return status;
}

static tulle_status take_whole_to(const json_document *document, const json_value *object,
                                  const char *key, uint64_t most, uint64_t *value,
                                  tulle_error *error) {
    const json_value *member = NULL;
    tulle_status const status =
        json_take_member(document, object, key, JSON_NUMBER, &member, error);
    if (status) return status;
    double const number = member->number;
    if (!(number >= 0.0 && number <= (double)most && number == floor(number)))
        return json_fail(document, member, error, "\"%s\" should be a whole number from 0 to %llu",
                         key, (unsigned long long)most);
    *value = (uint64_t)number;
    return TULLE_OK;
}

tulle_status json_take_whole(const json_document *document, const json_value *object,
                             const char *key, uint32_t *value, tulle_error *error) {
    uint64_t whole = *value;
    tulle_status const status = take_whole_to(document, object, key, UINT32_MAX, &whole, error);
    *value = (uint32_t)whole;
    return status;
}

tulle_status json_take_count(const json_document *document, const json_value *object,
                             const char *key, uint64_t *value, tulle_error *error) {
    return take_whole_to(document, object, key, (UINT64_C(1) << 53) - 1, value, error);
}

tulle_status json_take_bool(const json_document *document, const json_value *object,
                            const char *key, int *value, tulle_error *error) {
    const json_value *member = NULL;
    tulle_status const status = json_take_member(document, object, key, JSON_BOOL, &member, error);
    if (!status) *value = member->number > 0.5;
    return status;
}

bool json_parse_hash(const char *text, size_t length, uint64_t *value) {
    if (length < 1 || length > 16) return false;
    uint64_t sum = 0;
    for (size_t i = 0; i < length; i++) {
        char const c = text[i];
        char const letter = (char)(c | 0x20);
        if (c >= '0' && c <= '9')
            sum = sum << 4 | (uint64_t)(c - '0');
        else if (letter >= 'a' && letter <= 'f')
            sum = sum << 4 | (uint64_t)(letter - 'a' + 10);
        else
            return false;
    }
    *value = sum;
    return true;
}

tulle_status json_take_hash(const json_document *document, const json_value *object,
                            const char *key, uint64_t *value, tulle_error *error) {
    const json_value *member = NULL;
    tulle_status const status =
        json_take_member(document, object, key, JSON_STRING, &member, error);
    if (status) return status;
    if (!json_parse_hash(member->string, strlen(member->string), value))
        return json_fail(document, member, error, "\"%s\" should be hexadecimal digits", key);
    return TULLE_OK;
}

tulle_status json_take_fields(const json_document *document, const json_value *object,
                              const json_field *fields, size_t count, void *target,
                              tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < count && !status; i++) {
        const char *const key = fields[i].key;
        void *const at = (char *)target + fields[i].offset;
        switch (fields[i].kind) {
        case JSON_DOUBLE: status = json_take_double(document, object, key, at, error); break;
        case JSON_COUNT: status = json_take_count(document, object, key, at, error); break;
        case JSON_WHOLE: status = json_take_whole(document, object, key, at, error); break;
        case JSON_FLAG: status = json_take_bool(document, object, key, at, error); break;
        case JSON_HASH: status = json_take_hash(document, object, key, at, error); break;
        }
    }
    return status;
}
