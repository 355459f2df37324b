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

/* A product that is to be subtracted: c -= sum over `depth` columns of a b^T. */
typedef struct front_product {
    const float *a, *b;
    size_t stride, depth; /* of a and of b */
    float *c;
    size_t c_stride;
} front_product;

/* `vectors` registers of rows from `row` on, and `columns` numbers of b. */
FRONT_INLINE void subtract_tile(front_product product, size_t row, const size_t vectors,
                                const size_t columns) {
    const float *a = product.a + row, *b = product.b;
    float *const c = product.c + row;
    size_t const c_stride = product.c_stride;
    lanes sum[TILE_COLUMNS][2] = {0};
    for (size_t k = 0; k < product.depth; k++, a += product.stride, b += product.stride) {
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
FRONT_INLINE void subtract_rows(front_product product, size_t rows, const size_t columns) {
    size_t row = 0;
    for (; row + 2 * LANES <= rows; row += 2 * LANES) subtract_tile(product, row, 2, columns);
    if (row < rows) subtract_tile(product, row, 1, columns);
}

/* Lower triangle of the update. */
FRONT_INLINE void subtract_square(const front_panel *front, float *update) {
    const float *const below = front->columns + front->own;
    size_t const rows = front_round_up(front->others);
    for (size_t j = 0; j < front->others; j += TILE_COLUMNS) {
        size_t const top = j / FRONT_ROWS * FRONT_ROWS;
        front_product const product = {
            below + top, below + j, front->stride, front->own, update + j * rows + top, rows};
        if (j + TILE_COLUMNS <= front->others)
            subtract_rows(product, rows - top, TILE_COLUMNS);
        else
            subtract_rows(product, rows - top, 3);
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
        front_product const product = {a,     front->columns + first + j, front->stride,
                                       first, c + j * front->stride,      front->stride};
        if (j + TILE_COLUMNS <= columns)
            subtract_rows(product, rows, TILE_COLUMNS);
        else
            subtract_rows(product, rows, 3);
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

/* ---- kept fronts ---- */

typedef float lanes4 __attribute__((vector_size(16)));
typedef float lanes16 __attribute__((vector_size(64)));
typedef int32_t integers16 __attribute__((vector_size(64)));
typedef int16_t shorts16 __attribute__((vector_size(32)));

FRONT_INLINE lanes16 load16(const float *from) {
    lanes16 a;
    memcpy(&a, from, sizeof a);
    return a;
}
FRONT_INLINE void store16(float *to, lanes16 a) { memcpy(to, &a, sizeof a); }
FRONT_INLINE lanes16 unpack16(const int16_t *from) {
    shorts16 a;
    memcpy(&a, from, sizeof a);
    return __builtin_convertvector(__builtin_convertvector(a, integers16), lanes16);
}

/* Bits of a magnitude: they are in the order of the magnitudes. */
FRONT_INLINE int32_t get_magnitude(float a) {
    int32_t bits;
    memcpy(&bits, &a, sizeof bits);
    return bits & INT32_MAX;
}

/* Largest magnitude of a column below the diagonal. */
FRONT_INLINE float find_largest(const front_panel *front, size_t column) {
    const float *const c = front->columns + column * front->stride;
    size_t const whole = front_round_up(column + 1);
    integers16 most = {0};
    for (size_t i = column + 1; i < whole; i++)
        if (get_magnitude(c[i]) > most[0]) most[0] = get_magnitude(c[i]);
    for (size_t i = whole; i < front->stride; i += FRONT_ROWS) {
        integers16 const bits = (integers16)load16(c + i) & INT32_MAX;
        integers16 const more = bits > most;
        most = (bits & more) | (most & ~more);
    }
    int32_t largest = 0;
    for (size_t l = 0; l < FRONT_ROWS; l++) largest = most[l] > largest ? most[l] : largest;
    float result;
    memcpy(&result, &largest, sizeof result);
    return result;
}

/* Numbers times `scale`, rounded, half away from zero. */
FRONT_INLINE void pack16(int16_t *to, const float *from, float scale) {
    lanes16 const value = load16(from) * scale;
    integers16 const sign = (integers16)value & INT32_MIN;
    lanes16 const half = (lanes16)(sign | (integers16)((lanes16){0} + 0.5F));
    integers16 const rounded = __builtin_convertvector(value + half, integers16);
    shorts16 const packed = __builtin_convertvector(rounded, shorts16);
    memcpy(to, &packed, sizeof packed);
}

void TULLE_KERNEL(pack_front)(const front_panel *front, const packed_front *packed) {
    for (size_t j = 0; j < front->own; j++) {
        float *const c = front->columns + j * front->stride;
        int16_t *const to = packed->columns + j * front->stride;
        float const largest = find_largest(front, j);
        bool const is_usual = largest > 1e-30F && largest < 1e30F;
        float const scale = is_usual ? 32767.0F / largest : 0.0F;
        packed->scales[j] = is_usual ? largest / 32767.0F : 0.0F;
        packed->inverses[j] = c[j];
        size_t const top = j / FRONT_ROWS * FRONT_ROWS;
        for (size_t i = top; i <= j; i++) c[i] = 0.0F;
        memset(to, 0, (is_usual ? top : front->stride) * sizeof(int16_t));
        for (size_t i = top; is_usual && i < front->stride; i += FRONT_ROWS)
            pack16(to + i, c + i, scale);
    }
}

/* ---- solves ---- */

enum { SOLVE_COLUMNS = 6 };

/* Columns first .. first + columns of a solve with L. */
FRONT_INLINE void solve_columns_down(const packed_front *front, size_t first, const size_t columns,
                                     float *x) {
    const int16_t *const c = front->columns + first * front->stride;
    float done[SOLVE_COLUMNS], scaled[SOLVE_COLUMNS];
    for (size_t j = 0; j < columns; j++) {
        done[j] = x[first + j] * front->inverses[first + j];
        scaled[j] = done[j] * front->scales[first + j];
        for (size_t i = j + 1; i < columns; i++)
            x[first + i] -= (float)c[j * front->stride + first + i] * scaled[j];
    }
    for (size_t row = first / FRONT_ROWS * FRONT_ROWS; row < front->stride; row += FRONT_ROWS) {
        lanes16 sum = unpack16(c + row) * scaled[0];
#pragma GCC unroll 6
        for (size_t j = 1; j < columns; j++)
            sum += unpack16(c + j * front->stride + row) * scaled[j];
        store16(x + row, load16(x + row) - sum);
    }
    memcpy(x + first, done, columns * sizeof(float));
}

void TULLE_KERNEL(solve_front_down)(const packed_front *front, float *x) {
    for (size_t first = 0; first < front->own; first += SOLVE_COLUMNS) {
        if (first + SOLVE_COLUMNS <= front->own)
            solve_columns_down(front, first, SOLVE_COLUMNS, x);
        else
            solve_columns_down(front, first, 3, x);
    }
}

/* The lanes' sum, by halves. */
FRONT_INLINE float add_lanes(lanes16 a) {
    typedef float lanes8 __attribute__((vector_size(32)));
    lanes8 const b = __builtin_shufflevector(a, a, 0, 1, 2, 3, 4, 5, 6, 7) +
                     __builtin_shufflevector(a, a, 8, 9, 10, 11, 12, 13, 14, 15);
    lanes4 const c =
        __builtin_shufflevector(b, b, 0, 1, 2, 3) + __builtin_shufflevector(b, b, 4, 5, 6, 7);
    return (c[0] + c[2]) + (c[1] + c[3]);
}

/* Three columns at a time, from the last on. Their own numbers are zero while the others are summed
 * up: vectors begin above them. */
void TULLE_KERNEL(solve_front_up)(const packed_front *front, float *x) {
    for (size_t first = front->own; first > 0;) {
        first -= 3;
        const int16_t *const c = front->columns + first * front->stride;
        float own[3];
        memcpy(own, x + first, sizeof own);
        memset(x + first, 0, sizeof own);
        lanes16 sum0 = {0}, sum1 = {0}, sum2 = {0};
        for (size_t row = first / FRONT_ROWS * FRONT_ROWS; row < front->stride; row += FRONT_ROWS) {
            lanes16 const known = load16(x + row);
            sum0 += unpack16(c + row) * known;
            sum1 += unpack16(c + front->stride + row) * known;
            sum2 += unpack16(c + 2 * front->stride + row) * known;
        }
        float dots[3] = {add_lanes(sum0), add_lanes(sum1), add_lanes(sum2)};
        for (size_t j = 3; j-- > 0;) {
            for (size_t i = j + 1; i < 3; i++)
                dots[j] += (float)c[j * front->stride + first + i] * own[i];
            own[j] = (own[j] - dots[j] * front->scales[first + j]) * front->inverses[first + j];
        }
        memcpy(x + first, own, sizeof own);
    }
}

/* ---- updates ---- */

FRONT_INLINE void add_numbers(const float *from, float *to, size_t count) {
    size_t i = 0;
    for (; i + LANES <= count; i += LANES) store(to + i, load(to + i) + load(from + i));
    for (; i + 4 <= count; i += 4) {
        lanes4 a, b;
        memcpy(&a, from + i, sizeof a);
        memcpy(&b, to + i, sizeof b);
        b += a;
        memcpy(to + i, &b, sizeof b);
    }
    for (; i < count; i++) to[i] += from[i];
}

void TULLE_KERNEL(add_update)(const update_sum *sum) {
    size_t const own = sum->panel.own, update_stride = front_round_up(sum->panel.others);
    for (size_t c = 0; c < sum->run_count; c++) {
        front_run const run = sum->runs[c];
        for (size_t j = 0; j < 3 * (size_t)run.count; j++) {
            size_t const column = 3 * (size_t)run.to + j;
            const float *const from = sum->from + (3 * (size_t)run.from + j) * sum->from_stride;
            float *const to = column < own ? sum->panel.columns + column * sum->panel.stride
                                           : sum->update + (column - own) * update_stride - own;
            add_numbers(from + 3 * (size_t)run.from + j, to + column, 3 * (size_t)run.count - j);
            for (size_t r = c + 1; r < sum->run_count; r++)
                add_numbers(from + 3 * (size_t)sum->runs[r].from, to + 3 * (size_t)sum->runs[r].to,
                            3 * (size_t)sum->runs[r].count);
        }
    }
}
