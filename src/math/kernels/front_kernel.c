/* math/kernels/front_kernel.c - see front_kernel.h.
 *
 * Columns are factored in blocks: what earlier blocks take off a block, then its diagonal part,
 * then the rows below. Lanes are rows, so each entry is computed alone, in the same order of
 * operations for any width: sums over the columns of earlier blocks start from zero and run
 * upwards.
 *
 * Based on: Golub, Van Loan, Matrix computations, 4.2.6 (block Cholesky); Goto, van de Geijn,
 * Anatomy of high-performance matrix multiplication, 2008 (tiles in registers). Departure: columns
 * are contiguous for both factors of a product, so nothing is packed. */
#include "math/front_kernel.h"

#include <math.h>
#include <string.h>

#define FRONT_INLINE static inline __attribute__((always_inline))

/* Lanes of one register, and columns of a tile: two registers of each, with room for operands. */
#if defined(__AVX512F__)
enum { LANES = 16 };
#elif defined(__AVX2__)
enum { LANES = 8 };
#else
enum { LANES = 4 };
#endif
enum { TILE_COLUMNS = 6, BLOCK_COLUMNS = 12 };

typedef float lanes __attribute__((vector_size(4 * LANES)));

FRONT_INLINE lanes load(const float *from) {
    lanes a;
    memcpy(&a, from, sizeof a);
    return a;
}
FRONT_INLINE void store(float *to, lanes a) { memcpy(to, &a, sizeof a); }

/* c -= sum over `depth` columns of a b^T: a is `vectors` registers of rows, b `columns` numbers. */
FRONT_INLINE void subtract_tile(const float *a, const float *b, size_t stride, size_t depth,
                                float *c, size_t c_stride, const size_t vectors,
                                const size_t columns) {
    lanes sum[TILE_COLUMNS][2] = {0};
    for (size_t k = 0; k < depth; k++, a += stride, b += stride) {
        lanes const low = load(a), high = vectors > 1 ? load(a + LANES) : low;
#pragma GCC unroll 6
        for (size_t j = 0; j < columns; j++) {
            sum[j][0] += low * b[j];
            if (vectors > 1) sum[j][1] += high * b[j];
        }
    }
#pragma GCC unroll 6
    for (size_t j = 0; j < columns; j++) {
        store(c + j * c_stride, load(c + j * c_stride) - sum[j][0]);
        if (vectors > 1)
            store(c + j * c_stride + LANES, load(c + j * c_stride + LANES) - sum[j][1]);
    }
}

/* The same for all rows of a tile's columns: `rows` is a multiple of FRONT_ROWS. */
FRONT_INLINE void subtract_rows(const float *a, const float *b, size_t stride, size_t depth,
                                float *c, size_t c_stride, size_t rows, const size_t columns) {
    size_t row = 0;
    for (; row + 2 * LANES <= rows; row += 2 * LANES)
        subtract_tile(a + row, b, stride, depth, c + row, c_stride, 2, columns);
    if (row < rows) subtract_tile(a + row, b, stride, depth, c + row, c_stride, 1, columns);
}

/* Lower triangle of the update. */
FRONT_INLINE void subtract_square(const front_panel *front, float *update) {
    const float *const below = front->columns + front->own;
    size_t const rows = front_round_up(front->others);
    for (size_t j = 0; j < front->others; j += TILE_COLUMNS) {
        size_t const top = j / FRONT_ROWS * FRONT_ROWS;
        float *const c = update + j * rows + top;
        if (j + TILE_COLUMNS <= front->others)
            subtract_rows(below + top, below + j, front->stride, front->own, c, rows, rows - top,
                          TILE_COLUMNS);
        else
            subtract_rows(below + top, below + j, front->stride, front->own, c, rows, rows - top,
                          3);
    }
}

/* Factors the block on the diagonal, and leaves it in `block`, column by column, with the inverses
 * of its diagonal. */
