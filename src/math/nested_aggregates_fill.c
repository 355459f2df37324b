/* math/nested_aggregates_fill.c - numbers of nested aggregates, see nested_aggregates.h.
 *
 * A of the first level has the sums of the entries of the matrix between the vertices of two
 * aggregates; A of a level above is P^T A P of that below. Sums are in double precision, because
 * springs cancel in them and masses are left.
 *
 * A term that joins vertices whose aggregates are not joined by the mesh, as contact of cloth with
 * itself is, counts as if each of its vertices were tied to what does not move. */
#include "math/conjugate_gradients.h"
#include "math/nested_aggregates.h"

#include "base/parallel.h"

#include <string.h>

/* Aggregates of a chunk of a loop. */
enum { AGGREGATES_PER_CHUNK = 64, PRODUCTS_PER_CHUNK = 8 };

typedef struct fill_task {
    nested_aggregates *all;
    const block_matrix *matrix;
    const aggregate_level *level, *below;
    const double *values_below;
    double *values;     /* BLOCK_NUMBERS an entry */
    double *block_sums; /* of a grid: GRID_BLOCK * GRID_DIAGONALS a block */
} fill_task;

/* The inverse of an entry on the diagonal. */
static void invert_entry(const double *m, double *inverse) {
    double const block[9] = {m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5]};
    invert_block_of((preconditioner_source){.diagonal = block}, 0, inverse);
}

/* ---- the first level ---- */

/* Sums of the first places of a row. */
typedef struct place_sums {
    double blocks[FAR_PLACE][BLOCK_NUMBERS], scalars[FAR_PLACE];
} place_sums;

/* The sum of an entry that is far from the begin of its row, as many are around a vertex with
 * hundreds of neighbours. `times`: twice within an aggregate. */
static double *find_far(const fill_task *task, size_t row, uint32_t column, double *times) {
    const aggregate_level *const level = task->level;
    uint32_t const a = level->parents[row], b = level->parents[column];
    *times = a == b && column != row ? 2.0 : 1.0;
    return task->values + BLOCK_NUMBERS * (size_t)nested_aggregates_find(level, a, b);
}

/* Adds the entries of a vertex's row. Those within an aggregate count for their mirror images,
 * too. */
static void add_row(const fill_task *task, size_t row, size_t own_place, place_sums *sums) {
    const nested_aggregates *const all = task->all;
    const block_matrix *const matrix = task->matrix;
    for (uint32_t k = matrix->row_begin[row]; k < matrix->row_begin[row + 1]; k++) {
        size_t const place = all->block_places[k];
        if (place == NO_PLACE || all->is_fixed[matrix->columns[k]]) continue;
        const double *const m = matrix->values + BLOCK_NUMBERS * (size_t)k;
        double times = place == own_place && matrix->columns[k] != row ? 2.0 : 1.0;
        double *const sum = place == FAR_PLACE ? find_far(task, row, matrix->columns[k], &times)
                                               : sums->blocks[place];
        for (size_t i = 0; i < BLOCK_NUMBERS; i++) sum[i] += times * m[i];
    }
    for (uint32_t k = matrix->scalar_begin[row]; k < matrix->scalar_begin[row + 1]; k++) {
        size_t const place = all->scalar_places[k];
        uint32_t const column = matrix->scalar_columns[k];
        if (place == NO_PLACE || all->is_fixed[column]) continue;
        double times = place == own_place && column != row ? 2.0 : 1.0;
        if (place < FAR_PLACE) {
            sums->scalars[place] += times * block_matrix_get_scalar(matrix, k);
            continue;
        }
        double *const sum = find_far(task, row, column, &times);
        double const scalar = times * block_matrix_get_scalar(matrix, k);
        sum[0] += scalar;
        sum[3] += scalar;
        sum[5] += scalar;
    }
}

static void sum_first_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const fill_task *const task = context;
    const aggregate_level *const level = task->level;
    for (size_t a = begin; a < end; a++) {
        uint32_t const first = level->row_begin[a];
        size_t const row_size = level->row_begin[a + 1] - first;
        size_t const own_place = level->diagonals[a] - first;
        size_t const size = row_size < FAR_PLACE ? row_size : FAR_PLACE;
        place_sums sums;
        memset(sums.blocks, 0, size * sizeof *sums.blocks);
        memset(sums.scalars, 0, size * sizeof *sums.scalars);
        memset(task->values + BLOCK_NUMBERS * (first + own_place), 0,
               BLOCK_NUMBERS * (row_size - own_place) * sizeof(double));
        for (uint32_t i = level->member_begin[a]; i < level->member_begin[a + 1]; i++)
            if (!task->all->is_fixed[level->members[i]])
                add_row(task, level->members[i], own_place, &sums);
        for (size_t k = own_place; k < size; k++) {
            double *const to = task->values + BLOCK_NUMBERS * (first + k);
            memcpy(to, sums.blocks[k], sizeof sums.blocks[k]);
            to[0] += sums.scalars[k];
            to[3] += sums.scalars[k];
            to[5] += sums.scalars[k];
        }
    }
}

