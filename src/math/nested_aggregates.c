/* math/nested_aggregates.c - aggregates of a mesh, see nested_aggregates.h. Numbers are in
 * nested_aggregates_fill.c.
 *
 * Based on: Vanek, Mandel, Brezina, Algebraic multigrid by smoothed aggregation, 1996 (aggregates
 * are neighbourhoods that do not meet; what is left joins one of them). */
#include "math/nested_aggregates.h"

#include <string.h>

/* A level is the last when at most this many of its members have neighbours. Pieces of a cloth
 * never join, so members without neighbours do not count. Each of the others shares an aggregate
 * with a neighbour, so each level has at most half as many of them as the one below. */
enum { FEW_AGGREGATES = 8 };

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

/* The aggregates of a graph as a new level; false: no memory, and the level may be half made. */
static bool add_level(memory *heap, const member_graph *graph, arena *scratch,
                      nested_aggregates *all) {
    aggregate_level *const level = &all->levels[all->level_count++];
    level->member_count = graph->count;
    level->parents = memory_allocate(heap, graph->count * sizeof(uint32_t));
    uint32_t *const before = ARENA_NEW(scratch, uint32_t, graph->count);
    if (!level->parents || !before) return false;
    level->count = choose_parents(graph, level->parents, before);

    size_t const blocks = 9 * level->count, vectors = 3 * level->count + SINGLE_PADDING;
    level->member_begin = memory_allocate_zeroed(heap, level->count + 1, sizeof(uint32_t));
    level->members = memory_allocate(heap, level->member_count * sizeof(uint32_t));
    level->matrix_blocks = memory_allocate_zeroed(heap, blocks, sizeof(double));
    level->blocks = memory_allocate_zeroed(heap, blocks, sizeof(double));
    level->inverse = memory_allocate_zeroed(heap, blocks + SINGLE_PADDING, sizeof(float));
    level->residual = memory_allocate_zeroed(heap, vectors, sizeof(float));
    level->correction = memory_allocate_zeroed(heap, vectors, sizeof(float));
    level->dots = memory_allocate_zeroed(heap, level->count, sizeof(double));
    if (!level->member_begin || !level->members || !level->matrix_blocks || !level->blocks ||
        !level->inverse || !level->residual || !level->correction || !level->dots)
        return false;

    /* Sorts the members by aggregate. */
    uint32_t *const begin = level->member_begin;
    for (size_t m = 0; m < level->member_count; m++) begin[level->parents[m] + 1]++;
    for (size_t a = 0; a < level->count; a++) begin[a + 1] += begin[a];
    for (size_t m = level->member_count; m-- > 0;)
        level->members[--begin[level->parents[m] + 1]] = (uint32_t)m;
    /* Each entry has come down to the begin of the aggregate before it. */
    memmove(begin, begin + 1, level->count * sizeof(uint32_t));
    begin[level->count] = (uint32_t)level->member_count;
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

/* For each entry of a pattern the first level whose aggregates join its row and column. */
static void compute_entry_levels(const nested_aggregates *all, const uint32_t *begin,
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

nested_aggregates *nested_aggregates_build(memory *heap, const block_matrix *matrix,
                                           arena *scratch) {
    nested_aggregates *const all = memory_allocate_zeroed(heap, 1, sizeof *all);
    if (!all) return NULL;
    all->vertex_count = matrix->row_count;
    all->block_count = matrix->block_count;
    all->scalar_count = matrix->scalar_count;
    all->block_levels = memory_allocate(heap, all->block_count);
    all->scalar_levels = memory_allocate(heap, all->scalar_count);
    all->is_fixed = memory_allocate_zeroed(heap, all->vertex_count, 1);
    bool ok = all->block_levels && all->scalar_levels && all->is_fixed;

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
        ok = add_level(heap, &graph, scratch, all) &&
             make_coarse_graph(&graph, &all->levels[l], scratch, &coarse);
        graph = coarse;
    }
    arena_release(scratch, mark);
    if (!ok) {
        nested_aggregates_destroy(heap, all);
        return NULL;
    }
    compute_entry_levels(all, matrix->row_begin, matrix->columns, all->block_levels);
    compute_entry_levels(all, matrix->scalar_begin, matrix->scalar_columns, all->scalar_levels);
    return all;
}

void nested_aggregates_destroy(memory *heap, nested_aggregates *aggregates) {
    if (!aggregates) return;
    for (size_t l = 0; l < aggregates->level_count; l++) {
        const aggregate_level *const level = &aggregates->levels[l];
        size_t const vectors = 3 * level->count + SINGLE_PADDING;
        memory_release(heap, level->parents, level->member_count * sizeof(uint32_t));
        memory_release(heap, level->member_begin, (level->count + 1) * sizeof(uint32_t));
        memory_release(heap, level->members, level->member_count * sizeof(uint32_t));
        memory_release(heap, level->matrix_blocks, 9 * level->count * sizeof(double));
        memory_release(heap, level->blocks, 9 * level->count * sizeof(double));
        memory_release(heap, level->inverse, (9 * level->count + SINGLE_PADDING) * sizeof(float));
        memory_release(heap, level->residual, vectors * sizeof(float));
        memory_release(heap, level->correction, vectors * sizeof(float));
        memory_release(heap, level->dots, level->count * sizeof(double));
    }
    memory_release(heap, aggregates->block_levels, aggregates->block_count);
    memory_release(heap, aggregates->scalar_levels, aggregates->scalar_count);
    memory_release(heap, aggregates->is_fixed, aggregates->vertex_count);
    memory_release(heap, aggregates, sizeof *aggregates);
}
