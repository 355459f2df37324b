/* math/nested_aggregates.c - aggregates of a mesh, see nested_aggregates.h. Numbers are in
 * nested_aggregates_fill.c.
 *
 * Based on: Vanek, Mandel, Brezina, Algebraic multigrid by smoothed aggregation, 1996 (aggregates
 * are neighbourhoods that do not meet; what is left joins one of them). */
#include "math/nested_aggregates.h"

#include "math/single_kernel.h"

#include <string.h>

/* A level with so few members that have neighbours is the last. Pieces of a cloth never join, so
 * members without neighbours do not count. All others share an aggregate with a neighbour, so
 * each level has at most half as many of them as the one below. */
enum { FEW_AGGREGATES = 8 };

/* Neighbours of the members of a level: with themselves, or without. */
typedef struct member_graph {
    size_t count;
    uint32_t *begin, *neighbours;
} member_graph;

static void release_graph(memory *heap, member_graph *graph) {
    if (!graph->begin) return;
    memory_release(heap, graph->neighbours, graph->begin[graph->count] * sizeof(uint32_t));
    memory_release(heap, graph->begin, (graph->count + 1) * sizeof(uint32_t));
    *graph = (member_graph){0};
}

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

static bool list_members(memory *heap, aggregate_level *level) {
    level->member_begin = memory_allocate_zeroed(heap, level->count + 1, sizeof(uint32_t));
    level->members = memory_allocate(heap, level->member_count * sizeof(uint32_t));
    if (!level->member_begin || !level->members) return false;
    for (size_t m = 0; m < level->member_count; m++) level->member_begin[level->parents[m] + 1]++;
    for (size_t a = 0; a < level->count; a++) level->member_begin[a + 1] += level->member_begin[a];
    for (size_t m = level->member_count; m-- > 0;) {
        uint32_t const end = level->member_begin[level->parents[m] + 1];
        level->members[end - 1] = (uint32_t)m;
        level->member_begin[level->parents[m] + 1]--;
    }
    /* Each entry has come down to the begin of the aggregate before it. */
    memmove(level->member_begin, level->member_begin + 1, level->count * sizeof(uint32_t));
    level->member_begin[level->count] = (uint32_t)level->member_count;
    return true;
}

/* Adds to `row` the aggregates next to aggregate a that are not marked with it yet. */
static size_t list_neighbours(const member_graph *graph, const aggregate_level *level, size_t a,
                              uint32_t *mark, uint32_t *row) {
    size_t count = 0;
    for (uint32_t i = level->member_begin[a]; i < level->member_begin[a + 1]; i++) {
        uint32_t const member = level->members[i];
        for (uint32_t k = graph->begin[member]; k < graph->begin[member + 1]; k++) {
            uint32_t const other = level->parents[graph->neighbours[k]];
            if (other == a || mark[other] == a) continue;
            mark[other] = (uint32_t)a;
            if (row) row[count] = other;
            count++;
        }
    }
    return count;
}

/* The graph of a level's aggregates. */
static bool make_coarse_graph(memory *heap, const member_graph *graph, const aggregate_level *level,
                              member_graph *coarse) {
    *coarse = (member_graph){.count = level->count};
    uint32_t *const mark = memory_allocate(heap, level->count * sizeof(uint32_t));
    coarse->begin = memory_allocate_zeroed(heap, level->count + 1, sizeof(uint32_t));
    bool ok = mark && coarse->begin;
    if (ok) memset(mark, 0xff, level->count * sizeof(uint32_t));
    for (size_t a = 0; ok && a < level->count; a++)
        coarse->begin[a + 1] =
            coarse->begin[a] + (uint32_t)list_neighbours(graph, level, a, mark, NULL);
    if (ok) {
        coarse->neighbours = memory_allocate(heap, coarse->begin[level->count] * sizeof(uint32_t));
        ok = coarse->neighbours != NULL;
    }
    if (ok) memset(mark, 0xff, level->count * sizeof(uint32_t));
    for (size_t a = 0; ok && a < level->count; a++)
        list_neighbours(graph, level, a, mark, coarse->neighbours + coarse->begin[a]);
    memory_release(heap, mark, level->count * sizeof(uint32_t));
    return ok;
}

static void release_level(memory *heap, aggregate_level *level) {
    memory_release(heap, level->parents, level->member_count * sizeof(uint32_t));
    memory_release(heap, level->member_begin, (level->count + 1) * sizeof(uint32_t));
    memory_release(heap, level->members, level->member_count * sizeof(uint32_t));
    memory_release(heap, level->matrix_blocks, 9 * level->count * sizeof(double));
    memory_release(heap, level->blocks, 9 * level->count * sizeof(double));
    memory_release(heap, level->inverse, (9 * level->count + SINGLE_PADDING) * sizeof(float));
    memory_release(heap, level->residual, (3 * level->count + SINGLE_PADDING) * sizeof(float));
    memory_release(heap, level->correction, (3 * level->count + SINGLE_PADDING) * sizeof(float));
}

