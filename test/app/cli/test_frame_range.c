/* Frame ranges: every form against the frames that it names, every refusal with its reason. */
#include "app/cli/frame_range.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static const frame_range eleven = {0, 10, 1};  /* frames 0 .. 10 of a run */
static const frame_range tens = {20, 100, 10}; /* files 20, 30, ... 100 */

typedef struct range_case {
    const char *text;
    uint32_t first, last, step;
} range_case;

static void expect_range(const char *frame, const char *frames, frame_range available,
                         const range_case *expected) {
    frame_range range = {0};
    tulle_error error = {0};
    if (frame_range_read(frame, frames, available, &range, &error) != TULLE_OK)
        fail_msg("%s: %s", expected->text, error.message);
    if (range.first != expected->first || range.last != expected->last ||
        range.step != expected->step)
        fail_msg("%s: read as %u:%u:%u", expected->text, range.first, range.last, range.step);
}

static void ranges_are_read(void **unused) {
    (void)unused;
    static const range_case cases[] = {
        {"all", 0, 10, 1},   {"3", 3, 3, 1},        {"0", 0, 0, 1},       {"last", 10, 10, 1},
        {"2:5", 2, 5, 1},    {"2:2", 2, 2, 1},      {"0:10:3", 0, 9, 3},  {"0:10:5", 0, 10, 5},
        {"3:", 3, 10, 1},    {":4", 0, 4, 1},       {":", 0, 10, 1},      {"::4", 0, 8, 4},
        {"7::2", 7, 9, 2},   {":7:100", 0, 0, 100}, {"8:last", 8, 10, 1}, {"007", 7, 7, 1},
        {"last:", 10, 10, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        expect_range(NULL, cases[i].text, eleven, &cases[i]);
    static const range_case spaced[] = {{"all", 20, 100, 10},
                                        {"30", 30, 30, 10},
                                        {":55", 20, 50, 10},
                                        {"40::20", 40, 100, 20},
                                        {"last", 100, 100, 10}};
    for (size_t i = 0; i < sizeof spaced / sizeof spaced[0]; i++)
        expect_range(NULL, spaced[i].text, tens, &spaced[i]);
    expect_range("4", NULL, eleven, &(range_case){"--frame 4", 4, 4, 1});
    expect_range("last", NULL, eleven, &(range_case){"--frame last", 10, 10, 1});
    expect_range(NULL, NULL, tens, &(range_case){"nothing", 20, 100, 10});
    expect_range(NULL, "all", frame_range_make(1), &(range_case){"one", 0, 0, 1});
}

static void expect_refusal(const char *frame, const char *frames, frame_range available,
                           const char *reason) {
    frame_range range = {7, 8, 9};
    tulle_error error = {0};
    tulle_status const status = frame_range_read(frame, frames, available, &range, &error);
    const char *const text = frame ? frame : frames;
    if (status != TULLE_ERROR_INVALID_ARGUMENT) fail_msg("\"%s\" gives status %d", text, status);
    if (!strstr(error.message, reason))
        fail_msg("\"%s\": no \"%s\" in: %s", text, reason, error.message);
    assert_int_equal(range.first, 7);
    assert_int_equal(range.last, 8);
    assert_int_equal(range.step, 9);
}

static void what_is_no_range_is_refused(void **unused) {
    (void)unused;
    static const char *const texts[] = {"",
                                        "x",
                                        "-1",
                                        "1-3",
                                        "1:2:3:4",
                                        "1:2:0",
                                        "1:2:",
                                        "1,2",
                                        "1 2",
                                        "1:x",
                                        "all:",
                                        "+1",
                                        "1.5",
                                        "4294967296",
                                        "1:4294967296",
                                        "1:2:4294967296",
                                        "0x3",
                                        "last2",
                                        "lasting",
                                        "%d",
                                        "99999999999999999999999"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
        expect_refusal(NULL, texts[i], eleven, "should be N, A:B or A:B:STEP");
    expect_refusal("1:2", NULL, eleven, "should be the number of one frame");
    expect_refusal("all", NULL, eleven, "should be the number of one frame");
    expect_refusal("", NULL, eleven, "should be the number of one frame");
    expect_refusal("1", "1:2", eleven, "give one of them");
}

static void frames_that_do_not_exist_are_refused(void **unused) {
    (void)unused;
    expect_refusal(NULL, "11", eleven, "frame 11 does not exist; there are frames 0 to 10");
    expect_refusal("11", NULL, eleven, "--frame 11: frame 11 does not exist");
    expect_refusal(NULL, "0:11", eleven, "frame 11 does not exist");
    expect_refusal(NULL, "4294967295:", eleven, "frame 4294967295 does not exist");
    expect_refusal(NULL, "5:3", eleven, "ends before it begins");
    expect_refusal(NULL, "1", frame_range_make(1), "there is frame 0 alone");
    expect_refusal(NULL, "10:50", tens,
                   "frame 10 does not exist; there are frames 20 to 100, every 10th");
    expect_refusal(NULL, "25", tens, "frame 25 does not exist");
    expect_refusal(NULL, "20:60:15", tens, "a step of 15 meets frames");
}

static void frames_are_counted(void **unused) {
    (void)unused;
    frame_range const range = {3, 9, 2};
    assert_int_equal(frame_range_get_count(range), 4);
    for (uint32_t i = 0; i < 4; i++) assert_int_equal(frame_range_get(range, i), 3 + 2 * i);
    assert_int_equal(frame_range_get_count(frame_range_make(0x7fffffff)), 0x7fffffff);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ranges_are_read),
        cmocka_unit_test(what_is_no_range_is_refused),
        cmocka_unit_test(frames_that_do_not_exist_are_refused),
        cmocka_unit_test(frames_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
