/* math/nested_aggregates.c - aggregates of a mesh, see nested_aggregates.h. Numbers are in
 * nested_aggregates_fill.c, their use is in nested_aggregates_cycle.c.
 *
 * Based on: Vanek, Mandel, Brezina, Algebraic multigrid by smoothed aggregation, 1996 (aggregates
 * are neighbourhoods that do not meet; what is left joins one of them). Departure: weights are
 * smoothed by a mean over neighbours instead of the matrix, so they are found once per mesh. */
#include "math/nested_aggregates.h"

#include <string.h>

/* Aggregates of a first level whose sums are kept: 320 bytes each on a grid. */
enum { MOST_KEPT = 16384 };

/* A level is the last when at most this many of its members have neighbours. Pieces of a cloth
 * never join, so members without neighbours do not count. Each of the others shares an aggregate
 * with a neighbour, so each level has at most half as many of them as the one below. */
enum { FEW_AGGREGATES = 8 };

/* A member with more neighbours than this has the weight of its parent alone. A mean over them
 * would join all of their aggregates to each other. On grids members have eight neighbours or so.
 */
enum { MOST_AVERAGED = 32 };

/* Neighbours of the members of a level. A member may be its own neighbour. */
typedef struct member_graph {
    size_t count;
    const uint32_t *begin, *neighbours;
} member_graph;

/* Gives every member its aggregate; returns how many there are. `before`: room for the parents of
 * the first pass. */
static size_t choose_parents(const member_graph *graph, uint32_t *parents, uint32_t *before) {
    const uint32_t *const neighbours = graph->neighbours;
    size_t count = 0;
    memset(parents, 0xff, graph->count * sizeof(uint32_t));
    /* A member founds an aggregate with its neighbours where none of them is in one yet. */
    for (size_t m = 0; m < graph->count; m++) {
        bool is_free = parents[m] == TULLE_NONE;
        for (uint32_t k = graph->begin[m]; k < graph->begin[m + 1]; k++)
            is_free &= parents[neighbours[k]] == TULLE_NONE;
        if (!is_free) continue;
        parents[m] = (uint32_t)count;
        for (uint32_t k = graph->begin[m]; k < graph->begin[m + 1]; k++)
            parents[neighbours[k]] = (uint32_t)count;
        count++;
    }
    /* The others join the aggregate of a neighbour. */
    memcpy(before, parents, graph->count * sizeof(uint32_t));
    for (size_t m = 0; m < graph->count; m++) {
        uint32_t k = graph->begin[m];
        if (parents[m] != TULLE_NONE) continue;
        while (k < graph->begin[m + 1] && before[neighbours[k]] == TULLE_NONE) k++;
        parents[m] = k < graph->begin[m + 1] ? before[neighbours[k]] : (uint32_t)count++;
    }
    return count;
}

/* Sorts the members by aggregate. */
static void sort_members(aggregate_level *level) {
    uint32_t *const begin = level->member_begin;
    for (size_t m = 0; m < level->member_count; m++) begin[level->parents[m] + 1]++;
    for (size_t a = 0; a < level->count; a++) begin[a + 1] += begin[a];
    for (size_t m = level->member_count; m-- > 0;)
        level->members[--begin[level->parents[m] + 1]] = (uint32_t)m;
    /* Each entry has come down to the begin of the aggregate before it. */
    memmove(begin, begin + 1, level->count * sizeof(uint32_t));
    begin[level->count] = (uint32_t)level->member_count;
}

/* The aggregates of a graph, or the blocks of a grid, as a new level; false: no memory, and the
 * level may be half made. */
static bool add_level(memory *heap, const member_graph *graph, arena *scratch,
                      nested_aggregates *all) {
    const grid_transfer *const grid = all->level_count == 0 ? all->grid : NULL;
    aggregate_level *const level = &all->levels[all->level_count++];
    level->member_count = graph->count;
    level->parents = memory_allocate(heap, graph->count * sizeof(uint32_t));
    uint32_t *const before = ARENA_NEW(scratch, uint32_t, graph->count);
    if (!level->parents || !before) return false;
    if (grid) grid_transfer_find_parents(grid, level->parents);
    level->count = grid ? grid_transfer_count(grid) : choose_parents(graph, level->parents, before);
    level->member_begin = memory_allocate_zeroed(heap, level->count + 1, sizeof(uint32_t));
    level->members = memory_allocate(heap, level->member_count * sizeof(uint32_t));
    if (!level->member_begin || !level->members) return false;
    sort_members(level);
    return true;
}

