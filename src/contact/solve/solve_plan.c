/* contact/solve/solve_plan.c - the efforts of solves, each number with its reason. */
#include "contact/solve/solve_plan.h"

#include "contact/solve/hard_rows.h"

#include <math.h>

/* Solves of small cloth take some 30 iterations; with a patience of 16 it creeps where it should
 * stick. A larger factor damps flutter. A looseness of 4.5 slows sliding cloth by half a percent,
 * 10 by one and a half. */
const solve_effort solve_efforts[] = {
    [TULLE_QUALITY_DRAFT] = {100.0, 16, 0, 100.0, 0.1, (double)INFINITY},
    /* 100 times lets a loop of silk hang 1.2 % too high and damps a swing by Crank-Nicolson */
    [TULLE_QUALITY_NORMAL] = {30.0, 48, 32, 4.5, 0.01, (double)INFINITY},
    [TULLE_QUALITY_EXACT] = {0.0, 0, 32, 1.0, 0.0, (double)INFINITY},
};
const solve_effort cheap_effort = {0.0, 0, 32, 1.0, 0.0, LEAST_VIOLATION};

/* Solves of cloth that is stiff on average do not end late before they take a thousand iterations,
 * whatever the quality. Without a late end a swatch of silk does not converge in 5,000. */
const solve_effort stiff_effort = {10.0, 1500, 32, 1.0, 0.0, (double)INFINITY};
