/* subdivision/loop_subdivision_rows.c - the masks of Loop subdivision as rows of sparse matrices.
 *
 * Edge points: 3/8, 3/8 of the ends and 1/8, 1/8 of the opposite vertices, changed near sharp
 * vertices as the spoke rules say; 1/2, 1/2 on sharp edges. Vertices: (1 - n w, w ... w) with the
 * weight w of n neighbours; 1/8, 3/4, 1/8 along creases; 1 where fixed. Limits: the left
 * eigenvectors of those masks for the eigenvalue 1. Every row sums to one.
 *
 * Based on: Loop, Smooth subdivision surfaces based on triangles, 1987 (masks and limits of smooth
 * vertices, with his weights); Hoppe et al., Piecewise smooth surface reconstruction, 1994
 * (creases); Biermann, Levin, Zorin, 2000 (sectors). The limit mask of a dart is our own. */
#include "subdivision/loop_subdivision.h"

#include <math.h>

static const double PI = 3.14159265358979323846;
static const double DART_Q = 0.20871215252208009; /* (5 - sqrt(21)) / 2 */

/* An edge point needs six vertices at most with one flattened end, eight with two. */
enum { EDGE_ENTRY_MAX = 8 };

typedef struct edge_mask {
    size_t count;
    uint32_t columns[EDGE_ENTRY_MAX];
    double weights[EDGE_ENTRY_MAX];
} edge_mask;

/* Fills rows one after the other. */
typedef struct row_filler {
    const subdivision_level *level;
    const spoke_rule *rules;
    subdivision_rows *rows;
    bool is_limit;
    uint32_t *valences; /* vertex_count: edges */
    uint32_t *cursors;  /* vertex_count: the next free entry of each vertex's row */
} row_filler;

/* (5/8 - (3/8 + cos(2 pi / n) / 4)^2) / n */
double subdivision_get_neighbour_weight(uint32_t n) {
    if (n == 6) return 0.0625;
    double const middle = 0.375 + 0.25 * cos(2.0 * PI / n);
    return (0.625 - middle * middle) / n;
}

/* 1 / (n + 3 / (8 w)) */
double subdivision_get_limit_weight(uint32_t n) {
    if (n == 6) return 1.0 / 12.0;
    return 1.0 / (n + 0.375 / subdivision_get_neighbour_weight(n));
}

/* Limit weight of a dart's neighbour relative to that of the dart itself. The left eigenvector of
 * eigenvalue 1 satisfies 5 l_j - l_(j-1) - l_(j+1) = 8 w between l_0 = l_n = 0, the places of the
 * sharp edge, and 1/2 l = w + (l_1 + l_(n-1)) / 8 at that edge itself. With q + 1/q = 5 that is
 * l_j = 8/3 w (1 - (q^j + q^(n-j)) / (1 + q^n)). */
static double get_dart_ratio(uint32_t n, uint32_t position) {
    double const weight = subdivision_get_neighbour_weight(n);
    if (position == 0) return 2.0 * weight + 0.5 * get_dart_ratio(n, 1);
    double const left = pow(DART_Q, position), right = pow(DART_Q, n - position);
    return 8.0 / 3.0 * weight * (1.0 - (left + right) / (1.0 + pow(DART_Q, n)));
}

/* One and the ratios of all n neighbours. */
static double get_dart_sum(uint32_t n) {
    double const powers = 2.0 * (DART_Q - pow(DART_Q, n)) / (1.0 - DART_Q);
    double const sum = n - 1 - powers / (1.0 + pow(DART_Q, n));
    return 1.0 + get_dart_ratio(n, 0) + 8.0 / 3.0 * subdivision_get_neighbour_weight(n) * sum;
}

static void add_to_mask(edge_mask *mask, uint32_t column, double weight) {
    size_t at = 0;
    while (at < mask->count && mask->columns[at] != column) at++;
    if (at == mask->count) {
        mask->columns[mask->count] = column;
        mask->weights[mask->count++] = 0.0;
    }
    mask->weights[at] += weight;
}