/* The graph of a level's aggregates, in the arena; false: no memory. */
static bool make_coarse_graph(const member_graph *graph, const aggregate_level *level,
                              arena *scratch, member_graph *coarse) {
    uint32_t *const begin = ARENA_NEW(scratch, uint32_t, level->count + 1);
    uint32_t *const neighbours = ARENA_NEW(scratch, uint32_t, graph->begin[graph->count]);
    uint32_t *const mark = ARENA_NEW(scratch, uint32_t, level->count); /* last one it is next to */
    if (!begin || !neighbours || !mark) return false;
    memset(mark, 0xff, level->count * sizeof(uint32_t));
    uint32_t count = 0;
    for (uint32_t a = 0; a < level->count; a++) {
        begin[a] = count;
        for (uint32_t i = level->member_begin[a]; i < level->member_begin[a + 1]; i++) {
            uint32_t const member = level->members[i];
            for (uint32_t k = graph->begin[member]; k < graph->begin[member + 1]; k++) {
                uint32_t const other = level->parents[graph->neighbours[k]];
                if (other == a || mark[other] == a) continue;
                mark[other] = a;
                neighbours[count++] = other;
            }
        }
    }
    begin[level->count] = count;
    *coarse = (member_graph){level->count, begin, neighbours};
    return true;
}

/* ---- weights ---- */

static bool make_list(memory *heap, size_t row_count, size_t entry_count, weight_list *list) {
    list->count = entry_count;
    list->begin = memory_allocate_zeroed(heap, row_count + 1, sizeof(uint32_t));
    list->columns = memory_allocate(heap, entry_count * sizeof(uint32_t));
    list->weights = memory_allocate(heap, entry_count * sizeof(float));
    return list->begin && list->columns && list->weights;
}

static void release_list(memory *heap, size_t row_count, const weight_list *list) {
    memory_release(heap, list->columns, list->count * sizeof(uint32_t));
    memory_release(heap, list->weights, list->count * sizeof(float));
    memory_release(heap, list->begin, (row_count + 1) * sizeof(uint32_t));
}

/* Adds the weight of a member's neighbour, or of itself, to a row that begins at `first`; returns
 * the new end of the row. */
static uint32_t add_weight(weight_list *list, uint32_t first, uint32_t end, uint32_t aggregate,
                           float weight) {
    for (uint32_t k = first; k < end; k++)
        if (list->columns[k] == aggregate) {
            list->weights[k] += weight;
            return end;
        }
    list->columns[end] = aggregate;
    list->weights[end] = weight;
    return end + 1;
}

/* Each member has the mean of the parents of its neighbours and its own, if these are not too many.
 */
static bool make_weights(memory *heap, const member_graph *graph, arena *scratch,
                         aggregate_level *level) {
    size_t const most = graph->count + graph->begin[graph->count];
    weight_list wide = {.columns = ARENA_NEW(scratch, uint32_t, most),
                        .weights = ARENA_NEW(scratch, float, most),
                        .begin = ARENA_NEW(scratch, uint32_t, graph->count + 1)};
    if (!wide.columns || !wide.weights || !wide.begin) return false;
    uint32_t end = 0;
    for (uint32_t m = 0; m < graph->count; m++) {
        uint32_t const first = wide.begin[m] = end;
        uint32_t const neighbour_count = graph->begin[m + 1] - graph->begin[m];
        uint32_t const averaged = neighbour_count > MOST_AVERAGED ? 0 : neighbour_count;
        float const share = 1.0F / (float)(1 + averaged);
        end = add_weight(&wide, first, end, level->parents[m], share);
        for (uint32_t k = graph->begin[m]; k < graph->begin[m] + averaged; k++)
            end = add_weight(&wide, first, end, level->parents[graph->neighbours[k]], share);
    }
    wide.begin[graph->count] = end;
    weight_list *const by = &level->of_members, *const across = &level->of_aggregates;
    if (!make_list(heap, level->member_count, end, by) ||
        !make_list(heap, level->count, end, across))
        return false;
    memcpy(by->begin, wide.begin, (level->member_count + 1) * sizeof(uint32_t));
    memcpy(by->columns, wide.columns, end * sizeof(uint32_t));
    memcpy(by->weights, wide.weights, end * sizeof(float));
    for (uint32_t k = 0; k < end; k++) across->begin[by->columns[k] + 1]++;
    for (size_t a = 0; a < level->count; a++) across->begin[a + 1] += across->begin[a];
    for (uint32_t m = (uint32_t)level->member_count; m-- > 0;)
        for (uint32_t k = by->begin[m + 1]; k-- > by->begin[m];) {
            uint32_t const to = --across->begin[by->columns[k] + 1];
            across->columns[to] = m;
            across->weights[to] = by->weights[k];
        }
    memmove(across->begin, across->begin + 1, level->count * sizeof(uint32_t));
    across->begin[level->count] = end;
    return true;
}

