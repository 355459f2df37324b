/* Both broad phases against brute force over all feature pairs, on random and adversarial soups;
 * surface flags, refitting, thread counts, failing allocations, steady memory. */
#include "base/hash.h"
#include "detect/trees/broad_phase.h"
#include "support/soup_scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static size_t surface_of(const soup_scene *of, uint32_t vertex) {
    size_t s = 0;
    while (vertex >= of->surfaces[s].vertex_end) s++;
    return s;
}

static bool may_meet(const soup_scene *of, uint32_t vertex_a, uint32_t vertex_b) {
    size_t const a = surface_of(of, vertex_a), b = surface_of(of, vertex_b);
    return of->surfaces[a].is_present && of->surfaces[b].is_present &&
           !(of->surfaces[a].is_obstacle && of->surfaces[b].is_obstacle);
}

/* Distance between the boxes of two sets of moving vertices along the axis where it is most, in
 * exact enough arithmetic: positive when apart. */
static double box_gap(const soup_scene *of, const uint32_t *a, int a_count, const uint32_t *b,
                      int b_count) {
    double gap = -1e300;
    for (size_t k = 0; k < 3; k++) {
        double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
        for (int side = 0; side < 2; side++)
            for (int i = 0; i < (side == 0 ? a_count : b_count); i++) {
                size_t const at = 3 * (size_t)(side == 0 ? a[i] : b[i]) + k;
                low[side] = fmin(low[side], fmin(of->x0[at], of->x1[at]));
                high[side] = fmax(high[side], fmax(of->x0[at], of->x1[at]));
            }
        gap = fmax(gap, fmax(low[0] - high[1], low[1] - high[0]));
    }
    return gap;
}

/* Every pair nearer than the margin is there, none that is clearly farther, none that may not be,
 * and the list is strictly ascending. slack: [m] what rounding to float may add. */
static void check_kind(const soup_scene *of, feature_kind kind, const feature_pair *pairs,
                       size_t count, double margin, double slack) {
    bool const is_vt = kind == FEATURE_VERTEX_TRIANGLE;
    size_t const first_count = is_vt ? of->vertex_count : of->topo.edge_count;
    size_t const second_count = is_vt ? of->triangle_count : of->topo.edge_count;
    size_t at = 0;
    for (uint32_t i = 0; i < first_count; i++)
        for (uint32_t j = is_vt ? 0 : i + 1; j < second_count; j++) {
            uint32_t v[4];
            feature_pair_vertices(&of->topo, kind, (feature_pair){i, j}, v);
            bool const is_found = at < count && pairs[at].first == i && pairs[at].second == j;
            if (is_found) at++;
            int const a_count = is_vt ? 1 : 2;
            bool shares = false;
            for (int a = 0; a < a_count; a++)
                for (int b = a_count; b < 4; b++) shares = shares || v[a] == v[b];
            const adjacency *const around = &of->topo.vertex_triangles;
            bool const is_used = around->begin[v[0]] != around->begin[v[0] + 1];
            bool const is_allowed = !shares && is_used && may_meet(of, v[0], v[3]);
            double const gap = box_gap(of, v, a_count, v + a_count, 4 - a_count);
            if (is_allowed && gap <= margin) assert_true(is_found);
            if (!is_allowed || gap > margin + slack) assert_false(is_found);
        }
    assert_int_equal(at, count);
}

static void check_lists(const soup_scene *of, const pair_list *pairs, double margin, double slack) {
    check_kind(of, FEATURE_VERTEX_TRIANGLE, pairs->vertex_triangle.data,
               pairs->vertex_triangle.count, margin, slack);
    check_kind(of, FEATURE_EDGE_EDGE, pairs->edge_edge.data, pairs->edge_edge.count, margin, slack);
}

static void free_pairs(memory *heap, pair_list *pairs) {
    ARRAY_FREE(heap, &pairs->vertex_triangle);
    ARRAY_FREE(heap, &pairs->edge_edge);
}

static void assert_same_pairs(const pair_list *a, const pair_list *b) {
    assert_int_equal(a->vertex_triangle.count, b->vertex_triangle.count);
    assert_int_equal(a->edge_edge.count, b->edge_edge.count);
    if (a->vertex_triangle.count)
        assert_memory_equal(a->vertex_triangle.data, b->vertex_triangle.data,
                            a->vertex_triangle.count * sizeof(feature_pair));
    if (a->edge_edge.count)
        assert_memory_equal(a->edge_edge.data, b->edge_edge.data,
                            a->edge_edge.count * sizeof(feature_pair));
}

