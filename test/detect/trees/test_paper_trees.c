/* One voxel tree a patch and one of the isolated triangles: the pairs of the refitted tree without
 * labels, and with labels those without just the pairs whose features belong to triangles of one
 * patch. */
#include "base/hash.h"
#include "detect/trees/broad_phase.h"
#include "support/soup_scene.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint32_t labels[MAX_TRIANGLES];

static void free_pairs(memory *heap, pair_list *pairs) {
    ARRAY_FREE(heap, &pairs->vertex_triangle);
    ARRAY_FREE(heap, &pairs->edge_edge);
}

/* label_count 0: no labels are given. */
static void find_with(memory *heap, const soup_scene *of, broad_phase_method method,
                      uint32_t label_count, int threads, pair_list *pairs) {
    broad_phase *broad;
    search_counts counts;
    assert_int_equal(broad_phase_create(heap, &of->set, of->x0, method, &broad), TULLE_OK);
    if (label_count > 0)
        broad_phase_set_patches(broad,
                                (patch_labels){.labels = labels, .label_count = label_count});
    assert_int_equal(build_trees(broad, &of->set, of->x0, of->x1, 0.02, threads), TULLE_OK);
    assert_int_equal(find_pairs(broad, &of->set, threads, PAIRS_SORTED, pairs, &counts), TULLE_OK);
    assert_int_equal(counts.candidate_count, pairs->vertex_triangle.count + pairs->edge_edge.count);
    broad_phase_destroy(broad);
}

/* The triangles around a feature: `count` from the returned place on. */
static const uint32_t *triangles_around(const topology *topo, feature_kind kind, bool is_second,
                                        const uint32_t *feature, size_t *count) {
    *count = 1;
    if (kind == FEATURE_EDGE_EDGE) {
        const uint32_t *const triangles = topo->edge_triangles + 2 * (size_t)*feature;
        *count = triangles[1] == TULLE_NONE ? 1 : 2;
        return triangles;
    }
    if (is_second) return feature;
    const adjacency *const around = &topo->vertex_triangles;
    *count = around->begin[*feature + 1] - around->begin[*feature];
    return around->items + around->begin[*feature];
}

/* Whether both features of a pair belong to one patch; is_exact: by the lowest triangle of each,
 * else by any. */
static bool lies_within_patch(const topology *topo, feature_kind kind, const feature_pair *pair,
                              bool is_exact) {
    size_t first_count, second_count;
    const uint32_t *const first = triangles_around(topo, kind, false, &pair->first, &first_count);
    const uint32_t *const second = triangles_around(topo, kind, true, &pair->second, &second_count);
    for (size_t i = 0; i < (is_exact ? 1 : first_count); i++)
        for (size_t j = 0; j < (is_exact ? 1 : second_count); j++)
            if (labels[first[i]] != 0 && labels[first[i]] == labels[second[j]]) return true;
    return false;
}

typedef struct pair_span {
    const feature_pair *pairs;
    size_t count;
} pair_span;

/* `some` is `all` without the pairs within patches; where not exactly, it may have some of those.
 */
static void check_kind(const topology *topo, feature_kind kind, pair_span of_all, pair_span of_some,
                       bool is_exact) {
    const feature_pair *const all = of_all.pairs, *const some = of_some.pairs;
    size_t const some_count = of_some.count;
    size_t at = 0;
    for (size_t i = 0; i < of_all.count; i++) {
        bool const is_found =
            at < some_count && some[at].first == all[i].first && some[at].second == all[i].second;
        at += is_found;
        bool const is_within = lies_within_patch(topo, kind, &all[i], is_exact);
        if (!is_within) assert_true(is_found);
        if (is_within && is_exact) assert_false(is_found);
    }
    assert_int_equal(at, some_count);
}

