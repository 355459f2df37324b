/* The narrow phase in batches against one call of the filters and of time_of_impact for each pair,
 * bit for bit: for any batch size, number of threads and separation; order of edges; the earliest
 * only; overflow and repeat; failing allocations. */
#include "base/hash.h"
#include "base/parallel.h"
#include "detect/impact/narrow_phase.h"
#include "detect/trees/broad_phase.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 24, VERTEX_COUNT = 2 * SIDE * SIDE, TRIANGLE_COUNT = 4 * (SIDE - 1) * (SIDE - 1) };

/* Two crumpled sheets that move through each other. */
typedef struct sheets {
    double x0[3 * VERTEX_COUNT], x1[3 * VERTEX_COUNT];
    vertex_record records[VERTEX_COUNT];
    uint32_t vertex_surface[VERTEX_COUNT];
    uint32_t slots[16 * VERTEX_COUNT]; /* each slot is its own feature */
    topology topo;
    surface_range surfaces[2];
    surface_set set;
    pair_list pairs;
    pair_tables tables;
} sheets;

static void make_surfaces(sheets *to) {
    uint32_t const edges = (uint32_t)to->topo.edge_count;
    to->surfaces[0] = (surface_range){
        0, VERTEX_COUNT / 2, 0, edges / 2, 0, TRIANGLE_COUNT / 2, .is_present = true};
    to->surfaces[1] = (surface_range){VERTEX_COUNT / 2,   VERTEX_COUNT,   edges / 2,         edges,
                                      TRIANGLE_COUNT / 2, TRIANGLE_COUNT, .is_present = true};
    to->set = (surface_set){.topo = &to->topo, .surfaces = to->surfaces, .surface_count = 2};
}

static void make_tables(sheets *to) {
    for (uint32_t i = 0; i < 16 * VERTEX_COUNT; i++) to->slots[i] = i;
    for (size_t i = 0; i < VERTEX_COUNT; i++) {
        memcpy(to->records[i].start, to->x0 + 3 * i, 3 * sizeof(double));
        memcpy(to->records[i].end, to->x1 + 3 * i, 3 * sizeof(double));
        to->vertex_surface[i] = i >= VERTEX_COUNT / 2;
    }
    to->tables = (pair_tables){.vertex_features = to->slots,
                               .edge_features = to->slots,
                               .triangle_features = to->slots,
                               .vertex_corners = to->slots,
                               .edge_corners = to->topo.edges,
                               .triangle_corners = to->topo.triangles,
                               .records = to->records};
}

static void make_sheets(memory *heap, sheets *to) {
    static uint32_t triangles[3 * TRIANGLE_COUNT];
    uint64_t seed = 21;
    uint32_t *corner = triangles;
    memset(to, 0, sizeof *to);
    for (uint32_t s = 0; s < 2; s++)
        for (uint32_t i = 0; i < SIDE * SIDE; i++) {
            uint32_t const at = s * SIDE * SIDE + i, row = i / SIDE, column = i % SIDE;
            double const height = s == 0 ? 0.0 : 0.02;
            const double x[3] = {(double)column / SIDE, (double)row / SIDE, height};
            for (size_t k = 0; k < 3; k++) {
                to->x0[3 * at + k] = x[k] + 0.01 * (random_uniform(&seed) - 0.5);
                to->x1[3 * at + k] = to->x0[3 * at + k] + 0.01 * (random_uniform(&seed) - 0.5);
            }
            to->x1[3 * at + 2] += s == 0 ? 0.01 : -0.01;
            if (row + 1 == SIDE || column + 1 == SIDE) continue;
            const uint32_t corners[6] = {at, at + 1, at + SIDE, at + 1, at + SIDE + 1, at + SIDE};
            memcpy(corner, corners, sizeof corners);
            corner += 6;
        }
    assert_int_equal(topology_build(heap, triangles, TRIANGLE_COUNT, VERTEX_COUNT, &to->topo),
                     TULLE_OK);
    make_surfaces(to);
    broad_phase *broad;
    assert_int_equal(broad_phase_create(heap, &to->set, to->x0, BROAD_PHASE_REFIT, &broad),
                     TULLE_OK);
    assert_int_equal(build_trees(broad, &to->set, to->x0, to->x1, 1e-3, 1), TULLE_OK);
    assert_int_equal(find_pairs(broad, &to->set, 1, PAIRS_SORTED, &to->pairs, NULL), TULLE_OK);
    broad_phase_destroy(broad);
    make_tables(to);
}

static void free_sheets(memory *heap, sheets *of) {
    ARRAY_FREE(heap, &of->pairs.vertex_triangle);
    ARRAY_FREE(heap, &of->pairs.edge_edge);
    topology_destroy(heap, &of->topo);
}

typedef struct batch_feed {
    const sheets *of;
    narrow_phase *narrow;
    size_t batch_size;
    bool swaps_edges;
} batch_feed;