static int compare_pairs(const void *a, const void *b) {
    const feature_pair *const x = a, *const y = b;
    if (x->first != y->first) return x->first < y->first ? -1 : 1;
    return (x->second > y->second) - (x->second < y->second);
}

static void sort_list(pair_list *pairs) {
    if (pairs->vertex_triangle.count)
        qsort(pairs->vertex_triangle.data, pairs->vertex_triangle.count, sizeof(feature_pair),
              compare_pairs);
    if (pairs->edge_edge.count)
        qsort(pairs->edge_edge.data, pairs->edge_edge.count, sizeof(feature_pair), compare_pairs);
}

/* The list that is not sorted has the same pairs. */
static void check_unsorted(memory *heap, broad_phase *broad, const soup_scene *of, int threads,
                           const pair_list *sorted) {
    pair_list pairs = {0};
    assert_int_equal(find_pairs(broad, &of->set, threads, PAIRS_UNSORTED, &pairs, NULL), TULLE_OK);
    sort_list(&pairs);
    assert_same_pairs(&pairs, sorted);
    free_pairs(heap, &pairs);
}

static void find_with(memory *heap, const soup_scene *of, broad_phase_method method, double margin,
                      int threads, pair_list *pairs) {
    search_counts counts;
    broad_phase *broad;
    assert_int_equal(broad_phase_create(heap, &of->set, of->x0, method, &broad), TULLE_OK);
    assert_int_equal(build_trees(broad, &of->set, of->x0, of->x1, margin, threads), TULLE_OK);
    assert_int_equal(find_pairs(broad, &of->set, threads, PAIRS_SORTED, pairs, &counts), TULLE_OK);
    assert_int_equal(counts.candidate_count, pairs->vertex_triangle.count + pairs->edge_edge.count);
    check_unsorted(heap, broad, of, threads, pairs);
    broad_phase_destroy(broad);
}

/* Both methods and several thread counts against brute force. */
static void check_scene(const soup_scene *of, double margin) {
    memory heap = memory_default();
    pair_list first = {0};
    find_with(&heap, of, BROAD_PHASE_REFIT, margin, 1, &first);
    double extent = margin;
    for (size_t i = 0; i < 3 * of->vertex_count; i++)
        extent = fmax(extent, fmax(fabs(of->x0[i]), fabs(of->x1[i])));
    check_lists(of, &first, margin, 2e-6 * extent);
    for (int variant = 0; variant < 4; variant++) {
        pair_list again = {0};
        broad_phase_method const method = variant % 2 ? BROAD_PHASE_BVOX : BROAD_PHASE_REFIT;
        find_with(&heap, of, method, margin, variant < 2 ? 2 : 5, &again);
        assert_same_pairs(&first, &again);
        free_pairs(&heap, &again);
    }
    free_pairs(&heap, &first);
    assert_int_equal(heap.bytes_held, 0);
}

static void matches_brute_force_on_soups(void **state) {
    (void)state;
    memory heap = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint64_t seed = 1;
    for (int round = 0; round < 12 * SOUP_SHAPE_COUNT; round++) {
        memset(soup, 0, sizeof *soup);
        soup_shape const shape = (soup_shape)(round % SOUP_SHAPE_COUNT);
        size_t const count = 1 + random_next(&seed) % 200;
        double const motion = round % 3 == 0 ? 0.0 : 0.1 * random_uniform(&seed);
        soup_scene_add(soup, shape, count, motion, &seed);
        soup_scene_finish(&heap, soup);
        /* Points lie on multiples of 0.1: gaps equal to the margin but for rounding. */
        const double margins[3] = {0.0, 0.05, 0.1};
        check_scene(soup, margins[round / SOUP_SHAPE_COUNT % 3]);
        topology_destroy(&heap, &soup->topo);
    }
    free(soup);
    assert_int_equal(heap.bytes_held, 0);
}

