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

/* Where along a direction a set is cut, as a part of its vertices. */
enum { PLACE_COUNT = 5 };
static const double PLACES[PLACE_COUNT] = {0.5, 0.45, 0.55, 0.4, 0.6};

/* An axis along which a set has less than this part of its largest width is not looked at. */
#define NARROW 0.02

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
    uint32_t *stamps;
    uint32_t cut_count, stamp;
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

/* How many vertices a part has, and how many outside the set that is cut touch it. */
typedef struct part_count {
    size_t vertices, halo;
} part_count;

typedef struct cut {
    size_t direction, count; /* vertices of the first half */
    uint32_t half;           /* that gives the separator */
    double work;
} cut;

/* Operations to eliminate a part and all below: those of a grid when each cut halves the vertices
 * and the halo and its separator has 0.8 sqrt(vertices) vertices. */
static double estimate_work(part_count part) {
    double const m = (double)part.vertices, b = (double)part.halo;
    return 20.3 * m * sqrt(m) + 5.4 * m * b + 1.24 * sqrt(m) * b * b;
}

/* Operations of the separator's own front. */
static double estimate_front(part_count separator) {
    double const s = (double)separator.vertices, b = (double)separator.halo;
    return s * (s * s / 3.0 + s * b + b * b);
}

/* Marks the halves of a set. */
static void mark_sides(cutter *work, const uint32_t *set, size_t size, size_t count) {
    work->cut_count++;
    for (size_t i = 0; i < size; i++) work->sides[set[i]] = 2 * work->cut_count + (i >= count);
}

static bool touches_side(const cutter *work, uint32_t vertex, uint32_t side) {
    for (uint32_t k = work->pattern.begin[vertex]; k < work->pattern.begin[vertex + 1]; k++)
        if (work->sides[work->pattern.columns[k]] == side) return true;
    return false;
}

/* The vertex is part `own`, 0 or 1, or the separator, 2: notes what it touches outside the set.
 * Stamps tell which parts have touched a vertex: one bit each. */
static void count_halo(cutter *work, uint32_t vertex, uint32_t own, part_count parts[3]) {
    for (uint32_t k = work->pattern.begin[vertex]; k < work->pattern.begin[vertex + 1]; k++) {
        uint32_t const u = work->pattern.columns[k];
        if (work->sides[u] / 2 == work->cut_count) continue;
        if (work->stamps[u] / 8 != work->stamp) work->stamps[u] = 8 * work->stamp;
        if (work->stamps[u] % 8 == 0) parts[2].halo++;
        if (own < 2 && !(work->stamps[u] >> own & 1U)) parts[own].halo++;
        work->stamps[u] |= 1U << own;
    }
}

/* Work of a cut of the marked set. */
static double rate_cut(cutter *work, const uint32_t *set, size_t size, uint32_t half) {
    part_count parts[3] = {0};
    work->stamp++;
    for (size_t i = 0; i < size; i++) {
        uint32_t own = work->sides[set[i]] % 2;
        if (own == half && touches_side(work, set[i], 2 * work->cut_count + 1 - half)) own = 2;
        parts[own].vertices++;
        count_halo(work, set[i], own, parts);
    }
    parts[0].halo += parts[2].vertices;
    parts[1].halo += parts[2].vertices;
    return estimate_front(parts[2]) + estimate_work(parts[0]) + estimate_work(parts[1]);
}

/* The best cut of a set sorted along a direction. */
static void try_direction(cutter *work, const uint32_t *set, size_t size, size_t direction,
                          cut *best) {
    for (size_t p = 0; p < PLACE_COUNT; p++) {
        size_t const count = (size_t)(PLACES[p] * (double)size);
        mark_sides(work, set, size, count);
        for (uint32_t half = 0; half < 2; half++) {
            double const rated = rate_cut(work, set, size, half);
            if (rated < best->work) *best = (cut){direction, count, half, rated};
        }
    }
}

/* Widths of the set along the axes. */
static vec3 measure_widths(const cutter *work, const uint32_t *set, size_t size) {
    vec3 low = vec3_load(work->positions, set[0]), high = low;
    for (size_t i = 1; i < size; i++) {
        vec3 const p = vec3_load(work->positions, set[i]);
        low = vec3_make(fmin(low.x, p.x), fmin(low.y, p.y), fmin(low.z, p.z));
        high = vec3_make(fmax(high.x, p.x), fmax(high.y, p.y), fmax(high.z, p.z));
    }
    return vec3_sub(high, low);
}

/* Whether a direction differs from those without a part along a narrow axis. */
static bool is_worth_trying(vec3 direction, vec3 widths) {
    double const least = NARROW * fmax(widths.x, fmax(widths.y, widths.z));
    return !(direction.x != 0.0 && widths.x < least) && !(direction.y != 0.0 && widths.y < least) &&
           !(direction.z != 0.0 && widths.z < least);
}

/* Orders the set as first half, second half, separator. */
static void split_set(cutter *work, uint32_t *set, size_t size, size_t sizes[2]) {
    cut best = {.work = INFINITY};
    vec3 const widths =
        work->positions ? measure_widths(work, set, size) : vec3_make(0.0, 0.0, 0.0);
    for (size_t d = 0; d < DIRECTION_COUNT; d++) {
        if (!(work->positions ? is_worth_trying(DIRECTIONS[d], widths) : d == 0)) continue;
        sort_along(work, set, size, DIRECTIONS[d]);
        try_direction(work, set, size, d, &best);
    }
    sort_along(work, set, size, DIRECTIONS[best.direction]);
    mark_sides(work, set, size, best.count);
    uint32_t const other = 2 * work->cut_count + 1 - best.half;
    size_t separator = 0, place = 0;
    sizes[0] = 0;
    for (size_t i = 0; i < size; i++) {
        uint32_t const side = i >= best.count, vertex = set[i];
        if (side == best.half && touches_side(work, vertex, other)) {
            work->keys[separator++].vertex = vertex;
            continue;
        }
        set[place++] = vertex;
        sizes[0] += side == 0;
    }
    sizes[1] = place - sizes[0];
    for (size_t i = 0; i < separator; i++) set[place + i] = work->keys[i].vertex;
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
    work.stamps = memory_allocate_zeroed(heap, vertex_count, sizeof(uint32_t));
    work.has_memory = result->order && work.keys && work.sides && work.stamps;
    if (work.has_memory) {
        for (size_t v = 0; v < vertex_count; v++) result->order[v] = (uint32_t)v;
        dissect(&work, 0, vertex_count, 0);
    }
    memory_release(heap, work.keys, vertex_count * sizeof *work.keys);
    memory_release(heap, work.sides, vertex_count * sizeof(uint32_t));
    memory_release(heap, work.stamps, vertex_count * sizeof(uint32_t));
    if (!work.has_memory) dissection_destroy(heap, result);
    return work.has_memory;
}

void dissection_destroy(memory *heap, dissection *result) {
    memory_release(heap, result->order, result->vertex_count * sizeof(uint32_t));
    ARRAY_FREE(heap, &result->nodes);
    *result = (dissection){0};
}