/* The neighbour of a concave corner along a side of its sector, at this level. */
static uint32_t get_side_vertex(const subdivision_level *level, const spoke_rule *rule, int side) {
    size_t const parts = (size_t)1 << level->depth;
    size_t const edge = rule->side_edges[side] * parts + rule->side_ends[side] * (parts - 1);
    return level->edges[2 * edge + 1 - rule->side_ends[side]];
}

/* Adds `share` of the mask of a smooth edge as the rule at one of its ends has it. */
static void add_end_rule(const subdivision_level *level, size_t e, size_t end,
                         const spoke_rule *rule, double share, edge_mask *mask) {
    uint32_t const near = level->edges[2 * e + end], far = level->edges[2 * e + 1 - end];
    double const kept = share * (1.0 - rule->flatness), drawn = share * rule->flatness;
    add_to_mask(mask, near, kept * (0.75 - rule->far_weight));
    add_to_mask(mask, far, kept * rule->far_weight);
    add_to_mask(mask, level->edge_opposites[2 * e], 0.125 * kept);
    add_to_mask(mask, level->edge_opposites[2 * e + 1], 0.125 * kept);
    if (drawn == 0.0) return;
    const double *const side = rule->side_weights;
    add_to_mask(mask, near, drawn * (1.0 - 0.5 * (side[0] + side[1])));
    for (int i = 0; i < 2; i++)
        add_to_mask(mask, get_side_vertex(level, rule, i), 0.5 * drawn * side[i]);
}

/* Whether the rule changes the edge's mask; rules of darts only number their edges. */
static bool changes_mask(const spoke_rule *rule) {
    return rule->far_weight != 0.375 || rule->flatness != 0.0;
}

static void make_edge_mask(const row_filler *filler, size_t e, edge_mask *mask) {
    const subdivision_level *const level = filler->level;
    mask->count = 0;
    if (level->edge_is_sharp[e]) {
        add_to_mask(mask, level->edges[2 * e], 0.5);
        add_to_mask(mask, level->edges[2 * e + 1], 0.5);
        return;
    }
    const spoke_rule *const ends[2] = {&filler->rules[level->spoke_rules[2 * e]],
                                       &filler->rules[level->spoke_rules[2 * e + 1]]};
    bool const changes[2] = {changes_mask(ends[0]), changes_mask(ends[1])};
    double const share = changes[0] && changes[1] ? 0.5 : 1.0;
    if (changes[0] || !changes[1]) add_end_rule(level, e, 0, ends[0], share, mask);
    if (changes[1]) add_end_rule(level, e, 1, ends[1], share, mask);
}

static void add_entry(row_filler *filler, uint32_t row, uint32_t column, double weight) {
    uint32_t const at = filler->cursors[row]++;
    filler->rows->columns[at] = column;
    filler->rows->weights[at] = weight;
}

static bool has_neighbour_weight(const subdivision_level *level, size_t e, size_t end) {
    uint8_t const rule = level->vertex_rules[level->edges[2 * e + end]];
    return rule == VERTEX_SMOOTH || rule == VERTEX_DART ||
           (rule == VERTEX_CREASE && level->edge_is_sharp[e]);
}

/* Weight, in the row of a vertex, of its neighbour along an edge that has_neighbour_weight. */
static double get_weight(const row_filler *filler, size_t e, size_t end) {
    const subdivision_level *const level = filler->level;
    uint32_t const vertex = level->edges[2 * e + end], n = filler->valences[vertex];
    uint8_t const rule = level->vertex_rules[vertex];
    if (rule == VERTEX_CREASE) return filler->is_limit ? 1.0 / 6.0 : 0.125;
    if (!filler->is_limit) return subdivision_get_neighbour_weight(n);
    if (rule == VERTEX_SMOOTH) return subdivision_get_limit_weight(n);
    uint32_t const position = filler->rules[level->spoke_rules[2 * e + end]].dart_position;
    return get_dart_ratio(n, position) / get_dart_sum(n);
}

