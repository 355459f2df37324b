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

/* Begins the test of a function; its line in the table. */
#define ARGUMENTS_OF(name) static void arguments_of_##name(void **unused)
#define TABLE_LINE(name)                                                                           \
    { #name, arguments_of_##name, NULL, NULL, NULL }

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

/* Fails for a function that a header declares and the table lacks, and for a line of the table that
 * no header declares. Headers are paths below the sources' include/. */
static inline void expect_complete(const char *const *headers, size_t header_count,
                                   const struct CMUnitTest *table, size_t table_count) {
    const char *const source = getenv("TULLE_SOURCE_DIR");
    if (!source) skip(); /* CTest sets it */
    size_t declared_count = 0;
    for (size_t h = 0; h < header_count; h++) {
        char path[1024], line[512];
        snprintf(path, sizeof path, "%s/include/%s", source, headers[h]);
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
            for (size_t i = 0; i < table_count; i++) is_there |= strcmp(table[i].name, name) == 0;
            if (!is_there) fail_msg("%s: %s has no test of its arguments", headers[h], name);
            declared_count++;
        }
        fclose(file);
    }
    assert_int_equal(declared_count, table_count);
}

#endif
