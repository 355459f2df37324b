/* math/kernels/grid_fill.c - see grid_fill.h.
 *
 * Each row of the grid is summed over its columns first: what joins it to itself, to the next row
 * and to the one after, by columns of blocks. Then that goes to the rows of blocks that the two
 * rows have parts of. Entries above the main diagonal serve for those below. */
#include "math/grid_fill.h"

#include <string.h>

typedef double block8 __attribute__((vector_size(64)));
typedef double lanes4 __attribute__((vector_size(32)));

/* Six numbers and two more that are ignored. */
static inline block8 load_block(const double *from) {
    block8 a;
    memcpy(&a, from, sizeof a);
    return a;
}
static inline void add_block(double *to, block8 a) {
    a += load_block(to);
    memcpy(to, &a, sizeof a);
}

typedef struct row_band {
    const grid_fill *fill;
    size_t begin, end;        /* rows of blocks */
    size_t row;               /* of the grid */
    double *blocks, *scalars; /* of that row, by column of blocks */
    uint32_t *entries;        /* of that row: on each diagonal, for each column */
} row_band;

/* ---- along a row ---- */

/* Weights of the pairs. */
static inline lanes4 load_weights(const grid_diagonal *diagonal, size_t column) {
    lanes4 weights;
    memcpy(&weights, diagonal->weights + 4 * column, sizeof weights);
    return weights;
}

static block8 load_entry(const row_band *band, size_t d, size_t column) {
    const grid_diagonal *const diagonal = &band->fill->grid->diagonals[d];
    const block_matrix *const matrix = band->fill->source->matrix;
    size_t const width = band->fill->grid->columns.count;
    uint32_t const entry = band->entries[2 * d * width + column];
    uint32_t const scalar_entry = band->entries[(2 * d + 1) * width + column];
    block8 block = {0.0};
    if (diagonal->has_blocks && entry != TULLE_NONE)
        block = load_block(matrix->values + BLOCK_NUMBERS * (size_t)entry);
    if (scalar_entry == TULLE_NONE) return block;
    double const scalar = block_matrix_get_scalar(matrix, scalar_entry);
    block8 const identity = {scalar, 0.0, 0.0, scalar, 0.0, scalar};
    return block + identity;
}

static void sum_blocks(const row_band *band, size_t d) {
    const grid_diagonal *const diagonal = &band->fill->grid->diagonals[d];
    for (size_t r = 0; r < diagonal->run_count; r++) {
        const grid_run *const run = &diagonal->runs[r];
        block8 sums[4] = {{0.0}, {0.0}, {0.0}, {0.0}};
        for (size_t c = run->begin; c < run->end; c++) {
            block8 const entry = load_entry(band, d, c);
            lanes4 const weights = load_weights(diagonal, c);
            for (size_t i = 0; i < 4; i++) sums[i] += entry * weights[i];
        }
        for (size_t i = 0; i < 4; i++)
            if (run->times[i] != 0.0)
                add_block(band->blocks + GRID_BLOCK * run->places[i], sums[i] * run->times[i]);
    }
}

static void sum_scalars(const row_band *band, size_t d) {
    const grid_diagonal *const diagonal = &band->fill->grid->diagonals[d];
    const block_matrix *const matrix = band->fill->source->matrix;
    const uint32_t *const entries = band->entries + (2 * d + 1) * band->fill->grid->columns.count;
    for (size_t r = 0; r < diagonal->run_count; r++) {
        const grid_run *const run = &diagonal->runs[r];
        lanes4 sums = {0.0};
        for (size_t c = run->begin; c < run->end; c++)
            if (entries[c] != TULLE_NONE)
                sums += block_matrix_get_scalar(matrix, entries[c]) * load_weights(diagonal, c);
        for (size_t i = 0; i < 4; i++)
            if (run->times[i] != 0.0) band->scalars[run->places[i]] += sums[i] * run->times[i];
    }
}

/* Lists the entries of a row of the grid by diagonals, blocks and scalars in turn; those of fixed
 * vertices are none. */
static void list_entries(const row_band *band) {
    const grid_fill_source *const source = band->fill->source;
    const block_matrix *const matrix = source->matrix;
    const matrix_diagonals *const diagonals = &matrix->diagonals;
    size_t const width = band->fill->grid->columns.count;
    memset(band->entries, 0xff, 2 * diagonals->count * width * sizeof(uint32_t));
    for (size_t c = 0; c < width; c++) {
        size_t const v = band->row * width + c;
        if (source->is_fixed[v]) continue;
        for (uint32_t k = matrix->diagonal_positions[v]; k < matrix->row_begin[v + 1]; k++)
            if (!source->is_fixed[matrix->columns[k]])
                band->entries[2 * diagonals->of_blocks[k] * width + c] = k;
        uint32_t k = matrix->scalar_begin[v];
        uint32_t const end = matrix->scalar_begin[v + 1];
        while (k < end && matrix->scalar_columns[k] < v) k++;
        for (; k < end; k++)
            if (!source->is_fixed[matrix->scalar_columns[k]])
                band->entries[(2 * (size_t)diagonals->of_scalars[k] + 1) * width + c] = k;
    }
}

