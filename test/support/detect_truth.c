/* support/detect_truth.c - brute force over all pairs of a detect_scene. Pairs whose
 * boxes over the motion lie apart, or that are clearly farther apart than their separation along
 * one direction, are left out; all others are decided by rational arithmetic. */
#include "support/detect_scene.h"
#include "support/exact_approach.h"
#include "support/exact_ccd.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Halvings of the time of a step. */
enum { VERDICT_DEPTH = 4, EVENT_DEPTH = 7, TIME_DEPTH = 12 };

static size_t surface_of(const detect_scene *scene, uint32_t vertex) {
    size_t s = 0;
    while (vertex >= scene->surfaces[s].vertex_end) s++;
    return s;
}

static bool may_meet(const detect_scene *scene, size_t a, size_t b) {
    const tulle_detect_surface *const first = &scene->surfaces[a], *const second =
                                                                       &scene->surfaces[b];
    if (first->is_obstacle && second->is_obstacle) return false;
    if (a == b && first->ignores_self) return false;
    return !scene->has_collides || scene->collides[a * scene->surface_count + b];
}

static double separation_of(const detect_scene *scene, const uint32_t vertices[4]) {
    return 0.5 * (scene->surfaces[surface_of(scene, vertices[0])].thickness +
                  scene->surfaces[surface_of(scene, vertices[3])].thickness) +
           scene->minimum_separation;
}

static moving_pair load_pair(const detect_scene *scene, const uint32_t vertices[4]) {
    moving_pair pair;
    for (int k = 0; k < 4; k++) {
        pair.start[k] = vec3_load(scene->start, vertices[k]);
        pair.end[k] = vec3_load(scene->end, vertices[k]);
    }
    return pair;
}

/* Whether the features share no corner and their surfaces may meet. */
static bool is_allowed(const detect_scene *scene, int first_count, const uint32_t vertices[4]) {
    for (int a = 0; a < first_count; a++)
        for (int b = first_count; b < 4; b++)
            if (vertices[a] == vertices[b]) return false;
    return may_meet(scene, surface_of(scene, vertices[0]), surface_of(scene, vertices[3]));
}

/* Whether all corners of the first feature lie clearly beyond all of the second along a direction,
 * or its opposite, at both ends of the motion and so always. */
static bool is_apart_along(const moving_pair *pair, int first_count, vec3 along, double clear) {
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    double gap[2][2];
    for (int end = 0; end < 2; end++) {
        for (int side = 0; side < 2; side++) low[side] = INFINITY, high[side] = -INFINITY;
        for (int i = 0; i < 4; i++) {
            double const x = vec3_dot(along, end == 0 ? pair->start[i] : pair->end[i]);
            int const side = i < first_count ? 0 : 1;
            low[side] = fmin(low[side], x);
            high[side] = fmax(high[side], x);
        }
        gap[end][0] = low[0] - high[1];
        gap[end][1] = low[1] - high[0];
    }
    return (gap[0][0] > clear && gap[1][0] > clear) || (gap[0][1] > clear && gap[1][1] > clear);
}

/* Clearly apart along one of many directions, in floating point with much room. */
static bool is_clearly_apart(const moving_pair *pair, int first_count, double separation) {
    double most = 0.0;
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 3; k++)
            most = fmax(most, fmax(fabs((&pair->start[i].x)[k]), fabs((&pair->end[i].x)[k])));
    double const clear = 1.001 * separation + 1e-12 * most;
    if (!(most > 1e-140 && most < 1e140)) return false; /* products would not do */
    for (int i = 0; i < 13; i++) {                      /* half of the 26 neighbours of a cell */
        int const code = 14 + i;
        vec3 const along = vec3_make(code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1);
        if (is_apart_along(pair, first_count, vec3_normalize(along), clear)) return true;
    }
    for (int end = 0; end < 2; end++) {
        const vec3 *const p = end == 0 ? pair->start : pair->end;
        vec3 const normal = first_count == 1
                                ? vec3_cross(vec3_sub(p[2], p[1]), vec3_sub(p[3], p[1]))
                                : vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[3], p[2]));
        if (is_apart_along(pair, first_count, vec3_normalize(normal), clear)) return true;
    }
    return false;
}

static bool is_true(const detect_scene *scene, const detect_truth *of, const moving_pair *pair) {
    static const double times[] = {0.0, 0.25, 0.5, 0.75, 1.0};
    bool const has_face = of->kind == TULLE_DETECT_VERTEX_FACE;
    feature_kind const kind = has_face ? FEATURE_VERTEX_TRIANGLE : FEATURE_EDGE_EDGE;
    double const separation = separation_of(scene, of->vertices);
    if (is_clearly_apart(pair, has_face ? 1 : 2, separation)) return false;
    if (exact_pair_touches(kind, pair, 1.0)) return true;
    if (separation > 0.0 && scene->is_thorough)
        return find_approach(kind, pair, separation, VERDICT_DEPTH).verdict == APPROACH_NEAR;
    for (size_t i = 0; separation > 0.0 && i < sizeof times / sizeof times[0]; i++)
        if (!exact_pair_is_farther(kind, pair, times[i], separation)) return true;
    return false;
}

