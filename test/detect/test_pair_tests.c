/* Stage 8 against one call of time_of_impact for each pair: the same events in the order of the
 * list, for any number of threads; separations by function; counts; failing allocations. */
#include "base/hash.h"
#include "detect/broad_phase.h"
#include "detect/pair_tests.h"

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
    topology topo;
    surface_range surfaces[2];
    surface_set set;
    pair_list pairs;
} sheets;

static void make_sheets(memory *heap, sheets *to) {
    static uint32_t triangles[3 * TRIANGLE_COUNT];
    uint64_t seed = 21;
    uint32_t *corner = triangles;
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
    uint32_t const edges = (uint32_t)to->topo.edge_count;
    to->surfaces[0] = (surface_range){
        0, VERTEX_COUNT / 2, 0, edges / 2, 0, TRIANGLE_COUNT / 2, .is_present = true};
    to->surfaces[1] = (surface_range){VERTEX_COUNT / 2,   VERTEX_COUNT,   edges / 2,         edges,
                                      TRIANGLE_COUNT / 2, TRIANGLE_COUNT, .is_present = true};
    to->set = (surface_set){.topo = &to->topo, .surfaces = to->surfaces, .surface_count = 2};
    broad_phase *broad;
    assert_int_equal(broad_phase_create(heap, &to->set, to->x0, BROAD_PHASE_REFIT, &broad),
                     TULLE_OK);
    assert_int_equal(build_trees(broad, &to->set, to->x0, to->x1, 1e-3, 1), TULLE_OK);
    to->pairs = (pair_list){0};
    assert_int_equal(find_pairs(broad, &to->set, 1, &to->pairs, NULL), TULLE_OK);
    broad_phase_destroy(broad);
}

static void free_sheets(memory *heap, sheets *of) {
    ARRAY_FREE(heap, &of->pairs.vertex_triangle);
    ARRAY_FREE(heap, &of->pairs.edge_edge);
    topology_destroy(heap, &of->topo);
}

static double separation_by_height(void *context, feature_kind kind, feature_pair pair,
                                   const vec3 start[4]) {
    (void)pair;
    return *(const double *)context * (kind == FEATURE_EDGE_EDGE ? 1.0 : 0.5) *
           (1.0 + fabs(start[0].z));
}

/* Walks all pairs and the events beside each other. */
static void check_events(const sheets *of, const pair_test_input *input, const event_list *list,
                         const pair_test_counts *counts) {
    size_t at = 0;
    uint64_t states[4] = {0};
    double lower_bound = 1.0;
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
            double const separation =
                input->pair_separation ? separation_by_height(input->separation_context,
                                                              (feature_kind)kind, pair, paths.start)
                                       : input->separation;
            toi_result const result = time_of_impact((feature_kind)kind, &paths, separation);
            bool const is_event = at < list->events.count &&
                                  (int)list->events.data[at].kind == kind &&
                                  list->events.data[at].pair.first == pair.first &&
                                  list->events.data[at].pair.second == pair.second;
            if (is_event) {
                const toi_result *const found = &list->events.data[at++].result;
                assert_int_equal(found->state, result.state);
                assert_memory_equal(&found->lower_bound, &result.lower_bound, sizeof(double));
                assert_memory_equal(&found->closest, &result.closest, sizeof result.closest);
                states[result.state]++;
                lower_bound = fmin(lower_bound, result.lower_bound);
            } else if (result.state != TOI_SEPARATED) {
                /* Only the filters, which prove more, may take it out. */
                assert_true(pair_stays_apart((feature_kind)kind, &paths, separation) ||
                            (separation == 0.0 && pair_cannot_cross((feature_kind)kind, &paths)));
            }
        }
    }
    assert_int_equal(at, list->events.count);
    assert_int_equal(counts->hit_count, states[TOI_HIT]);
    assert_int_equal(counts->touching_count, states[TOI_TOUCHING_AT_START]);
    assert_int_equal(counts->unresolved_count, states[TOI_UNRESOLVED]);
    assert_int_equal(counts->filtered_count + counts->tested_count, counts->candidate_count);
    assert_true(counts->lower_bound == lower_bound);
}

