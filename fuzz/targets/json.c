/* fuzz/targets/json.c - the reader of JSON: the table of values agrees with itself, and a document
 * that is written again is read to the same values. */
#include "support/fuzz.h"

#include "io/text/json_quote.h"
#include "io/text/json_read.h"
#include "io/text/json_write.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TEXTS_MAX = 1 << 16 };

static json_document read_document(memory *heap, const char *text, size_t length) {
    json_document document;
    tulle_error error = {0};
    FUZZ_CHECK_OK(json_read(heap, "again.json", text, length, &document, &error), &error);
    return document;
}

static void write_value(json_writer *writer, const json_document *document,
                        const json_value *value) {
    switch (value->type) {
    case JSON_NULL: json_put_string(writer, value->key, NULL); break;
    case JSON_BOOL: json_put_bool(writer, value->key, value->number != 0.0); break;
    case JSON_NUMBER: json_put_double(writer, value->key, value->number); break;
    case JSON_STRING: json_put_string(writer, value->key, value->string); break;
    case JSON_ARRAY:
    case JSON_OBJECT:
        json_begin(writer, value->key, value->type == JSON_ARRAY ? '[' : '{');
        for (const json_value *item = json_get_first(document, value); item;
             item = json_get_next(document, item))
            write_value(writer, document, item);
        json_end(writer, value->type == JSON_ARRAY ? ']' : '}');
    }
}

/* A writer puts U+FFFD for a byte that is no UTF-8. */
static bool is_utf8(const char *text) {
    char piece[JSON_PIECE_SIZE];
    while (json_take_piece(&text, piece) > 0)
        if (strcmp(piece, "\\ufffd") == 0) return false;
    return true;
}

static bool has_only_utf8(const json_document *document) {
    for (size_t i = 0; i < document->values.count; i++) {
        const json_value *const value = &document->values.data[i];
        if (value->key && !is_utf8(value->key)) return false;
        if (value->type == JSON_STRING && !is_utf8(value->string)) return false;
    }
    return true;
}

/* Values are in the order of the text, so both tables run alike. */
static void check_same(const json_document *a, const json_document *b) {
    FUZZ_CHECK(a->values.count == b->values.count);
    for (size_t i = 0; i < a->values.count; i++) {
        const json_value *const x = &a->values.data[i], *const y = &b->values.data[i];
        FUZZ_CHECK(x->type == y->type && x->count == y->count && x->next == y->next);
        FUZZ_CHECK(!x->key == !y->key && (!x->key || strcmp(x->key, y->key) == 0));
        FUZZ_CHECK(x->type != JSON_STRING || strcmp(x->string, y->string) == 0);
        FUZZ_CHECK(x->type != JSON_NUMBER || (isfinite(x->number) && x->number == y->number));
    }
}

/* Every member is found by its key, and counts are right. */
static void check_items(const json_document *document, const json_value *parent) {
    size_t count = 0;
    for (const json_value *item = json_get_first(document, parent); item;
         item = json_get_next(document, item)) {
        FUZZ_CHECK(item->line >= 1 && item->column >= 1);
        FUZZ_CHECK(!item->key == (parent->type == JSON_ARRAY));
        FUZZ_CHECK(!item->key || json_find(document, parent, item->key) == item);
        if (item->type >= JSON_ARRAY) check_items(document, item);
        count++;
    }
    FUZZ_CHECK(count == parent->count);
}

static void take_members(const json_document *document) {
    const json_value *const root = json_get_root(document);
    const json_value *member;
    const char *text;
    double number;
    uint32_t whole;
    int truth;
    uint64_t hash;
    tulle_error error = {0};
    static const char *const keys[] = {"a", "version", ""};
    for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        (void)json_take_member(document, root, keys[i], JSON_OBJECT, &member, &error);
        (void)json_take_string(document, root, keys[i], &text, &error);
        (void)json_take_double(document, root, keys[i], &number, &error);
        (void)json_take_whole(document, root, keys[i], &whole, &error);
        (void)json_take_bool(document, root, keys[i], &truth, &error);
        (void)json_take_hash(document, root, keys[i], &hash, &error);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    memory heap = memory_default();
    json_document document;
    tulle_error error = {0};
    tulle_status const status =
        json_read(&heap, "input.json", (const char *)data, size, &document, &error);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(error.line >= 1 && error.column >= 1);
        return 0;
    }
    const json_value *const root = json_get_root(&document);
    if (root->type >= JSON_ARRAY) check_items(&document, root);
    take_members(&document);
    const char *const path = fuzz_path("again.json");
    output_file *output = NULL;
    FUZZ_CHECK_OK(output_open(path, &output, &error), &error);
    json_writer writer = json_writer_make(output);
    write_value(&writer, &document, root);
    FUZZ_CHECK_OK(output_commit(output, &error), &error);
    static char text[TEXTS_MAX];
    FILE *const file = fopen(path, "rb");
    FUZZ_CHECK(file);
    size_t const length = fread(text, 1, sizeof text, file);
    fclose(file);
    if (length < sizeof text && has_only_utf8(&document)) {
        json_document again = read_document(&heap, text, length);
        check_same(&document, &again);
        json_destroy(&again);
    }
    json_destroy(&document);
    return 0;
}

void fuzz_make_seeds(void) {
    fuzz_put_text_seed("kinds", "{\"a\": [1, -0.5e+3, true, false, null, \"\\u00e9\\n\\ud83d\\ude00"
                                "\"], \"version\": \"0.1.0\", \"\": {\"x\": {}, \"y\": []}}\n");
    fuzz_put_text_seed("deep", "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]");
    fuzz_put_text_seed("numbers", "[0, 1e308, 4.9e-324, -0, 123456789012345678901234567890, 1E-9]");
    fuzz_put_text_seed("hash", "{\"a\": \"0123456789abcdef\", \"version\": 4294967295}");
}
