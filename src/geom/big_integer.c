/* geom/big_integer.c - see big_integer.h. Sign and magnitude, schoolbook arithmetic. */
#include "geom/big_integer.h"

#include <stdbool.h>
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
    for (int i = 0; i < count; i++) {
        /* the value times 2^-lowest: its mantissa shifted to the left */
        int const shift = parts[i].mantissa ? parts[i].exponent - lowest : 0;
        int const skipped = shift / 32, rest = shift % 32;
        uint64_t const low = parts[i].mantissa << rest;
        uint64_t const high = rest ? parts[i].mantissa >> (64 - rest) : 0;
        big_integer *const shifted = i == 0 ? &origin : &point;
        if (skipped > 0) memset(shifted->limbs, 0, (size_t)skipped * sizeof *shifted->limbs);
        shifted->limbs[skipped] = (uint32_t)low;
        shifted->limbs[skipped + 1] = (uint32_t)(low >> 32);
        shifted->limbs[skipped + 2] = (uint32_t)high;
        shifted->count = skipped + 3;
        trim(shifted, parts[i].sign);
        if (i > 0) big_integer_add(&differences[i - 1], &point, &origin, -1);
    }
}

void big_integer_add(big_integer *result, const big_integer *a, const big_integer *b, int factor) {
    int const sign_of_b = factor * b->sign;
    int top = a->count - 1; /* the highest limb in which they differ */
    while (a->count == b->count && top > 0 && a->limbs[top] == b->limbs[top]) top--;
    bool const is_b_larger =
        a->count != b->count ? a->count < b->count : top >= 0 && a->limbs[top] < b->limbs[top];
    const big_integer *const larger = is_b_larger ? b : a;
    const big_integer *const smaller = is_b_larger ? a : b;

    /* The magnitude of the larger one, and that of the other one added or taken away. Shifts of a
     * negative carry keep its sign, as gcc and clang define it. */
    int64_t const sign = a->sign * sign_of_b < 0 ? -1 : 1;
    int const count = larger->count, both = smaller->count;
    int64_t carry = 0;
    int i = 0;
    for (; i < both; i++, carry >>= 32) {
        carry += (int64_t)larger->limbs[i] + sign * (int64_t)smaller->limbs[i];
        result->limbs[i] = (uint32_t)carry;
    }
    for (; i < count; i++, carry >>= 32) {
        carry += larger->limbs[i];
        result->limbs[i] = (uint32_t)carry;
    }
    result->count = count;
    if (carry) result->limbs[result->count++] = (uint32_t)carry;
    trim(result, is_b_larger ? sign_of_b : a->sign);
}

void big_integer_multiply(big_integer *result, const big_integer *a, const big_integer *b) {
    int const a_count = a->sign && b->sign ? a->count : 0, b_count = b->count;
    result->count = a_count > 0 ? a_count + b_count : 0;
    for (int i = 0; i < a_count; i++) {
        uint64_t const factor = a->limbs[i];
        uint64_t carry = 0;
        for (int j = 0; j < b_count; j++) {
            carry += factor * b->limbs[j] + (i > 0 ? result->limbs[i + j] : 0);
            result->limbs[i + j] = (uint32_t)carry;
            carry >>= 32;
        }
        result->limbs[i + b_count] = (uint32_t)carry;
    }
    trim(result, a->sign * b->sign);
}