static void feed_pairs(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    const batch_feed *const feed = context;
    size_t const vertex_triangle_count = feed->of->pairs.vertex_triangle.count;
    for (int kind = 0; kind < 2; kind++) {
        pair_batch batch = {.kind = (feature_kind)kind};
        for (size_t i = begin; i < end; i++) {
            bool const is_edge_edge = i >= vertex_triangle_count;
            if (is_edge_edge != (kind == FEATURE_EDGE_EDGE)) continue;
            feature_pair const pair =
                is_edge_edge ? feed->of->pairs.edge_edge.data[i - vertex_triangle_count]
                             : feed->of->pairs.vertex_triangle.data[i];
            bool const swaps = is_edge_edge && feed->swaps_edges;
            batch.first[batch.count] = swaps ? pair.second : pair.first;
            batch.second[batch.count++] = swaps ? pair.first : pair.second;
            if (batch.count < feed->batch_size) continue;
            consume_pairs(feed->narrow, &feed->of->tables, &batch, worker);
            batch.count = 0;
        }
        consume_pairs(feed->narrow, &feed->of->tables, &batch, worker);
    }
}

static void flush_worker(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)begin, (void)end, (void)worker;
    const batch_feed *const feed = context;
    narrow_phase_flush(feed->narrow, &feed->of->tables, (int)chunk);
}

/* Passes until one is complete; returns how many it took, or 0 when memory was short. */
static int run_narrow_phase(const batch_feed *feed, const narrow_phase_input *input) {
    size_t const count = feed->of->pairs.vertex_triangle.count + feed->of->pairs.edge_edge.count;
    for (int passes = 1;; passes++) {
        tulle_status status = narrow_phase_start(feed->narrow, input);
        if (status == TULLE_OK) {
            parallel_for(count, 3000, input->threads, feed_pairs, (void *)feed);
            parallel_for((size_t)input->threads, 1, input->threads, flush_worker, (void *)feed);
            if (narrow_phase_finish(feed->narrow, &status)) return passes;
        }
        if (status != TULLE_OK) {
            assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
            return 0;
        }
    }
}

/* Walks all pairs and the events beside each other. */
static void check_events(const sheets *of, const narrow_phase_input *input,
                         const narrow_phase *narrow) {
    size_t at = 0, event_count;
    const raw_event *const events = narrow_phase_get_events(narrow, &event_count);
    uint64_t filtered_count = 0;
    for (int kind = 0; kind < 2; kind++) {
        size_t const count =
            kind == 0 ? of->pairs.vertex_triangle.count : of->pairs.edge_edge.count;
        for (size_t i = 0; i < count; i++) {
            feature_pair const pair =
                kind == 0 ? of->pairs.vertex_triangle.data[i] : of->pairs.edge_edge.data[i];
            uint32_t v[4];
            moving_pair paths;
            feature_pair_vertices(&of->topo, (feature_kind)kind, pair, v);
            for (int k = 0; k < 4; k++) {
                paths.start[k] = vec3_load(of->x0, v[k]);
                paths.end[k] = vec3_load(of->x1, v[k]);
            }
            bool const same = v[0] / (VERTEX_COUNT / 2) == v[2] / (VERTEX_COUNT / 2);
            double const separation = input->separations[input->vertex_surface && !same];
            if ((separation == 0.0 && pair_cannot_cross((feature_kind)kind, &paths)) ||
                prove_apart((feature_kind)kind, &paths, separation) == APART_BY_DIRECTION) {
                filtered_count++;
                continue;
            }
            toi_result const result = time_of_impact((feature_kind)kind, &paths, separation);
            if (result.state == TOI_SEPARATED) continue;
            assert_true(at < event_count);
            const raw_event *const event = &events[at++];
            assert_int_equal(event->kind, kind);
            assert_int_equal(event->key, (uint64_t)pair.first << 32 | pair.second);
            assert_int_equal(event->state, result.state);
            assert_memory_equal(&event->time, &result.lower_bound, sizeof(double));
        }
    }
    assert_int_equal(at, event_count);
    narrow_phase_counts const counts = narrow_phase_get_counts(narrow);
    assert_int_equal(counts.filtered_count, filtered_count);
    assert_int_equal(counts.candidate_count,
                     of->pairs.vertex_triangle.count + of->pairs.edge_edge.count);
    assert_int_equal(counts.filtered_count + counts.tested_count, counts.candidate_count);
    /* Some pairs are shown apart by the direction at the end alone, some before it. */
    assert_true(counts.pooled_count > counts.tested_count);
    assert_true(counts.pooled_count < counts.candidate_count);
}