static void try_pair(const detect_scene *scene, const detect_truth *candidate,
                     detect_truths *truths) {
    int const first_count = candidate->kind == TULLE_DETECT_VERTEX_FACE ? 1 : 2;
    if (!is_allowed(scene, first_count, candidate->vertices)) return;
    moving_pair const pair = load_pair(scene, candidate->vertices);
    if (!is_true(scene, candidate, &pair)) return;
    assert_true(truths->count < DETECT_MAX_TRUTHS);
    truths->pairs[truths->count++] = *candidate;
}

/* Bounds of a feature over the motion. */
typedef struct motion_box {
    double low[3], high[3];
} motion_box;

static motion_box make_box(const detect_scene *scene, const uint32_t *vertices, int count) {
    motion_box box;
    for (size_t k = 0; k < 3; k++) {
        box.low[k] = INFINITY;
        box.high[k] = -INFINITY;
        for (int i = 0; i < count; i++) {
            double const a = scene->start[3 * (size_t)vertices[i] + k];
            double const b = scene->end[3 * (size_t)vertices[i] + k];
            box.low[k] = fmin(box.low[k], fmin(a, b));
            box.high[k] = fmax(box.high[k], fmax(a, b));
        }
    }
    return box;
}

/* Farther apart than `clear` along an axis. */
static bool boxes_are_apart(const motion_box *a, const motion_box *b, double clear) {
    for (int k = 0; k < 3; k++)
        if (a->low[k] - b->high[k] > clear || b->low[k] - a->high[k] > clear) return true;
    return false;
}

/* With room for rounding. */
static double find_largest_separation(const detect_scene *scene) {
    double most = 0.0;
    for (size_t s = 0; s < scene->surface_count; s++)
        most = fmax(most, scene->surfaces[s].thickness);
    return 1.001 * (most + scene->minimum_separation);
}

static void find_vertex_face_truths(const detect_scene *scene, detect_truths *truths) {
    static unsigned char is_used[DETECT_MAX_VERTICES];
    static motion_box boxes[DETECT_MAX_TRIANGLES];
    double const clear = find_largest_separation(scene);
    memset(is_used, 0, sizeof is_used);
    for (size_t i = 0; i < 3 * scene->triangle_count; i++) is_used[scene->triangles[i]] = 1;
    for (size_t f = 0; f < scene->triangle_count; f++)
        boxes[f] = make_box(scene, scene->triangles + 3 * f, 3);
    for (uint32_t v = 0; v < scene->vertex_count; v++) {
        motion_box const box = make_box(scene, &v, 1);
        for (uint32_t f = 0; is_used[v] && f < scene->triangle_count; f++) {
            if (boxes_are_apart(&box, &boxes[f], clear)) continue;
            const uint32_t *const corners = scene->triangles + 3 * (size_t)f;
            detect_truth const candidate = {
                TULLE_DETECT_VERTEX_FACE, f, {v, corners[0], corners[1], corners[2]}};
            try_pair(scene, &candidate, truths);
        }
    }
}

static int compare_edges(const void *first, const void *second) {
    const uint32_t *const a = first, *const b = second;
    if (a[0] != b[0]) return a[0] < b[0] ? -1 : 1;
    return a[1] < b[1] ? -1 : a[1] > b[1];
}

/* All edges, each once, sorted. */
static size_t list_edges(const detect_scene *scene, uint32_t edges[][2]) {
    size_t const all = 3 * scene->triangle_count;
    for (size_t i = 0; i < all; i++) {
        uint32_t const a = scene->triangles[i], b = scene->triangles[i % 3 == 2 ? i - 2 : i + 1];
        edges[i][0] = a < b ? a : b;
        edges[i][1] = a < b ? b : a;
    }
    qsort(edges, all, sizeof edges[0], compare_edges);
    size_t count = 0;
    for (size_t i = 0; i < all; i++)
        if (i == 0 || compare_edges(edges[i], edges[count - 1]) != 0)
            memmove(edges[count++], edges[i], sizeof edges[0]);
    return count;
}

