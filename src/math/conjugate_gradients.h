/* math/conjugate_gradients.h - preconditioned conjugate gradients for symmetric positive definite
 * systems over vertices, with some vertices held fixed. */
#ifndef TULLE_MATH_CONJUGATE_GRADIENTS_H
#define TULLE_MATH_CONJUGATE_GRADIENTS_H

#include "base/arena.h"
#include "base/stop.h"
#include "math/block_matrix.h"

/* y = A x over 3 * vertex_count doubles that do not overlap. Called from the thread that solves; it
 * may run parallel_for itself and must give the same bits for any number of threads. */
typedef void (*linear_operator)(void *context, const double *x, double *y);

/* Adds to P^-1 r what more a preconditioner finds for the residual r; returns r . that. Both have 3
 * * vertex_count doubles. Symmetric and positive; called like a linear_operator. */
typedef double (*residual_correction)(void *context, const double *residual,
                                      double *preconditioned);

typedef struct conjugate_gradients_problem {
    size_t vertex_count;
    linear_operator apply;
    void *apply_context;
    const double *right_hand_side; /* b, 3 * vertex_count */
    const double *inverse;         /* P^-1, BLOCK_NUMBERS * vertex_count; zero at fixed vertices,
                                      whose entries of x stay as given */
    residual_correction correct;   /* null: P^-1 alone; for conjugate_gradients_solve alone */
    void *correct_context;
    int plain_iterations;   /* before it is called for the first time; > 0 */
    const uint8_t *is_idle; /* vertex_count: fixed, and the product at them is of no use; null: none
                             */
    /* It ends at the norm `target`, and after `patience` iterations, or at once if that is not
     * positive, at late_target, which is no less. A norm is sqrt(r . P^-1 r). */
    double target, late_target;
    int patience;
    int limit; /* iterations */
    int threads;
    double *residual; /* b - A x, 3 * vertex_count: of the given x, then of the last */
    stop_poll *stop;  /* asked before each iteration; then it ends as at the limit. May be null */
} conjugate_gradients_problem;

typedef enum conjugate_gradients_end {
    CONJUGATE_GRADIENTS_CONVERGED,
    CONJUGATE_GRADIENTS_ITERATION_LIMIT,
    CONJUGATE_GRADIENTS_NOT_POSITIVE, /* p . A p <= 0 for a direction p: A is not positive definite
                                       */
    CONJUGATE_GRADIENTS_NOT_FINITE,   /* a product or a dot became infinite or NaN */
    CONJUGATE_GRADIENTS_STALLED       /* of single_solve only: no nearer by single precision */
} conjugate_gradients_end;

typedef struct conjugate_gradients_result {
    conjugate_gradients_end end;
    int iterations; /* products with A */
    double norm;    /* at the end */
} conjugate_gradients_result;

/* P^-1 of all vertices from the diagonal blocks of A, 9 * count, which are symmetric: zero at fixed
 * ones (null: none are). A block that is not positive definite is replaced by its positive
 * diagonal, or by 1. */
typedef struct preconditioner_source {
    const double *diagonal;
    const uint8_t *is_fixed;
} preconditioner_source;
void conjugate_gradients_invert(preconditioner_source source, size_t count, int threads,
                                double *inverse);
/* That of one vertex. */
void invert_block_of(preconditioner_source source, size_t vertex, double inverse[BLOCK_NUMBERS]);

/* sqrt(r . P^-1 r). TULLE_OK or TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status conjugate_gradients_measure(const conjugate_gradients_problem *problem,
                                         const double *r, arena *scratch, double *norm);
/* Makes the residual of x, and its norm. x null: the residual holds A x. TULLE_OK or
 * TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status conjugate_gradients_leave(const conjugate_gradients_problem *problem, const double *x,
                                       arena *scratch, double *norm);

/* Solves A x = b from the given x and its residual (warm start; fixed entries are data). x and the
 * residual are then those of the last iterate, whatever the end. Scratch comes from the arena
 * and is released. Returns TULLE_OK or TULLE_ERROR_OUT_OF_MEMORY (x unchanged); how the iteration
 * ended is in `result`. Bits do not depend on `threads`. */
tulle_status conjugate_gradients_solve(const conjugate_gradients_problem *problem, double *x,
                                       arena *scratch, conjugate_gradients_result *result);

#endif
