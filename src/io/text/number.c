/* io/text/number.c - see number.h. The digits are collected without their point and handed to
 * strtod as an integer with an exponent, a form that no locale changes.
 *
 * Based on: W. Clinger, How to read floating point numbers accurately, 1990 (the exact fast path).
 */
#include "io/text/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    DIGIT_MAX = 800, /* a double's value never depends on more than 768 significant digits, beyond
                        whether any later one is not zero */
    EXACT_DIGIT_MAX = 15,   /* integers of so many digits are exact doubles */
    EXACT_EXPONENT_MAX = 22 /* 10^22 is the largest power of ten that is an exact double */
};

/* A decimal number taken apart: (-1)^is_negative * digits * 10^exponent. */
typedef struct decimal {
    char digits[DIGIT_MAX + 1]; /* significant ones, without leading zeros */
    int digit_count;
    int is_negative;
    long long exponent;
} decimal;

static int is_digit(char c) { return c >= '0' && c <= '9'; }

/* Adds one digit, before the point or after it. */
static void add_digit(decimal *number, char digit, int is_fraction) {
    if (number->digit_count == 0 && digit == '0') {
        number->exponent -= is_fraction;
    } else if (number->digit_count < DIGIT_MAX) {
        number->digits[number->digit_count++] = digit;
        number->exponent -= is_fraction;
    } else {
        /* Too many to keep: a later nonzero digit only has to lift the value off a tie. */
        if (digit != '0') number->digits[DIGIT_MAX - 1] = '1';
        number->exponent += !is_fraction;
    }
}

/* Reads the exponent's digits; returns the place after them, or null. */
static const char *read_exponent(const char *cursor, const char *end, decimal *number) {
    long long const limit = 1000000000000000;
    int const is_negative = cursor < end && *cursor == '-';
    if (cursor < end && (*cursor == '-' || *cursor == '+')) cursor++;
    if (cursor == end || !is_digit(*cursor)) return NULL;
    long long exponent = 0;
    for (; cursor < end && is_digit(*cursor); cursor++)
        if (exponent < limit) exponent = exponent * 10 + (*cursor - '0');
    number->exponent += is_negative ? -exponent : exponent;
    return cursor;
}

static int take_apart(const char *cursor, const char *end, decimal *number) {
    number->digit_count = 0;
    number->exponent = 0;
    number->is_negative = cursor < end && *cursor == '-';
    if (cursor < end && (*cursor == '-' || *cursor == '+')) cursor++;
    int has_digits = 0;
    int is_fraction = 0;
    for (; cursor < end; cursor++) {
        if (*cursor == '.' && !is_fraction) {
            is_fraction = 1;
        } else if (is_digit(*cursor)) {
            add_digit(number, *cursor, is_fraction);
            has_digits = 1;
        } else {
            break;
        }
    }
    if (!has_digits) return 0;
    if (cursor < end && (*cursor == 'e' || *cursor == 'E'))
        cursor = read_exponent(cursor + 1, end, number);
    return cursor == end;
}

/* Exact product or quotient of two exact doubles, rounded once. */
static int convert_exactly(const decimal *number, double *value) {
    static const double powers[EXACT_EXPONENT_MAX + 1] = {
        1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
        1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    if (number->digit_count > EXACT_DIGIT_MAX || number->exponent > EXACT_EXPONENT_MAX ||
        number->exponent < -EXACT_EXPONENT_MAX)
        return 0;
    int64_t integer = 0;
    for (int i = 0; i < number->digit_count; i++)
        integer = integer * 10 + (number->digits[i] - '0');
    *value = number->exponent >= 0 ? (double)integer * powers[number->exponent]
                                   : (double)integer / powers[-number->exponent];
    return 1;
}

static double convert(const decimal *number) {
    double value = 0.0;
    if (convert_exactly(number, &value)) return value;
    char text[DIGIT_MAX + 24];
    snprintf(text, sizeof text, "%.*se%lld", number->digit_count, number->digits, number->exponent);
    return strtod(text, NULL);
}

number_outcome number_parse_double(const char *text, size_t length, double *value) {
    decimal number;
    if (!take_apart(text, text + length, &number)) return NUMBER_MALFORMED;
    double const magnitude = number.digit_count == 0 ? 0.0 : convert(&number);
    if (isinf(magnitude)) return NUMBER_OUT_OF_RANGE;
    *value = number.is_negative ? -magnitude : magnitude;
    return NUMBER_READ;
}

number_outcome number_parse_integer(const char *text, size_t length, int64_t *value) {
    const char *cursor = text;
    const char *const end = text + length;
    int const is_negative = cursor < end && *cursor == '-';
    if (cursor < end && (*cursor == '-' || *cursor == '+')) cursor++;
    if (cursor == end) return NUMBER_MALFORMED;
    int64_t sum = 0; /* kept negative: its range is the larger one */
    int is_too_large = 0;
    for (; cursor < end; cursor++) {
        if (!is_digit(*cursor)) return NUMBER_MALFORMED;
        int const digit = *cursor - '0';
        if (sum < (INT64_MIN + digit) / 10)
            is_too_large = 1;
        else
            sum = sum * 10 - digit;
    }
    if (is_too_large || (!is_negative && sum == INT64_MIN)) return NUMBER_OUT_OF_RANGE;
    *value = is_negative ? sum : -sum;
    return NUMBER_READ;
}

/* Replaces the locale's decimal mark, one or several bytes, by a point. */
static size_t restore_point(char *text, size_t length) {
    size_t const begin = strspn(text, "+-0123456789e");
    if (begin == length) return length;
    size_t end = begin;
    while (end < length && !strchr("+-0123456789e", text[end])) end++;
    text[begin] = '.';
    memmove(text + begin + 1, text + end, length - end + 1);
    return length - (end - begin) + 1;
}

/* With the fewest digits, from `least` on, that give `value` again; as a float or as a double. */
static size_t format(double value, int least, int is_float, char text[NUMBER_TEXT_SIZE]) {
    if (!isfinite(value)) {
        const char *const word = isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
        memcpy(text, word, strlen(word) + 1);
        return strlen(word);
    }
    size_t length = 0;
    for (int digits = least; digits <= (is_float ? 9 : 17); digits++) {
        length = (size_t)snprintf(text, NUMBER_TEXT_SIZE, "%.*g", digits, value);
        length = restore_point(text, length);
        double again = 0.0;
        if (number_parse_double(text, length, &again) != NUMBER_READ) continue;
        if (again == value || (is_float && (float)again == (float)value)) break;
    }
    return length;
}

size_t number_format_double(double value, char text[NUMBER_TEXT_SIZE]) {
    return format(value, 15, 0, text);
}

size_t number_format_float(float value, char text[NUMBER_TEXT_SIZE]) {
    return format((double)value, 6, 1, text);
}