FRONT_INLINE uint32_t factor_block(const front_panel *front, size_t first, const size_t columns,
                                   const float *floors, float block[BLOCK_COLUMNS][BLOCK_COLUMNS]) {
    uint32_t raised = 0;
    for (size_t j = 0; j < columns; j++)
        for (size_t i = j; i < columns; i++)
            block[j][i] = front->columns[(first + j) * front->stride + first + i];
    for (size_t j = 0; j < columns; j++) {
        float pivot = block[j][j];
        if (!(pivot >= floors[first + j])) pivot = floors[first + j], raised++;
        float const inverse = 1.0F / sqrtf(pivot);
        block[j][j] = inverse;
        for (size_t i = j + 1; i < columns; i++) block[j][i] *= inverse;
        for (size_t k = j + 1; k < columns; k++)
            for (size_t i = k; i < columns; i++) block[k][i] -= block[j][i] * block[j][k];
    }
    return raised;
}

/* Rows below the block times the inverse of its transpose; rows beside it become what they will.
 * Each row's column waits for those before it, but all later columns are updated at once. */
FRONT_INLINE void divide_rows(const front_panel *front, size_t first, const size_t columns,
                              float block[BLOCK_COLUMNS][BLOCK_COLUMNS]) {
    float *const c = front->columns + first * front->stride;
    for (size_t row = first / FRONT_ROWS * FRONT_ROWS; row < front->stride; row += LANES) {
        lanes x[BLOCK_COLUMNS];
#pragma GCC unroll 12
        for (size_t j = 0; j < columns; j++) x[j] = load(c + j * front->stride + row);
#pragma GCC unroll 12
        for (size_t j = 0; j < columns; j++) {
            x[j] *= block[j][j];
            store(c + j * front->stride + row, x[j]);
#pragma GCC unroll 12
            for (size_t k = j + 1; k < columns; k++) x[k] -= x[j] * block[j][k];
        }
    }
    for (size_t j = 0; j < columns; j++)
        for (size_t i = j; i < columns; i++) c[j * front->stride + first + i] = block[j][i];
}

/* One block of columns, `columns` of them. */
FRONT_INLINE uint32_t factor_columns(const front_panel *front, size_t first, const size_t columns,
                                     const float *floors) {
    size_t const top = first / FRONT_ROWS * FRONT_ROWS;
    const float *const a = front->columns + top;
    float *const c = front->columns + first * front->stride + top;
    size_t const rows = front->stride - top;
    for (size_t j = 0; j < columns && first > 0; j += TILE_COLUMNS) {
        const float *const b = front->columns + first + j;
        if (j + TILE_COLUMNS <= columns)
            subtract_rows(a, b, front->stride, first, c + j * front->stride, front->stride, rows,
                          TILE_COLUMNS);
        else
            subtract_rows(a, b, front->stride, first, c + j * front->stride, front->stride, rows,
                          3);
    }
    float block[BLOCK_COLUMNS][BLOCK_COLUMNS];
    uint32_t const raised = factor_block(front, first, columns, floors, block);
    divide_rows(front, first, columns, block);
    return raised;
}

uint32_t TULLE_KERNEL(factor_front)(const front_panel *front, const float *floors, float *update) {
    uint32_t raised = 0;
    size_t first = 0;
    for (; first + BLOCK_COLUMNS <= front->own; first += BLOCK_COLUMNS)
        raised += factor_columns(front, first, BLOCK_COLUMNS, floors);
    switch (front->own - first) {
    case 9: raised += factor_columns(front, first, 9, floors); break;
    case 6: raised += factor_columns(front, first, 6, floors); break;
    case 3: raised += factor_columns(front, first, 3, floors); break;
    default: break;
    }
    if (front->others > 0) subtract_square(front, update);
    return raised;
}

/* ---- solves ---- */

enum { SOLVE_COLUMNS = 6 };

