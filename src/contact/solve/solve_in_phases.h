/* contact/solve/solve_in_phases.h - the linear solves of stage 7, the cheapest way first. */
#ifndef TULLE_CONTACT_SOLVE_SOLVE_IN_PHASES_H
#define TULLE_CONTACT_SOLVE_SOLVE_IN_PHASES_H

#include "contact/solve/solve_motion.h"

/* What the solves of one linear system share. Before the first one, set all down to `single`, and
 * zero the rest. */
typedef struct phased_solve {
    const contact_scene *scene;
    const motion_system *system;
    double *residual;     /* 3 per vertex: b - A u after a solve, if has_residual */
    single_system single; /* the matrix of the system, without hard rows between solves */
    int plain_iterations; /* without aggregates, of all solves so far */
    bool has_residual;
} phased_solve;

/* Solves as conjugate_gradients_solve does. problem->apply adds the hard rows to the matrix, none
 * of which may have a tilt. The problem is one of cloth, or of cloth and bodies. */
tulle_status solve_in_phases(phased_solve *phases, const conjugate_gradients_problem *problem,
                             contact_row *const *hard_rows, size_t hard_count, double *u,
                             conjugate_gradients_result *result);

/* The same in double precision, for small cloth, for ties at a height over cloth, and for those
 * that hold bodies. */
tulle_status solve_in_double(phased_solve *phases, const conjugate_gradients_problem *problem,
                             contact_row *const *hard_rows, size_t hard_count, double *u,
                             conjugate_gradients_result *result);

#endif
