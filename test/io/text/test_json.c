/* The JSON reader and writer: what goes out comes back, what is not JSON is refused by place, and
 * no damaged text crashes. */
#define _XOPEN_SOURCE 700
#include "base/hash.h"
#include "io/text/json_read.h"
#include "io/text/json_write.h"

#include "io/io_support.h"

#include <math.h>

static memory heap;

static tulle_status read_text(const char *text, json_document *document, tulle_error *error) {
    return json_read(&heap, "a.json", text, strlen(text), document, error);
}

static void written_values_come_back(void **state) {
    (void)state;
    const char *const path = test_path("out.json");
    const char *const text = "quote \" back \\ line\n tab\t bell\a end \xc3\xa9\x7f";
    output_file *output = NULL;
    assert_int_equal(output_open(path, &output, NULL), TULLE_OK);
    json_writer writer = json_writer_make(output);
    json_begin(&writer, NULL, '{');
    json_put_string(&writer, "text", text);
    json_put_string(&writer, "none", NULL);
    json_put_double(&writer, "third", 1.0 / 3.0);
    json_put_double(&writer, "lost", NAN);
    json_put_bool(&writer, "yes", true);
    json_put_hash(&writer, "hash", UINT64_C(0xfedcba9876543210));
    json_begin(&writer, "empty", '[');
    json_end(&writer, ']');
    json_begin(&writer, "list", '[');
    json_put_unsigned(&writer, NULL, 4000000000u);
    json_begin(&writer, NULL, '{');
    json_end(&writer, '}');
    json_end(&writer, ']');
    json_end(&writer, '}');
    assert_int_equal(output_commit(output, NULL), TULLE_OK);
    size_t size;
    char *const bytes = get_file(path, &size);
    json_document document;
    tulle_error error;
    assert_int_equal(json_read(&heap, path, bytes, size, &document, &error), TULLE_OK);
    free(bytes);
    const json_value *const root = json_get_root(&document);
    const char *string = NULL;
    assert_int_equal(json_take_string(&document, root, "text", &string, NULL), TULLE_OK);
    assert_string_equal(string, text);
    assert_int_equal(json_find(&document, root, "none")->type, JSON_NULL);
    assert_int_equal(json_find(&document, root, "lost")->type, JSON_NULL);
    double number = 0.0;
    assert_int_equal(json_take_double(&document, root, "third", &number, NULL), TULLE_OK);
    assert_true(number == 1.0 / 3.0);
    int yes = 0;
    assert_int_equal(json_take_bool(&document, root, "yes", &yes, NULL), TULLE_OK);
    assert_int_equal(yes, 1);
    uint64_t hash = 0;
    assert_int_equal(json_take_hash(&document, root, "hash", &hash, NULL), TULLE_OK);
    assert_true(hash == UINT64_C(0xfedcba9876543210));
    assert_int_equal(json_find(&document, root, "empty")->count, 0);
    const json_value *const list = json_find(&document, root, "list");
    assert_int_equal(list->count, 2);
    const json_value *const first = json_get_first(&document, list);
    assert_true(first->number == 4000000000.0);
    assert_int_equal(json_get_next(&document, first)->type, JSON_OBJECT);
    assert_null(json_get_next(&document, json_get_next(&document, first)));
    json_destroy(&document);
    assert_int_equal(heap.bytes_held, 0);
}

static void characters_by_number(void **state) {
    (void)state;
    json_document document;
    assert_int_equal(read_text("\"\\u0041\\u00e9\\u20AC\\ud83d\\ude00\\/\\b\"", &document, NULL),
                     TULLE_OK);
    assert_string_equal(json_get_root(&document)->string,
                        "A\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80/\b");
    json_destroy(&document);
}

typedef struct bad_text {
    const char *text;
    int line, column;
} bad_text;