static void check_labels(const soup_scene *of, uint32_t label_count) {
    memory heap = memory_default();
    pair_list all = {0};
    find_with(&heap, of, BROAD_PHASE_REFIT, 0, 1, &all);
    for (int variant = 0; variant < 4; variant++) {
        pair_list some = {0};
        bool const is_paper = variant % 2 == 0;
        find_with(&heap, of, is_paper ? BROAD_PHASE_PAPER : BROAD_PHASE_REFIT, label_count,
                  1 + variant, &some);
        check_kind(&of->topo, FEATURE_VERTEX_TRIANGLE,
                   (pair_span){all.vertex_triangle.data, all.vertex_triangle.count},
                   (pair_span){some.vertex_triangle.data, some.vertex_triangle.count}, is_paper);
        check_kind(&of->topo, FEATURE_EDGE_EDGE,
                   (pair_span){all.edge_edge.data, all.edge_edge.count},
                   (pair_span){some.edge_edge.data, some.edge_edge.count}, is_paper);
        free_pairs(&heap, &some);
    }
    free_pairs(&heap, &all);
    assert_int_equal(heap.bytes_held, 0);
}

/* Fills the labels of a surface with labels from `first` on, none, one, few or one a triangle,
 * in runs or anyhow, and returns the next free label. */
static uint32_t label_surface(const soup_scene *of, size_t surface, uint32_t first,
                              uint64_t *seed) {
    const surface_range *const range = &of->surfaces[surface];
    uint32_t const count = range->triangle_end - range->triangle_begin;
    static const uint32_t label_counts[] = {0, 1, 2, 7, 60, 100000};
    uint32_t const wanted = label_counts[random_next(seed) % 6];
    uint32_t const used = wanted < count ? wanted : count;
    uint64_t const isolated_share = 1 + random_next(seed) % 8;
    bool const is_in_runs = random_next(seed) % 2;
    for (uint32_t i = 0; i < count; i++) {
        bool const is_isolated = used == 0 || random_next(seed) % isolated_share == 0;
        uint32_t const which = is_in_runs ? (uint32_t)((uint64_t)i * used / count)
                                          : (uint32_t)(random_next(seed) % (used + !used));
        labels[range->triangle_begin + i] = is_isolated ? 0 : first + which;
    }
    return first + used + (uint32_t)(random_next(seed) % 3);
}

static void leaves_out_just_pairs_within_patches(void **state) {
    (void)state;
    memory heap = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint64_t seed = 11;
    for (int round = 0; round < 150; round++) {
        memset(soup, 0, sizeof *soup);
        size_t const surface_count = 1 + random_next(&seed) % (round % 2 ? MAX_SURFACES : 1);
        uint32_t next = 1 + (uint32_t)(random_next(&seed) % 3);
        for (size_t s = 0; s < surface_count; s++) {
            soup_shape const shape = (soup_shape)(random_next(&seed) % SOUP_SHAPE_COUNT);
            size_t const count = shape == SOUP_SHEET ? 60 : random_next(&seed) % 120;
            soup_scene_add(soup, shape, count, 0.02, &seed);
            next = label_surface(soup, s, next, &seed);
            soup->surfaces[s].is_obstacle = random_next(&seed) % 4 == 0;
            soup->surfaces[s].is_static = random_next(&seed) % 4 == 0;
            soup->surfaces[s].is_present = random_next(&seed) % 6 != 0;
        }
        soup_scene_finish(&heap, soup);
        check_labels(soup, next - 1);
        topology_destroy(&heap, &soup->topo);
    }
    free(soup);
    assert_int_equal(heap.bytes_held, 0);
}