static void find_edge_edge_truths(const detect_scene *scene, detect_truths *truths) {
    static uint32_t edges[3 * DETECT_MAX_TRIANGLES][2];
    static motion_box boxes[3 * DETECT_MAX_TRIANGLES];
    double const clear = find_largest_separation(scene);
    size_t const count = list_edges(scene, edges);
    for (size_t i = 0; i < count; i++) boxes[i] = make_box(scene, edges[i], 2);
    for (size_t i = 0; i < count; i++)
        for (size_t j = i + 1; j < count; j++) {
            if (boxes_are_apart(&boxes[i], &boxes[j], clear)) continue;
            detect_truth const candidate = {TULLE_DETECT_EDGE_EDGE,
                                            TULLE_NONE,
                                            {edges[i][0], edges[i][1], edges[j][0], edges[j][1]}};
            try_pair(scene, &candidate, truths);
        }
}

void detect_scene_time_truth(const detect_scene *scene, const detect_truth *truth, double *from,
                             double *by) {
    moving_pair const pair = load_pair(scene, truth->vertices);
    feature_kind const kind =
        truth->kind == TULLE_DETECT_VERTEX_FACE ? FEATURE_VERTEX_TRIANGLE : FEATURE_EDGE_EDGE;
    approach const found =
        find_approach(kind, &pair, separation_of(scene, truth->vertices), TIME_DEPTH);
    *from = found.from;
    *by = found.by;
}

void detect_scene_find_truths(const detect_scene *scene, detect_truths *truths) {
    truths->count = 0;
    find_vertex_face_truths(scene, truths);
    find_edge_edge_truths(scene, truths);
}

static bool is_same(const detect_truth *truth, const tulle_detect_event *event) {
    return truth->kind == event->kind && truth->face == event->face &&
           memcmp(truth->vertices, event->vertices, sizeof truth->vertices) == 0;
}

bool detect_events_contain(const detect_truths *truths, const tulle_detect_event *events,
                           size_t count) {
    size_t at = 0;
    for (size_t i = 0; i < truths->count; i++) {
        const detect_truth *const truth = &truths->pairs[i];
        while (at < count && !is_same(truth, &events[at])) at++;
        if (at < count) continue;
        print_error("missed: %s, vertices %u %u %u %u\n",
                    truth->kind == TULLE_DETECT_VERTEX_FACE ? "vertex/face" : "edge/edge",
                    truth->vertices[0], truth->vertices[1], truth->vertices[2], truth->vertices[3]);
        return false;
    }
    return true;
}

/* Strictly ascending by (kind, first feature, second feature). */
static bool is_before(const tulle_detect_event *a, const tulle_detect_event *b) {
    if (a->kind != b->kind) return a->kind < b->kind;
    if (a->kind == TULLE_DETECT_VERTEX_FACE) {
        if (a->vertices[0] != b->vertices[0]) return a->vertices[0] < b->vertices[0];
        return a->face < b->face;
    }
    int const first = compare_edges(a->vertices, b->vertices);
    return first < 0 || (first == 0 && compare_edges(a->vertices + 2, b->vertices + 2) < 0);
}

/* The vector between the closest points at the time of the event, and the extent of the pair. */
static vec3 find_difference(const tulle_detect_event *event, const moving_pair *pair,
                            double *extent) {
    vec3 sum = {0.0, 0.0, 0.0};
    *extent = 0.0;
    for (int k = 0; k < 4; k++) {
        vec3 const start = vec3_sub(pair->start[k], pair->start[0]);
        vec3 const end = vec3_sub(pair->end[k], pair->end[0]);
        sum = vec3_add_scaled(sum, vec3_lerp(start, end, event->time), event->weights[k]);
        *extent = fmax(*extent, fmax(vec3_norm(start), vec3_norm(end)));
    }
    return sum;
}

static void check_place(const tulle_detect_event *event, const moving_pair *pair) {
    double first = 0.0, second = 0.0, extent;
    int const first_count = event->kind == TULLE_DETECT_VERTEX_FACE ? 1 : 2;
    for (int k = 0; k < 4; k++) {
        double const side = k < first_count ? 1.0 : -1.0;
        assert_true(side * event->weights[k] >= 0.0 && side * event->weights[k] <= 1.0);
        *(k < first_count ? &first : &second) += event->weights[k];
    }
    assert_true(fabs(first - 1.0) < 1e-14 && fabs(second + 1.0) < 1e-14);
    vec3 const normal = vec3_load(event->normal, 0);
    double const length = vec3_norm(normal);
    assert_true(length == 0.0 || fabs(length - 1.0) < 1e-12);
    assert_true(event->distance >= 0.0);
    vec3 const difference = find_difference(event, pair, &extent);
    if (!(extent > 1e-140 && extent < 1e140)) return; /* squares would not do */
    assert_true(length > 0.0 || event->distance < 1e-11 * extent);
    assert_true(fabs(vec3_norm(difference) - event->distance) < 1e-11 * extent);
    vec3 const along = vec3_scale(normal, event->distance);
    assert_true(vec3_norm(vec3_sub(difference, along)) < 1e-11 * extent);
}

