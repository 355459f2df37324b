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

/* ---- how the diagonals of the matrix go through the grid ---- */

/* Between columns of one row only what is right of the main diagonal is there, for what is left of
 * it, too. */
static void find_target(const grid_diagonal *diagonal, size_t from, size_t to, size_t *place,
                        double *times) {
    bool const is_next = from <= to + 1 && to <= from + 1;
    *place = 0;
    *times = is_next ? 1.0 : 0.0;
    if (!is_next) return;
    if (diagonal->down > 0) {
        *place = grid_fill_get_place(from, diagonal->down, to + 1 - from);
    } else if (from == to) {
        *place = grid_fill_get_place(from, 0, 1);
        *times = diagonal->step == 0 ? 1.0 : 2.0;
    } else {
        *place = grid_fill_get_place(from < to ? from : to, 0, 2);
        if (from > to && diagonal->step == 0) *times = 0.0;
    }
}

/* Whether lines have a part in the lower (0) or the upper one (1) of their blocks. */
static bool have_part(const grid_axis *axis, size_t begin, size_t end, size_t which) {
    for (size_t line = begin; line < end; line++)
        if ((which == 0 ? axis->share[line] : 1.0F - axis->share[line]) != 0.0F) return true;
    return false;
}

static void add_run(const grid_axis *columns, size_t begin, size_t end, grid_diagonal *diagonal) {
    grid_run *const run = &diagonal->runs[diagonal->run_count++];
    size_t const to = begin + (size_t)diagonal->step, to_end = end + (size_t)diagonal->step;
    run->begin = begin;
    run->end = end;
    for (size_t i = 0; i < 4; i++) {
        find_target(diagonal, columns->lower[begin] + i / 2, columns->lower[to] + i % 2,
                    &run->places[i], &run->times[i]);
        if (have_part(columns, begin, end, i / 2) && have_part(columns, to, to_end, i % 2))
            continue;
        run->places[i] = 0;
        run->times[i] = 0.0;
    }
}

/* A diagonal that has such an offset, with room for its runs and weights. */
static void follow_diagonal(const grid_axis *columns, size_t offset, grid_diagonal *diagonal) {
    /* none goes more than GRID_REACH columns to the left */
    diagonal->down = (offset + GRID_REACH) / columns->count;
    diagonal->step = (int)offset - (int)(diagonal->down * columns->count);
    size_t const step = (size_t)diagonal->step;
    size_t const first = diagonal->step < 0 ? (size_t)-diagonal->step : 0;
    size_t const last = columns->count - (diagonal->step > 0 ? step : 0);
    for (size_t c = first; c < last; c++)
        for (size_t i = 0; i < 4; i++) {
            double const from = (double)columns->share[c], to = (double)columns->share[c + step];
            diagonal->weights[4 * c + i] =
                (i / 2 == 0 ? from : 1.0 - from) * (i % 2 == 0 ? to : 1.0 - to);
        }
    for (size_t begin = first, end; begin < last; begin = end) {
        end = begin + 1;
        while (end < last && columns->lower[end] == columns->lower[begin] &&
               columns->lower[end + step] == columns->lower[begin + step])
            end++;
        add_run(columns, begin, end, diagonal);
    }
}

/* False: no memory. */
static bool follow_diagonals(const grid_axis *columns, const matrix_diagonals *pattern,
                             arena *scratch, grid_diagonal *diagonals) {
    for (size_t d = 0; d < pattern->count; d++) {
        diagonals[d] = (grid_diagonal){.has_blocks = d < pattern->block_count,
                                       .runs = ARENA_NEW(scratch, grid_run, columns->count),
                                       .weights = ARENA_NEW(scratch, double, 4 * columns->count)};
        if (!diagonals[d].runs || !diagonals[d].weights) return false;
        follow_diagonal(columns, pattern->offsets[d], &diagonals[d]);
    }
    return true;
}

bool grid_transfer_sum(const grid_transfer *grid, const grid_fill_source *source, int threads,
                       arena *scratch, double *sums) {
    arena_mark const mark = arena_get_mark(scratch);
    const matrix_diagonals *const pattern = &source->matrix->diagonals;
    grid_diagonal diagonals[DIAGONALS_MAX];
    size_t const workers = threads > 1 ? (size_t)threads : 1;
    sum_task task = {.fill = {&grid->rows, &grid->columns, source, diagonals, sums},
                     .room_size = grid_fill_get_room(&grid->columns, pattern->count)};
    task.rooms = ARENA_NEW(scratch, double, task.room_size *workers);
    bool const has_memory =
        task.rooms && follow_diagonals(&grid->columns, pattern, scratch, diagonals);
    if (has_memory) parallel_for(grid->rows.block_count, ROWS_PER_BAND, threads, sum_band, &task);
    arena_release(scratch, mark);
    return has_memory;
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
    bool is_joined_up = true;
    for (size_t i = 0; i < blocks.count; i++)
        for (size_t j = 0; j < blocks.count; j++)
            is_joined_up &=
                !is_before(&blocks, i, j) || find_diagonal(&blocks, i, j) < GRID_DIAGONALS;
    for (size_t i = 0; i < blocks.count; i++)
        for (size_t j = 0; j < blocks.count; j++) {
            if (!is_before(&blocks, i, j) || (!is_joined_up && i != j)) continue;
            size_t const block = blocks.rows[i] * grid->columns.block_count + blocks.columns[i];
            double *const to =
                sums + GRID_BLOCK * (GRID_DIAGONALS * block + find_diagonal(&blocks, i, j));
            double const weight = blocks.weights[i] * blocks.weights[j];
            for (size_t n = 0; n < BLOCK_NUMBERS; n++) to[n] += weight * stiffness[n];
        }
}
