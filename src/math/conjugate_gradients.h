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
    const double *diagonal;        /* 9 * vertex_count: diagonal blocks of A (symmetric), inverted
                                      inside as the preconditioner P; a block that is not positive
                                      definite is replaced by its positive diagonal, or by 1 */
    const double *inverse;         /* P^-1, BLOCK_NUMBERS * vertex_count; null: not at hand */
    residual_correction correct;   /* null: P^-1 alone; for conjugate_gradients_solve alone */
    void *correct_context;
    int plain_iterations;    /* before it is called for the first time; > 0 */
    const uint8_t *is_fixed; /* vertex_count, null: none. Fixed entries of x stay as given */
    const uint8_t *is_idle; /* vertex_count: fixed, and the product at them is of no use; null: none
                             */
    double tolerance;       /* stop at sqrt(r . P^-1 r) <= tolerance * reference */
    double reference;       /* > 0; otherwise sqrt(b . P^-1 b) over free vertices, and the
                               first residual where that is zero */
    /* A solve that another one follows may stop early: at early_share of its first residual, but
     * not above early_most times the reference. 0: it does not */
    double early_share, early_most;
    /* After `patience` iterations, or at once if that is not positive, a solve also ends at this
     * tolerance, which result.target does not tell. 0: it does not */
    double late_tolerance;
    int patience;
    int max_iterations;
    int threads;
    double *residual; /* b - A x of the end goes here, 3 * vertex_count; null: nowhere */
    bool has_product; /* `residual` holds A x of the given x; for single_solve alone */
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
    int iterations;  /* products with A, less the one of the first residual */
    double residual; /* sqrt(r . P^-1 r) / reference at the end */
    double reference;
    double target; /* residual at which it was to end */
} conjugate_gradients_result;

/* Solves A x = b from the given x (warm start; fixed entries are data). x then holds the last
 * iterate, whatever the end. Scratch (18 doubles a vertex) comes from the
 * arena and is released. Returns TULLE_OK or TULLE_ERROR_OUT_OF_MEMORY (x unchanged); how the
 * iteration ended is in `result`. Bits do not depend on `threads`. */
tulle_status conjugate_gradients_solve(const conjugate_gradients_problem *problem, double *x,
                                       arena *scratch, conjugate_gradients_result *result);

/* sqrt(b . P^-1 b) over free vertices, without a product; the problem has the inverse. TULLE_OK or
 * TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status conjugate_gradients_measure(const conjugate_gradients_problem *problem, arena *scratch,
                                         double *norm);
/* P^-1 of all vertices. */
void conjugate_gradients_invert(const conjugate_gradients_problem *problem, double *inverse);

/* The residual at which a solve with this first residual ends. */
double conjugate_gradients_choose_target(const conjugate_gradients_problem *problem,
                                         double reference, double first);

/* The preconditioner's block of a vertex: zero at a fixed one. */
void invert_block_of(const conjugate_gradients_problem *problem, size_t vertex,
                     double inverse[BLOCK_NUMBERS]);

#endif
