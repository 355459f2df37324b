/* contact/rows/admissible_rows.c - see admissible_rows.h.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3.5 (admissible feature pairs). Departure: the condition is an angle with a
 * tolerance instead of a sign, so that the edges inside a flat mesh neither stop a slider nor come
 * and go with rounding. */
#include "contact/rows/admissible_rows.h"

#include "contact/rows/normal_cones.h"

#include <string.h>

/* Part of a gap by which the inside of a triangle may be further than the rim and still replace
 * it: the slope tolerance's own size. */
static const double RIM_GAP_TOLERANCE = 0.02;

/* The neighbourhood of one feature of a row. */
typedef struct cone_test {
    const contact_scene *scene;
    const double *x1;
    double time;
    const double *slope_tolerances; /* two sines */
    bool *is_within;                /* of each; false: not asked for */
    vec3 point;                     /* [m] of contact, on the feature */
    vec3 outward;                   /* unit, from the feature's surface towards the other body */
    const uint32_t *others;         /* vertices of the other feature ... */
    int other_count;                /* ... 0 when it is of another surface */
} cone_test;

/* Inside a narrow fold both features hang on one vertex, and points ever nearer to each other lie
 * towards it. That vertex says nothing against the pair: no other pair would hold the fold open. */
static bool joins_both_features(const cone_test *test, uint32_t vertex) {
    const adjacency *const around = &test->scene->set->topo->vertex_neighbours;
    for (int k = 0; k < test->other_count; k++) {
        if (vertex == test->others[k]) return true;
        for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++)
            if (around->items[i] == test->others[k]) return true;
    }
    return false;
}

/* Tests neighbours of the feature, or TULLE_NONE, until both tolerances have failed. */
static void test_neighbours(const cone_test *test, const uint32_t *neighbours, size_t count) {
    const contact_scene *const scene = test->scene;
    bool *const is_within = test->is_within;
    for (size_t i = 0; i < count && (is_within[0] || is_within[1]); i++) {
        uint32_t const v = neighbours[i];
        if (v == TULLE_NONE) continue;
        vec3 const at = vec3_lerp(vec3_load(scene->x0, v), vec3_load(test->x1, v), test->time);
        vec3 const to = vec3_sub(at, test->point);
        double const height = vec3_dot(test->outward, to);
        if (height <= 0.0) continue;
        double const length = vec3_norm(to);
        bool const is_behind[2] = {height <= test->slope_tolerances[0] * length,
                                   height <= test->slope_tolerances[1] * length};
        if ((is_behind[0] || !is_within[0]) && (is_behind[1] || !is_within[1])) continue;
        if (joins_both_features(test, v)) continue;
        is_within[0] &= is_behind[0];
        is_within[1] &= is_behind[1];
    }
}

bool is_on_rim(const double weights[4]) {
    for (int k = 0; k < 4; k++)
        if (fabs(weights[k]) < RIM_WEIGHT) return true;
    return false;
}

void test_admissible(const contact_scene *scene, const double *x1, const contact_row *row,
                     double time, const double slope_tolerances[2], bool is_within[2]) {
    const row_frame *const frame = &row->frame;
    const topology *const topo = scene->set->topo;
    bool const is_edge_row = frame->kind == FEATURE_EDGE_EDGE;
    bool const is_one_surface =
        scene->vertex_surface[frame->vertices[0]] == scene->vertex_surface[frame->vertices[3]];
    int const split = is_edge_row ? 2 : 1;
    if (is_edge_row && is_on_rim(frame->weights)) is_within[0] = is_within[1] = false;
    for (int side = 0; side < 2 && (is_within[0] || is_within[1]); side++) {
        int const begin = side == 0 ? 0 : split, end = side == 0 ? split : 4;
        cone_test test = {.scene = scene,
                          .x1 = x1,
                          .time = time,
                          .slope_tolerances = slope_tolerances,
                          .is_within = is_within,
                          .outward = side == 0 ? vec3_neg(frame->normal) : frame->normal,
                          .others = frame->vertices + (side == 0 ? split : 0),
                          .other_count = is_one_surface ? 4 - (end - begin) : 0};
        /* what the row touches on this side */
        rim_part part = is_edge_row ? RIM_EDGE : RIM_VERTEX;
        uint32_t feature = side == 0 ? frame->pair.first : frame->pair.second;
        if (!is_edge_row && side == 1) part = find_rim_part(topo, row, &feature);
        if (part == RIM_VERTEX) {
            const adjacency *const around = &topo->vertex_neighbours;
            uint32_t const first = around->begin[feature];
            test.point = vec3_lerp(vec3_load(scene->x0, feature), vec3_load(x1, feature), time);
            test_neighbours(&test, around->items + first, around->begin[feature + 1] - first);
        } else if (part == RIM_EDGE) {
            for (int k = begin; k < end; k++) {
                uint32_t const v = frame->vertices[k];
                vec3 const at = vec3_lerp(vec3_load(scene->x0, v), vec3_load(x1, v), time);
                test.point = vec3_add_scaled(test.point, at, fabs(frame->weights[k]));
            }
            test_neighbours(&test, topo->edge_opposites + 2 * (size_t)feature, 2);
        }
    }
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
    double const own = rows[i]->frame.gap, gap = own + RIM_GAP_TOLERANCE * fabs(own);
    for (size_t j = begin; j < end; j++) {
        bool const is_same =
            labels[j].part == labels[i].part && labels[j].feature == labels[i].feature;
        if (is_same && j < i) return true;
        if (labels[j].part != RIM_INSIDE || !(rows[j]->frame.gap <= gap)) continue;
        for (int k = 1; k < 4; k++)
            for (int l = 1; l < 4; l++)
                if (rows[i]->frame.vertices[k] == rows[j]->frame.vertices[l]) return true;
    }
    return false;
}

/* Two vertices nearest to each other: the row of the smaller one stays. Looks among the rows of
 * vertex `other`, if it has any, for one that touches `vertex`. */
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
    for (size_t begin = 0, end; begin < vertex_row_count; begin = end) {
        uint32_t const vertex = rows[begin]->frame.pair.first;
        for (end = begin; end < vertex_row_count && rows[end]->frame.pair.first == vertex;) end++;
        for (size_t i = begin; i < end; i++) {
            is_dropped[i] = is_redundant(rows, labels, begin, end, i);
            if (labels[i].part == RIM_VERTEX && labels[i].feature < vertex)
                is_dropped[i] |=
                    has_mirror_row(rows, labels, vertex_row_count, vertex, labels[i].feature);
        }
    }
    size_t kept = 0;
    for (size_t i = 0; i < *count; i++)
        if (!is_dropped[i]) rows[kept++] = rows[i];
    *count = kept;
    arena_release(scene->scratch, mark);
    return TULLE_OK;
}