/* The aggregates of a graph as a new level; false: no memory. */
static bool add_level(memory *heap, nested_aggregates *all, const member_graph *graph) {
    aggregate_level level = {.member_count = graph->count};
    uint32_t *const before = memory_allocate(heap, graph->count * sizeof(uint32_t));
    level.parents = memory_allocate(heap, graph->count * sizeof(uint32_t));
    bool ok = before && level.parents;
    if (ok) level.count = choose_parents(graph, level.parents, before);
    memory_release(heap, before, graph->count * sizeof(uint32_t));
    ok = ok && list_members(heap, &level);
    if (ok) {
        size_t const blocks = 9 * level.count, vectors = 3 * level.count + SINGLE_PADDING;
        level.matrix_blocks = memory_allocate_zeroed(heap, blocks, sizeof(double));
        level.blocks = memory_allocate_zeroed(heap, blocks, sizeof(double));
        level.inverse = memory_allocate_zeroed(heap, blocks + SINGLE_PADDING, sizeof(float));
        level.residual = memory_allocate_zeroed(heap, vectors, sizeof(float));
        level.correction = memory_allocate_zeroed(heap, vectors, sizeof(float));
        ok = level.matrix_blocks && level.blocks && level.inverse && level.residual &&
             level.correction;
    }
    if (ok)
        all->levels[all->level_count++] = level;
    else
        release_level(heap, &level);
    return ok;
}

static bool add_levels(memory *heap, nested_aggregates *all, const block_matrix *matrix) {
    /* The matrix's rows are used as they are. They also name each vertex itself, which does no
     * harm. */
    member_graph graph = {all->vertex_count, (uint32_t *)(uintptr_t)matrix->row_begin,
                          (uint32_t *)(uintptr_t)matrix->columns};
    bool ok = true;
    for (size_t l = 0; ok && l < AGGREGATE_LEVELS_MAX; l++) {
        size_t joined_count = 0; /* members with another neighbour */
        for (size_t m = 0; m < graph.count; m++) {
            bool is_alone = true;
            for (uint32_t k = graph.begin[m]; k < graph.begin[m + 1]; k++)
                is_alone &= graph.neighbours[k] == m;
            joined_count += !is_alone;
        }
        if (joined_count <= FEW_AGGREGATES) break;
        ok = add_level(heap, all, &graph);
        if (!ok) break;
        member_graph coarse;
        ok = make_coarse_graph(heap, &graph, &all->levels[l], &coarse);
        if (l > 0) release_graph(heap, &graph);
        graph = coarse;
    }
    if (graph.begin != matrix->row_begin) release_graph(heap, &graph);
    return ok;
}

/* For each entry of a pattern the first level whose aggregates join its row and column. */
static void find_entry_levels(const nested_aggregates *all, const uint32_t *begin,
                              const uint32_t *columns, uint8_t *levels) {
    for (uint32_t row = 0; row < all->vertex_count; row++) {
        for (uint32_t k = begin[row]; k < begin[row + 1]; k++) {
            uint32_t a = row, b = columns[k];
            size_t level = 0;
            for (; level < all->level_count; level++) {
                a = all->levels[level].parents[a];
                b = all->levels[level].parents[b];
                if (a == b) break;
            }
            levels[k] = (uint8_t)level;
        }
    }
}

nested_aggregates *nested_aggregates_build(memory *heap, const block_matrix *matrix) {
    nested_aggregates *const all = memory_allocate_zeroed(heap, 1, sizeof *all);
    if (!all) return NULL;
    all->vertex_count = matrix->row_count;
    all->block_count = matrix->block_count;
    all->scalar_count = matrix->scalar_count;
    all->block_levels = memory_allocate(heap, all->block_count);
    all->scalar_levels = memory_allocate(heap, all->scalar_count);
    all->is_fixed = memory_allocate_zeroed(heap, all->vertex_count, 1);
    all->partials = memory_allocate_zeroed(heap, all->vertex_count, sizeof(double));
    if (!all->block_levels || !all->scalar_levels || !all->is_fixed || !all->partials ||
        !add_levels(heap, all, matrix)) {
        nested_aggregates_destroy(heap, all);
        return NULL;
    }
    find_entry_levels(all, matrix->row_begin, matrix->columns, all->block_levels);
    find_entry_levels(all, matrix->scalar_begin, matrix->scalar_columns, all->scalar_levels);
    return all;
}

void nested_aggregates_destroy(memory *heap, nested_aggregates *aggregates) {
    if (!aggregates) return;
    for (size_t l = 0; l < aggregates->level_count; l++)
        release_level(heap, &aggregates->levels[l]);
    memory_release(heap, aggregates->block_levels, aggregates->block_count);
    memory_release(heap, aggregates->scalar_levels, aggregates->scalar_count);
    memory_release(heap, aggregates->is_fixed, aggregates->vertex_count);
    memory_release(heap, aggregates->partials, aggregates->vertex_count * sizeof(double));
    memory_release(heap, aggregates, sizeof *aggregates);
}
