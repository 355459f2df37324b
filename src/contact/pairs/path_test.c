/* contact/pairs/path_test.c - see path_test.h.
 *
 * The test is a chain, the cheapest first: the direction between the middles or the common
 * normal separates; an axis or the closest direction at the start separates, all eight pairs at a
 * time; no vertex moved relative to the others; the closest direction at the end separates; a plane
 * that turns from the closest direction at the start to that at the end separates; conservative
 * advancement with the pair's own gap. Each link is a proof, so a pair that leaves the chain is
 * safe. */
#include "contact/pairs/path_test.h"

#include "base/parallel.h"
#include "contact/pairs/apart_pairs.h"
#include "contact/pairs/near_pairs.h"
#include "contact/pairs/pair_filter.h"
#include "contact/pairs/pair_rules.h"

#include <string.h>

enum {
    GAP_CHUNK = 8192, /* pairs; some 60 microseconds */
    GAP_PART = 512    /* of these, filtered at a time with the smallest gap so far */
};

/* A pair that starts at the minimum gap or nearer may come nearer by this factor, so that a step
 * can begin. It was pressed there by the step before, or the start was bad. The factor is so near
 * to 1 that 10,000 pressed steps take a hundredth of the distance. */
static const double PART_OF_START = 1.0 - 1e-6;
/* Accepted states keep more than xi up to this relative rounding. */
static const double MINIMUM_ROUNDING = 1e-9;

typedef struct path_test {
    const contact_scene *scene;
    const double *x1;
    pair_tables tables; /* of x0 -> x1 */
} path_test;

/* The rest of the chain, for pairs that the cheapest test does not separate. A
 * pair that may come under its gap becomes an event. */
static void measure_hits(const void *context, feature_kind kind, pair_event *events, size_t count,
                         scan_verdict *verdicts) {
    const path_test *const test = context;
    const contact_scene *const scene = test->scene;
    double const least = scene->settings.minimum_gap;
    apart_query query = {.kind = kind, .count = count};
    bool is_apart[SCAN_MOST];
    for (size_t i = 0; i < count; i++) {
        query.pairs[i] = events[i].pair;
        query.separations[i] = least;
    }
    mark_apart(&test->tables, &query, is_apart);
    for (size_t i = 0; i < count; i++) {
        verdicts[i] = SCAN_DROP;
        if (is_apart[i]) continue;
        uint32_t vertices[4];
        moving_pair paths;
        feature_pair_vertices(scene->set->topo, kind, events[i].pair, vertices);
        load_points(scene->x0, vertices, paths.start);
        load_points(test->x1, vertices, paths.end);
        /* where all four points rest nothing can change, however near they are */
        if (memcmp(paths.start, paths.end, sizeof paths.start) == 0) continue;
        apart_proof const proof = prove_apart(kind, &paths, least);
        if (proof == APART_BY_TURNING) verdicts[i] = SCAN_DROP_TURNING;
        if (proof != APART_UNPROVEN) continue;
        double const start = sqrt(closest_of_pair(kind, paths.start).distance2);
        double gap = compute_pair_distances(scene, kind, vertices, NULL).minimum;
        if (!(start > gap * (1.0 + MINIMUM_ROUNDING))) gap = fmin(gap, PART_OF_START * start);
        toi_result const result = time_of_impact(kind, &paths, gap);
        if (result.state == TOI_SEPARATED) continue;
        events[i].time = result.lower_bound;
        if (!pair_is_ignored(scene, kind, events[i].pair)) verdicts[i] = SCAN_EVENT;
    }
}

tulle_status find_hits(const contact_scene *scene, const pair_source *source, const double *x1,
                       const bool *has_changed, pair_events *hits) {
    path_test test = {.scene = scene, .x1 = x1};
    /* [m] xi with rounding slack */
    double const minimum = scene->settings.minimum_gap + compute_rounding_slack(scene, x1);
    pair_scan const scan = {.records = make_records(scene, scene->x0, x1),
                            .at_start = minimum,
                            .at_end = minimum,
                            .has_changed = has_changed,
                            .measure = measure_hits,
                            .context = &test};
    pair_list pairs;
    if (!make_feature_tables(scene, scan.records, &test.tables)) return TULLE_ERROR_OUT_OF_MEMORY;
    tulle_status status = pick_pairs(scene, source, x1, minimum, &pairs);
    if (status == TULLE_OK) status = scan_pairs(scene, &pairs, &scan, hits);
    return status;
}

