/* math/dissection.c - nested dissection, see dissection.h.
 *
 * A set of vertices is cut in two halves by a plane; the vertices of one half that touch the other
 * separate them and are eliminated after both. Of several directions for the plane the one with the
 * fewest such vertices is taken. Small sets are eliminated whole.
 *
 * Based on: George, Nested dissection of a regular finite element mesh, 1973; Gilbert, Miller,
 * Teng, Geometric mesh partitioning: implementation and experiments, 1998 (cuts by position).
 * Departure: planes through the median along fixed directions, no circles. */
#include "math/dissection.h"

#include "math/vec3.h"

#include <stdlib.h>
#include <string.h>

/* Vertices that are eliminated together: fewer would make fronts too small for wide vectors. */
enum { WHOLE_SET = 8 };

enum { DIRECTION_COUNT = 9 };
static const vec3 DIRECTIONS[DIRECTION_COUNT] = {
    {1, 0, 0}, {0, 1, 0},  {0, 0, 1}, {1, 1, 0},  {1, -1, 0},
    {1, 0, 1}, {1, 0, -1}, {0, 1, 1}, {0, 1, -1},
};

typedef struct keyed_vertex {
    double key;
    uint32_t vertex;
} keyed_vertex;

typedef struct cutter {
    memory *heap;
    block_pattern pattern;
    const double *positions;
    keyed_vertex *keys; /* of the set that is cut */
    uint32_t *sides;    /* of each vertex: 2 * number of the cut + half */
    uint32_t cut_count;
    dissection *result;
    bool has_memory;
} cutter;

static int compare_keys(const void *a, const void *b) {
    const keyed_vertex *const x = a, *const y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return (x->vertex > y->vertex) - (x->vertex < y->vertex);
}

/* Sorts a set along a direction. */
static void sort_along(cutter *work, uint32_t *set, size_t count, vec3 direction) {
    for (size_t i = 0; i < count; i++) {
        double const key =
            work->positions ? vec3_dot(direction, vec3_load(work->positions, set[i])) : 0.0;
        work->keys[i] = (keyed_vertex){key, set[i]};
    }
    qsort(work->keys, count, sizeof *work->keys, compare_keys);
    for (size_t i = 0; i < count; i++) set[i] = work->keys[i].vertex;
}

static bool touches_side(const cutter *work, uint32_t vertex, uint32_t side) {
    for (uint32_t k = work->pattern.begin[vertex]; k < work->pattern.begin[vertex + 1]; k++)
        if (work->sides[work->pattern.columns[k]] == side) return true;
    return false;
}

/* The sides of the set's halves, and how many vertices of the half that has fewer of them touch the
 * other; *half says which it is. */
static size_t cut_in_halves(cutter *work, const uint32_t *set, size_t count, uint32_t *half) {
    uint32_t const sides[2] = {2 * work->cut_count, 2 * work->cut_count + 1};
    work->cut_count++;
    for (size_t i = 0; i < count; i++) work->sides[set[i]] = sides[i >= count / 2];
    size_t touching[2] = {0, 0};
    for (size_t i = 0; i < count; i++) {
        uint32_t const side = i >= count / 2;
        touching[side] += touches_side(work, set[i], sides[1 - side]);
    }
    *half = touching[1] < touching[0];
    return touching[*half];
}

/* Orders the set as first half, second half, separator. */
static void split_set(cutter *work, uint32_t *set, size_t count, size_t sizes[2]) {
    size_t best = 0, least = SIZE_MAX;
    uint32_t half = 0;
    for (size_t d = 0; d < DIRECTION_COUNT; d++) {
        sort_along(work, set, count, DIRECTIONS[d]);
        size_t const touching = cut_in_halves(work, set, count, &half);
        if (touching < least) least = touching, best = d;
    }
    sort_along(work, set, count, DIRECTIONS[best]);
    cut_in_halves(work, set, count, &half);
    uint32_t const other = 2 * (work->cut_count - 1) + 1 - half;
    size_t place[2] = {0, 0}, separator = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t const side = i >= count / 2, vertex = set[i];
        if (side == half && touches_side(work, vertex, other))
            work->keys[separator++].vertex = vertex;
        else
            set[side ? place[0] + place[1] : place[0]] = vertex, place[side]++;
    }
    for (size_t i = 0; i < separator; i++) set[place[0] + place[1] + i] = work->keys[i].vertex;
    sizes[0] = place[0];
    sizes[1] = place[1];
}

/* Vertices that are near one another get near places. */
static void sort_own(cutter *work, uint32_t *set, size_t count) {
    size_t best = 0;
    double widest = -1.0;
    for (size_t d = 0; work->positions && d < DIRECTION_COUNT; d++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < count; i++) {
            double const key = vec3_dot(DIRECTIONS[d], vec3_load(work->positions, set[i])) /
                               vec3_norm(DIRECTIONS[d]);
            low = fmin(low, key);
            high = fmax(high, key);
        }
        if (high - low > widest) widest = high - low, best = d;
    }
    sort_along(work, set, count, DIRECTIONS[best]);
}

/* Makes the nodes of a set; the last is its root. */
static void dissect(cutter *work, size_t begin, size_t count, uint32_t depth) {
    uint32_t *const set = work->result->order + begin;
    size_t sizes[2] = {0, 0};
    uint32_t children[2] = {TULLE_NONE, TULLE_NONE};
    if (count > WHOLE_SET) {
        split_set(work, set, count, sizes);
        for (size_t side = 0; side < 2; side++) {
            if (sizes[side] == 0) continue;
            dissect(work, begin + (side ? sizes[0] : 0), sizes[side], depth + 1);
            children[side] = (uint32_t)work->result->nodes.count - 1;
        }
    }
    size_t const below = sizes[0] + sizes[1];
    sort_own(work, set + below, count - below);
    work->has_memory = work->has_memory && ARRAY_RESERVE(work->heap, &work->result->nodes, 1);
    if (!work->has_memory) return;
    uint32_t const node = (uint32_t)work->result->nodes.count++;
    work->result->nodes.data[node] =
        (dissection_node){(uint32_t)(begin + below), (uint32_t)(begin + count), TULLE_NONE, depth};
    for (size_t side = 0; side < 2; side++)
        if (children[side] != TULLE_NONE) work->result->nodes.data[children[side]].parent = node;
}

bool dissection_build(memory *heap, size_t vertex_count, block_pattern pattern,
                      const double *positions, dissection *result) {
    *result = (dissection){.vertex_count = vertex_count};
    cutter work = {
        .heap = heap, .pattern = pattern, .positions = positions, .result = result, .cut_count = 1};
    result->order = memory_allocate(heap, vertex_count * sizeof(uint32_t));
    work.keys = memory_allocate(heap, vertex_count * sizeof *work.keys);
    work.sides = memory_allocate_zeroed(heap, vertex_count, sizeof(uint32_t));
    work.has_memory = result->order && work.keys && work.sides;
    if (work.has_memory) {
        for (size_t v = 0; v < vertex_count; v++) result->order[v] = (uint32_t)v;
        dissect(&work, 0, vertex_count, 0);
    }
    memory_release(heap, work.keys, vertex_count * sizeof *work.keys);
    memory_release(heap, work.sides, vertex_count * sizeof(uint32_t));
    if (!work.has_memory) dissection_destroy(heap, result);
    return work.has_memory;
}

void dissection_destroy(memory *heap, dissection *result) {
    memory_release(heap, result->order, result->vertex_count * sizeof(uint32_t));
    ARRAY_FREE(heap, &result->nodes);
    *result = (dissection){0};
}