/* ---- entries ---- */

/* Columns of a row as they are found. */
typedef struct row_columns {
    uint32_t row, count;
    uint32_t *columns, *marks; /* the last row that a column was found in */
} row_columns;

static void add_column(row_columns *found, uint32_t column) {
    if (found->marks[column] == found->row) return;
    found->marks[column] = found->row;
    uint32_t k = found->count++; /* rows are short */
    for (; k > 0 && found->columns[k - 1] > column; k--) found->columns[k] = found->columns[k - 1];
    found->columns[k] = column;
}

/* The aggregates that an aggregate of the first level is joined to. */
static void find_first_columns(const aggregate_level *level, const block_matrix *matrix,
                               row_columns *found) {
    for (uint32_t i = level->member_begin[found->row]; i < level->member_begin[found->row + 1];
         i++) {
        uint32_t const v = level->members[i];
        for (uint32_t k = matrix->row_begin[v]; k < matrix->row_begin[v + 1]; k++)
            add_column(found, level->parents[matrix->columns[k]]);
        for (uint32_t k = matrix->scalar_begin[v]; k < matrix->scalar_begin[v + 1]; k++)
            add_column(found, level->parents[matrix->scalar_columns[k]]);
    }
}

/* The same of a level above it. */
static void find_columns(const aggregate_level *level, const aggregate_level *below,
                         row_columns *found) {
    const weight_list *const members = &level->of_aggregates, *const parents = &level->of_members;
    for (uint32_t i = members->begin[found->row]; i < members->begin[found->row + 1]; i++) {
        uint32_t const member = members->columns[i];
        for (uint32_t k = below->row_begin[member]; k < below->row_begin[member + 1]; k++) {
            uint32_t const other = below->columns[k];
            for (uint32_t j = parents->begin[other]; j < parents->begin[other + 1]; j++)
                add_column(found, parents->columns[j]);
        }
    }
}

/* The same of a block: itself and those around it. */
static void find_block_columns(const grid_transfer *grid, row_columns *found) {
    size_t const rows = grid->rows.block_count, columns = grid->columns.block_count;
    size_t const row = found->row / columns, column = found->row % columns;
    for (size_t r = row > 0 ? row - 1 : 0; r < rows && r <= row + 1; r++)
        for (size_t c = column > 0 ? column - 1 : 0; c < columns && c <= column + 1; c++)
            add_column(found, (uint32_t)(r * columns + c));
}

uint32_t nested_aggregates_find(const aggregate_level *level, uint32_t row, uint32_t column) {
    return find_in_columns(level->columns, level->row_begin[row], level->row_begin[row + 1],
                           column);
}

