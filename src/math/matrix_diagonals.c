/* math/matrix_diagonals.c - see matrix_diagonals.h. */
#include "math/matrix_diagonals.h"

/* Diagonals, with room for the zeros that products meet beyond both ends, have at most so many
 * times the entries of the pattern. A place on a diagonal takes less than half the time of an entry
 * in a row. */
enum { MOST_PLACES = 2 };

/* The number of the diagonal with this offset, which is added if there is room. */
static size_t find_or_add(matrix_diagonals *diagonals, uint32_t offset, size_t most) {
    for (size_t d = 0; d < diagonals->count; d++)
        if (diagonals->offsets[d] == offset) return d;
    if (diagonals->count < most) diagonals->offsets[diagonals->count] = offset;
    return diagonals->count < most ? diagonals->count++ : NO_DIAGONAL;
}

/* Numbers the entries of a pattern; false: they need more than `most` diagonals. */
static bool number_entries(size_t row_count, entry_pattern pattern, size_t most,
                           matrix_diagonals *diagonals, uint8_t *numbers) {
    for (size_t row = 0; row < row_count; row++)
        for (uint32_t k = pattern.begin[row]; k < pattern.begin[row + 1]; k++) {
            uint32_t const column = pattern.columns[k];
            numbers[k] = NO_DIAGONAL;
            if (column < row) continue;
            numbers[k] = (uint8_t)find_or_add(diagonals, column - (uint32_t)row, most);
            if (numbers[k] == NO_DIAGONAL) return false;
        }
    return true;
}

static bool are_full(const matrix_diagonals *diagonals, size_t row_count, size_t entry_count) {
    size_t farthest = 0;
    for (size_t d = 0; d < diagonals->count; d++)
        if (diagonals->offsets[d] > farthest) farthest = diagonals->offsets[d];
    size_t const places = (2 * diagonals->count - 1) * (row_count + 2 * farthest);
    return places <= MOST_PLACES * entry_count;
}

tulle_status matrix_diagonals_find(memory *heap, size_t row_count, entry_pattern blocks,
                                   entry_pattern scalars, matrix_diagonals *result) {
    size_t const entry_count = blocks.entry_count + scalars.entry_count;
    matrix_diagonals found = {.of_blocks = memory_allocate(heap, blocks.entry_count),
                              .of_scalars = memory_allocate(heap, scalars.entry_count)};
    *result = (matrix_diagonals){0};
    tulle_status const status =
        found.of_blocks && found.of_scalars ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
    bool is_found = status == TULLE_OK;
    if (is_found) {
        found.count = 1; /* the main diagonal, whose offset is 0 */
        is_found = number_entries(row_count, blocks, BLOCK_DIAGONALS_MAX, &found, found.of_blocks);
        found.block_count = found.count;
    }
    is_found = is_found &&
               number_entries(row_count, scalars, DIAGONALS_MAX, &found, found.of_scalars) &&
               are_full(&found, row_count, entry_count);
    if (is_found) {
        *result = found;
        return TULLE_OK;
    }
    memory_release(heap, found.of_blocks, blocks.entry_count);
    memory_release(heap, found.of_scalars, scalars.entry_count);
    return status;
}
