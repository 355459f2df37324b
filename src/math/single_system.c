/* math/single_system.c - the matrix of a solve in single precision, see single_solve.h. */
#include "math/single_solve.h"

#include "base/parallel.h"

#include <string.h>

/* Rows of a chunk. */
enum { ROWS_PER_CHUNK = 512 };

/* ---- by rows ---- */

static void copy_rows(const single_system *system, size_t begin, size_t end) {
    const block_matrix *const matrix = system->matrix;
    const single_matrix *const copy = &system->copy;
    for (size_t i = SINGLE_BLOCK * (size_t)matrix->row_begin[begin];
         i < SINGLE_BLOCK * (size_t)matrix->row_begin[end]; i++)
        copy->values[i] = (float)matrix->values[i];
    for (size_t i = matrix->scalar_begin[begin]; i < matrix->scalar_begin[end]; i++)
        copy->scalar_values[i] = (float)block_matrix_get_scalar(matrix, i);
}

static bool make_rows(single_system *system, arena *scratch) {
    const block_matrix *const matrix = system->matrix;
    single_matrix *const copy = &system->copy;
    *copy = (single_matrix){
        .row_begin = matrix->row_begin,
        .columns = matrix->columns,
        .scalar_begin = matrix->scalar_begin,
        .scalar_columns = matrix->scalar_columns,
        .values = ARENA_NEW(scratch, float, SINGLE_BLOCK * matrix->block_count + SINGLE_PADDING),
        .scalar_values = ARENA_NEW(scratch, float, matrix->scalar_count)};
    if (!copy->values || !copy->scalar_values) return false;
    memset(copy->values + SINGLE_BLOCK * matrix->block_count, 0, SINGLE_PADDING * sizeof(float));
    return true;
}

/* ---- by diagonals ---- */

/* The first plane of a diagonal; of the one after the last: how many planes there are. */
static size_t get_first_plane(const matrix_diagonals *pattern, size_t diagonal) {
    size_t const block_count = pattern->block_count;
    return diagonal < block_count ? SINGLE_BLOCK * diagonal
                                  : SINGLE_BLOCK * block_count + (diagonal - block_count);
}

/* Planes of DIAGONAL_ROWS rows. */
typedef struct row_tile {
    float numbers[SINGLE_BLOCK * DIAGONALS_MAX][DIAGONAL_ROWS];
    size_t planes[DIAGONALS_MAX]; /* the first of each diagonal */
} row_tile;

/* Puts the entries of a row at place `at`. */
static void copy_row(const block_matrix *matrix, size_t row, row_tile *tile, size_t at) {
    const matrix_diagonals *const pattern = &matrix->diagonals;
    for (uint32_t k = matrix->row_begin[row]; k < matrix->row_begin[row + 1]; k++) {
        if (pattern->of_blocks[k] == NO_DIAGONAL) continue;
        size_t const plane = tile->planes[pattern->of_blocks[k]];
        const double *const block = matrix->values + SINGLE_BLOCK * (size_t)k;
        for (size_t i = 0; i < SINGLE_BLOCK; i++) tile->numbers[plane + i][at] = (float)block[i];
    }
    for (uint32_t k = matrix->scalar_begin[row]; k < matrix->scalar_begin[row + 1]; k++) {
        if (pattern->of_scalars[k] == NO_DIAGONAL) continue;
        size_t const plane = tile->planes[pattern->of_scalars[k]];
        float const value = (float)block_matrix_get_scalar(matrix, k);
        tile->numbers[plane][at] += value;
        if (pattern->of_scalars[k] >= pattern->block_count) continue;
        tile->numbers[plane + 3][at] += value; /* of a block: xx, yy, zz */
        tile->numbers[plane + 5][at] += value;
    }
}

