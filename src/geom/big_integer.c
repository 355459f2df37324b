/* geom/big_integer.c - see big_integer.h. Sign and magnitude, schoolbook arithmetic. */
#include "geom/big_integer.h"

#include <limits.h>
#include <stdbool.h>
#include <string.h>

/* Drops leading zeros and sets the sign of what is left. */
static void trim(big_integer *a, int sign) {
    while (a->count > 0 && a->limbs[a->count - 1] == 0) a->count--;
    a->sign = a->count > 0 ? sign : 0;
}

void big_integer_set_differences(big_integer *differences, const double *values, int count) {
    /* |value| = mantissa * 2^exponent with an odd mantissa, or mantissa 0. */
    uint64_t mantissas[4];
    int exponents[4], lowest = INT_MAX;
    for (int i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        int const field = (int)(bits >> 52 & 0x7ff); /* 0 for subnormal numbers */
        mantissas[i] = (bits & ((UINT64_C(1) << 52) - 1)) | (uint64_t)(field > 0) << 52;
        exponents[i] = (field > 0 ? field : 1) - 1075;
        if (mantissas[i] == 0) continue;
        for (; !(mantissas[i] & 0xff); mantissas[i] >>= 8) exponents[i] += 8;
        for (; !(mantissas[i] & 1); mantissas[i] >>= 1) exponents[i]++;
        if (exponents[i] < lowest) lowest = exponents[i];
    }
    big_integer origin, point;
    for (int i = 0; i < count; i++) {
        /* The value times 2^-lowest: its mantissa shifted to the left. */
        int const shift = mantissas[i] ? exponents[i] - lowest : 0;
        int const skipped = shift / 32, rest = shift % 32;
        uint64_t const low = mantissas[i] << rest;
        uint64_t const high = rest ? mantissas[i] >> (64 - rest) : 0;
        big_integer *const shifted = i == 0 ? &origin : &point;
        if (skipped > 0) memset(shifted->limbs, 0, (size_t)skipped * sizeof *shifted->limbs);
        shifted->limbs[skipped] = (uint32_t)low;
        shifted->limbs[skipped + 1] = (uint32_t)(low >> 32);
        shifted->limbs[skipped + 2] = (uint32_t)high;
        shifted->count = skipped + 3;
        trim(shifted, values[i] < 0.0 ? -1 : 1);
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