/* Entries of the level that was added last. */
static bool make_entries(memory *heap, const block_matrix *matrix, arena *scratch,
                         nested_aggregates *all) {
    aggregate_level *const level = &all->levels[all->level_count - 1];
    bool const is_first = all->level_count == 1;
    size_t const count = level->count;
    arena_mark const mark = arena_get_mark(scratch);
    row_columns found = {.columns = ARENA_NEW(scratch, uint32_t, count),
                         .marks = ARENA_NEW(scratch, uint32_t, count)};
    level->row_begin = memory_allocate_zeroed(heap, count + 1, sizeof(uint32_t));
    level->diagonals = memory_allocate(heap, count * sizeof(uint32_t));
    level->dots = memory_allocate_zeroed(heap, count, sizeof(double));
    if (!found.columns || !found.marks || !level->row_begin || !level->diagonals || !level->dots)
        return false;
    for (int pass = 0; pass < 2; pass++) { /* counts, then writes */
        memset(found.marks, 0xff, count * sizeof(uint32_t));
        uint32_t end = 0;
        for (found.row = 0; found.row < count; found.row++) {
            found.count = 0;
            if (!is_first)
                find_columns(level, level - 1, &found);
            else if (all->grid)
                find_block_columns(all->grid, &found);
            else
                find_first_columns(level, matrix, &found);
            if (pass == 1)
                memcpy(level->columns + end, found.columns, found.count * sizeof(uint32_t));
            end += found.count;
            level->row_begin[found.row + 1] = end;
        }
        if (pass == 1) break;
        level->entry_count = end;
        level->columns = memory_allocate(heap, end * sizeof(uint32_t));
        if (!level->columns) return false;
    }
    for (uint32_t a = 0; a < count; a++) level->diagonals[a] = nested_aggregates_find(level, a, a);
    arena_release(scratch, mark);
    return true;
}

static bool make_vectors(memory *heap, aggregate_level *level) {
    size_t const size = 3 * level->count + SINGLE_PADDING;
    float **const vectors[] = {&level->residual, &level->guess, &level->correction,
                               &level->product};
    bool ok = true;
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++) {
        *vectors[i] = memory_allocate_zeroed(heap, size, sizeof(float));
        ok &= *vectors[i] != NULL;
    }
    level->no_scalars = memory_allocate_zeroed(heap, level->count + 1, sizeof(uint32_t));
    level->values = memory_allocate_zeroed(heap, SINGLE_BLOCK * level->entry_count + SINGLE_PADDING,
                                           sizeof(float));
    level->inverse = memory_allocate_zeroed(heap, 9 * level->count + SINGLE_PADDING, sizeof(float));
    return ok && level->no_scalars && level->values && level->inverse;
}

static void release_vectors(memory *heap, const aggregate_level *level) {
    size_t const count = level->count;
    float *const vectors[] = {level->residual, level->guess, level->correction, level->product};
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++)
        memory_release(heap, vectors[i], (3 * count + SINGLE_PADDING) * sizeof(float));
    memory_release(heap, level->no_scalars, (count + 1) * sizeof(uint32_t));
    memory_release(heap, level->values,
                   (SINGLE_BLOCK * level->entry_count + SINGLE_PADDING) * sizeof(float));
    memory_release(heap, level->inverse, (9 * count + SINGLE_PADDING) * sizeof(float));
}

/* For each entry of a pattern the place of its entry in the row of the first level. Each pair of
 * aggregates counts once, from the row of the lower one; so does each pair of vertices of one
 * aggregate. */
static void compute_places(const aggregate_level *level, size_t row_count, const uint32_t *begin,
                           const uint32_t *columns, uint8_t *places) {
    for (uint32_t row = 0; row < row_count; row++) {
        uint32_t const a = level->parents[row];
        for (uint32_t k = begin[row]; k < begin[row + 1]; k++) {
            uint32_t const b = level->parents[columns[k]];
            bool const is_mirror = b < a || (b == a && columns[k] < row);
            uint32_t const place = nested_aggregates_find(level, a, b) - level->row_begin[a];
            places[k] = (uint8_t)(is_mirror ? NO_PLACE : place < FAR_PLACE ? place : FAR_PLACE);
        }
    }
}

static bool make_matrix_sums(memory *heap, nested_aggregates *all) {
    const aggregate_level *const first = &all->levels[0];
    if (first->count > MOST_KEPT) return true;
    all->matrix_sum_count =
        all->grid ? GRID_BLOCK * GRID_DIAGONALS * first->count : BLOCK_NUMBERS * first->entry_count;
    all->matrix_sums = memory_allocate(heap, all->matrix_sum_count * sizeof(double));
    return all->matrix_sums != NULL;
}