/* Rows are put side by side in a tile first, because planes are far apart. */
static void copy_diagonals(const single_system *system, size_t begin, size_t end) {
    const single_diagonals *const to = &system->diagonals;
    size_t const plane_count = get_first_plane(to->pattern, to->pattern->count);
    row_tile tile;
    for (size_t d = 0; d < to->pattern->count; d++)
        tile.planes[d] = get_first_plane(to->pattern, d);
    memset(tile.numbers, 0, plane_count * sizeof *tile.numbers); /* rows may be missing */
    for (size_t row = begin; row < end; row++) copy_row(system->matrix, row, &tile, row - begin);
    for (size_t plane = 0; plane < plane_count; plane++)
        memcpy(to->planes + plane * to->stride + begin, tile.numbers[plane], sizeof *tile.numbers);
}

static bool make_diagonals(single_system *system, arena *scratch) {
    const matrix_diagonals *const pattern = &system->matrix->diagonals;
    size_t const row_count = system->matrix->row_count;
    size_t const plane_count = get_first_plane(pattern, pattern->count);
    size_t reach = 0;
    for (size_t d = 0; d < pattern->count; d++)
        if (pattern->offsets[d] > reach) reach = pattern->offsets[d];
    reach = (reach / DIAGONAL_ROWS + 1) * DIAGONAL_ROWS;
    size_t const rows = (row_count / DIAGONAL_ROWS + 1) * DIAGONAL_ROWS;
    size_t const stride = reach + rows + reach;
    float *const room = ARENA_NEW(scratch, float, plane_count *stride);
    if (!room) return false;
    for (size_t plane = 0; plane < plane_count; plane++) {
        float *const end = room + plane * stride + reach + row_count;
        memset(room + plane * stride, 0, reach * sizeof(float));
        memset(end, 0, (stride - reach - row_count) * sizeof(float));
    }
    system->diagonals = (single_diagonals){pattern, reach, stride, room + reach};
    return true;
}

bool single_system_make(const block_matrix *matrix, arena *scratch, single_system *system) {
    size_t const group_count = parallel_chunk_count(matrix->row_count, DIAGONAL_ROWS);
    *system =
        (single_system){.matrix = matrix, .is_stale = ARENA_NEW(scratch, uint8_t, group_count)};
    if (!system->is_stale) return false;
    memset(system->is_stale, 1, group_count);
    return matrix->diagonals.count > 0 ? make_diagonals(system, scratch)
                                       : make_rows(system, scratch);
}

/* Copies what is stale, of idle chunks nothing: their planes have zeros. */
static void renew_rows(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const single_system *const system = context;
    bool const is_idle = are_idle(system->matrix->is_idle, begin, end);
    for (size_t row = begin; row < end; row += DIAGONAL_ROWS) {
        uint8_t *const is_stale = &system->is_stale[row / DIAGONAL_ROWS];
        size_t const next = row + DIAGONAL_ROWS < end ? row + DIAGONAL_ROWS : end;
        size_t const row_end = is_idle ? row : next;
        if (*is_stale && system->diagonals.pattern)
            copy_diagonals(system, row, row_end);
        else if (*is_stale)
            copy_rows(system, row, row_end);
        *is_stale = 0;
    }
}

/* ---- terms ---- */

/* Adds a block to the copy, at an entry of the pattern in this row. */
static void add_block(single_system *system, size_t entry, size_t row, const float *block) {
    const single_diagonals *const diagonals = &system->diagonals;
    float *to;
    size_t stride = 1;
    if (!diagonals->pattern) {
        to = system->copy.values + SINGLE_BLOCK * entry;
    } else {
        if (diagonals->pattern->of_blocks[entry] == NO_DIAGONAL) return;
        stride = diagonals->stride;
        to = diagonals->planes + row +
             stride * get_first_plane(diagonals->pattern, diagonals->pattern->of_blocks[entry]);
    }
    for (size_t k = 0; k < SINGLE_BLOCK; k++) to[k * stride] += block[k];
}

