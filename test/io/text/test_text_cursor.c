/* Words and lines of a text, and where the cursor is in it. */
#include "io/text/text_cursor.h"

#include <limits.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static void lines_end_in_each_way(void **state) {
    (void)state;
    static const char text[] = "one\ntwo\r\nthree\rfour\n\nsix";
    static const char *const words[] = {"one", "two", "three", "four", "", "six"};
    text_cursor cursor = text_cursor_make("path", text, strlen(text));
    for (int i = 0; i < 6; i++) {
        assert_int_equal(cursor.line, i + 1);
        text_word const word = text_take_word(&cursor);
        assert_true(word.length == 0 ? words[i][0] == '\0' : text_word_is(word, words[i]));
        assert_int_equal(text_take_word(&cursor).length, 0);
        assert_true(text_next_line(&cursor) == (i < 5));
    }
}

/* The number stays where there are more lines than it can count. */
static void lines_beyond_the_largest_number_have_that(void **state) {
    (void)state;
    static const char text[] = "a\nb\nc\n";
    text_cursor cursor = text_cursor_make("path", text, strlen(text));
    cursor.line = INT_MAX - 1;
    for (int i = 0; i < 2; i++) {
        assert_true(text_next_line(&cursor));
        assert_int_equal(cursor.line, INT_MAX);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_end_in_each_way),
        cmocka_unit_test(lines_beyond_the_largest_number_have_that),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