static void without_labels_it_is_one_tree(void **state) {
    (void)state;
    memory heap = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint64_t seed = 12;
    for (int shape = 0; shape < SOUP_SHAPE_COUNT; shape++) {
        memset(soup, 0, sizeof *soup);
        soup_scene_add(soup, (soup_shape)shape, 400, 0.01, &seed);
        soup_scene_finish(&heap, soup);
        memset(labels, 0, sizeof labels);
        pair_list lists[3] = {0};
        find_with(&heap, soup, BROAD_PHASE_REFIT, 0, 2, &lists[0]);
        find_with(&heap, soup, BROAD_PHASE_PAPER, 0, 2, &lists[1]);
        find_with(&heap, soup, BROAD_PHASE_PAPER, 9, 2, &lists[2]);
        for (int i = 1; i < 3; i++) {
            assert_int_equal(lists[i].vertex_triangle.count, lists[0].vertex_triangle.count);
            assert_int_equal(lists[i].edge_edge.count, lists[0].edge_edge.count);
            assert_memory_equal(lists[i].vertex_triangle.data, lists[0].vertex_triangle.data,
                                lists[0].vertex_triangle.count * sizeof(feature_pair));
            assert_memory_equal(lists[i].edge_edge.data, lists[0].edge_edge.data,
                                lists[0].edge_edge.count * sizeof(feature_pair));
        }
        for (int i = 0; i < 3; i++) free_pairs(&heap, &lists[i]);
        topology_destroy(&heap, &soup->topo);
    }
    free(soup);
}

/* One patch of all: nothing is left to be compared. */
static void one_patch_has_no_pairs(void **state) {
    (void)state;
    memory heap = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint64_t seed = 13;
    soup_scene_add(soup, SOUP_SHEET, 2000, 0.01, &seed);
    soup_scene_finish(&heap, soup);
    for (int i = 0; i < MAX_TRIANGLES; i++) labels[i] = 3;
    pair_list pairs = {0};
    find_with(&heap, soup, BROAD_PHASE_PAPER, 3, 2, &pairs);
    assert_int_equal(pairs.vertex_triangle.count + pairs.edge_edge.count, 0);
    free_pairs(&heap, &pairs);
    topology_destroy(&heap, &soup->topo);
    free(soup);
}

typedef struct failing_allocator {
    size_t calls, fails_at;
} failing_allocator;

static void *allocate_or_fail(void *context, size_t byte_count) {
    failing_allocator *const allocator = context;
    return ++allocator->calls == allocator->fails_at ? NULL : malloc(byte_count);
}

static void release_plainly(void *context, void *pointer, size_t byte_count) {
    (void)context, (void)byte_count;
    free(pointer);
}

/* Patches change from step to step; each allocation fails once, and the same calls then succeed. */
static void survives_failing_allocations_over_steps(void **state) {
    (void)state;
    memory plain = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint64_t seed = 14;
    soup_scene_add(soup, SOUP_SHEET, 200, 0.02, &seed);
    soup_scene_finish(&plain, soup);
    bool has_failed = true;
    size_t k = 0;
    for (; has_failed; k++) {
        failing_allocator allocator = {.fails_at = k + 1};
        memory heap = {.allocator = {allocate_or_fail, release_plainly, &allocator, 0}};
        broad_phase *broad = NULL;
        pair_list pairs = {0};
        has_failed =
            broad_phase_create(&heap, &soup->set, soup->x0, BROAD_PHASE_PAPER, &broad) != TULLE_OK;
        for (uint32_t step = 0; broad && step < 6; step++) {
            uint32_t const patch = 1 + step * step * 30; /* triangles of a patch */
            for (uint32_t i = 0; i < MAX_TRIANGLES; i++) labels[i] = 1 + i / patch;
            broad_phase_set_patches(broad,
                                    (patch_labels){.labels = labels, .label_count = MAX_TRIANGLES});
            tulle_status status = build_trees(broad, &soup->set, soup->x0, soup->x1, 0.02, 1);
            if (status == TULLE_OK)
                status = find_pairs(broad, &soup->set, 1, PAIRS_SORTED, &pairs, NULL);
            if (status == TULLE_OK) continue;
            assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
            assert_false(has_failed);
            has_failed = true;
            step--;
        }
        free_pairs(&heap, &pairs);
        broad_phase_destroy(broad);
        assert_int_equal(heap.bytes_held, 0);
    }
    assert_true(k > 20);
    topology_destroy(&plain, &soup->topo);
    free(soup);
}

/* Voxel trees are shaped by where the triangles are: a sheet takes hardly more pairs of leaves than
 * with trees that its rest shape made. */
