/* fuzz/support/soup.c - see soup.h. */
#include "support/soup.h"

#include <float.h>

static double take_coordinate(fuzz_bytes *bytes, soup_places places, size_t axis) {
    if (places == SOUP_FINE) return fuzz_take_between(bytes, -2.0, 2.0);
    int const byte = fuzz_take(bytes);
    double const whole = byte % 5 - 2;
    if (places == SOUP_BESIDE) return whole * (1.0 + (byte / 5 % 8 - 4) * DBL_EPSILON);
    return places == SOUP_BILLION && axis == 0 ? 1e9 * whole : whole;
}

void soup_take_points(fuzz_bytes *bytes, soup_places places, size_t count, double *points) {
    for (size_t i = 0; i < 3 * count; i++) points[i] = take_coordinate(bytes, places, i % 3);
}
