/* base/integer.h - arithmetic of whole numbers. */
#ifndef TULLE_BASE_INTEGER_H
#define TULLE_BASE_INTEGER_H

#include <stdint.h>

/* The greatest common divisor; of 0 and b it is b. */
static inline uint32_t integer_compute_common_factor(uint32_t a, uint32_t b) {
    while (b != 0) {
        uint32_t const rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

#endif
