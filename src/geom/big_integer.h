/* geom/big_integer.h - signed integers just long enough for the exact sign of a 3x3 determinant of
 * doubles.
 *
 * A finite double is an integer times 2^-1074 below 2^2098, so differences of coordinates need 2099
 * bits, products of two of them and their sums 4200, products of three and their sums 6301.
 * Everything fits into a fixed array; nothing is allocated and nothing can fail.
 */
#ifndef TULLE_GEOM_BIG_INTEGER_H
#define TULLE_GEOM_BIG_INTEGER_H

#include <stdint.h>

enum { BIG_INTEGER_LIMBS = 200 }; /* of 32 bits: 6400 bits */

typedef struct big_integer {
    int sign;                          /* -1, 0 or +1 */
    int count;                         /* limbs in use, the last one nonzero; 0 for zero */
    uint32_t limbs[BIG_INTEGER_LIMBS]; /* magnitude, least significant first */
} big_integer;

/* Writes values[1..count-1] - values[0], all times one power of two that makes the values integers,
 * to differences[0..count-2]. count: 2 .. 4; values finite. */
void big_integer_set_differences(big_integer *differences, const double *values, int count);
/* result = a + factor b; factor: 1 or -1; result is neither a nor b. */
void big_integer_add(big_integer *result, const big_integer *a, const big_integer *b, int factor);
/* result = a b; result is neither a nor b. */
void big_integer_multiply(big_integer *result, const big_integer *a, const big_integer *b);

#endif
