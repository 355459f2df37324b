/* math/single_solve.h - conjugate gradients in single precision with residuals in double. */
#ifndef TULLE_MATH_SINGLE_SOLVE_H
#define TULLE_MATH_SINGLE_SOLVE_H

#include "math/conjugate_gradients.h"
#include "math/diagonal_kernel.h"
#include "math/nested_aggregates.h"
#include "math/single_kernel.h"

/* Unknowns outside the matrix, which terms apart pull, too. They follow its own at once: they are
 * where they make the quadratic form least. */
typedef struct outer_unknowns {
    void (*settle)(void *context, double *x); /* sets them in x, whose first are the matrix' own */
    /* From the pulls of terms apart while they are held, 3 a term: those as they follow. Returns
     * how much less the curvature along the direction is. */
    double (*yield)(void *context, double *pulls);
    void *context;
} outer_unknowns;

/* A matrix in single precision, with terms; its numbers lie in the arena. */
typedef struct single_system {
    const block_matrix *matrix;
    uint8_t *is_stale; /* of each DIAGONAL_ROWS rows: not yet copied, or with terms */
    /* With the terms that lie in the pattern: by diagonals if the matrix has them, else by rows */
    single_diagonals diagonals; /* pattern null: none */
    single_matrix copy;
    const matrix_term **apart; /* the others */
    size_t apart_count;
    const outer_unknowns *outer;   /* null: none */
    nested_aggregates *aggregates; /* with the same terms, for a preconditioner; null: none */
} single_system;

/* Makes room for the matrix, whose blocks are each symmetric, and which stays borrowed. False: no
 * memory. */
bool single_system_make(const block_matrix *matrix, arena *scratch, single_system *system);
/* Puts these terms, which stay borrowed, in place of earlier ones. Copies the matrix first, of
 * which no number may have changed since the first call. False: no memory. */
bool single_system_set_terms(single_system *system, const matrix_term *terms, size_t count,
                             int threads, arena *scratch);

/* Vectors and inverse of the matrix' size, zeroed, as its kernels take them. False: no memory. */
bool single_vectors_make(const single_system *system, arena *scratch, single_vectors *vectors);
/* The kernels of single_kernel.h or those of diagonal_kernel.h, for rows begin .. end - 1 and
 * without the terms apart. */
float single_system_multiply(const single_system *system, const single_vectors *vectors,
                             size_t begin, size_t end);
float single_system_advance(const single_system *system, const single_vectors *vectors, float alpha,
                            size_t begin, size_t end);
void single_system_turn(const single_system *system, const single_vectors *vectors, float beta,
                        size_t begin, size_t end);

/* Aggregates for a system that takes more than plain_iterations with the blocks of the diagonal
 * alone. */
typedef struct late_aggregates {
    int plain_iterations;
    bool (*add)(void *context); /* gives the system its aggregates; false: no memory */
    void *context;
} late_aggregates;

/* Solves as conjugate_gradients_solve does, to the same residual, which is measured in double
 * precision with problem->apply: this must be the system's matrix with its terms. It may have outer
 * unknowns after the problem's vertices; then the residual has room for them. The
 * preconditioner is the blocks of the diagonal, with those of aggregates if the system has them, or
 * once it has them (late, null: never). Where single precision comes no nearer the iteration ends
 * with CONJUGATE_GRADIENTS_STALLED; x is then still better than before. TULLE_OK or
 * TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status single_solve(const conjugate_gradients_problem *problem, const single_system *system,
                          const late_aggregates *late, double *x, arena *scratch,
                          conjugate_gradients_result *result);

#endif