/* Weight of a vertex in its own row. */
static double get_own_weight(const row_filler *filler, size_t vertex) {
    uint32_t const n = filler->valences[vertex];
    switch ((vertex_rule)filler->level->vertex_rules[vertex]) {
    case VERTEX_FIXED: return 1.0;
    case VERTEX_CREASE: return filler->is_limit ? 2.0 / 3.0 : 0.75;
    case VERTEX_SMOOTH:
        return 1.0 - n * (filler->is_limit ? subdivision_get_limit_weight(n)
                                           : subdivision_get_neighbour_weight(n));
    case VERTEX_DART:
        return filler->is_limit ? 1.0 / get_dart_sum(n)
                                : 1.0 - n * subdivision_get_neighbour_weight(n);
    }
    return 1.0;
}

/* Whether the other end of a smooth edge changes its mask. Limit masks hold for standard edges, so
 * what the change does to the next ring of this end is added to its row. */
static bool needs_correction(const row_filler *filler, size_t e, size_t end) {
    const subdivision_level *const level = filler->level;
    uint32_t const other_rule = level->spoke_rules[2 * e + 1 - end];
    return filler->is_limit && other_rule != 0 && !level->edge_is_sharp[e] &&
           changes_mask(&filler->rules[other_rule]) && has_neighbour_weight(level, e, end);
}

/* Corrections take the weight of the edge times the difference of the two masks. */
static void add_correction(row_filler *filler, size_t e, size_t end) {
    const subdivision_level *const level = filler->level;
    uint32_t const row = level->edges[2 * e + end];
    double const weight = get_weight(filler, e, end);
    edge_mask mask;
    make_edge_mask(filler, e, &mask);
    add_to_mask(&mask, row, -0.375);
    add_to_mask(&mask, level->edges[2 * e + 1 - end], -0.375);
    add_to_mask(&mask, level->edge_opposites[2 * e], -0.125);
    add_to_mask(&mask, level->edge_opposites[2 * e + 1], -0.125);
    for (size_t i = 0; i < EDGE_ENTRY_MAX; i++)
        add_entry(filler, row, i < mask.count ? mask.columns[i] : row,
                  i < mask.count ? weight * mask.weights[i] : 0.0);
}

static void count_valences(row_filler *filler) {
    const subdivision_level *const level = filler->level;
    for (size_t v = 0; v < level->vertex_count; v++) filler->valences[v] = 0;
    for (size_t i = 0; i < 2 * level->edge_count; i++) filler->valences[level->edges[i]]++;
}

/* Entries of the vertices' rows, left in cursors. */
static void count_vertex_entries(row_filler *filler) {
    const subdivision_level *const level = filler->level;
    for (size_t v = 0; v < level->vertex_count; v++) filler->cursors[v] = 1;
    for (size_t e = 0; e < level->edge_count; e++) {
        for (size_t end = 0; end < 2; end++) {
            uint32_t *const count = &filler->cursors[level->edges[2 * e + end]];
            if (has_neighbour_weight(level, e, end)) (*count)++;
            if (needs_correction(filler, e, end)) *count += EDGE_ENTRY_MAX;
        }
    }
}

/* Turns counts into begins, for the vertices' rows and, of a refinement, the edges'. */
static void lay_out_rows(row_filler *filler) {
    const subdivision_level *const level = filler->level;
    subdivision_rows *const rows = filler->rows;
    edge_mask mask;
    uint32_t at = 0;
    for (size_t v = 0; v < level->vertex_count; v++) {
        rows->begin[v] = at;
        at += filler->cursors[v];
        filler->cursors[v] = rows->begin[v];
    }
    for (size_t r = level->vertex_count; r < rows->row_count; r++) {
        rows->begin[r] = at;
        make_edge_mask(filler, r - level->vertex_count, &mask);
        at += (uint32_t)mask.count;
    }
    rows->begin[rows->row_count] = at;
    rows->entry_count = at;
}