/* What is left of the diagonal is what is right of it, mirrored. */
static void mirror_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const fill_task *const task = context;
    const aggregate_level *const level = task->level;
    for (uint32_t a = (uint32_t)begin; a < end; a++)
        for (uint32_t k = level->row_begin[a]; k < level->diagonals[a]; k++) {
            uint32_t const mirror = nested_aggregates_find(level, level->columns[k], a);
            memcpy(task->values + BLOCK_NUMBERS * (size_t)k,
                   task->values + BLOCK_NUMBERS * (size_t)mirror, BLOCK_NUMBERS * sizeof(double));
        }
}

/* ---- terms ---- */

/* Adds a term to entries of the first level. Vertices of one aggregate become one. */
static void add_term(const nested_aggregates *all, const matrix_term *term, double *values) {
    const aggregate_level *const level = &all->levels[0];
    uint32_t aggregates[4], entries[4][4];
    double weights[4];
    size_t count = 0;
    for (size_t k = 0; k < 4; k++) {
        uint32_t const vertex = term->vertices[k];
        if (vertex == TULLE_NONE || all->is_fixed[vertex]) continue;
        size_t place = 0;
        while (place < count && aggregates[place] != level->parents[vertex]) place++;
        if (place == count) weights[count++] = 0.0;
        aggregates[place] = level->parents[vertex];
        weights[place] += term->weights[k];
    }
    bool is_joined = true;
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < count; j++) {
            entries[i][j] = nested_aggregates_find(level, aggregates[i], aggregates[j]);
            is_joined &= entries[i][j] != TULLE_NONE;
        }
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < count; j++) {
            if (!is_joined && i != j) continue;
            double *const to = values + BLOCK_NUMBERS * (size_t)entries[i][j];
            for (size_t k = 0; k < BLOCK_NUMBERS; k++)
                to[k] += weights[i] * weights[j] * term->stiffness.m[block_places[k]];
        }
}

/* ---- sums that are kept ---- */

/* False: there are none of this matrix. */
static bool recall_sums(const nested_aggregates *all, const aggregated_system *system, double *sums,
                        size_t count) {
    if (!all->has_sums || !system->is_known) return false;
    memcpy(sums, all->matrix_sums, count * sizeof *sums);
    return true;
}

static void keep_sums(nested_aggregates *all, const double *sums, size_t count) {
    all->has_sums = all->matrix_sums != NULL;
    if (all->has_sums) memcpy(all->matrix_sums, sums, count * sizeof *sums);
}

/* ---- the blocks of a grid ---- */

/* The sum of an entry, which is kept once for both triangles. */
static const double *get_block_sum(const fill_task *task, size_t row, size_t column) {
    size_t const first = row < column ? row : column, last = row < column ? column : row;
    size_t const columns = task->all->grid->columns.block_count;
    size_t const down = last / columns - first / columns;
    size_t const way = last % columns + 1 - first % columns; /* 0 to 2 */
    size_t const diagonal = down == 0 ? way - 1 : way + 2;
    return task->block_sums + GRID_BLOCK * (GRID_DIAGONALS * first + diagonal);
}

/* To entries by rows, for the level above, and by diagonals in single precision. */
static void put_blocks(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const fill_task *const task = context;
    const aggregate_level *const level = task->level;
    const grid_transfer *const grid = task->all->grid;
    for (size_t a = begin; a < end; a++) {
        for (uint32_t k = level->row_begin[a]; k < level->row_begin[a + 1]; k++)
            memcpy(task->values + BLOCK_NUMBERS * (size_t)k,
                   get_block_sum(task, a, level->columns[k]), BLOCK_NUMBERS * sizeof(double));
        const double *const sums = task->block_sums + GRID_BLOCK * GRID_DIAGONALS * a;
        for (size_t d = 0; d < GRID_DIAGONALS; d++)
            for (size_t i = 0; i < SINGLE_BLOCK; i++)
                grid->matrix.planes[(SINGLE_BLOCK * d + i) * grid->matrix.stride + a] =
                    (float)sums[GRID_BLOCK * d + i];
        double inverse[BLOCK_NUMBERS];
        invert_entry(sums, inverse);
        for (size_t i = 0; i < BLOCK_NUMBERS; i++)
            grid->vectors.inverse[i * grid->matrix.stride + a] = FIRST_STEP * (float)inverse[i];
    }
}

