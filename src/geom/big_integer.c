/* geom/big_integer.c - see big_integer.h. Sign and magnitude, schoolbook arithmetic. */
#include "geom/big_integer.h"

#include <string.h>

/* |value| = mantissa * 2^exponent with an odd mantissa, or mantissa 0. */
typedef struct binary_value {
    uint64_t mantissa;
    int exponent;
    int sign;
} binary_value;

static binary_value split_double(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    int const field = (int)(bits >> 52 & 0x7ff);
    binary_value parts = {.mantissa = bits & ((UINT64_C(1) << 52) - 1),
                          .exponent = (field ? field : 1) - 1075,
                          .sign = bits >> 63 ? -1 : 1};
    if (field) parts.mantissa |= UINT64_C(1) << 52;
    if (parts.mantissa == 0) return (binary_value){0};
    while (!(parts.mantissa & 0xff)) parts.mantissa >>= 8, parts.exponent += 8;
    while (!(parts.mantissa & 1)) parts.mantissa >>= 1, parts.exponent += 1;
    return parts;
}

static void trim(big_integer *a, int sign) {
    while (a->count > 0 && a->limbs[a->count - 1] == 0) a->count--;
    a->sign = a->count > 0 ? sign : 0;
}

/* result = mantissa * 2^shift with sign; shift >= 0. */
static void set_shifted(big_integer *result, binary_value value, int shift) {
    int const skipped = shift / 32, rest = shift % 32;
    uint64_t const low = value.mantissa << rest;
    uint64_t const high = rest ? value.mantissa >> (64 - rest) : 0;
    memset(result->limbs, 0, (size_t)skipped * sizeof *result->limbs);
    result->limbs[skipped] = (uint32_t)low;
    result->limbs[skipped + 1] = (uint32_t)(low >> 32);
    result->limbs[skipped + 2] = (uint32_t)high;
    result->count = skipped + 3;
    trim(result, value.sign);
}

void big_integer_set_differences(big_integer *differences, const double *values, int count) {
    binary_value parts[4];
    int lowest = 0;
    int has_lowest = 0;
    for (int i = 0; i < count; i++) {
        parts[i] = split_double(values[i]);
        if (parts[i].mantissa && (!has_lowest || parts[i].exponent < lowest)) {
            lowest = parts[i].exponent;
            has_lowest = 1;
        }
    }
    big_integer origin, point;
    set_shifted(&origin, parts[0], parts[0].mantissa ? parts[0].exponent - lowest : 0);
    for (int i = 1; i < count; i++) {
        set_shifted(&point, parts[i], parts[i].mantissa ? parts[i].exponent - lowest : 0);
        big_integer_subtract(&differences[i - 1], &point, &origin);
    }
}

/* -1, 0, +1 as |a| is below, equal to or above |b|. */
static int compare_magnitude(const big_integer *a, const big_integer *b) {
    if (a->count != b->count) return a->count < b->count ? -1 : 1;
    for (int i = a->count; i-- > 0;)
        if (a->limbs[i] != b->limbs[i]) return a->limbs[i] < b->limbs[i] ? -1 : 1;
    return 0;
}

/* result = |a| + |b|, count a >= count b */
static void add_magnitude(big_integer *result, const big_integer *a, const big_integer *b) {
    uint64_t carry = 0;
    for (int i = 0; i < a->count; i++) {
        carry += (uint64_t)a->limbs[i] + (i < b->count ? b->limbs[i] : 0);
        result->limbs[i] = (uint32_t)carry;
        carry >>= 32;
    }
    result->count = a->count;
    if (carry) result->limbs[result->count++] = (uint32_t)carry;
}

/* result = |a| - |b|, |a| >= |b| */
static void subtract_magnitude(big_integer *result, const big_integer *a, const big_integer *b) {
    uint64_t borrow = 0;
    for (int i = 0; i < a->count; i++) {
        uint64_t const taken = (i < b->count ? b->limbs[i] : 0) + borrow;
        borrow = a->limbs[i] < taken;
        result->limbs[i] = (uint32_t)(a->limbs[i] - taken);
    }
    result->count = a->count;
}

static void add_signed(big_integer *result, const big_integer *a, const big_integer *b,
                       int sign_of_b) {
    if (a->sign * sign_of_b >= 0) {
        int const sign = a->sign ? a->sign : sign_of_b;
        if (a->count >= b->count)
            add_magnitude(result, a, b);
        else
            add_magnitude(result, b, a);
        trim(result, sign);
    } else if (compare_magnitude(a, b) >= 0) {
        subtract_magnitude(result, a, b);
        trim(result, a->sign);
    } else {
        subtract_magnitude(result, b, a);
        trim(result, sign_of_b);
    }
}

void big_integer_add(big_integer *result, const big_integer *a, const big_integer *b) {
    add_signed(result, a, b, b->sign);
}

void big_integer_subtract(big_integer *result, const big_integer *a, const big_integer *b) {
    add_signed(result, a, b, -b->sign);
}

void big_integer_multiply(big_integer *result, const big_integer *a, const big_integer *b) {
    result->count = a->sign && b->sign ? a->count + b->count : 0;
    memset(result->limbs, 0, (size_t)result->count * sizeof *result->limbs);
    for (int i = 0; result->count > 0 && i < a->count; i++) {
        uint64_t carry = 0;
        for (int j = 0; j < b->count; j++) {
            carry += (uint64_t)a->limbs[i] * b->limbs[j] + result->limbs[i + j];
            result->limbs[i + j] = (uint32_t)carry;
            carry >>= 32;
        }
        result->limbs[i + b->count] = (uint32_t)carry;
    }
    trim(result, a->sign * b->sign);
}