typedef struct gap_search {
    const contact_scene *scene;
    const vertex_record *records; /* at rest at x1 */
    const double *x1;
    double limit, slack;
    const feature_pair *pairs;
    feature_kind kind;
    smallest_gap *smallest; /* one a chunk */
} gap_search;

/* Of equal distances the first pair in (first, second) wins, so that the order of the pairs does
 * not matter. */
static bool is_smaller(double distance, feature_pair pair, const smallest_gap *than) {
    if (distance != than->distance) return distance < than->distance;
    return pair.first != than->pair.first ? pair.first < than->pair.first
                                          : pair.second < than->pair.second;
}

/* The nearest pair of a chunk. The limit stands for a pair that none precedes. */
static void search_chunk(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    const gap_search *const search = context;
    const topology *const topo = search->scene->set->topo;
    feature_kind const kind = search->kind;
    smallest_gap best = {.distance = search->limit, .kind = kind};
    feature_pair kept[GAP_PART];
    for (size_t i = begin; i < end; i += GAP_PART) {
        double const bound = best.distance + search->slack;
        pair_filter const filter = {topo, search->records, bound, bound};
        size_t const part = end - i < GAP_PART ? end - i : GAP_PART;
        size_t const count =
            TULLE_PICK_KERNEL(filter_pairs)(&filter, kind, search->pairs + i, part, kept);
        for (size_t k = 0; k < count; k++) {
            uint32_t vertices[4];
            vec3 points[4];
            feature_pair_vertices(topo, kind, kept[k], vertices);
            load_points(search->x1, vertices, points);
            double const distance = sqrt(closest_of_pair(kind, points).distance2);
            if (!is_smaller(distance, kept[k], &best)) continue;
            if (pair_is_ignored(search->scene, kind, kept[k])) continue;
            best.distance = distance;
            best.pair = kept[k];
        }
    }
    search->smallest[chunk] = best;
}

tulle_status find_smallest_gap(const contact_scene *scene, const pair_source *source,
                               const double *x1, double limit, smallest_gap *result) {
    arena_mark const mark = arena_get_mark(scene->scratch);
    gap_search search = {.scene = scene,
                         .records = make_records(scene, x1, x1),
                         .x1 = x1,
                         .limit = limit,
                         .slack = compute_rounding_slack(scene, x1)};
    const near_pair_list *const near = source->near_pairs;
    pair_list pairs = *source->pairs;
    tulle_status status = TULLE_OK;
    *result = (smallest_gap){.distance = (double)INFINITY};
    if (!search.records) return TULLE_ERROR_OUT_OF_MEMORY;

    /* The pair that is nearest at the start bounds the smallest distance at x1. */
    if (near && near->pairs.count > 0) {
        const near_pair *const nearest = &near->pairs.data[near->nearest];
        uint32_t vertices[4];
        vec3 points[4];
        feature_pair_vertices(scene->set->topo, nearest->kind, nearest->pair, vertices);
        load_points(x1, vertices, points);
        double const distance = sqrt(closest_of_pair(nearest->kind, points).distance2);
        search.limit = fmin(search.limit, nextafter(distance, (double)INFINITY));
        status = pick_pairs(scene, source, x1, distance, &pairs);
    }

    /* The pairs of each kind; of equal distances that of a vertex and a triangle comes first. */
    const feature_pair *const lists[2] = {pairs.vertex_triangle.data, pairs.edge_edge.data};
    size_t const counts[2] = {pairs.vertex_triangle.count, pairs.edge_edge.count};
    for (int kind = 0; status == TULLE_OK && kind < 2; kind++) {
        size_t const chunk_count = parallel_chunk_count(counts[kind], GAP_CHUNK);
        search.kind = (feature_kind)kind;
        search.pairs = lists[kind];
        search.smallest = ARENA_NEW(scene->scratch, smallest_gap, chunk_count);
        if (!search.smallest) {
            status = TULLE_ERROR_OUT_OF_MEMORY;
            break;
        }
        parallel_for(counts[kind], GAP_CHUNK, scene->threads, search_chunk, &search);
        for (size_t chunk = 0; chunk < chunk_count; chunk++) {
            smallest_gap const found = search.smallest[chunk];
            if (found.distance < search.limit &&
                (result->kind != search.kind || is_smaller(found.distance, found.pair, result)))
                *result = found;
        }
        search.limit = fmin(search.limit, result->distance);
    }
    arena_release(scene->scratch, mark);
    return status;
}
