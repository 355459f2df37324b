/* contact/path_test.c - see path_test.h.
 *
 * The test is a chain from cheap to dear: no vertex moved relative to the others; the direction
 * between the middles separates; the closest direction separates; a plane that turns from the
 * closest direction at the start to that at the end separates; conservative advancement with the
 * pair's own gap. Each link is a proof, so a pair that leaves the chain is safe. */
#include "contact/path_test.h"

#include "base/parallel.h"
#include "base/timer.h"
#include "contact/near_pairs.h"
#include "contact/pair_rules.h"

#include <string.h>

enum { GAP_CHUNK = 8192 /* pairs; some 150 microseconds */ };

typedef struct path_test {
    const contact_scene *scene;
    const double *x1;
    const bool *has_changed;
    double minimum; /* [m] xi with rounding slack */
} path_test;

static moving_pair load_paths(const path_test *test, const uint32_t vertices[4]) {
    moving_pair paths;
    load_points(test->scene->x0, vertices, paths.start);
    load_points(test->x1, vertices, paths.end);
    return paths;
}

static bool may_hit(const void *context, feature_kind kind, feature_pair pair) {
    const path_test *const test = context;
    uint32_t v[4];
    feature_pair_vertices(test->scene->set->topo, kind, pair, v);
    const bool *const changed = test->has_changed;
    if (changed && !(changed[v[0]] || changed[v[1]] || changed[v[2]] || changed[v[3]]))
        return false;
    moving_pair const paths = load_paths(test, v);
    return !middles_separate(kind, paths.start, paths.end, test->minimum, test->minimum);
}

/* True when all four points rest: then nothing can change, however near they are. */
static bool is_at_rest(const moving_pair *paths) {
    return memcmp(paths->start, paths->end, sizeof paths->start) == 0;
}

static scan_verdict measure_hit(const void *context, pair_event *event) {
    const path_test *const test = context;
    feature_kind const kind = event->kind;
    feature_pair const pair = event->pair;
    uint32_t vertices[4];
    feature_pair_vertices(test->scene->set->topo, kind, pair, vertices);
    moving_pair const paths = load_paths(test, vertices);
    if (is_at_rest(&paths)) return SCAN_DROP;
    apart_proof const proof = prove_apart(kind, &paths, test->scene->settings.minimum_gap);
    if (proof != APART_UNPROVEN) return proof == APART_BY_TURNING ? SCAN_DROP_TURNING : SCAN_DROP;
    double const start = sqrt(closest_of_pair(kind, paths.start).distance2);
    double const minimum = find_pair_distances(test->scene, kind, vertices).minimum;
    toi_result const result = time_of_impact(kind, &paths, find_minimum_gap(minimum, start));
    if (result.state == TOI_SEPARATED) return SCAN_DROP;
    event->time = result.lower_bound;
    return pair_is_ignored(test->scene, kind, pair) ? SCAN_DROP : SCAN_EVENT;
}

tulle_status find_hits(const contact_scene *scene, const pair_source *source, const double *x1,
                       const bool *has_changed, pair_events *hits) {
    path_test const test = {.scene = scene,
                            .x1 = x1,
                            .has_changed = has_changed,
                            .minimum =
                                scene->settings.minimum_gap + find_rounding_slack(scene, x1)};
    pair_scan const scan = {may_hit, measure_hit, &test, false};
    double const start = timer_now();
    pair_list pairs;
    tulle_status status = pick_pairs(scene, source, x1, test.minimum, &pairs);
    if (status == TULLE_OK) status = scan_pairs(scene, &pairs, &scan, hits);
    if (scene->times) scene->times->test_pairs += timer_now() - start;
    return status;
}

typedef struct gap_search {
    const contact_scene *scene;
    const double *x1;
    double limit, slack;
    const feature_pair *pairs;
    feature_kind kind;
    smallest_gap *smallest; /* one a chunk */
} gap_search;

static void search_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    const gap_search *const search = context;
    smallest_gap best = {.distance = INFINITY, .kind = search->kind};
    double limit = search->limit;
    for (size_t i = begin; i < end; i++) {
        uint32_t vertices[4];
        vec3 points[4];
        feature_pair_vertices(search->scene->set->topo, search->kind, search->pairs[i], vertices);
        load_points(search->x1, vertices, points);
        double const bound = limit + search->slack;
        if (middles_separate(search->kind, points, points, bound, bound) ||
            common_normal_separates(search->kind, points, bound))
            continue;
        double const distance = sqrt(closest_of_pair(search->kind, points).distance2);
        if (!(distance < limit) || pair_is_ignored(search->scene, search->kind, search->pairs[i]))
            continue;
        limit = best.distance = distance;
        best.pair = search->pairs[i];
    }
    search->smallest[chunk] = best;
}

/* Improves `result` by the pairs of one kind. */
static tulle_status search_kind(gap_search *search, const feature_pair *pairs, size_t count,
                                smallest_gap *result) {
    size_t const chunk_count = parallel_chunk_count(count, GAP_CHUNK);
    search->pairs = pairs;
    search->smallest = ARENA_NEW(search->scene->scratch, smallest_gap, chunk_count);
    if (!search->smallest) return TULLE_ERROR_OUT_OF_MEMORY;
    parallel_for(count, GAP_CHUNK, search->scene->threads, search_chunk, search);
    for (size_t chunk = 0; chunk < chunk_count; chunk++)
        if (search->smallest[chunk].distance < result->distance) *result = search->smallest[chunk];
    return TULLE_OK;
}

tulle_status find_smallest_gap(const contact_scene *scene, const pair_source *source,
                               const double *x1, double limit, smallest_gap *result) {
    arena_mark const mark = arena_get_mark(scene->scratch);
    gap_search search = {.scene = scene,
                         .x1 = x1,
                         .limit = limit,
                         .slack = find_rounding_slack(scene, x1),
                         .kind = FEATURE_VERTEX_TRIANGLE};
    pair_list pairs;
    *result = (smallest_gap){.distance = (double)INFINITY};
    tulle_status status = pick_pairs_for_nearest(scene, source, x1, &pairs);
    if (status == TULLE_OK)
        status =
            search_kind(&search, pairs.vertex_triangle.data, pairs.vertex_triangle.count, result);
    search.kind = FEATURE_EDGE_EDGE;
    if (status == TULLE_OK)
        status = search_kind(&search, pairs.edge_edge.data, pairs.edge_edge.count, result);
    arena_release(scene->scratch, mark);
    return status;
}