/* Columns first .. first + columns of a solve with L. */
FRONT_INLINE void solve_columns_down(const front_panel *front, size_t first, const size_t columns,
                                     float *x) {
    const float *const c = front->columns + first * front->stride;
    for (size_t j = 0; j < columns; j++) {
        x[first + j] *= c[j * front->stride + first + j];
        for (size_t i = j + 1; i < columns; i++)
            x[first + i] -= c[j * front->stride + first + i] * x[first + j];
    }
    float done[SOLVE_COLUMNS];
    memcpy(done, x + first, columns * sizeof(float));
    for (size_t row = first / FRONT_ROWS * FRONT_ROWS; row < front->stride; row += LANES) {
        lanes sum = load(c + row) * done[0];
#pragma GCC unroll 6
        for (size_t j = 1; j < columns; j++) sum += load(c + j * front->stride + row) * done[j];
        store(x + row, load(x + row) - sum);
    }
    memcpy(x + first, done, columns * sizeof(float));
}

void TULLE_KERNEL(solve_front_down)(const front_panel *front, float *x) {
    float kept[FRONT_ROWS];
    for (size_t first = 0; first < front->own; first += SOLVE_COLUMNS) {
        /* The vectors begin above the block: what is solved there already is put back. */
        size_t const top = first / FRONT_ROWS * FRONT_ROWS;
        memcpy(kept, x + top, (first - top) * sizeof(float));
        if (first + SOLVE_COLUMNS <= front->own)
            solve_columns_down(front, first, SOLVE_COLUMNS, x);
        else
            solve_columns_down(front, first, 3, x);
        memcpy(x + top, kept, (first - top) * sizeof(float));
    }
}

/* The lanes' sum, in an order that does not depend on their number in a register. */
FRONT_INLINE float add_lanes(const float sums[FRONT_ROWS]) {
    float half[8];
    for (size_t l = 0; l < 8; l++) half[l] = sums[l] + sums[l + 8];
    return ((half[0] + half[4]) + (half[2] + half[6])) +
           ((half[1] + half[5]) + (half[3] + half[7]));
}

/* Sums of x times each of `columns` columns, over rows from `row` on. */
FRONT_INLINE void dot_columns(const front_panel *front, size_t first, size_t row, const float *x,
                              const size_t columns, float *dots) {
    enum { PARTS = FRONT_ROWS / LANES };
    const float *const c = front->columns + first * front->stride;
    lanes sum[3][PARTS] = {0};
    for (; row < front->stride; row += FRONT_ROWS)
#pragma GCC unroll 4
        for (size_t p = 0; p < PARTS; p++) {
            lanes const known = load(x + row + p * LANES);
#pragma GCC unroll 3
            for (size_t j = 0; j < columns; j++)
                sum[j][p] += load(c + j * front->stride + row + p * LANES) * known;
        }
    for (size_t j = 0; j < columns; j++) {
        float sums[FRONT_ROWS];
        memcpy(sums, sum[j], sizeof sums);
        dots[j] = add_lanes(sums);
    }
}

/* Three columns, from the last on. Rows up to the next multiple of FRONT_ROWS come one by one. */
void TULLE_KERNEL(solve_front_up)(const front_panel *front, float *x) {
    for (size_t first = front->own; first > 0;) {
        first -= 3;
        const float *const c = front->columns + first * front->stride;
        size_t const whole = front_round_up(first + 3);
        float dots[3];
        dot_columns(front, first, whole, x, 3, dots);
        for (size_t i = first + 3; i < whole && i < front->stride; i++)
            for (size_t j = 0; j < 3; j++) dots[j] += c[j * front->stride + i] * x[i];
        for (size_t j = 3; j-- > 0;) {
            float value = x[first + j] - dots[j];
            for (size_t i = j + 1; i < 3; i++)
                value -= c[j * front->stride + first + i] * x[first + i];
            x[first + j] = value * c[j * front->stride + first + j];
        }
    }
}

/* ---- updates ---- */

void TULLE_KERNEL(add_front_patch)(const front_patch *patch) {
    for (size_t j = 0; j < patch->columns; j++) {
        const float *const from = patch->from + j * patch->from_stride;
        float *const to = patch->to + j * patch->to_stride;
        size_t row = patch->is_lower ? j : 0;
        for (; row + LANES <= patch->rows; row += LANES)
            store(to + row, load(to + row) + load(from + row));
        for (; row < patch->rows; row++) to[row] += from[row];
    }
}
