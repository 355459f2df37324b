/* contact/solve/solve_in_phases.h - the linear solves of stage 7, the cheapest way first. */
#ifndef TULLE_CONTACT_SOLVE_SOLVE_IN_PHASES_H
#define TULLE_CONTACT_SOLVE_SOLVE_IN_PHASES_H

#include "contact/solve/solve_motion.h"

/* What the solves of one linear system share. Before the first one, set all down to `single`, and
 * zero the rest. */
typedef struct phased_solve {
    const contact_scene *scene;
    const motion_system *system;
    double *residual;     /* 3 per vertex: b - A u after a solve, if has_residual; before one, A u
                             if has_product */
    single_system single; /* the matrix of the system, without hard rows between solves */
    int plain_iterations; /* without aggregates, of all solves so far */
    bool has_residual, has_product;
    const uint8_t *is_fixed; /* vertices */
    contact_row **hard_rows; /* of the round */
    size_t hard_count;
    const double *diagonal; /* of the round: its blocks, with hard rows */
} phased_solve;

/* Where a solve ends, as parts of the reference, which is a norm. */
typedef struct solve_goal {
    double reference; /* 0: that of the right-hand side */
    double tolerance;
    double early_share, early_tolerance; /* of the plan */
    double late_tolerance;               /* once its patience is over; 0: not so */
    int patience;
} solve_goal;

/* Solves the linear problem, whose targets and residual are set here, and sets the goal's reference
 * where it is 0. problem->apply adds the hard rows to the matrix. The problem is one of cloth, or
 * of cloth and bodies. Not `is_single`: in double precision from the beginning, for small cloth,
 * for rows with tilts, and for ties that hold bodies. */
tulle_status solve_in_phases(phased_solve *phases, const conjugate_gradients_problem *problem,
                             solve_goal *goal, bool is_single, double *u,
                             conjugate_gradients_result *result);

#endif
