/* fuzz/support/soup.h - coordinates for small surfaces, taken from bytes; memory for the rational
 * numbers that judge them. */
#ifndef TULLE_FUZZ_SOUP_H
#define TULLE_FUZZ_SOUP_H

#include "support/fuzz.h"

/* How coordinates lie. On lattices nearly everything touches, coincides or has no area. */
typedef enum soup_places {
    SOUP_COARSE,  /* whole numbers -2 .. 2 */
    SOUP_FINE,    /* 65536 places from -2 to 2 */
    SOUP_BESIDE,  /* whole numbers, moved by some last bits */
    SOUP_BILLION, /* a lattice of -2 .. 2 where x is a billion times longer */
    SOUP_PLACES_COUNT
} soup_places;

/* Fills `count` points, 3 numbers each. */
void soup_take_points(fuzz_bytes *bytes, soup_places places, size_t count, double *points);

/* Lets GMP keep its memory for later numbers: the address sanitizer's heap would take most of the
 * time. Call it before the first number; later calls change nothing. */
void soup_pool_numbers(void);

#endif