static void events_match_single_tests(void **state) {
    (void)state;
    memory heap = memory_default();
    static sheets soup;
    make_sheets(&heap, &soup);
    for (int variant = 0; variant < 3; variant++) {
        const double separations[4] = {variant ? 1e-4 : 0.0, variant == 2 ? 0.0 : 1e-3,
                                       variant == 2 ? 0.0 : 1e-3, variant ? 1e-4 : 0.0};
        narrow_phase_input input = {.set = &soup.set,
                                    .separations = separations,
                                    .vertex_surface = variant ? soup.vertex_surface : NULL};
        batch_feed feed = {.of = &soup};
        assert_int_equal(narrow_phase_create(&heap, &feed.narrow), TULLE_OK);
        uint64_t warm_count = 0;
        for (input.threads = 1; input.threads <= 8; input.threads++) {
            static const size_t sizes[] = {PAIR_BATCH_SIZE, 1, 7, 8, 9, 100, 1023, 2047};
            feed.batch_size = sizes[input.threads - 1];
            feed.swaps_edges = input.threads % 2 == 0;
            int const passes = run_narrow_phase(&feed, &input);
            assert_true(passes >= 1 && passes <= (input.threads == 1 ? 2 : 1));
            check_events(&soup, &input, feed.narrow);
            warm_count = heap.allocate_count;
            assert_int_equal(run_narrow_phase(&feed, &input), 1);
            check_events(&soup, &input, feed.narrow);
            assert_int_equal(heap.allocate_count, warm_count);
        }
        size_t event_count;
        narrow_phase_get_events(feed.narrow, &event_count);
        assert_true(event_count > 100);
        narrow_phase_destroy(feed.narrow);
    }
    free_sheets(&heap, &soup);
    assert_int_equal(heap.bytes_held, 0);
}

static void earliest_is_earliest(void **state) {
    (void)state;
    memory heap = memory_default();
    static sheets soup;
    make_sheets(&heap, &soup);
    double const separation = 1e-4;
    narrow_phase_input input = {.set = &soup.set, .separations = &separation, .threads = 1};
    batch_feed feed = {.of = &soup, .batch_size = 500};
    narrow_phase *all;
    assert_int_equal(narrow_phase_create(&heap, &all), TULLE_OK);
    assert_int_equal(narrow_phase_create(&heap, &feed.narrow), TULLE_OK);
    narrow_phase *const some = feed.narrow;
    feed.narrow = all;
    assert_true(run_narrow_phase(&feed, &input) > 0);
    size_t all_count, count;
    const raw_event *const all_events = narrow_phase_get_events(all, &all_count);
    double earliest = 1.0;
    for (size_t i = 0; i < all_count; i++) earliest = fmin(earliest, all_events[i].time);
    feed.narrow = some;
    input.only_earliest = true;
    for (input.threads = 1; input.threads <= 8; input.threads++) {
        assert_true(run_narrow_phase(&feed, &input) > 0);
        const raw_event *const events = narrow_phase_get_events(some, &count);
        size_t at = 0;
        for (size_t i = 0; i < all_count; i++) {
            if (all_events[i].time > earliest) continue;
            assert_true(at < count);
            assert_int_equal(events[at].key, all_events[i].key);
            assert_int_equal(events[at].kind, all_events[i].kind);
            assert_int_equal(events[at].state, all_events[i].state);
            assert_memory_equal(&events[at++].time, &earliest, sizeof earliest);
        }
        assert_int_equal(at, count);
        assert_true(count > 0);
    }
    narrow_phase_destroy(all);
    narrow_phase_destroy(some);
    free_sheets(&heap, &soup);
    assert_int_equal(heap.bytes_held, 0);
}

typedef struct failing_allocator {
    size_t calls, fails_at;
} failing_allocator;

static void *allocate_or_fail(void *context, size_t byte_count) {
    failing_allocator *const allocator = context;
    return ++allocator->calls == allocator->fails_at ? NULL : malloc(byte_count);
}

static void release_plainly(void *context, void *pointer, size_t byte_count) {
    (void)context;
    (void)byte_count;
    free(pointer);
}

static void survives_failing_allocations(void **state) {
    (void)state;
    memory plain = memory_default();
    static sheets soup;
    make_sheets(&plain, &soup);
    double const separation = 1e-4;
    bool has_failed = true;
    for (size_t k = 1; has_failed; k++) {
        failing_allocator allocator = {.fails_at = k};
        memory heap = {.allocator = {allocate_or_fail, release_plainly, &allocator, 0}};
        narrow_phase_input input = {.set = &soup.set, .separations = &separation, .threads = 1};
        batch_feed feed = {.of = &soup, .batch_size = 777};
        has_failed = narrow_phase_create(&heap, &feed.narrow) != TULLE_OK;
        if (has_failed) continue;
        for (int attempt = 0; attempt < 2; attempt++) {
            bool const is_short = run_narrow_phase(&feed, &input) == 0;
            assert_false(is_short && has_failed); /* only one allocation fails */
            has_failed = has_failed || is_short;
            if (!is_short) check_events(&soup, &input, feed.narrow);
            input.threads = 2; /* needs more workers */
        }
        if (has_failed) { /* it goes on as if nothing had happened */
            assert_true(run_narrow_phase(&feed, &input) > 0);
            check_events(&soup, &input, feed.narrow);
        } else {
            assert_true(k > 4);
        }
        narrow_phase_destroy(feed.narrow);
        assert_int_equal(heap.bytes_held, 0);
    }
    free_sheets(&plain, &soup);
    assert_int_equal(plain.bytes_held, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(events_match_single_tests),
        cmocka_unit_test(earliest_is_earliest),
        cmocka_unit_test(survives_failing_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