nested_aggregates *nested_aggregates_build(memory *heap, const block_matrix *matrix,
                                           arena *scratch) {
    nested_aggregates *const all = memory_allocate_zeroed(heap, 1, sizeof *all);
    if (!all) return NULL;
    all->vertex_count = matrix->row_count;
    all->block_count = matrix->block_count;
    all->scalar_count = matrix->scalar_count;
    all->is_fixed = memory_allocate_zeroed(heap, all->vertex_count, 1);
    bool ok = all->is_fixed && grid_transfer_build(heap, matrix, &all->grid);
    if (ok && !all->grid) {
        all->block_places = memory_allocate(heap, all->block_count);
        all->scalar_places = memory_allocate(heap, all->scalar_count);
        ok = all->block_places && all->scalar_places;
    }

    arena_mark const mark = arena_get_mark(scratch);
    /* The matrix's rows are used as they are. They also name each vertex itself, which does no
     * harm. */
    member_graph graph = {all->vertex_count, matrix->row_begin, matrix->columns};
    for (size_t l = 0; ok && l < AGGREGATE_LEVELS_MAX; l++) {
        size_t joined_count = 0; /* members with another neighbour */
        for (size_t m = 0; m < graph.count; m++) {
            bool is_alone = true;
            for (uint32_t k = graph.begin[m]; k < graph.begin[m + 1]; k++)
                is_alone &= graph.neighbours[k] == m;
            joined_count += !is_alone;
        }
        if (joined_count <= FEW_AGGREGATES) break;
        member_graph coarse = {0};
        aggregate_level *const level = &all->levels[l];
        ok = add_level(heap, &graph, scratch, all) &&
             (l == 0 || make_weights(heap, &graph, scratch, level)) &&
             make_entries(heap, matrix, scratch, all) &&
             ((l == 0 && all->grid) || make_vectors(heap, level)) &&
             make_coarse_graph(&graph, level, scratch, &coarse);
        graph = coarse;
    }
    arena_release(scratch, mark);
    if (!ok) {
        nested_aggregates_destroy(heap, all);
        return NULL;
    }
    if (all->level_count > 0 && !make_matrix_sums(heap, all)) {
        nested_aggregates_destroy(heap, all);
        return NULL;
    }
    if (all->level_count == 0 || all->grid) return all;
    compute_places(&all->levels[0], all->vertex_count, matrix->row_begin, matrix->columns,
                   all->block_places);
    compute_places(&all->levels[0], all->vertex_count, matrix->scalar_begin, matrix->scalar_columns,
                   all->scalar_places);
    return all;
}

void nested_aggregates_destroy(memory *heap, nested_aggregates *aggregates) {
    if (!aggregates) return;
    memory_release(heap, aggregates->matrix_sums, aggregates->matrix_sum_count * sizeof(double));
    for (size_t l = 0; l < aggregates->level_count; l++) {
        const aggregate_level *const level = &aggregates->levels[l];
        size_t const count = level->count, entries = level->entry_count;
        if (l > 0 || !aggregates->grid) release_vectors(heap, level);
        memory_release(heap, level->parents, level->member_count * sizeof(uint32_t));
        memory_release(heap, level->member_begin, (count + 1) * sizeof(uint32_t));
        memory_release(heap, level->members, level->member_count * sizeof(uint32_t));
        release_list(heap, level->member_count, &level->of_members);
        release_list(heap, count, &level->of_aggregates);
        memory_release(heap, level->row_begin, (count + 1) * sizeof(uint32_t));
        memory_release(heap, level->columns, entries * sizeof(uint32_t));
        memory_release(heap, level->diagonals, count * sizeof(uint32_t));
        memory_release(heap, level->dots, count * sizeof(double));
    }
    if (!aggregates->grid) {
        memory_release(heap, aggregates->block_places, aggregates->block_count);
        memory_release(heap, aggregates->scalar_places, aggregates->scalar_count);
    }
    grid_transfer_destroy(heap, aggregates->grid);
    memory_release(heap, aggregates->is_fixed, aggregates->vertex_count);
    memory_release(heap, aggregates, sizeof *aggregates);
}
