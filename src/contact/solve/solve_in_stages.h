/* contact/solve/solve_in_stages.h - the linear solves of stage 7, cheapest way first. */
#ifndef TULLE_CONTACT_SOLVE_SOLVE_IN_STAGES_H
#define TULLE_CONTACT_SOLVE_SOLVE_IN_STAGES_H

#include "contact/solve/solve_motion.h"

/* What the solves of one linear system share; zeroed but for the first two and room for the
 * residual before the first. */
typedef struct staged_solve {
    const contact_scene *scene;
    const motion_system *system; /* with its matrix */
    int plain_iterations;        /* of all solves so far, without aggregates */
    bool has_aggregates;         /* they have the numbers of this matrix */
    double *residual;            /* 3 a vertex: b - A u after a solve, if has_residual */
    bool has_residual;
} staged_solve;

/* Solves as conjugate_gradients_solve does. The rows are those that problem->apply adds to the
 * matrix. */
tulle_status solve_in_stages(staged_solve *stages, const conjugate_gradients_problem *problem,
                             contact_row *const *hard_rows, size_t hard_count, double *u,
                             conjugate_gradients_result *result);

#endif
