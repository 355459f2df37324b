/* Numbered files: which names are patterns, what they name, which files of a folder they find, and
 * that no text of the user becomes a format. */
#define _DEFAULT_SOURCE /* mkdtemp */
#include "app/cli/numbered_files.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[] = "/tmp/tulle-numbered-XXXXXX";

static void patterns_are_read(void **unused) {
    (void)unused;
    static const struct {
        const char *text;
        uint32_t number;
        const char *path; /* null: a * */
    } cases[] = {{"a_%04d.obj", 7, "a_0007.obj"},
                 {"a_%04d.obj", 12345, "a_12345.obj"},
                 {"a%d.obj", 0, "a0.obj"},
                 {"%d", 42, "42"},
                 {"x/y%s/%01d.ply", 3, "x/y%s/3.ply"},
                 {"%09d.vtp", 1, "000000001.vtp"},
                 {"a_*.obj", 0, NULL},
                 {"/%n/*", 0, NULL}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        name_pattern pattern;
        tulle_error error = {0};
        assert_true(name_pattern_is_meant(cases[i].text));
        if (name_pattern_read(cases[i].text, &pattern, &error) != TULLE_OK)
            fail_msg("%s", error.message);
        assert_int_equal(pattern.is_any, cases[i].path == NULL);
        char path[NUMBERED_PATH_SIZE];
        if (!cases[i].path) continue;
        assert_true(name_pattern_format(&pattern, cases[i].number, path));
        assert_string_equal(path, cases[i].path);
    }
    assert_false(name_pattern_is_meant("a.obj"));
    assert_false(name_pattern_is_meant("100%/a*b/c.obj"));
}

static void other_patterns_are_refused(void **unused) {
    (void)unused;
    static const char *const texts[] = {"a_%s.obj",
                                        "a_%n.obj",
                                        "a_%.obj",
                                        "a_%04.obj",
                                        "a_%4d.obj",
                                        "a_%-4d.obj",
                                        "a_%00d.obj",
                                        "a_%0d.obj",
                                        "a_%010d.obj",
                                        "a_%ld.obj",
                                        "a_%d%d.obj",
                                        "a_%d_%04d.obj",
                                        "a_%%d.obj",
                                        "a_%x.obj",
                                        "a_%d%.obj",
                                        "a_*_*.obj",
                                        "a_*%d.obj",
                                        "a_%d*.obj",
                                        "%",
                                        "a_%1$d",
                                        "a_%.3d.obj",
                                        "a_%+d.obj",
                                        "a_%99999999999d.obj"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        name_pattern pattern;
        tulle_error error = {0};
        assert_true(name_pattern_is_meant(texts[i]));
        if (name_pattern_read(texts[i], &pattern, &error) != TULLE_ERROR_INVALID_ARGUMENT)
            fail_msg("%s is taken for a pattern", texts[i]);
        assert_non_null(strstr(error.message, texts[i]));
    }
    char *const path = calloc(1, NUMBERED_PATH_SIZE + 8);
    memset(path, 'a', NUMBERED_PATH_SIZE - 2);
    memcpy(path + NUMBERED_PATH_SIZE - 2, "%03d", 5);
    name_pattern pattern;
    char written[NUMBERED_PATH_SIZE];
    assert_int_equal(name_pattern_read(path, &pattern, NULL), TULLE_OK);
    assert_false(name_pattern_format(&pattern, 1, written));
    free(path);
}

static void touch(const char *name) {
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *const stream = fopen(path, "w");
    assert_non_null(stream);
    fclose(stream);
}

static tulle_status find(const char *name, numbered_files *found, tulle_error *error) {
    static char text[256];
    snprintf(text, sizeof text, "%s/%s", folder, name);
    name_pattern pattern;
    assert_int_equal(name_pattern_read(text, &pattern, error), TULLE_OK);
    return numbered_files_find(&pattern, found, error);
}

/* numbers ends with -1. */
static void expect_found(const char *name, const long *numbers, frame_range range, long gap) {
    numbered_files found;
    tulle_error error = {0};
    if (find(name, &found, &error) != TULLE_OK) fail_msg("%s: %s", name, error.message);
    size_t count = 0;
    for (; numbers[count] >= 0; count++) {
        assert_true(count < found.count);
        assert_int_equal(found.files[count].number, numbers[count]);
    }
    assert_int_equal(found.count, count);
    assert_int_equal(found.range.first, range.first);
    assert_int_equal(found.range.last, range.last);
    assert_int_equal(found.range.step, range.step);
    assert_int_equal(found.has_gaps, gap >= 0);
    if (gap >= 0) assert_int_equal(found.gap, gap);
    numbered_files_destroy(&found);
}

static void files_are_found(void **unused) {
    (void)unused;
    static const char *const names[] = {
        "a_0010.obj", "a_0000.obj", "a_0005.obj", "a_12345.obj", "a_00007.obj",    "a_7.obj",
        "a_0005.ply", "a_.obj",     "a_x.obj",    "ba_0001.obj", "a_0001.obj~",    "b1.obj",
        "b2.obj",     "b4.obj",     "b04.obj",    "c9.obj",      "d0000000001.obj"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) touch(names[i]);
    expect_found("a_%04d.obj", (long[]){0, 5, 10, 12345, -1}, (frame_range){0, 12345, 5}, 15);
    expect_found("a_%d.obj", (long[]){7, 12345, -1}, (frame_range){7, 12345, 12338}, -1);
    expect_found("a_%04d.ply", (long[]){5, -1}, (frame_range){5, 5, 1}, -1);
    expect_found("b%d.obj", (long[]){1, 2, 4, -1}, (frame_range){1, 4, 1}, 3);
    expect_found("b%02d.obj", (long[]){4, -1}, (frame_range){4, 4, 1}, -1);
    expect_found("c*.obj", (long[]){9, -1}, (frame_range){9, 9, 1}, -1);
    numbered_files found;
    tulle_error error = {0};
    assert_int_equal(find("b*.obj", &found, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "same number"));
    assert_int_equal(find("d*.obj", &found, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "no file"));
    assert_int_equal(find("none/a%d.obj", &found, &error), TULLE_ERROR_IO);
}

static void paths_are_looked_up(void **unused) {
    (void)unused;
    numbered_files found;
    tulle_error error = {0};
    assert_int_equal(find("a_%04d.obj", &found, &error), TULLE_OK);
    char path[NUMBERED_PATH_SIZE], expected[256];
    snprintf(expected, sizeof expected, "%s/a_0010.obj", folder);
    assert_true(numbered_files_get_path(&found, 10, path));
    assert_string_equal(path, expected);
    assert_false(numbered_files_get_path(&found, 11, path));
    assert_false(numbered_files_get_path(&found, 99999, path));
    numbered_files_destroy(&found);
}

static int set_up(void **unused) {
    (void)unused;
    return mkdtemp(folder) ? 0 : -1;
}

static int tear_down(void **unused) {
    (void)unused;
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patterns_are_read),
        cmocka_unit_test(other_patterns_are_refused),
        cmocka_unit_test(files_are_found),
        cmocka_unit_test(paths_are_looked_up),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
