/* math/grid_transfer_fill.c - P^T A P of a grid's blocks, see grid_transfer.h. */
#include "math/grid_fill.h"

#include "base/parallel.h"

/* Rows of blocks that one thread adds up; it needs rows of the matrix of the blocks beside, too. */
enum { ROWS_PER_BAND = 6 };

/* ---- the matrix ---- */

typedef struct sum_task {
    grid_fill fill;
    double *rooms; /* of each thread */
    size_t room_size;
} sum_task;

static void sum_band(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    const sum_task *const task = context;
    TULLE_PICK_KERNEL(grid_sum_band)
    (&task->fill, begin, end, task->rooms + task->room_size * (size_t)worker);
}

bool grid_transfer_sum(const grid_transfer *grid, const grid_fill_source *source, int threads,
                       arena *scratch, double *sums) {
    arena_mark const mark = arena_get_mark(scratch);
    size_t const workers = threads > 1 ? (size_t)threads : 1;
    sum_task task = {.fill = {grid, source, sums}, .room_size = grid_fill_get_room(grid)};
    task.rooms = ARENA_NEW(scratch, double, task.room_size *workers);
    if (task.rooms) parallel_for(grid->rows.block_count, ROWS_PER_BAND, threads, sum_band, &task);
    arena_release(scratch, mark);
    return task.rooms != NULL;
}

/* ---- terms ---- */

/* Blocks that a term joins, with its weights. */
typedef struct term_blocks {
    size_t count;
    size_t rows[16], columns[16];
    double weights[16];
} term_blocks;

static void add_weight(term_blocks *blocks, size_t row, size_t column, double weight) {
    if (weight == 0.0) return;
    size_t k = 0;
    while (k < blocks->count && (blocks->rows[k] != row || blocks->columns[k] != column)) k++;
    if (k == blocks->count) {
        blocks->rows[k] = row;
        blocks->columns[k] = column;
        blocks->weights[k] = 0.0;
        blocks->count++;
    }
    blocks->weights[k] += weight;
}

static void find_blocks(const grid_transfer *grid, const matrix_term *term, const uint8_t *is_fixed,
                        term_blocks *blocks) {
    blocks->count = 0;
    for (size_t k = 0; k < 4; k++) {
        uint32_t const vertex = term->vertices[k];
        if (vertex == TULLE_NONE || is_fixed[vertex]) continue;
        size_t const row = vertex / grid->columns.count, column = vertex % grid->columns.count;
        size_t const r = grid->rows.lower[row], c = grid->columns.lower[column];
        double const row_share = (double)grid->rows.share[row];
        double const column_share = (double)grid->columns.share[column];
        double const lower = term->weights[k] * row_share, upper = term->weights[k] - lower;
        add_weight(blocks, r, c, lower * column_share);
        add_weight(blocks, r, c + 1, lower - lower * column_share);
        add_weight(blocks, r + 1, c, upper * column_share);
        add_weight(blocks, r + 1, c + 1, upper - upper * column_share);
    }
}

/* The diagonal of the entry between two blocks, of which the second follows the first in the order
 * of blocks; GRID_DIAGONALS where they are not next to each other. */
static size_t find_diagonal(const term_blocks *blocks, size_t i, size_t j) {
    size_t const down = blocks->rows[j] - blocks->rows[i];
    size_t const way = blocks->columns[j] + 1 - blocks->columns[i];
    if (down > 1 || way > 2) return GRID_DIAGONALS;
    return down == 0 ? way - 1 : way + 2;
}

static bool is_before(const term_blocks *blocks, size_t i, size_t j) {
    return blocks->rows[i] < blocks->rows[j] ||
           (blocks->rows[i] == blocks->rows[j] && blocks->columns[i] <= blocks->columns[j]);
}

void grid_transfer_add_term(const grid_transfer *grid, const matrix_term *term,
                            const uint8_t *is_fixed, double *sums) {
    term_blocks blocks;
    find_blocks(grid, term, is_fixed, &blocks);
    double stiffness[BLOCK_NUMBERS];
    for (size_t n = 0; n < BLOCK_NUMBERS; n++) stiffness[n] = term->stiffness.m[block_places[n]];
    bool are_neighbours = true;
    for (size_t i = 0; i < blocks.count; i++)
        for (size_t j = 0; j < blocks.count; j++)
            are_neighbours &=
                !is_before(&blocks, i, j) || find_diagonal(&blocks, i, j) < GRID_DIAGONALS;
    for (size_t i = 0; i < blocks.count; i++)
        for (size_t j = 0; j < blocks.count; j++) {
            if (!is_before(&blocks, i, j) || (!are_neighbours && i != j)) continue;
            size_t const block = blocks.rows[i] * grid->columns.block_count + blocks.columns[i];
            double *const to =
                sums + GRID_BLOCK * (GRID_DIAGONALS * block + find_diagonal(&blocks, i, j));
            double const weight = blocks.weights[i] * blocks.weights[j];
            for (size_t n = 0; n < BLOCK_NUMBERS; n++) to[n] += weight * stiffness[n];
        }
}
