/* math/nested_aggregates.h - a preconditioner for matrices over the vertices of a mesh. It solves
 * for aggregates of vertices, and by a cycle over aggregates of these, and so on, what the blocks
 * of the diagonal solve for vertices.
 *
 * With P, which gives all vertices of an aggregate its value, and C, a cycle for A_0 = P^T A P,
 *     B = D^-1 + P C P^T;
 * D^-1 is the caller's. Where the vertices make a grid, the first aggregates are its blocks, and P
 * is smoother (grid_transfer.h). Aggregates are found once per mesh, numbers for each matrix. */
#ifndef TULLE_MATH_NESTED_AGGREGATES_H
#define TULLE_MATH_NESTED_AGGREGATES_H

#include "base/arena.h"
#include "math/block_matrix.h"
#include "math/grid_transfer.h"
#include "math/matrix_term.h"
#include "math/single_kernel.h"

enum { AGGREGATE_LEVELS_MAX = 6 };
/* Part of D^-1 r that a step of the cycle goes on the first level, see nested_aggregates_cycle.c.
 */
static const float FIRST_STEP = 0.5F;

/* Sparse weights: of each row from begin to the next one's. */
typedef struct weight_list {
    size_t count;
    uint32_t *begin, *columns;
    float *weights;
} weight_list;

/* The aggregates of one level; its members are vertices or the aggregates of the level below. */
typedef struct aggregate_level {
    size_t count, member_count;
    uint32_t *parents;      /* member_count: the aggregate of each member */
    uint32_t *member_begin; /* count + 1, into members */
    uint32_t *members;      /* member_count, ascending in an aggregate */
    /* P of the levels above the first, by members and by aggregates: the mean of the parents of a
     * member and its neighbours, or the parent of a member with very many. That of the first is the
     * grid's, or gives each vertex its parent's value. */
    weight_list of_members, of_aggregates;
    /* A of the level. Both triangles, columns ascending in a row. */
    size_t entry_count;
    uint32_t *row_begin, *columns; /* count + 1; entry_count */
    uint32_t *diagonals;           /* count: the entry on the diagonal */
    uint32_t *no_scalars;          /* count + 1 zeros, which the kernel asks for */
    /* The rest is null in the first level of a grid, which has its own. */
    float *values;  /* SINGLE_BLOCK an entry, and padding */
    float *inverse; /* 9 * count of the diagonal's inverse, and padding */
    /* 3 * count and padding: P^T r; what comes before and after the level above; a product */
    float *residual, *guess, *correction, *product;
    double *dots; /* residual . correction, for each chunk of a loop; count at most */
} aggregate_level;

typedef struct nested_aggregates {
    size_t vertex_count, block_count, scalar_count;
    size_t level_count;
    aggregate_level levels[AGGREGATE_LEVELS_MAX];
    grid_transfer *grid; /* null: the first aggregates have any shape */
    /* Without a grid. Of each entry of the matrix, the place of its entry in its row of the first
     * level; NO_PLACE where its mirror image is counted; FAR_PLACE where it must be looked for. */
    uint8_t *block_places, *scalar_places;
    uint8_t *is_fixed; /* vertex_count, of the last matrix */
    /* A of the first level without terms, of the last matrix that was read; null: large, and so
     * none is kept. */
    double *matrix_sums;
    size_t matrix_sum_count;
    bool has_sums;
} nested_aggregates;

enum { FAR_PLACE = 254, NO_PLACE = 255 };

/* Entry (row, column) of a level; TULLE_NONE: it has none. */
uint32_t nested_aggregates_find(const aggregate_level *level, uint32_t row, uint32_t column);

/* What aggregates take their numbers from. */
typedef struct aggregated_system {
    const block_matrix *matrix;
    const uint8_t *is_fixed;
    const matrix_term *terms;
    size_t term_count;
    /* Matrix and fixed vertices are those of the call before: where its sums are kept, no more than
     * the terms is taken anew. */
    bool is_known;
} aggregated_system;

/* Aggregates of the vertices that the matrix joins. Null: no memory. During the call
 * scratch holds the graphs of the levels. */
nested_aggregates *nested_aggregates_build(memory *heap, const block_matrix *matrix,
                                           arena *scratch);
void nested_aggregates_destroy(memory *heap, nested_aggregates *aggregates);

/* Takes the numbers of a matrix and of terms on it, without the rows and columns of fixed vertices
 * (null: none). During the call scratch holds sums. False: no memory. */
bool nested_aggregates_set(nested_aggregates *aggregates, const aggregated_system *system,
                           int threads, arena *scratch);

/* Finds the correction P C P^T r for the residual r of `vectors`, which lies in planes
 * (diagonal_kernel.h) if the aggregates have a grid; returns r . correction. The same bits for any
 * number of threads. */
double nested_aggregates_correct(nested_aggregates *aggregates, const single_vectors *vectors,
                                 int threads);
/* Adds the correction found to vertices begin .. end - 1 of vectors.preconditioned. */
void nested_aggregates_add(const nested_aggregates *aggregates, const single_vectors *vectors,
                           size_t begin, size_t end);

#endif
