/* math/single_solve.h - conjugate gradients in single precision with residuals in double. */
#ifndef TULLE_MATH_SINGLE_SOLVE_H
#define TULLE_MATH_SINGLE_SOLVE_H

#include "math/conjugate_gradients.h"
#include "math/single_kernel.h"
#include "math/sparse_cholesky.h"

/* A matrix in single precision, with terms; its numbers lie in the arena. */
typedef struct single_system {
    const block_matrix *matrix;
    single_matrix copy;          /* with the terms that lie in the pattern */
    const cholesky_term **apart; /* the others */
    size_t apart_count;
} single_system;

/* Copies matrix and terms; both stay borrowed. False: no memory. */
bool single_system_make(const block_matrix *matrix, const cholesky_term *terms, size_t term_count,
                        int threads, arena *scratch, single_system *system);

/* Solves as conjugate_gradients_solve does, to the same residual, measured in double precision with
 * problem->apply, which must be the system's matrix with its terms. `factor` (null: none) is the
 * preconditioner. Where single precision comes no nearer the iteration ends with
 * CONJUGATE_GRADIENTS_STALLED; x is then still better than before. */
tulle_status single_solve(const conjugate_gradients_problem *problem, const single_system *system,
                          sparse_cholesky *factor, double *x, arena *scratch,
                          conjugate_gradients_result *result);

#endif
