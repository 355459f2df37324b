/* Rows that `tulle reproduce` keeps: found in any order, never under another head, and of a file
 * that was cut anywhere only whole rows. */
#include "app/cli/whole_file.h"
#include "app/reproduce_kept.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const char *const directory = "."; /* where the tests run */
static const char *const file = "test_reproduce_kept.csv";
static const char *const head = "# build 1\nframe,count\n";
enum { ROWS = 300 };

static int remove_file(void **state) {
    (void)state;
    (void)remove(file);
    return 0;
}

static reproduce_kept open_rows(const char *with_head) {
    reproduce const self = {.directory = directory};
    reproduce_kept kept;
    assert_int_equal(reproduce_kept_open(&self, file, with_head, &kept, NULL), TULLE_OK);
    return kept;
}

static void write_rows(void) {
    reproduce_kept kept = open_rows(head);
    for (int i = 0; i < ROWS; i++)
        assert_int_equal(reproduce_kept_add(&kept, NULL, "%d,%d\n", i, 7 * i), TULLE_OK);
    assert_int_equal(reproduce_kept_save(&kept, NULL), TULLE_OK);
    reproduce_kept_close(&kept);
}

/* The row's number, or -1 without it. */
static long find(reproduce_kept *kept, int row) {
    char key[16];
    snprintf(key, sizeof key, "%d,", row);
    const char *const found = reproduce_kept_find(kept, key);
    return found ? strtol(found, NULL, 10) : -1;
}

static void rows_are_found_in_any_order(void **state) {
    (void)state;
    write_rows();
    reproduce_kept kept = open_rows(head);
    for (int i = 0; i < ROWS; i++) assert_int_equal(find(&kept, i), 7 * i);
    for (int i = ROWS - 1; i >= 0; i--) assert_int_equal(find(&kept, i), 7 * i);
    for (int i = 0; i < ROWS; i++) assert_int_equal(find(&kept, i * 91 % ROWS), i * 91 % ROWS * 7);
    assert_int_equal(find(&kept, ROWS), -1);
    assert_int_equal(reproduce_kept_add(&kept, NULL, "%d,5\n", ROWS), TULLE_OK);
    assert_int_equal(find(&kept, ROWS), 5);
    assert_int_equal(find(&kept, 1), 7);
    reproduce_kept_forget(&kept);
    assert_int_equal(find(&kept, 1), -1);
    reproduce_kept_close(&kept);
}

static void rows_under_another_head_are_not_given(void **state) {
    (void)state;
    static const char *const others[] = {"# build 2\nframe,count\n", "# build 1\nframe,number\n",
                                         "# build 1\nframe,count\n0,0,0\n"};
    write_rows();
    for (size_t i = 0; i < 3; i++) {
        reproduce_kept kept = open_rows(others[i]);
        for (int row = 0; row < ROWS; row++) assert_int_equal(find(&kept, row), -1);
        reproduce_kept_close(&kept);
    }
    /* and looking does not change the file */
    reproduce_kept kept = open_rows(head);
    assert_int_equal(find(&kept, ROWS - 1), 7 * (ROWS - 1));
    reproduce_kept_close(&kept);
}

static void write_bytes(const char *bytes, size_t count) {
    FILE *const stream = fopen(file, "wb");
    assert_non_null(stream);
    assert_int_equal(fwrite(bytes, 1, count, stream), count);
    assert_int_equal(fclose(stream), 0);
}

static void of_a_cut_file_only_whole_rows_are_given(void **state) {
    (void)state;
    char *bytes = NULL;
    size_t count = 0;
    write_rows();
    assert_int_equal(whole_file_read(file, &bytes, &count, NULL), TULLE_OK);
    for (size_t cut = 0; cut < count; cut++) {
        write_bytes(bytes, cut);
        reproduce_kept kept = open_rows(head);
        for (int row = 0; row < ROWS; row += 37) {
            long const found = find(&kept, row);
            assert_true(found == -1 || found == 7 * row);
        }
        reproduce_kept_close(&kept);
    }
    bytes[count / 2] = '\0';
    write_bytes(bytes, count);
    reproduce_kept kept = open_rows(head);
    assert_int_equal(find(&kept, 0), -1);
    reproduce_kept_close(&kept);
    free(bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(rows_are_found_in_any_order, remove_file, remove_file),
        cmocka_unit_test_setup_teardown(rows_under_another_head_are_not_given, remove_file,
                                        remove_file),
        cmocka_unit_test_setup_teardown(of_a_cut_file_only_whole_rows_are_given, remove_file,
                                        remove_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