/* Large enough that workers descend through several levels. */
static void matches_brute_force_on_a_large_sheet(void **state) {
    (void)state;
    memory heap = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint64_t seed = 7;
    soup_scene_add(soup, SOUP_SHEET, 5000, 0.005, &seed);
    soup_scene_finish(&heap, soup);
    check_scene(soup, 0.01);
    topology_destroy(&heap, &soup->topo);
    free(soup);
}

static void matches_brute_force_between_surfaces(void **state) {
    (void)state;
    memory heap = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint64_t seed = 2;
    for (int round = 0; round < 40; round++) {
        memset(soup, 0, sizeof *soup);
        size_t const surface_count = 1 + random_next(&seed) % MAX_SURFACES;
        for (size_t s = 0; s < surface_count; s++) {
            soup_shape const shape = (soup_shape)(random_next(&seed) % SOUP_SHAPE_COUNT);
            /* Some surfaces have no triangle at all. */
            size_t const count = shape == SOUP_SHEET ? 30 : random_next(&seed) % 60;
            soup_scene_add(soup, shape, count, 0.05, &seed);
            soup->surfaces[s].is_obstacle = random_next(&seed) % 2 == 0;
            soup->surfaces[s].is_present = random_next(&seed) % 5 != 0;
        }
        soup_scene_finish(&heap, soup);
        check_scene(soup, 0.02);
        topology_destroy(&heap, &soup->topo);
    }
    free(soup);
    assert_int_equal(heap.bytes_held, 0);
}

/* The same shape in nanometres and in light years, and far from the origin. */
static void matches_brute_force_at_any_scale(void **state) {
    (void)state;
    memory heap = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    const double scales[] = {1e-300, 1e-9, 1e16, 1e200};
    for (size_t round = 0; round < 2 * (sizeof scales / sizeof scales[0]); round++) {
        memset(soup, 0, sizeof *soup);
        uint64_t seed = 3;
        double const scale = scales[round / 2], offset = round % 2 ? 1e5 : 0.0;
        soup_scene_add(soup, SOUP_RANDOM, 150, 0.1, &seed);
        for (size_t i = 0; i < 3 * soup->vertex_count; i++) {
            soup->x0[i] = scale * (soup->x0[i] + offset);
            soup->x1[i] = scale * (soup->x1[i] + offset);
        }
        soup_scene_finish(&heap, soup);
        check_scene(soup, 0.01 * scale);
        topology_destroy(&heap, &soup->topo);
    }
    free(soup);
}

/* A broad phase kept over steps gives what a fresh one gives, with static and vanishing surfaces
 * and another margin, and makes no heap call once warm. */
static void keeps_over_steps(void **state) {
    (void)state;
    for (int method = 0; method < 2; method++) {
        memory heap = memory_default(), kept_heap = memory_default();
        soup_scene *const soup = calloc(1, sizeof *soup);
        uint64_t seed = 4;
        soup_scene_add(soup, SOUP_SHEET, 150, 0.02, &seed);
        soup_scene_add(soup, SOUP_RANDOM, 100, 0.0, &seed);
        soup_scene_add(soup, SOUP_NEEDLES, 50, 0.0, &seed);
        soup->surfaces[1].is_obstacle = soup->surfaces[2].is_obstacle = true;
        soup->surfaces[1].is_static = true;
        soup_scene_finish(&heap, soup);
        broad_phase *broad;
        assert_int_equal(broad_phase_create(&kept_heap, &soup->set, soup->x0,
                                            (broad_phase_method)method, &broad),
                         TULLE_OK);
        pair_list kept = {0};
        uint64_t warm_count = 0;
        for (int step = 0; step < 12; step++) {
            soup->surfaces[1].is_present = step % 4 != 3;
            double const margin = step < 8 ? 0.05 : 0.02;
            for (uint32_t i = 3 * soup->surfaces[0].vertex_begin;
                 i < 3 * soup->surfaces[0].vertex_end; i++) {
                soup->x0[i] = soup->x1[i];
                soup->x1[i] += 0.01 * (2.0 * random_uniform(&seed) - 1.0);
            }
            if (step == 3) warm_count = kept_heap.allocate_count;
            int const threads = 1 + step % 3;
            assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, threads),
                             TULLE_OK);
            assert_int_equal(find_pairs(broad, &soup->set, threads, PAIRS_SORTED, &kept, NULL),
                             TULLE_OK);
            check_lists(soup, &kept, margin, 1e-5);
        }
        assert_true(kept.edge_edge.count > 100 && kept.vertex_triangle.count > 100);
        assert_int_equal(kept_heap.allocate_count, warm_count);
        free_pairs(&kept_heap, &kept);
        broad_phase_destroy(broad);
        assert_int_equal(kept_heap.bytes_held, 0);
        topology_destroy(&heap, &soup->topo);
        free(soup);
    }
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

