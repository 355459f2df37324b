/* contact/commit/select_admissible.c - see select_admissible.h.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3.5 (admissible feature pairs). Departure: the condition is an angle with a
 * tolerance instead of a sign, so that the edges inside a flat mesh neither stop a slider nor come
 * and go with rounding. */
#include "contact/commit/select_admissible.h"

#include "contact/rows/normal_cones.h"

#include <string.h>

/* Part of a gap by which the inside of a triangle may be further than the rim and still replace
 * it: the slope tolerance's own size. */
#define RIM_GAP_TOLERANCE 0.02

/* Neighbourhood test of one row. */
typedef struct cone_test {
    const contact_scene *scene;
    const double *x1;
    double time;
    double slope_tolerances[2]; /* sines */
    bool *is_within;            /* of each; false: not asked for any more */
    vec3 outward;               /* unit, from the feature's surface towards the other body */
    const uint32_t *others;     /* vertices of the other feature ... */
    int other_count;            /* ... 0 when it is of another surface */
} cone_test;

static vec3 point_at(const cone_test *test, uint32_t vertex) {
    return vec3_lerp(vec3_load(test->scene->x0, vertex), vec3_load(test->x1, vertex), test->time);
}

static bool are_neighbours(const topology *topo, uint32_t a, uint32_t b) {
    const adjacency *const around = &topo->vertex_neighbours;
    for (uint32_t i = around->begin[a]; i < around->begin[a + 1]; i++)
        if (around->items[i] == b) return true;
    return false;
}

/* Inside a narrow fold both features hang on one vertex, and points ever nearer to each other lie
 * towards it. That vertex says nothing against the pair: no other pair would hold the fold open. */
static bool joins_both_features(const cone_test *test, uint32_t vertex) {
    for (int k = 0; k < test->other_count; k++)
        if (vertex == test->others[k] ||
            are_neighbours(test->scene->set->topo, vertex, test->others[k]))
            return true;
    return false;
}

/* False when no tolerance holds any more. */
static bool test_neighbour(const cone_test *test, vec3 contact_point, uint32_t neighbour) {
    vec3 const to = vec3_sub(point_at(test, neighbour), contact_point);
    double const height = vec3_dot(test->outward, to);
    if (height <= 0.0) return true;
    double const length = vec3_norm(to);
    bool *const is_within = test->is_within;
    bool const is_behind[2] = {height <= test->slope_tolerances[0] * length,
                               height <= test->slope_tolerances[1] * length};
    if ((is_behind[0] || !is_within[0]) && (is_behind[1] || !is_within[1])) return true;
    if (joins_both_features(test, neighbour)) return true;
    is_within[0] &= is_behind[0];
    is_within[1] &= is_behind[1];
    return is_within[0] || is_within[1];
}

static void test_vertex_cone(const cone_test *test, uint32_t vertex) {
    const adjacency *const around = &test->scene->set->topo->vertex_neighbours;
    vec3 const point = point_at(test, vertex);
    for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++)
        if (!test_neighbour(test, point, around->items[i])) return;
}

static void test_edge_cone(const cone_test *test, uint32_t edge, vec3 contact_point) {
    const uint32_t *const opposites = test->scene->set->topo->edge_opposites + 2 * (size_t)edge;
    for (int k = 0; k < 2; k++)
        if (opposites[k] != TULLE_NONE && !test_neighbour(test, contact_point, opposites[k]))
            return;
}

static vec3 blend_side(const cone_test *test, const contact_row *row, int begin, int end) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (int k = begin; k < end; k++)
        sum = vec3_add_scaled(sum, point_at(test, row->frame.vertices[k]),
                              fabs(row->frame.weights[k]));
    return sum;
}

/* Turns the test to the row's first feature, or its second. */
static void face_feature(cone_test *test, const contact_row *row, bool is_first) {
    const uint32_t *const surface = test->scene->vertex_surface;
    int const first_count = row->frame.kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    test->outward = is_first ? vec3_neg(row->frame.normal) : row->frame.normal;
    test->others = is_first ? row->frame.vertices + first_count : row->frame.vertices;
    test->other_count = is_first ? 4 - first_count : first_count;
    if (surface[row->frame.vertices[0]] != surface[row->frame.vertices[3]]) test->other_count = 0;
}

static void test_vertex_row(cone_test *test, const contact_row *row) {
    face_feature(test, row, true);
    test_vertex_cone(test, row->frame.vertices[0]);
    if (!test->is_within[0] && !test->is_within[1]) return;
    face_feature(test, row, false);
    uint32_t feature = 0;
    switch (find_rim_part(test->scene->set->topo, row, &feature)) {
    case RIM_INSIDE: break;
    case RIM_EDGE: test_edge_cone(test, feature, blend_side(test, row, 1, 4)); break;
    case RIM_VERTEX: test_vertex_cone(test, feature); break;
    }
}

bool is_on_rim(const double weights[4]) {
    for (int k = 0; k < 4; k++)
        if (fabs(weights[k]) < RIM_WEIGHT) return true;
    return false;
}