static void fill_vertex_rows(row_filler *filler) {
    const subdivision_level *const level = filler->level;
    for (size_t v = 0; v < level->vertex_count; v++)
        add_entry(filler, (uint32_t)v, (uint32_t)v, get_own_weight(filler, v));
    for (size_t e = 0; e < level->edge_count; e++) {
        for (size_t end = 0; end < 2; end++) {
            const uint32_t *const ends = level->edges + 2 * e;
            if (has_neighbour_weight(level, e, end))
                add_entry(filler, ends[end], ends[1 - end], get_weight(filler, e, end));
            if (needs_correction(filler, e, end)) add_correction(filler, e, end);
        }
    }
}

static void fill_edge_rows(row_filler *filler) {
    subdivision_rows *const rows = filler->rows;
    edge_mask mask;
    for (size_t r = filler->level->vertex_count; r < rows->row_count; r++) {
        make_edge_mask(filler, r - filler->level->vertex_count, &mask);
        for (size_t i = 0; i < mask.count; i++) {
            rows->columns[rows->begin[r] + i] = mask.columns[i];
            rows->weights[rows->begin[r] + i] = mask.weights[i];
        }
    }
}

static bool fill_rows(memory *heap, row_filler *filler) {
    subdivision_rows *const rows = filler->rows;
    rows->begin = memory_allocate(heap, (rows->row_count + 1) * sizeof *rows->begin);
    if (!rows->begin) return false;
    count_valences(filler);
    count_vertex_entries(filler);
    lay_out_rows(filler);
    rows->columns = memory_allocate(heap, rows->entry_count * sizeof *rows->columns);
    rows->weights = memory_allocate(heap, rows->entry_count * sizeof *rows->weights);
    if (!rows->columns || !rows->weights) return false;
    fill_vertex_rows(filler);
    fill_edge_rows(filler);
    return true;
}

static bool make_rows(memory *heap, const subdivision_level *level, const spoke_rule_table *rules,
                      bool is_limit, subdivision_rows *rows) {
    size_t const bytes = level->vertex_count * sizeof(uint32_t);
    *rows =
        (subdivision_rows){.row_count = level->vertex_count + (is_limit ? 0 : level->edge_count),
                           .column_count = level->vertex_count};
    row_filler filler = {.level = level,
                         .rules = rules->data,
                         .rows = rows,
                         .is_limit = is_limit,
                         .valences = memory_allocate(heap, bytes),
                         .cursors = memory_allocate(heap, bytes)};
    bool const is_filled = filler.valences && filler.cursors && fill_rows(heap, &filler);
    memory_release(heap, filler.valences, bytes);
    memory_release(heap, filler.cursors, bytes);
    if (!is_filled) subdivision_rows_destroy(heap, rows);
    return is_filled;
}

bool subdivision_rows_refine(memory *heap, const subdivision_level *level,
                             const spoke_rule_table *rules, subdivision_rows *rows) {
    return make_rows(heap, level, rules, false, rows);
}

bool subdivision_rows_limit(memory *heap, const subdivision_level *level,
                            const spoke_rule_table *rules, subdivision_rows *rows) {
    return make_rows(heap, level, rules, true, rows);
}

void subdivision_rows_destroy(memory *heap, subdivision_rows *rows) {
    memory_release(heap, rows->begin, (rows->row_count + 1) * sizeof *rows->begin);
    memory_release(heap, rows->columns, rows->entry_count * sizeof *rows->columns);
    memory_release(heap, rows->weights, rows->entry_count * sizeof *rows->weights);
    *rows = (subdivision_rows){0};
}