static void events_match_single_tests(void **state) {
    (void)state;
    memory heap = memory_default();
    static sheets soup;
    make_sheets(&heap, &soup);
    arena scratch = arena_make(&heap);
    double scale = 1e-3;
    for (int variant = 0; variant < 3; variant++) {
        pair_test_input input = {.topo = &soup.topo,
                                 .x0 = soup.x0,
                                 .x1 = soup.x1,
                                 .pairs = &soup.pairs,
                                 .separation = variant == 0 ? 0.0 : 1e-4,
                                 .pair_separation = variant == 2 ? separation_by_height : NULL,
                                 .separation_context = &scale,
                                 .threads = 1};
        event_list events = {0};
        pair_test_counts counts;
        assert_int_equal(test_pairs(&input, &heap, &scratch, &events, &counts), TULLE_OK);
        assert_int_equal(counts.candidate_count,
                         soup.pairs.vertex_triangle.count + soup.pairs.edge_edge.count);
        assert_true(events.events.count > 100 && counts.filtered_count > 1000);
        check_events(&soup, &input, &events, &counts);
        event_list again = {0};
        uint64_t warm_count = 0;
        for (input.threads = 2; input.threads < 9; input.threads += 3) {
            assert_int_equal(test_pairs(&input, &heap, &scratch, &again, NULL), TULLE_OK);
            check_events(&soup, &input, &again, &counts);
            if (input.threads == 2)
                warm_count = heap.allocate_count;
            else
                assert_int_equal(heap.allocate_count, warm_count);
        }
        ARRAY_FREE(&heap, &events.events);
        ARRAY_FREE(&heap, &again.events);
    }
    arena_destroy(&scratch);
    free_sheets(&heap, &soup);
    assert_int_equal(heap.bytes_held, 0);
}

static void no_pairs_make_no_events(void **state) {
    (void)state;
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    pair_list const pairs = {0};
    pair_test_input const input = {.pairs = &pairs, .threads = 2};
    event_list events = {0};
    pair_test_counts counts;
    assert_int_equal(test_pairs(&input, &heap, &scratch, &events, &counts), TULLE_OK);
    assert_int_equal(events.events.count, 0);
    assert_true(counts.lower_bound == 1.0);
    ARRAY_FREE(&heap, &events.events);
    arena_destroy(&scratch);
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
    bool has_failed = true;
    for (size_t k = 1; has_failed; k++) {
        failing_allocator allocator = {.fails_at = k};
        memory heap =
            memory_make((tulle_allocator){allocate_or_fail, release_plainly, &allocator, 0});
        arena scratch = arena_make(&heap);
        pair_test_input const input = {.topo = &soup.topo,
                                       .x0 = soup.x0,
                                       .x1 = soup.x1,
                                       .pairs = &soup.pairs,
                                       .separation = 1e-4,
                                       .threads = 2};
        event_list events = {0};
        pair_test_counts counts;
        tulle_status const status = test_pairs(&input, &heap, &scratch, &events, &counts);
        has_failed = status != TULLE_OK;
        if (has_failed) {
            assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
            assert_int_equal(events.events.count, 0);
            assert_int_equal(test_pairs(&input, &heap, &scratch, &events, &counts), TULLE_OK);
        } else {
            assert_true(k > 4);
        }
        check_events(&soup, &input, &events, &counts);
        ARRAY_FREE(&heap, &events.events);
        arena_destroy(&scratch);
        assert_int_equal(heap.bytes_held, 0);
    }
    free_sheets(&plain, &soup);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(events_match_single_tests),
        cmocka_unit_test(no_pairs_make_no_events),
        cmocka_unit_test(survives_failing_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