static void what_is_no_json_is_refused_by_place(void **state) {
    (void)state;
    static const bad_text texts[] = {{"", 1, 1},
                                     {"{", 1, 2},
                                     {"[1,]", 1, 4},
                                     {"[1 2]", 1, 4},
                                     {"{\"a\" 1}", 1, 6},
                                     {"{a: 1}", 1, 2},
                                     {"[01]", 1, 2},
                                     {"[1.]", 1, 2},
                                     {"[.5]", 1, 2},
                                     {"[+1]", 1, 2},
                                     {"[1e]", 1, 2},
                                     {"[nan]", 1, 2},
                                     {"[1e999]", 1, 2},
                                     {"[tru]", 1, 2},
                                     {"\"a", 1, 3},
                                     {"\"a\n\"", 1, 3},
                                     {"\"\\x\"", 1, 3},
                                     {"\"\\u12\"", 1, 4},
                                     {"\"\\u0000\"", 1, 8},
                                     {"\"\\ud800\"", 1, 8},
                                     {"[\n1,\n\n x]", 4, 2},
                                     {"[1] 2", 1, 5},
                                     {"{\"a\":1,\"a\":2}", 1, 11},
                                     {"[1}", 1, 3},
                                     {"'a'", 1, 1},
                                     {"[1,,2]", 1, 4},
                                     {"\xff", 1, 1},
                                     {"// c\n1", 1, 1}};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        json_document document;
        tulle_error error = {0};
        if (read_text(texts[i].text, &document, &error) != TULLE_ERROR_PARSE ||
            error.line != texts[i].line || error.column != texts[i].column)
            fail_msg("\"%s\": status %d at %d:%d: %s", texts[i].text, error.status, error.line,
                     error.column, error.message);
        assert_int_equal(heap.bytes_held, 0);
    }
}

static void depth_and_members_are_limited(void **state) {
    (void)state;
    static char text[100000];
    json_document document;
    tulle_error error;
    memset(text, '[', 50000);
    assert_int_equal(read_text(text, &document, &error), TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "deep"));
    size_t length = (size_t)sprintf(text, "{");
    for (int i = 0; i < 300; i++)
        length += (size_t)sprintf(text + length, "%s\"k%d\":0", i ? "," : "", i);
    sprintf(text + length, "}");
    assert_int_equal(read_text(text, &document, &error), TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "members"));
    assert_int_equal(heap.bytes_held, 0);
}

static void members_must_be_of_their_type(void **state) {
    (void)state;
    json_document document;
    tulle_error error;
    assert_int_equal(read_text("{\n \"a\": 1.5, \"b\": \"xyz\", \"c\": -1}", &document, NULL),
                     TULLE_OK);
    const json_value *const root = json_get_root(&document);
    uint32_t whole;
    uint64_t hash;
    const char *string;
    assert_int_equal(json_take_whole(&document, root, "a", &whole, &error), TULLE_ERROR_PARSE);
    assert_int_equal(error.line, 2);
    assert_int_equal(json_take_whole(&document, root, "c", &whole, &error), TULLE_ERROR_PARSE);
    assert_int_equal(json_take_hash(&document, root, "b", &hash, &error), TULLE_ERROR_PARSE);
    assert_int_equal(json_take_string(&document, root, "a", &string, &error), TULLE_ERROR_PARSE);
    assert_int_equal(json_take_string(&document, root, "d", &string, &error), TULLE_ERROR_PARSE);
    assert_string_equal(error.message, "key \"d\" is missing");
    json_destroy(&document);
}

static void damaged_texts_do_no_harm(void **state) {
    (void)state;
    static const char sound[] =
        "{\"a\": [1, -2.5e3, true, null], \"b\": {\"c\": \"x\\u00e9\\n\"}, \"d\": false}";
    char text[sizeof sound];
    for (size_t length = 0; length < sizeof sound - 1; length++) {
        json_document document;
        assert_int_equal(json_read(&heap, "a", sound, length, &document, NULL), TULLE_ERROR_PARSE);
    }
    for (size_t bit = 0; bit < 8 * (sizeof sound - 1); bit++) {
        memcpy(text, sound, sizeof sound);
        text[bit / 8] ^= (char)(1 << bit % 8);
        json_document document;
        tulle_status const status = json_read(&heap, "a", text, sizeof sound - 1, &document, NULL);
        assert_true(status == TULLE_OK || status == TULLE_ERROR_PARSE);
        if (!status) json_destroy(&document);
    }
    uint64_t seed = 1;
    static const char letters[] = "{}[]\",:0123456789.eE+-truefalsn\\u \n";
    for (int round = 0; round < 20000; round++) {
        char random[64];
        size_t const length = (size_t)(random_uniform(&seed) * sizeof random);
        for (size_t i = 0; i < length; i++)
            random[i] = letters[random_next(&seed) % (sizeof letters - 1)];
        json_document document;
        if (!json_read(&heap, "a", random, length, &document, NULL)) json_destroy(&document);
    }
    assert_int_equal(heap.bytes_held, 0);
}

int main(void) {
    heap = memory_default();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(written_values_come_back),
        cmocka_unit_test(characters_by_number),
        cmocka_unit_test(what_is_no_json_is_refused_by_place),
        cmocka_unit_test(depth_and_members_are_limited),
        cmocka_unit_test(members_must_be_of_their_type),
        cmocka_unit_test(damaged_texts_do_no_harm),
    };
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
