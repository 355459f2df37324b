/* math/nested_aggregates.h - a preconditioner for matrices over the vertices of a mesh. It does for
 * aggregates of vertices, for aggregates of these, and so on, what the blocks of the diagonal do
 * for vertices.
 *
 * With P_l, which gives all vertices of an aggregate its value,
 *     B = D^-1 + sum over levels l of P_l G_l^-1 P_l^T,    G_l the diagonal blocks of P_l^T A P_l;
 * D^-1 is the caller's. Aggregates are found once per mesh, numbers for each matrix. */
#ifndef TULLE_MATH_NESTED_AGGREGATES_H
#define TULLE_MATH_NESTED_AGGREGATES_H

#include "base/arena.h"
#include "math/block_matrix.h"
#include "math/matrix_term.h"
#include "math/single_kernel.h"

enum { AGGREGATE_LEVELS_MAX = 6 };

/* The aggregates of one level; its members are vertices or the aggregates of the level below. */
typedef struct aggregate_level {
    size_t count, member_count;
    uint32_t *parents;      /* member_count: the aggregate of each member */
    uint32_t *member_begin; /* count + 1, into members */
    uint32_t *members;      /* member_count, ascending in an aggregate */
    double *matrix_blocks;  /* 9 * count: G of the matrix without terms */
    double *blocks;         /* 9 * count: G */
    float *inverse;         /* 9 * count of G^-1, and padding */
    float *residual;        /* 3 * count: P^T r, and padding */
    float *correction;      /* 3 * count and padding: at last, of all levels from this one up */
    double *dots;           /* count at most: of both, for each chunk of a loop */
} aggregate_level;

typedef struct nested_aggregates {
    size_t vertex_count, block_count, scalar_count;
    size_t level_count;
    aggregate_level levels[AGGREGATE_LEVELS_MAX];
    /* Of each entry of the matrix: the first level whose aggregates join row and column. */
    uint8_t *block_levels, *scalar_levels;
    uint8_t *is_fixed; /* vertex_count, of the last matrix */
} nested_aggregates;

/* Aggregates of the vertices that the matrix joins. Null: no memory. During the call
 * scratch holds the graphs of the levels. */
nested_aggregates *nested_aggregates_build(memory *heap, const block_matrix *matrix,
                                           arena *scratch);
void nested_aggregates_destroy(memory *heap, nested_aggregates *aggregates);

/* Takes the numbers of a matrix without the rows and columns of fixed vertices (null: none).
 * During the call scratch holds sums of blocks. False: no memory. */
bool nested_aggregates_set_matrix(nested_aggregates *aggregates, const block_matrix *matrix,
                                  const uint8_t *is_fixed, int threads, arena *scratch);
/* Puts these terms on the last matrix in place of earlier ones, and makes the aggregates ready
 * for use. */
void nested_aggregates_set_terms(nested_aggregates *aggregates, const matrix_term *terms,
                                 size_t count, int threads);

/* The correction sum P_l G_l^-1 P_l^T r as values of the first level's aggregates (levels[0]
 * .correction), for the residual r of `vectors`; returns r . correction. The same bits for any
 * number of threads. */
double nested_aggregates_correct(nested_aggregates *aggregates, const single_vectors *vectors,
                                 int threads);

#endif
