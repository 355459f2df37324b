/* elastica.h - the elastica, an inextensible strip that bends under forces, integrated numerically:
 * what experiments with bent strips are held against. Lengths are in those of the strip. */
#ifndef TULLE_TEST_ELASTICA_H
#define TULLE_TEST_ELASTICA_H

#include <stdbool.h>
#include <stddef.h>

/* Half of a loop that hangs as a heart: its ends are clamped side by side and lead up, its lowest
 * point lies in the middle. */
typedef struct heart {
    double weight; /* rho g L^3 / B, with the length L of the whole loop */
    double gap;    /* of each end from the middle, in L */
} heart;
/* Finds how far the loop hangs below its clamped ends, in L. `points`: null, or 2 * `count` places
 * along the half, from the end on, x from the middle outwards, y upwards. False: not found. */
bool elastica_find_heart(heart def, double *drop, double *points, size_t count);

/* Load of a strip over the one at which it buckles, when its ends have come nearer to each other by
 * `shortening` of its length. The same whether both ends are clamped or both are hinges. */
double elastica_find_load(double shortening);

#endif