/* Adds a term, or lists it where blocks of it are not in the pattern. */
static void add_term(single_system *system, const matrix_term *term) {
    uint32_t places[4][4];
    if (!block_matrix_find_term(system->matrix, term, places)) {
        system->apart[system->apart_count++] = term;
        return;
    }
    for (size_t i = 0; i < 4; i++)
        for (size_t j = 0; j < 4; j++) {
            if (places[i][j] == TULLE_NONE) continue;
            double const scale = term->weights[i] * term->weights[j];
            float block[SINGLE_BLOCK];
            for (size_t k = 0; k < SINGLE_BLOCK; k++)
                block[k] = (float)(scale * term->stiffness.m[block_places[k]]);
            add_block(system, places[i][j], term->vertices[i], block);
            system->is_stale[term->vertices[i] / DIAGONAL_ROWS] = 1;
        }
}

bool single_system_set_terms(single_system *system, const matrix_term *terms, size_t count,
                             int threads, arena *scratch) {
    system->apart_count = 0;
    system->apart = ARENA_NEW(scratch, const matrix_term *, count);
    if (!system->apart) return false;
    parallel_for(system->matrix->row_count, ROWS_PER_CHUNK, threads, renew_rows, system);
    for (size_t t = 0; t < count; t++) add_term(system, &terms[t]);
    return true;
}

/* ---- loops ---- */

bool single_vectors_make(const single_system *system, arena *scratch, single_vectors *vectors) {
    const single_diagonals *const by = &system->diagonals;
    size_t const count = system->matrix->row_count;
    size_t const size = by->pattern ? 3 * by->stride : 3 * count + SINGLE_PADDING;
    size_t const inverse_size =
        SINGLE_BLOCK * (by->pattern ? by->stride : count) + (by->pattern ? 0 : SINGLE_PADDING);
    size_t const first = by->pattern ? by->reach : 0;
    *vectors = (single_vectors){.vertex_step = by->pattern ? 1 : 3,
                                .number_step = by->pattern ? by->stride : 1,
                                .inverse_step = by->pattern ? 1 : SINGLE_BLOCK};
    float **const all[] = {&vectors->x,       &vectors->residual,       &vectors->direction,
                           &vectors->product, &vectors->preconditioned, &vectors->inverse};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        float *const room =
            ARENA_NEW_ZEROED(scratch, float, all[i] == &vectors->inverse ? inverse_size : size);
        if (!room) return false;
        *all[i] = room + first;
    }
    return true;
}

float single_system_multiply(const single_system *system, const single_vectors *vectors,
                             size_t begin, size_t end) {
    return system->diagonals.pattern
               ? TULLE_PICK_KERNEL(diagonal_multiply)(&system->diagonals, vectors, begin, end)
               : TULLE_PICK_KERNEL(single_multiply)(&system->copy, vectors, begin, end);
}

float single_system_advance(const single_system *system, const single_vectors *vectors, float alpha,
                            size_t begin, size_t end) {
    return system->diagonals.pattern
               ? TULLE_PICK_KERNEL(diagonal_advance)(vectors, alpha, begin, end)
               : TULLE_PICK_KERNEL(single_advance)(vectors, alpha, begin, end);
}

void single_system_turn(const single_system *system, const single_vectors *vectors, float beta,
                        size_t begin, size_t end) {
    const nested_aggregates *const aggregates = system->aggregates;
    bool const by_rows = !system->diagonals.pattern;
    if (by_rows && aggregates && aggregates->level_count > 0) {
        single_correction const correction = {aggregates->levels[0].correction,
                                              aggregates->levels[0].parents, aggregates->is_fixed};
        TULLE_PICK_KERNEL(single_turn_corrected)(vectors, &correction, beta, begin, end);
        return;
    }
    if (aggregates) nested_aggregates_add(aggregates, vectors, begin, end);
    if (by_rows)
        TULLE_PICK_KERNEL(single_turn)(vectors, beta, begin, end);
    else
        TULLE_PICK_KERNEL(diagonal_turn)(vectors, beta, begin, end);
}