static void check_time(const detect_scene *scene, const tulle_detect_event *event,
                       const moving_pair *pair) {
    feature_kind const kind =
        event->kind == TULLE_DETECT_VERTEX_FACE ? FEATURE_VERTEX_TRIANGLE : FEATURE_EDGE_EDGE;
    assert_true(event->time >= 0.0 && event->time <= 1.0);
    assert_true(event->state != TULLE_DETECT_TOUCHING_AT_START || event->time == 0.0);
    if (event->time == 0.0) return;
    double const separation = separation_of(scene, event->vertices);
    if (separation == 0.0) assert_false(exact_pair_touches(kind, pair, event->time));
    for (int k = 0; separation > 0.0 && k <= 2; k++)
        assert_true(exact_pair_is_farther(kind, pair, 0.5 * k * event->time, separation));
}

/* [m] What rounding may change of a distance of the pair. */
static double bound_rounding(const moving_pair *pair, double distance) {
    double extent = 0.0;
    for (int k = 1; k < 4; k++) {
        vec3 const start = vec3_sub(pair->start[k], pair->start[0]);
        vec3 const end = vec3_sub(pair->end[k], pair->end[0]);
        extent = fmax(extent, hypot(hypot(start.x, start.y), start.z));
        extent = fmax(extent, hypot(hypot(end.x, end.y), end.z));
    }
    return 1e-12 * distance + 1e-11 * extent + 4.0 * DBL_TRUE_MIN;
}

/* A distance that was told is the exact one but for rounding. */
static void verify_distance(feature_kind kind, const moving_pair *pair, double t, double distance) {
    double const slack = bound_rounding(pair, distance);
    assert_false(exact_pair_is_farther(kind, pair, t, distance + slack));
    if (distance > slack) assert_true(exact_pair_is_farther(kind, pair, t, distance - slack));
}

/* The distance at the start, in the scale of the pair. */
static double measure_start(feature_kind kind, const moving_pair *pair) {
    vec3 points[4] = {0};
    int exponent = 0;
    double most = 0.0;
    for (int k = 1; k < 4; k++) {
        points[k] = vec3_sub(pair->start[k], pair->start[0]);
        most = fmax(most, fmax(fabs(points[k].x), fmax(fabs(points[k].y), fabs(points[k].z))));
    }
    (void)frexp(most, &exponent);
    for (int k = 1; k < 4; k++)
        points[k] = vec3_make(ldexp(points[k].x, -exponent), ldexp(points[k].y, -exponent),
                              ldexp(points[k].z, -exponent));
    return ldexp(sqrt(closest_of_pair(kind, points).distance2), exponent);
}

bool detect_event_check_near(const detect_scene *scene, const tulle_detect_event *event) {
    feature_kind const kind =
        event->kind == TULLE_DETECT_VERTEX_FACE ? FEATURE_VERTEX_TRIANGLE : FEATURE_EDGE_EDGE;
    moving_pair const pair = load_pair(scene, event->vertices);
    double const separation = separation_of(scene, event->vertices);
    verify_distance(kind, &pair, event->time, event->distance);
    double const start = measure_start(kind, &pair);
    verify_distance(kind, &pair, 0.0, start);
    /* Advancement stops where this is left of the way. */
    double const way = fmax(start - separation, 0.0);
    double const left = separation > 0.0 ? fmax(0.05 * separation, 1e-3 * way) : 1e-4 * way;
    double const most = separation + fmin(left, 0.1 * way);
    if (event->state != TULLE_DETECT_UNRESOLVED)
        assert_false(
            exact_pair_is_farther(kind, &pair, event->time, most + bound_rounding(&pair, most)));
    return find_approach(kind, &pair, separation, EVENT_DEPTH).verdict != APPROACH_APART;
}

void detect_events_check(const detect_scene *scene, const tulle_detect_event *events,
                         size_t count) {
    for (size_t i = 0; i < count; i++) {
        const tulle_detect_event *const event = &events[i];
        const uint32_t *const v = event->vertices;
        bool const has_face = event->kind == TULLE_DETECT_VERTEX_FACE;
        assert_true(i == 0 || is_before(&events[i - 1], event));
        assert_true(is_allowed(scene, has_face ? 1 : 2, v));
        if (has_face)
            assert_memory_equal(scene->triangles + 3 * (size_t)event->face, v + 1, 3 * sizeof *v);
        else
            assert_true(event->face == TULLE_NONE && v[0] < v[1] && v[2] < v[3]);
        assert_int_equal(event->surfaces[0], surface_of(scene, v[0]));
        assert_int_equal(event->surfaces[1], surface_of(scene, v[3]));
        moving_pair const pair = load_pair(scene, v);
        check_place(event, &pair);
        check_time(scene, event, &pair);
    }
}
