/* math/grid_transfer.h - between the vertices of a grid and blocks of them, for the first level of
 * nested aggregates.
 *
 * Where vertices are numbered row by row and each is joined to near ones alone, aggregates are
 * blocks of four by four vertices or some more, row by row. P gives each vertex the mean of the
 * blocks of its neighbours along the row, and of these the mean along the column. So it is a
 * product of weights of rows and weights of columns, and is applied to whole rows at a time.
 * Entries join a block to itself and to the eight around it. Sheets that follow each other share no
 * block.
 *
 * Based on: Vanek, Mandel, Brezina, Algebraic multigrid by smoothed aggregation, 1996. Departure:
 * the mean over neighbours smooths in place of the matrix. */
#ifndef TULLE_MATH_GRID_TRANSFER_H
#define TULLE_MATH_GRID_TRANSFER_H

#include "base/arena.h"
#include "math/block_matrix.h"
#include "math/diagonal_kernel.h"
#include "math/grid_kernel.h"

/* How many rows and columns an entry may go. */
enum { GRID_REACH = 2 };

/* Rows or columns in blocks. A line has parts of two blocks that follow each other. */
typedef struct grid_axis {
    size_t count, block_count;
    uint32_t *begin; /* block_count + 1: the first line of each block */
    uint32_t *lower; /* count: the first of the two blocks */
    float *share;    /* count: the part of that one; the next has the rest, which may be 0 */
} grid_axis;

/* Rows that an entry goes down: none to two. */
enum { GRID_ROWS_DOWN = 3 };
/* A column of blocks has sums for the one before it, itself and the next. */
enum { GRID_WAYS = 3 };
/* Place of a sum of a column of blocks: way 0, 1, 2 to the one before, itself, the next. */
static inline size_t grid_transfer_get_place(size_t column, size_t down, size_t way) {
    return (column * GRID_ROWS_DOWN + down) * GRID_WAYS + way;
}

/* Columns from begin to end - 1, whose entries on a diagonal go from parts of two columns of blocks
 * to parts of two. Sums are by pairs of these: lower to lower, lower to upper, upper to lower,
 * upper to upper. */
typedef struct grid_run {
    size_t begin, end;
    size_t places[4]; /* where the sum of a pair goes */
    double times[4];  /* and how often it counts; 0: nowhere */
} grid_run;

/* A diagonal of the matrix: entries that go so many rows down and columns to the right. */
typedef struct grid_diagonal {
    size_t down;
    int step;
    bool has_blocks; /* not scalars alone */
    size_t run_count;
    grid_run *runs;
    double *weights; /* four a column, of the pairs */
} grid_diagonal;

typedef struct grid_transfer {
    grid_axis rows, columns;
    grid_diagonal *diagonals; /* as the matrix has them */
    size_t diagonal_count;
    /* A row of blocks spread over the columns, for each and one more: three planes of line_stride
     * numbers. */
    float *lines;
    size_t line_stride;
    float *is_free; /* 1 or 0 a vertex of the last matrix, and SINGLE_PADDING */
    bool has_fixed;
    /* A of the blocks by diagonals, and vectors: the residual P^T r, the guess as direction, its
     * product, the correction as preconditioned; of the inverse a step's part. */
    matrix_diagonals pattern;
    single_diagonals matrix;
    single_vectors vectors;
    float *planes; /* what they all lie in */
    size_t plane_count;
} grid_transfer;

enum { GRID_DIAGONALS = 5 }; /* the main diagonal and four above it */
enum { GRID_BLOCK = 8 };     /* the BLOCK_NUMBERS of a block's sum, and two more */

/* The grid that a matrix' vertices make. *result is null where they make none. False: no memory. */
bool grid_transfer_build(memory *heap, const block_matrix *matrix, grid_transfer **result);
void grid_transfer_destroy(memory *heap, grid_transfer *grid);

static inline size_t grid_transfer_count(const grid_transfer *grid) {
    return grid->rows.block_count * grid->columns.block_count;
}

/* The block that each vertex is in: what `parents` of a level holds. */
void grid_transfer_find_parents(const grid_transfer *grid, uint32_t *parents);

static inline bool grid_axis_has_part(const grid_axis *axis, size_t line, size_t block) {
    return axis->lower[line] == block ||
           (axis->lower[line] + 1 == block && axis->share[line] < 1.0F);
}
static inline double grid_axis_get_part(const grid_axis *axis, size_t line, size_t block) {
    double const share = (double)axis->share[line];
    return axis->lower[line] == block ? share : 1.0 - share;
}
/* Lines that may have a part in a block, from first to end - 1. */
typedef struct line_range {
    size_t first, end;
} line_range;
static inline line_range grid_axis_get_lines(const grid_axis *axis, size_t block) {
    size_t const begin = axis->begin[block], end = axis->begin[block + 1];
    return (line_range){begin > 0 ? begin - 1 : 0, end < axis->count ? end + 1 : end};
}

/* Notes which vertices are fixed. */
void grid_transfer_set_fixed(grid_transfer *grid, const uint8_t *is_fixed);

/* What P^T A P is made of. Rows and columns of fixed vertices count as 0. */
typedef struct grid_fill_source {
    const block_matrix *matrix;
    const uint8_t *is_fixed;
} grid_fill_source;
/* P^T A P: GRID_DIAGONALS entries of GRID_BLOCK numbers a block, to itself, to the next, and to the
 * three below. False: no memory. */
bool grid_transfer_sum(const grid_transfer *grid, const grid_fill_source *source, int threads,
                       arena *scratch, double *sums);
/* Adds a term to the sums of all blocks. Where it joins blocks that are apart, as contact of cloth
 * with itself does, it counts as if each of its blocks were tied to what does not move. */
void grid_transfer_add_term(const grid_transfer *grid, const matrix_term *term,
                            const uint8_t *is_fixed, double *sums);

/* P^T r of these rows of blocks, into vectors.residual. Residuals lie in planes. */
void grid_transfer_restrict(const grid_transfer *grid, const single_vectors *from, size_t begin,
                            size_t end);
/* The lines of these rows of blocks, of vectors.preconditioned. */
void grid_transfer_expand(const grid_transfer *grid, size_t begin, size_t end);
/* Adds P z of expanded lines to vertices begin .. end - 1 of planes; to fixed ones nothing. */
void grid_transfer_add(const grid_transfer *grid, float *planes, size_t number_step, size_t begin,
                       size_t end);

#endif