static void voxels_part_a_sheet(void **state) {
    (void)state;
    static const broad_phase_method methods[] = {BROAD_PHASE_REFIT, BROAD_PHASE_BVOX,
                                                 BROAD_PHASE_PAPER};
    memory heap = memory_default();
    uint64_t seed = 31, leaf_pairs[3];
    soup_scene *const soup = calloc(1, sizeof *soup);
    assert_non_null(soup);
    soup_scene_add(soup, SOUP_SHEET, 5000, 0.0, &seed);
    for (size_t i = soup->triangle_count - 1; i > 0; i--) { /* in an order that helps nobody */
        size_t const other = (size_t)(random_next(&seed) % (i + 1));
        for (size_t k = 0; k < 3; k++) {
            uint32_t const corner = soup->triangles[3 * i + k];
            soup->triangles[3 * i + k] = soup->triangles[3 * other + k];
            soup->triangles[3 * other + k] = corner;
        }
    }
    soup_scene_finish(&heap, soup);
    for (int m = 0; m < 3; m++) {
        broad_phase *broad;
        pair_list pairs = {0};
        search_counts counts;
        assert_int_equal(broad_phase_create(&heap, &soup->set, soup->x0, methods[m], &broad),
                         TULLE_OK);
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, 1e-6, 1), TULLE_OK);
        assert_int_equal(find_pairs(broad, &soup->set, 1, PAIRS_UNSORTED, &pairs, &counts),
                         TULLE_OK);
        leaf_pairs[m] = counts.leaf_pair_count;
        free_pairs(&heap, &pairs);
        broad_phase_destroy(broad);
    }
    print_message("%zu triangles: %d pairs of leaves, %d by voxels, %d by the paper's trees\n",
                  soup->triangle_count, (int)leaf_pairs[0], (int)leaf_pairs[1], (int)leaf_pairs[2]);
    for (int m = 1; m < 3; m++) assert_true(leaf_pairs[m] < 4 * leaf_pairs[0]);
    topology_destroy(&heap, &soup->topo);
    free(soup);
    assert_int_equal(heap.bytes_held, 0);
}

/* Boxes are as fine beside the mesh at any size of it: so small that single precision has no number
 * of it, and so large. */
static void sizes_change_no_pair(void **state) {
    (void)state;
    static const int exponents[] = {0, -300, 300};
    memory heap = memory_default();
    search_counts counts[3];
    for (int i = 0; i < 3; i++) {
        uint64_t seed = 33;
        soup_scene *const soup = calloc(1, sizeof *soup);
        assert_non_null(soup);
        soup_scene_add(soup, SOUP_RANDOM, 500, 0.02, &seed);
        for (size_t k = 0; k < 3 * soup->vertex_count; k++) {
            soup->x0[k] = ldexp(soup->x0[k], exponents[i]);
            soup->x1[k] = ldexp(soup->x1[k], exponents[i]);
        }
        soup_scene_finish(&heap, soup);
        broad_phase *broad;
        pair_list pairs = {0};
        double const margin = ldexp(0.01, exponents[i]);
        assert_int_equal(broad_phase_create(&heap, &soup->set, soup->x0, BROAD_PHASE_REFIT, &broad),
                         TULLE_OK);
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, 1), TULLE_OK);
        assert_int_equal(find_pairs(broad, &soup->set, 1, PAIRS_UNSORTED, &pairs, &counts[i]),
                         TULLE_OK);
        assert_int_equal(counts[i].candidate_count, counts[0].candidate_count);
        assert_int_equal(counts[i].leaf_pair_count, counts[0].leaf_pair_count);
        free_pairs(&heap, &pairs);
        broad_phase_destroy(broad);
        topology_destroy(&heap, &soup->topo);
        free(soup);
    }
    assert_true(counts[0].candidate_count > 1000);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(leaves_out_just_pairs_within_patches),
        cmocka_unit_test(without_labels_it_is_one_tree),
        cmocka_unit_test(one_patch_has_no_pairs),
        cmocka_unit_test(voxels_part_a_sheet),
        cmocka_unit_test(sizes_change_no_pair),
        cmocka_unit_test(survives_failing_allocations_over_steps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
