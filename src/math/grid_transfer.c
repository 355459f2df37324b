/* math/grid_transfer.c - see grid_transfer.h. */
#include "math/grid_transfer.h"

#include <string.h>

/* Lines in a block, or some more where they do not divide evenly. With as many no entry of the
 * matrix joins a block to one that is not next to it. */
enum { BLOCK_LINES = 4 };
/* With fewer columns a diagonal of the matrix could go two ways through the grid. */
enum { LEAST_COLUMNS = 2 * GRID_REACH + 1 };
/* Lines of the largest block and the two beside it. */
enum { MOST_LINES = 2 * BLOCK_LINES - 1 + 2 };

/* ---- the grid ---- */

/* Vertices of a row: up to the first that is not joined to the next. */
static size_t count_columns(const block_matrix *matrix) {
    uint32_t count = 1;
    while (count < matrix->row_count && block_matrix_find(matrix, count - 1, count) != TULLE_NONE)
        count++;
    return count;
}

static size_t get_distance(size_t a, size_t b) { return a > b ? a - b : b - a; }

/* Whether all entries of a pattern are of vertices that are near. */
static bool are_near(const uint32_t *begin, const uint32_t *columns, size_t row_count,
                     size_t column_count) {
    for (size_t v = 0; v < row_count; v++) {
        size_t const row = v / column_count, column = v % column_count;
        for (uint32_t k = begin[v]; k < begin[v + 1]; k++)
            if (get_distance(columns[k] / column_count, row) > GRID_REACH ||
                get_distance(columns[k] % column_count, column) > GRID_REACH)
                return false;
    }
    return true;
}

/* Whether any vertex of a row is joined to one of the next. */
static bool are_rows_joined(const block_matrix *matrix, size_t row, size_t column_count) {
    size_t const end = (row + 1) * column_count;
    for (size_t v = row * column_count; v < end; v++)
        if (matrix->columns[matrix->row_begin[v + 1] - 1] >= end) return true;
    return false;
}

/* Cuts lines first .. end - 1, which no block leaves, into blocks. */
static void cut_lines(grid_axis *axis, size_t first, size_t end) {
    size_t const count = end - first;
    size_t const block_count = count < 2 * (size_t)BLOCK_LINES ? 1 : count / BLOCK_LINES;
    for (size_t b = 0; b < block_count; b++) {
        size_t const begin = first + count * b / block_count;
        size_t const next = first + count * (b + 1) / block_count;
        size_t const number = axis->block_count++;
        axis->begin[number] = (uint32_t)begin;
        axis->begin[number + 1] = (uint32_t)next;
        for (size_t line = begin; line < next; line++) {
            /* the mean over a line and the ones beside it, of which one may be of another block */
            bool const has_before = line > first, has_after = line + 1 < end;
            float const whole = 1.0F + (float)has_before + (float)has_after;
            bool const is_first = has_before && line == begin;
            bool const is_last = has_after && line + 1 == next;
            axis->lower[line] = (uint32_t)(is_first ? number - 1 : number);
            axis->share[line] = is_first ? 1.0F / whole : is_last ? (whole - 1.0F) / whole : 1.0F;
        }
    }
}

static bool make_axis(memory *heap, size_t count, grid_axis *axis) {
    axis->count = count;
    axis->begin = memory_allocate_zeroed(heap, count + 1, sizeof(uint32_t));
    axis->lower = memory_allocate(heap, count * sizeof(uint32_t));
    axis->share = memory_allocate(heap, count * sizeof(float));
    return axis->begin && axis->lower && axis->share;
}