static bool fill_blocks(fill_task *task, const aggregated_system *system, int threads,
                        arena *scratch) {
    grid_transfer *const grid = task->all->grid;
    size_t const count = task->level->count;
    const uint8_t *const is_fixed = task->all->is_fixed;
    grid_fill_source const source = {task->matrix, is_fixed};
    size_t const sum_count = GRID_BLOCK * GRID_DIAGONALS * count;
    task->block_sums = ARENA_NEW(scratch, double, sum_count);
    if (!task->block_sums) return false;
    if (!recall_sums(task->all, system, task->block_sums, sum_count)) {
        if (!grid_transfer_sum(grid, &source, threads, scratch, task->block_sums)) return false;
        keep_sums(task->all, task->block_sums, sum_count);
    }
    grid_transfer_set_fixed(grid, is_fixed);
    for (size_t t = 0; t < system->term_count; t++)
        grid_transfer_add_term(grid, &system->terms[t], is_fixed, task->block_sums);
    parallel_for(count, AGGREGATES_PER_CHUNK, threads, put_blocks, task);
    return true;
}

/* ---- the levels above ---- */

static void multiply_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const fill_task *const task = context;
    const aggregate_level *const level = task->level, *const below = task->below;
    const weight_list *const members = &level->of_aggregates, *const parents = &level->of_members;
    for (uint32_t a = (uint32_t)begin; a < end; a++) {
        uint32_t const first = level->diagonals[a], last = level->row_begin[a + 1];
        memset(task->values + BLOCK_NUMBERS * (size_t)first, 0,
               BLOCK_NUMBERS * (last - first) * sizeof(double));
        for (uint32_t i = members->begin[a]; i < members->begin[a + 1]; i++) {
            uint32_t const member = members->columns[i];
            for (uint32_t k = below->row_begin[member]; k < below->row_begin[member + 1]; k++) {
                const double *const from = task->values_below + BLOCK_NUMBERS * (size_t)k;
                uint32_t const other = below->columns[k];
                for (uint32_t j = parents->begin[other]; j < parents->begin[other + 1]; j++) {
                    if (parents->columns[j] < a) continue;
                    uint32_t entry = first;
                    while (level->columns[entry] != parents->columns[j]) entry++;
                    double *const to = task->values + BLOCK_NUMBERS * (size_t)entry;
                    double const weight = (double)members->weights[i] * (double)parents->weights[j];
                    for (size_t n = 0; n < BLOCK_NUMBERS; n++) to[n] += weight * from[n];
                }
            }
        }
    }
}

/* In single precision, with the inverse of the diagonal. */
static void round_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const fill_task *const task = context;
    const aggregate_level *const level = task->level;
    for (size_t i = BLOCK_NUMBERS * (size_t)level->row_begin[begin];
         i < BLOCK_NUMBERS * (size_t)level->row_begin[end]; i++)
        level->values[i] = (float)task->values[i];
    for (size_t a = begin; a < end; a++) {
        double n[BLOCK_NUMBERS];
        invert_entry(task->values + BLOCK_NUMBERS * (size_t)level->diagonals[a], n);
        double const full[9] = {n[0], n[1], n[2], n[1], n[3], n[4], n[2], n[4], n[5]};
        for (size_t i = 0; i < 9; i++) level->inverse[9 * a + i] = (float)full[i];
    }
}

bool nested_aggregates_set(nested_aggregates *aggregates, const aggregated_system *system,
                           int threads, arena *scratch) {
    if (system->is_fixed)
        memcpy(aggregates->is_fixed, system->is_fixed, aggregates->vertex_count);
    else
        memset(aggregates->is_fixed, 0, aggregates->vertex_count);
    arena_mark const mark = arena_get_mark(scratch);
    fill_task task = {.all = aggregates, .matrix = system->matrix};
    bool ok = true;
    for (size_t l = 0; ok && l < aggregates->level_count; l++) {
        const aggregate_level *const level = &aggregates->levels[l];
        task.below = task.level;
        task.values_below = task.values;
        task.level = level;
        task.values = ARENA_NEW(scratch, double, BLOCK_NUMBERS * level->entry_count);
        ok = task.values != NULL;
        if (!ok) break;
        if (l == 0 && aggregates->grid) {
            ok = fill_blocks(&task, system, threads, scratch);
            continue;
        }
        size_t const number_count = BLOCK_NUMBERS * level->entry_count;
        bool const has_sums = l == 0 && recall_sums(aggregates, system, task.values, number_count);
        if (!has_sums) {
            if (l == 0)
                parallel_for(level->count, AGGREGATES_PER_CHUNK, threads, sum_first_rows, &task);
            else
                parallel_for(level->count, PRODUCTS_PER_CHUNK, threads, multiply_rows, &task);
            parallel_for(level->count, AGGREGATES_PER_CHUNK, threads, mirror_rows, &task);
            if (l == 0) keep_sums(aggregates, task.values, number_count);
        }
        for (size_t t = 0; l == 0 && t < system->term_count; t++)
            add_term(aggregates, &system->terms[t], task.values);
        parallel_for(level->count, AGGREGATES_PER_CHUNK, threads, round_rows, &task);
    }
    arena_release(scratch, mark);
    return ok;
}
