/* dynamics/excess_kernel.h - kernel: the energy of springs on their way, and what a linear system
 * expects of it, see linear_excess.c. */
#ifndef TULLE_DYNAMICS_EXCESS_KERNEL_H
#define TULLE_DYNAMICS_EXCESS_KERNEL_H

#include "dynamics/spring.h"
#include "math/kernel_target.h"

/* Where springs are linearised and where they go: x0 [m], two mean velocities [m/s] and h [s]. */
typedef struct excess_motion {
    const double *positions, *guess, *mean; /* guess null: about x0 */
    double time_step;
} excess_motion;

/* The sums over these springs, in their order. */
TULLE_DECLARE_KERNEL(way_energies, sum_excess,
                     (const cloth_spring *springs, size_t count, const excess_motion *motion))

#endif