static void release_axis(memory *heap, const grid_axis *axis) {
    memory_release(heap, axis->begin, (axis->count + 1) * sizeof(uint32_t));
    memory_release(heap, axis->lower, axis->count * sizeof(uint32_t));
    memory_release(heap, axis->share, axis->count * sizeof(float));
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
        *place = grid_transfer_get_place(from, diagonal->down, to + 1 - from);
    } else if (from == to) {
        *place = grid_transfer_get_place(from, 0, 1);
        *times = diagonal->step == 0 ? 1.0 : 2.0;
    } else {
        *place = grid_transfer_get_place(from < to ? from : to, 0, 2);
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

static bool follow_diagonals(memory *heap, const matrix_diagonals *pattern, grid_transfer *grid) {
    size_t const columns = grid->columns.count;
    grid->diagonals = memory_allocate_zeroed(heap, pattern->count, sizeof *grid->diagonals);
    if (!grid->diagonals) return false;
    grid->diagonal_count = pattern->count;
    for (size_t d = 0; d < pattern->count; d++) {
        grid_diagonal *const diagonal = &grid->diagonals[d];
        diagonal->has_blocks = d < pattern->block_count;
        diagonal->runs = memory_allocate_zeroed(heap, columns, sizeof *diagonal->runs);
        diagonal->weights = memory_allocate_zeroed(heap, 4 * columns, sizeof(double));
        if (!diagonal->runs || !diagonal->weights) return false;
        follow_diagonal(&grid->columns, pattern->offsets[d], diagonal);
    }
    return true;
}

static void release_diagonals(memory *heap, const grid_transfer *grid) {
    size_t const columns = grid->columns.count;
    for (size_t d = 0; d < grid->diagonal_count; d++) {
        memory_release(heap, grid->diagonals[d].runs, columns * sizeof(grid_run));
        memory_release(heap, grid->diagonals[d].weights, 4 * columns * sizeof(double));
    }
    memory_release(heap, grid->diagonals, grid->diagonal_count * sizeof *grid->diagonals);
}

/* ---- the level ---- */

/* Matrix, inverse and vectors, all zero. */
static bool make_planes(memory *heap, grid_transfer *grid) {
    size_t const count = grid_transfer_count(grid), columns = grid->columns.block_count;
    size_t const offsets[GRID_DIAGONALS] = {0, 1, columns - 1, columns, columns + 1};
    grid->pattern.block_count = grid->pattern.count = GRID_DIAGONALS;
    for (size_t d = 0; d < GRID_DIAGONALS; d++) grid->pattern.offsets[d] = (uint32_t)offsets[d];
    size_t const reach = ((columns + 1) / DIAGONAL_ROWS + 1) * DIAGONAL_ROWS;
    size_t const stride = reach + (count / DIAGONAL_ROWS + 1) * DIAGONAL_ROWS + reach;
    size_t const matrix_planes = SINGLE_BLOCK * GRID_DIAGONALS;
    float **const vectors[] = {&grid->vectors.residual, &grid->vectors.direction,
                               &grid->vectors.product, &grid->vectors.preconditioned};
    size_t const vector_count = sizeof vectors / sizeof *vectors;
    grid->plane_count = (matrix_planes + SINGLE_BLOCK + 3 * vector_count) * stride;
    grid->planes = memory_allocate_zeroed(heap, grid->plane_count, sizeof(float));
    if (!grid->planes) return false;
    float *next = grid->planes + reach;
    grid->matrix = (single_diagonals){&grid->pattern, reach, stride, next};
    next += matrix_planes * stride;
    grid->vectors = (single_vectors){
        .inverse = next, .vertex_step = 1, .number_step = stride, .inverse_step = 1};
    next += SINGLE_BLOCK * stride;
    for (size_t i = 0; i < vector_count; i++, next += 3 * stride) *vectors[i] = next;
    return true;
}

static size_t count_lines(const grid_transfer *grid) {
    return 3 * grid->line_stride * (grid->rows.block_count + 1);
}

bool grid_transfer_build(memory *heap, const block_matrix *matrix, grid_transfer **result) {
    size_t const vertex_count = matrix->row_count;
    *result = NULL;
    if (matrix->diagonals.count == 0) return true;
    size_t const columns = count_columns(matrix);
    if (columns < LEAST_COLUMNS || vertex_count % columns != 0 ||
        !are_near(matrix->row_begin, matrix->columns, vertex_count, columns) ||
        !are_near(matrix->scalar_begin, matrix->scalar_columns, vertex_count, columns))
        return true;

    grid_transfer *const grid = memory_allocate_zeroed(heap, 1, sizeof *grid);
    if (!grid) return false;
    bool ok = make_axis(heap, vertex_count / columns, &grid->rows) &&
              make_axis(heap, columns, &grid->columns);
    if (ok) {
        size_t first = 0; /* row of a sheet */
        for (size_t row = 0; row < grid->rows.count; row++) {
            if (row + 1 < grid->rows.count && are_rows_joined(matrix, row, columns)) continue;
            cut_lines(&grid->rows, first, row + 1);
            first = row + 1;
        }
        cut_lines(&grid->columns, 0, columns);
        grid->line_stride = columns + SINGLE_PADDING;
        grid->lines = memory_allocate_zeroed(heap, count_lines(grid), sizeof(float));
        grid->is_free = memory_allocate_zeroed(heap, vertex_count + SINGLE_PADDING, sizeof(float));
        ok = grid->lines && grid->is_free && make_planes(heap, grid) &&
             follow_diagonals(heap, &matrix->diagonals, grid);
    }
    if (!ok) {
        grid_transfer_destroy(heap, grid);
        return false;
    }
    *result = grid;
    return true;
}

void grid_transfer_destroy(memory *heap, grid_transfer *grid) {
    if (!grid) return;
    memory_release(heap, grid->lines, count_lines(grid) * sizeof(float));
    memory_release(heap, grid->is_free,
                   (grid->rows.count * grid->columns.count + SINGLE_PADDING) * sizeof(float));
    memory_release(heap, grid->planes, grid->plane_count * sizeof(float));
    release_diagonals(heap, grid);
    release_axis(heap, &grid->rows);
    release_axis(heap, &grid->columns);
    memory_release(heap, grid, sizeof *grid);
}

void grid_transfer_find_parents(const grid_transfer *grid, uint32_t *parents) {
    const grid_axis *const rows = &grid->rows, *const columns = &grid->columns;
    for (size_t k = 0; k < rows->block_count; k++)
        for (size_t row = rows->begin[k]; row < rows->begin[k + 1]; row++)
            for (size_t b = 0; b < columns->block_count; b++)
                for (size_t c = columns->begin[b]; c < columns->begin[b + 1]; c++)
                    parents[row * columns->count + c] = (uint32_t)(k * columns->block_count + b);
}

void grid_transfer_set_fixed(grid_transfer *grid, const uint8_t *is_fixed) {
    size_t const count = grid->rows.count * grid->columns.count;
    grid->has_fixed = false;
    for (size_t v = 0; v < count; v++) {
        grid->is_free[v] = is_fixed[v] ? 0.0F : 1.0F;
        grid->has_fixed |= is_fixed[v] != 0;
    }
}

/* ---- between vertices and blocks ---- */

static float *get_line(const grid_transfer *grid, size_t block_row) {
    return grid->lines + 3 * grid->line_stride * block_row;
}

static float get_part(const grid_axis *axis, size_t line, size_t block) {
    return axis->lower[line] == block ? axis->share[line] : 1.0F - axis->share[line];
}

/* Adds up the rows that have a part of a row of blocks. */
static void sum_rows(const grid_transfer *grid, const single_vectors *from, size_t block_row) {
    const grid_axis *const rows = &grid->rows;
    line_range const lines = grid_axis_get_lines(rows, block_row);
    float parts[MOST_LINES];
    size_t first = lines.first, count = 0;
    for (size_t row = lines.first; row < lines.end; row++) {
        if (!grid_axis_has_part(rows, row, block_row)) continue;
        if (count == 0) first = row;
        parts[count++] = get_part(rows, row, block_row);
    }
    size_t const vertex = first * grid->columns.count;
    line_sum const sum = {.vectors = from->residual + vertex,
                          .number_step = from->number_step,
                          .is_free = grid->has_fixed ? grid->is_free + vertex : NULL,
                          .row_count = count,
                          .column_count = grid->columns.count,
                          .parts = parts,
                          .line = get_line(grid, block_row),
                          .line_stride = grid->line_stride};
    TULLE_PICK_KERNEL(grid_sum_rows)(&sum);
}

void grid_transfer_restrict(const grid_transfer *grid, const single_vectors *from, size_t begin,
                            size_t end) {
    const grid_axis *const columns = &grid->columns;
    const single_vectors *const to = &grid->vectors;
    for (size_t k = begin; k < end; k++) {
        sum_rows(grid, from, k);
        const float *const line = get_line(grid, k);
        for (size_t b = 0; b < columns->block_count; b++) {
            line_range const lines = grid_axis_get_lines(columns, b);
            float sum[3] = {0.0F, 0.0F, 0.0F};
            for (size_t c = lines.first; c < lines.end; c++) {
                float const part = get_part(columns, c, b);
                for (size_t i = 0; i < 3; i++) sum[i] += line[i * grid->line_stride + c] * part;
            }
            for (size_t i = 0; i < 3; i++)
                to->residual[i * to->number_step + k * columns->block_count + b] = sum[i];
        }
    }
}

void grid_transfer_expand(const grid_transfer *grid, size_t begin, size_t end) {
    const grid_axis *const columns = &grid->columns;
    const single_vectors *const from = &grid->vectors;
    for (size_t k = begin; k < end; k++)
        for (size_t i = 0; i < 3; i++) {
            const float *const values =
                from->preconditioned + i * from->number_step + k * columns->block_count;
            float *const line = get_line(grid, k) + i * grid->line_stride;
            for (size_t c = 0; c < columns->count; c++) {
                const float *const value = values + columns->lower[c];
                line[c] = value[0] * columns->share[c] + value[1] * (1.0F - columns->share[c]);
            }
        }
}

void grid_transfer_add(const grid_transfer *grid, float *planes, size_t number_step, size_t begin,
                       size_t end) {
    const grid_axis *const rows = &grid->rows;
    size_t const column_count = grid->columns.count;
    for (size_t v = begin, next; v < end; v = next) {
        size_t const row = v / column_count, column = v % column_count;
        next = (row + 1) * column_count < end ? (row + 1) * column_count : end;
        line_spread const spread = {.lower = get_line(grid, rows->lower[row]) + column,
                                    .upper = get_line(grid, rows->lower[row] + 1) + column,
                                    .line_stride = grid->line_stride,
                                    .share = rows->share[row],
                                    .is_free = grid->has_fixed ? grid->is_free + v : NULL,
                                    .vectors = planes + v,
                                    .number_step = number_step,
                                    .count = next - v};
        TULLE_PICK_KERNEL(grid_add_lines)(&spread);
    }
}
