/* A line of checksums.csv is read if it is one that a run may write. Others are refused by their
 * number, though their chain is right: whoever made them knew how. */
#define _GNU_SOURCE
#include "io/run/run_checksums_format.h"
#include "io/run_support.h"

/* Reads a file of this line, with its chain; the fields are name, frame, begin, end and hash. */
static tulle_status read_line(const char *fields, tulle_error *error) {
    char text[512];
    memory heap = memory_default();
    const char *const directory = test_path("sums");
    uint64_t const chain = hash_bytes(checksums_get_first_mark().chain, fields, strlen(fields));
    mkdir(directory, 0777);
    snprintf(text, sizeof text, "%s%s%016llx\n", CHECKSUMS_HEADING, fields,
             (unsigned long long)chain);
    put_file(test_path("sums/checksums.csv"), text, strlen(text));
    checksums sums = {0};
    tulle_status const status = checksums_read(&sums, &heap, directory, NULL, error);
    if (status == TULLE_OK) {
        const checksum_line *const line = checksums_find(&sums, "sheet.pc2", 32);
        assert_int_equal(sums.lines.count, 1);
        assert_true(line && line->sum.end == 96 && line->sum.hash == 0xab);
        assert_int_equal(line->frame, strstr(fields, ",,") ? CHECKSUM_NO_FRAME : 7);
    }
    checksums_release(&sums);
    assert_int_equal(heap.bytes_held, 0);
    return status;
}

static void lines_that_no_run_writes_are_refused(void **state) {
    (void)state;
    static const char *const good[] = {"sheet.pc2,7,32,96,ab,", "sheet.pc2,,32,96,ab,"};
    static const char *const bad[] = {",7,32,96,ab,",           "sheet.pc2,x,32,96,ab,",
                                      "sheet.pc2,-1,32,96,ab,", "sheet.pc2,2147483647,32,96,ab,",
                                      "sheet.pc2,7,96,96,ab,",  "sheet.pc2,7,32,,ab,",
                                      "sheet.pc2,7,32,96,,",    "sheet.pc2,7,32,96,xy,",
                                      "sheet.pc2,7,32,96,",     "sheet.pc2,7,32,96,ab,1,",
                                      "../sheet.pc2,,0,9,ab,",  "vtp/../sheet.pc2,,0,9,ab,"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        assert_int_equal(read_line(good[i], NULL), TULLE_OK);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        tulle_error error = {0};
        if (read_line(bad[i], &error) != TULLE_ERROR_PARSE || error.line != 2)
            fail_msg("%s: line %d: %s", bad[i], error.line, error.message);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(lines_that_no_run_writes_are_refused)};
    return cmocka_run_group_tests(tests, make_test_folder, remove_test_folder);
}
