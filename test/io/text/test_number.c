/* Decimal text to double and back: against the C library, and in a locale with a decimal comma. */
#define _XOPEN_SOURCE 700
#include "base/hash.h"
#include "io/text/number.h"
#include "support/comma_locale.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static double parse(const char *text) {
    double value = -12345.0;
    assert_int_equal(number_parse_double(text, strlen(text), &value), NUMBER_READ);
    return value;
}

static void assert_same_bits(double a, double b, const char *text) {
    if (memcmp(&a, &b, sizeof a) != 0) fail_msg("\"%s\": %a is not %a", text, a, b);
}

static void agrees_with_strtod(void **state) {
    (void)state;
    uint64_t seed = 7;
    for (int i = 0; i < 100000; i++) {
        char text[128];
        int length = 0;
        if (random_uniform(&seed) < 0.5) text[length++] = '-';
        int const digits = 1 + (int)(random_uniform(&seed) * 40);
        int const point = (int)(random_uniform(&seed) * 60) - 10;
        for (int d = 0; d < digits; d++) {
            if (d == point) text[length++] = '.';
            text[length++] = (char)('0' + (int)(random_uniform(&seed) * 10));
        }
        if (random_uniform(&seed) < 0.7)
            snprintf(text + length, 16, "e%d", (int)(random_uniform(&seed) * 700) - 380);
        else
            text[length] = '\0';
        double const expected = strtod(text, NULL);
        double value = 0.0;
        number_outcome const outcome = number_parse_double(text, strlen(text), &value);
        if (isinf(expected)) {
            assert_int_equal(outcome, NUMBER_OUT_OF_RANGE);
        } else {
            assert_int_equal(outcome, NUMBER_READ);
            assert_same_bits(value, expected, text);
        }
    }
}

/* Halfway between two doubles, decided by the last of very many digits. */
static void very_long_numbers_are_rounded_correctly(void **state) {
    (void)state;
    static char text[5000];
    const char *const tie =
        "1.00000000000000011102230246251565404236316680908203125"; /* 1 + 2^-53 */
    double const above = nextafter(1.0, 2.0);
    assert_same_bits(parse(tie), 1.0, tie);
    memset(text, '0', sizeof text);
    memcpy(text, tie, strlen(tie));
    text[sizeof text - 2] = '1';
    text[sizeof text - 1] = '\0';
    assert_same_bits(parse(text), above, "a tie and 1e-4998");
    text[sizeof text - 2] = '0';
    assert_same_bits(parse(text), 1.0, "a tie with zeros");
}

static void long_zeros_and_exponents_cancel(void **state) {
    (void)state;
    size_t const zeros = 100000;
    char *const text = malloc(zeros + 40);
    assert_non_null(text);
    memcpy(text, "0.", 2);
    memset(text + 2, '0', zeros);
    strcpy(text + 2 + zeros, "25e100000");
    assert_same_bits(parse(text), 0.25, "0.000...25e100000");
    text[0] = '4';
    memset(text + 1, '0', zeros);
    strcpy(text + 1 + zeros, "e-100000");
    assert_same_bits(parse(text), 4.0, "4000...e-100000");
    free(text);
}

static void limits_of_double(void **state) {
    (void)state;
    assert_same_bits(parse("1.7976931348623157e308"), 1.7976931348623157e308, "largest");
    assert_same_bits(parse("4.9406564584124654e-324"), 4.9406564584124654e-324, "smallest");
    assert_same_bits(parse("1e-400"), 0.0, "underflow");
    assert_same_bits(parse("-0"), -0.0, "minus zero");
    assert_same_bits(parse("-1e-99999999999999999999999"), -0.0, "deep underflow");
    double value = 1.0;
    assert_int_equal(number_parse_double("1.8e308", 7, &value), NUMBER_OUT_OF_RANGE);
    assert_int_equal(number_parse_double("1e99999999999999999999999", 25, &value),
                     NUMBER_OUT_OF_RANGE);
    assert_same_bits(parse("0e99999999999999999999999"), 0.0, "zero with an exponent");
}

static void malformed_numbers_are_refused(void **state) {
    (void)state;
    const char *const texts[] = {"",    "+",   "-",    ".",     "e5",   "1e",  "1e+",  "1.2.3",
                                 "1,5", "nan", "inf",  "-inf",  "0x10", "1f",  " 1",   "1 ",
                                 "--1", "1-",  "1e5.", "1_000", "NaN",  "1d5", "\xff", "Infinity"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        double value = 0.0;
        if (number_parse_double(texts[i], strlen(texts[i]), &value) != NUMBER_MALFORMED)
            fail_msg("\"%s\" was read as a number", texts[i]);
    }
}

static void integers(void **state) {
    (void)state;
    int64_t value = 0;
    assert_int_equal(number_parse_integer("-9223372036854775808", 20, &value), NUMBER_READ);
    assert_true(value == INT64_MIN);
    assert_int_equal(number_parse_integer("9223372036854775807", 19, &value), NUMBER_READ);
    assert_true(value == INT64_MAX);
    assert_int_equal(number_parse_integer("+42", 3, &value), NUMBER_READ);
    assert_int_equal(value, 42);
    assert_int_equal(number_parse_integer("9223372036854775808", 19, &value), NUMBER_OUT_OF_RANGE);
    assert_int_equal(number_parse_integer("-9223372036854775809", 20, &value), NUMBER_OUT_OF_RANGE);
    assert_int_equal(number_parse_integer("99999999999999999999999", 23, &value),
                     NUMBER_OUT_OF_RANGE);
    const char *const texts[] = {"", "-", "1.0", "1e3", "0x1", "1 ", "12a"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
        assert_int_equal(number_parse_integer(texts[i], strlen(texts[i]), &value),
                         NUMBER_MALFORMED);
}

static void every_double_survives_the_text(void **state) {
    (void)state;
    uint64_t seed = 11;
    for (int i = 0; i < 100000; i++) {
        uint64_t const bits = random_next(&seed);
        double value;
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value)) continue;
        char text[NUMBER_TEXT_SIZE];
        size_t const length = number_format_double(value, text);
        assert_int_equal(length, strlen(text));
        assert_same_bits(parse(text), value, text);
    }
    char text[NUMBER_TEXT_SIZE];
    number_format_double(0.1, text);
    assert_string_equal(text, "0.1");
    number_format_double(-0.0, text);
    assert_string_equal(text, "-0");
    number_format_double(-INFINITY, text);
    assert_string_equal(text, "-inf");
}

/* The same in any locale with a decimal comma that this machine has. */
static void a_decimal_comma_changes_nothing(void **state) {
    (void)state;
    use_decimal_comma();
    char text[NUMBER_TEXT_SIZE];
    number_format_double(1.5, text);
    assert_string_equal(text, "1.5");
    every_double_survives_the_text(state);
    assert_same_bits(parse("0.12345678901234567890"), 0x1.f9add3746f65fp-4, "20 digits");
    use_decimal_point();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_strtod),
        cmocka_unit_test(very_long_numbers_are_rounded_correctly),
        cmocka_unit_test(long_zeros_and_exponents_cancel),
        cmocka_unit_test(limits_of_double),
        cmocka_unit_test(malformed_numbers_are_refused),
        cmocka_unit_test(integers),
        cmocka_unit_test(every_double_survives_the_text),
        cmocka_unit_test(a_decimal_comma_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