static void sum_row(const row_band *band) {
    const grid_fill *const fill = band->fill;
    size_t const count = GRID_ROWS_DOWN * GRID_WAYS * fill->grid->columns.block_count;
    memset(band->blocks, 0, GRID_BLOCK * count * sizeof(double));
    memset(band->scalars, 0, count * sizeof(double));
    list_entries(band);
    for (size_t d = 0; d < fill->source->matrix->diagonals.count; d++)
        if (fill->grid->diagonals[d].has_blocks)
            sum_blocks(band, d);
        else
            sum_scalars(band, d);
    for (size_t i = 0; i < count; i++) {
        double const sum = band->scalars[i];
        block8 const identity = {sum, 0.0, 0.0, sum, 0.0, sum};
        add_block(band->blocks + GRID_BLOCK * i, identity);
    }
}

/* ---- to rows of blocks ---- */

static double get_row_part(const grid_axis *rows, size_t row, size_t block) {
    return grid_axis_has_part(rows, row, block) ? grid_axis_get_part(rows, row, block) : 0.0;
}

/* The sum from a column of blocks to the one that lies `way` from it. */
static inline block8 load_sum(const row_band *from, size_t column, size_t down, size_t way) {
    return load_block(from->blocks + GRID_BLOCK * grid_transfer_get_place(column, down, way));
}

/* Entries between a row of blocks and itself. */
static void add_to_own(const row_band *from, size_t block_row, size_t down, double part) {
    size_t const columns = from->fill->grid->columns.block_count;
    double *to = from->fill->sums + GRID_BLOCK * GRID_DIAGONALS * columns * block_row;
    /* Entries between two rows count once for each direction. */
    double const twice = down == 0 ? part : 2.0 * part;
    for (size_t b = 0; b < columns; b++, to += GRID_BLOCK * GRID_DIAGONALS) {
        add_block(to, load_sum(from, b, down, 1) * twice);
        if (b + 1 == columns) continue;
        block8 sum = load_sum(from, b, down, 2) * part;
        if (down > 0) sum += load_sum(from, b + 1, down, 0) * part;
        add_block(to + GRID_BLOCK, sum);
    }
}

/* Entries between a row of blocks and the next. Parts: of this row of the grid in the first times
 * the one below in the second; the other way round, which is 0 unless the first is not. */
static void add_to_next(const row_band *from, size_t block_row, size_t down,
                        const double parts[2]) {
    size_t const columns = from->fill->grid->columns.block_count;
    double *to = from->fill->sums + GRID_BLOCK * GRID_DIAGONALS * columns * block_row;
    double const part = parts[0], back = down == 0 ? 0.0 : parts[1];
    for (size_t b = 0; b < columns; b++, to += GRID_BLOCK * GRID_DIAGONALS) {
        add_block(to + 3 * (size_t)GRID_BLOCK, load_sum(from, b, down, 1) * (part + back));
        /* of the row itself only the way to the next is there */
        if (b > 0)
            add_block(to + 2 * (size_t)GRID_BLOCK,
                      (down == 0 ? load_sum(from, b - 1, 0, 2) : load_sum(from, b, down, 0)) *
                              part +
                          load_sum(from, b - 1, down, 2) * back);
        if (b + 1 < columns)
            add_block(to + 4 * (size_t)GRID_BLOCK,
                      load_sum(from, b, down, 2) * part + load_sum(from, b + 1, down, 0) * back);
    }
}

static void add_to_rows(const row_band *from) {
    const grid_axis *const rows = &from->fill->grid->rows;
    for (size_t down = 0; down < GRID_ROWS_DOWN && from->row + down < rows->count; down++) {
        size_t const below = from->row + down;
        for (size_t k = rows->lower[from->row]; k <= rows->lower[below] + 1; k++) {
            if (k < from->begin || k >= from->end) continue;
            double const own = get_row_part(rows, from->row, k);
            double const other = get_row_part(rows, below, k);
            double const parts[2] = {own * get_row_part(rows, below, k + 1),
                                     other * get_row_part(rows, from->row, k + 1)};
            if (own * other != 0.0) add_to_own(from, k, down, own * other);
            if (parts[0] != 0.0) add_to_next(from, k, down, parts);
        }
    }
}

void TULLE_KERNEL(grid_sum_band)(const grid_fill *fill, size_t begin, size_t end, double *room) {
    const grid_axis *const rows = &fill->grid->rows;
    size_t const columns = fill->grid->columns.block_count;
    size_t const size = GRID_BLOCK * GRID_DIAGONALS * columns;
    memset(fill->sums + size * begin, 0, size * (end - begin) * sizeof(double));
    size_t const place_count = GRID_ROWS_DOWN * GRID_WAYS * columns;
    row_band band = {.fill = fill,
                     .begin = begin,
                     .end = end,
                     .blocks = room,
                     .scalars = room + GRID_BLOCK * place_count,
                     .entries = (uint32_t *)(void *)(room + (GRID_BLOCK + 1) * place_count)};
    size_t const last = grid_axis_get_lines(rows, end - 1).end;
    for (band.row = grid_axis_get_lines(rows, begin).first; band.row < last; band.row++) {
        sum_row(&band);
        add_to_rows(&band);
    }
}