static void test_edge_row(cone_test *test, const contact_row *row) {
    face_feature(test, row, true);
    test_edge_cone(test, row->frame.pair.first, blend_side(test, row, 0, 2));
    if (!test->is_within[0] && !test->is_within[1]) return;
    face_feature(test, row, false);
    test_edge_cone(test, row->frame.pair.second, blend_side(test, row, 2, 4));
}

void test_admissible(const contact_scene *scene, const double *x1, const contact_row *row,
                     double time, const double slope_tolerances[2], bool is_within[2]) {
    cone_test test = {.scene = scene,
                      .x1 = x1,
                      .time = time,
                      .slope_tolerances = {slope_tolerances[0], slope_tolerances[1]},
                      .is_within = is_within};
    bool const is_edge_row = row->frame.kind == FEATURE_EDGE_EDGE;
    if (is_edge_row && is_on_rim(row->frame.weights)) is_within[0] = is_within[1] = false;
    if (!is_within[0] && !is_within[1]) return;
    if (is_edge_row)
        test_edge_row(&test, row);
    else
        test_vertex_row(&test, row);
}

static bool triangles_share_vertex(const contact_row *a, const contact_row *b) {
    for (int i = 1; i < 4; i++)
        for (int j = 1; j < 4; j++)
            if (a->frame.vertices[i] == b->frame.vertices[j]) return true;
    return false;
}

/* What a rim row touches; part RIM_INSIDE for the others. */
typedef struct rim_label {
    rim_part part;
    uint32_t feature;
} rim_label;

/* The row of a rim whose vertex is nearer to the inside of a triangle next to it, or that repeats
 * an earlier row of the same vertex. Rows begin .. end-1 are those of the vertex. */
static bool is_redundant(contact_row *const *rows, const rim_label *labels, size_t begin,
                         size_t end, size_t i) {
    if (labels[i].part == RIM_INSIDE) return false;
    /* Frames of later times tilt a little, which shortens the gap by as much. */
    double const gap = rows[i]->frame.gap + RIM_GAP_TOLERANCE * fabs(rows[i]->frame.gap);
    for (size_t j = begin; j < end; j++) {
        bool const is_same =
            labels[j].part == labels[i].part && labels[j].feature == labels[i].feature;
        if (is_same && j < i) return true;
        if (labels[j].part == RIM_INSIDE && rows[j]->frame.gap <= gap &&
            triangles_share_vertex(rows[i], rows[j]))
            return true;
    }
    return false;
}

/* Two vertices nearest to each other: the row of the smaller one stays. Looks among the rows of
 * vertex `other`, of which `found` is any, or after the end if it has none. */
static bool has_mirror_row(contact_row *const *rows, const rim_label *labels, size_t count,
                           uint32_t vertex, uint32_t other) {
    size_t low = 0, high = count;
    while (low < high) {
        size_t const middle = low + (high - low) / 2;
        if (rows[middle]->frame.pair.first < other)
            low = middle + 1;
        else
            high = middle;
    }
    for (; low < count && rows[low]->frame.pair.first == other; low++)
        if (labels[low].part == RIM_VERTEX && labels[low].feature == vertex) return true;
    return false;
}

static void mark_redundant(contact_row *const *rows, const rim_label *labels, size_t count,
                           bool *is_dropped) {
    for (size_t begin = 0, end; begin < count; begin = end) {
        uint32_t const vertex = rows[begin]->frame.pair.first;
        for (end = begin; end < count && rows[end]->frame.pair.first == vertex;) end++;
        for (size_t i = begin; i < end; i++) {
            is_dropped[i] = is_redundant(rows, labels, begin, end, i);
            if (labels[i].part == RIM_VERTEX && labels[i].feature < vertex)
                is_dropped[i] |= has_mirror_row(rows, labels, count, vertex, labels[i].feature);
        }
    }
}

tulle_status thin_rim_rows(const contact_scene *scene, contact_row **rows, size_t *count) {
    size_t vertex_row_count = 0;
    while (vertex_row_count < *count &&
           rows[vertex_row_count]->frame.kind == FEATURE_VERTEX_TRIANGLE)
        vertex_row_count++;
    arena_mark const mark = arena_get_mark(scene->scratch);
    rim_label *const labels = ARENA_NEW(scene->scratch, rim_label, vertex_row_count);
    bool *const is_dropped = ARENA_NEW_ZEROED(scene->scratch, bool, *count);
    if (!labels || !is_dropped) {
        arena_release(scene->scratch, mark);
        return TULLE_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < vertex_row_count; i++) {
        labels[i].feature = 0;
        labels[i].part = find_rim_part(scene->set->topo, rows[i], &labels[i].feature);
    }
    mark_redundant(rows, labels, vertex_row_count, is_dropped);
    size_t kept = 0;
    for (size_t i = 0; i < *count; i++)
        if (!is_dropped[i]) rows[kept++] = rows[i];
    *count = kept;
    arena_release(scene->scratch, mark);
    return TULLE_OK;
}
