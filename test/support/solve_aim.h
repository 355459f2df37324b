/* Targets of conjugate gradients as parts of a norm. */
#ifndef TULLE_TEST_SOLVE_AIM_H
#define TULLE_TEST_SOLVE_AIM_H

#include "math/conjugate_gradients.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

/* Makes the residual of x and sets both targets to this part of the reference; 0: the norm of the
 * right-hand side, or of the residual where that is zero. Returns the reference. */
static inline double aim_solve(conjugate_gradients_problem *problem, const double *x,
                               double tolerance, double reference, arena *scratch) {
    double first;
    if (!(reference > 0.0))
        assert_int_equal(
            conjugate_gradients_measure(problem, problem->right_hand_side, scratch, &reference),
            TULLE_OK);
    assert_int_equal(conjugate_gradients_leave(problem, x, scratch, &first), TULLE_OK);
    if (!(reference > 0.0)) reference = first;
    problem->target = problem->late_target = tolerance * reference;
    return reference;
}

#endif