/* Every single allocation fails once: the error is returned, nothing leaks, the list is empty, and
 * the same calls succeed afterwards. */
static void survives_failing_allocations(void **state) {
    (void)state;
    memory plain = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint64_t seed = 5;
    soup_scene_add(soup, SOUP_SHEET, 150, 0.02, &seed);
    soup_scene_add(soup, SOUP_RANDOM, 60, 0.02, &seed);
    soup_scene_finish(&plain, soup);
    for (int method = 0; method < 2; method++) {
        bool has_failed = true;
        size_t k = 0;
        for (; has_failed; k++) {
            failing_allocator allocator = {.fails_at = k + 1};
            memory heap = {.allocator = {allocate_or_fail, release_plainly, &allocator, 0}};
            broad_phase *broad;
            pair_list pairs = {0};
            tulle_status status =
                broad_phase_create(&heap, &soup->set, soup->x0, (broad_phase_method)method, &broad);
            if (status != TULLE_OK) assert_null(broad);
            /* The masks of leaves come with the second pass. */
            for (int pass = 0, attempt = 0; pass < 2 && broad;) {
                status = build_trees(broad, &soup->set, soup->x0, soup->x1, 0.05, 2);
                if (status == TULLE_OK)
                    status = find_pairs(broad, &soup->set, 2, PAIRS_SORTED, &pairs, NULL);
                if (status == TULLE_OK) {
                    check_lists(soup, &pairs, 0.05, 1e-5);
                    free_pairs(&heap, &pairs);
                    pass++;
                    continue;
                }
                assert_int_equal(attempt++, 0);
                assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
                assert_int_equal(pairs.vertex_triangle.count + pairs.edge_edge.count, 0);
            }
            free_pairs(&heap, &pairs);
            broad_phase_destroy(broad);
            assert_int_equal(heap.bytes_held, 0);
            has_failed = allocator.calls > k; /* also where it only trims an array */
        }
        assert_true(k > 30);
    }
    topology_destroy(&plain, &soup->topo);
    free(soup);
}

static void refuses_what_is_not_finite(void **state) {
    (void)state;
    memory heap = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint64_t seed = 6;
    soup_scene_add(soup, SOUP_SHEET, 20, 0.02, &seed);
    soup_scene_finish(&heap, soup);
    broad_phase *broad;
    pair_list pairs = {0};
    assert_int_equal(broad_phase_create(&heap, &soup->set, soup->x0, BROAD_PHASE_REFIT, &broad),
                     TULLE_OK);
    assert_int_equal(find_pairs(broad, &soup->set, 1, PAIRS_SORTED, &pairs, NULL),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, (double)NAN, 1),
                     TULLE_ERROR_INVALID_ARGUMENT);
    const double bad[] = {(double)NAN, (double)INFINITY};
    for (int i = 0; i < 2; i++) {
        soup->x1[7] = bad[i];
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, 0.1, 1),
                         TULLE_ERROR_INVALID_ARGUMENT);
    }
    soup->x1[7] = 0.0;
    assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, 0.1, 1), TULLE_OK);
    broad_phase_destroy(broad);
    soup->x0[7] = (double)NAN;
    assert_int_equal(broad_phase_create(&heap, &soup->set, soup->x0, BROAD_PHASE_BVOX, &broad),
                     TULLE_ERROR_INVALID_ARGUMENT);
    topology_destroy(&heap, &soup->topo);
    free(soup);
    assert_int_equal(heap.bytes_held, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(matches_brute_force_on_soups),
        cmocka_unit_test(matches_brute_force_on_a_large_sheet),
        cmocka_unit_test(matches_brute_force_between_surfaces),
        cmocka_unit_test(matches_brute_force_at_any_scale),
        cmocka_unit_test(keeps_over_steps),
        cmocka_unit_test(survives_failing_allocations),
        cmocka_unit_test(refuses_what_is_not_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
