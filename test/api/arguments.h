/* api/arguments.h - tests of what public functions do with null pointers and with numbers that are
 * out of range: one test for each function, under its name. */
#ifndef TULLE_TEST_API_ARGUMENTS_H
#define TULLE_TEST_API_ARGUMENTS_H

#include "support/test_support.h"
#include "tulle/tulle.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The tests in their order, each under the name of a function. */
static struct CMUnitTest argument_tests[64];
static size_t argument_test_count;

/* Begins the test of a function, and adds it to the table before main. */
#define ARGUMENTS_OF(function)                                                                     \
    static void arguments_of_##function(void **);                                                  \
    __attribute__((constructor)) static void add_##function(void) {                                \
        assert_true(argument_test_count < sizeof argument_tests / sizeof argument_tests[0]);       \
        argument_tests[argument_test_count++] =                                                    \
            (struct CMUnitTest){#function, arguments_of_##function, NULL, NULL, NULL};             \
    }                                                                                              \
    static void arguments_of_##function(__attribute__((unused)) void **unused)

/* What the call wrote that is judged. */
static tulle_error error;

/* A call that was given `error` is refused with `expected`, in words. */
static inline void expect_status(tulle_status expected, tulle_status status, const char *call,
                                 int line) {
    if (status != expected)
        fail_msg("line %d: %s: status %d, not %d (%s)", line, call, (int)status, (int)expected,
                 error.message);
    if (error.message[0] == '\0' || error.status != status)
        fail_msg("line %d: %s: no message, or that of another status", line, call);
    error = (tulle_error){0};
}
#define REFUSED(call) expect_status(TULLE_ERROR_INVALID_ARGUMENT, (call), #call, __LINE__)
#define REFUSED_WITH(status, call) expect_status((status), (call), #call, __LINE__)

static inline void expect_fine(tulle_status status, const char *call, int line) {
    if (status != TULLE_OK)
        fail_msg("line %d: %s: status %d (%s)", line, call, (int)status, error.message);
}
#define FINE(call) expect_fine((call), #call, __LINE__)

/* Numbers that no length, time or factor may be. */
static const double no_numbers[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, -DBL_MAX,
                                    DBL_MAX};
enum { NO_NUMBER_COUNT = sizeof no_numbers / sizeof no_numbers[0] };
static const int no_choices[] = {-1, 99, INT_MIN, INT_MAX};
enum { NO_CHOICE_COUNT = sizeof no_choices / sizeof no_choices[0] };
/* Sets an enum to what is none of its values, whatever its type. */
#define SET_CHOICE(choice, value) memcpy(&(choice), &(value), sizeof(int))

/* Paths below the sources' include/ of what the table is of, which null ends. */
static const char *const *tested_headers;

/* Fails for a function that a header declares and the table lacks, and for a test of the table that
 * no header declares. */
static inline void every_function_has_its_test(void **unused) {
    (void)unused;
    const char *const source = getenv("TULLE_SOURCE_DIR");
    if (!source) skip(); /* CTest sets it */
    size_t declared_count = 0;
    for (size_t h = 0; tested_headers[h]; h++) {
        char path[1024], line[512];
        snprintf(path, sizeof path, "%s/include/%s", source, tested_headers[h]);
        FILE *const file = fopen(path, "r");
        assert_non_null(file);
        while (fgets(line, sizeof line, file)) {
            if (strncmp(line, "TULLE_API ", 10) != 0) continue;
            char *const end = strchr(line, '(');
            assert_non_null(end);
            *end = '\0';
            const char *name = strstr(line, "tulle_");
            for (const char *next = name; next; next = strstr(next + 1, "tulle_")) name = next;
            bool is_there = false;
            for (size_t i = 0; i < argument_test_count; i++)
                is_there |= strcmp(argument_tests[i].name, name) == 0;
            if (!is_there) fail_msg("%s: %s has no test of its arguments", tested_headers[h], name);
            declared_count++;
        }
        fclose(file);
    }
    assert_int_equal(declared_count, argument_test_count);
}

/* Runs the table; what main returns. */
static inline int run_arguments(const char *const *headers, CMFixtureFunction set_up,
                                CMFixtureFunction tear_down) {
    const struct CMUnitTest others[] = {cmocka_unit_test(every_function_has_its_test)};
    tested_headers = headers;
    int const failed = _cmocka_run_group_tests("arguments", argument_tests, argument_test_count,
                                               set_up, tear_down);
    return cmocka_run_group_tests(others, NULL, NULL) + failed;
}
#define HEADERS(...) ((const char *const[]){__VA_ARGS__, NULL})

#endif
