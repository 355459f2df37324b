/* The streaming search against the sorted list: the same pairs for every number of threads and
 * every kernel target; with labels of patches only pairs within one patch may be missing; surfaces
 * that do not meet give nothing. */
#include "base/hash.h"
#include "detect/trees/broad_phase_parts.h"
#include "detect/trees/tree_kernels.h"
#include "geom/distance.h"
#include "math/kernel_target.h"
#include "support/pair_keys.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static size_t surface_of(const soup_scene *of, uint32_t vertex) {
    size_t s = 0;
    while (vertex >= of->surfaces[s].vertex_end) s++;
    return s;
}

static void streams_what_the_list_holds(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 11;
    kernel_target const widest = kernel_target_get();
    for (int round = 0; round < 20; round++) {
        soup_scene *const soup = make_scene(&heap, &seed, 150);
        for (int method = 0; method < 2; method++) {
            broad_phase *const broad = make_trees(&heap, soup, (broad_phase_method)method);
            key_list const list = list_keys(&heap, broad, &soup->set, 1);
            for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
                if (!kernel_target_force((kernel_target)target)) continue;
                for (int threads = 1; threads <= MAX_THREADS; threads++) {
                    assert_int_equal(
                        build_trees(broad, &soup->set, soup->x0, soup->x1, 0.02, threads),
                        TULLE_OK);
                    key_list const stream = search_keys(broad, &soup->set, threads);
                    assert_same_keys(&list, &stream);
                    free(stream.keys);
                }
            }
            kernel_target_force(widest);
            free(list.keys);
            broad_phase_destroy(broad);
        }
        free_scene(&heap, soup);
    }
    assert_int_equal(heap.bytes_held, 0);
}

/* The tables lead to the positions, to the bit. */
static void check_tables(const soup_scene *of, const pair_tables *tables) {
    assert_int_equal((uintptr_t)tables->records % 64, 0);
    for (uint32_t slot = 0; slot < of->topo.triangle_count; slot++)
        for (uint32_t k = 0; k < 3; k++) {
            size_t const vertex = of->topo.triangles[3 * tables->triangle_features[slot] + k];
            const vertex_record *const record =
                &tables->records[tables->triangle_corners[3 * slot + k]];
            assert_memory_equal(record->start, of->x0 + 3 * vertex, 3 * sizeof(double));
            assert_memory_equal(record->end, of->x1 + 3 * vertex, 3 * sizeof(double));
            assert_true(record->start[3] == 0.0 && record->end[3] == 0.0);
        }
    for (uint32_t slot = 0; slot < of->topo.edge_count; slot++)
        for (uint32_t k = 0; k < 2; k++) {
            size_t const vertex = of->topo.edges[2 * tables->edge_features[slot] + k];
            assert_memory_equal(tables->records[tables->edge_corners[2 * slot + k]].start,
                                of->x0 + 3 * vertex, 3 * sizeof(double));
        }
}

static void tables_lead_to_positions(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 12;
    for (int round = 0; round < 10; round++) {
        soup_scene *const soup = make_scene(&heap, &seed, 100);
        broad_phase *const broad = make_trees(&heap, soup, (broad_phase_method)(round % 2));
        check_tables(soup, broad_phase_get_tables(broad));
        broad_phase_destroy(broad);
        free_scene(&heap, soup);
    }
}

static void consume_none(void *context, const pair_tables *tables, const pair_batch *batch,
                         int worker) {
    (void)context, (void)tables, (void)batch, (void)worker;
    fail_msg("a batch of trees that were not built");
}

/* Trees that could not be built are not searched; once they are built again, they are. */
static void trees_that_were_not_built_are_refused(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 16;
    soup_scene *const soup = make_scene(&heap, &seed, 100);
    for (int method = 0; method < 2; method++) {
        broad_phase *const broad = make_trees(&heap, soup, (broad_phase_method)method);
        key_list const before = search_keys(broad, &soup->set, 1);
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, (double)NAN, 1),
                         TULLE_ERROR_INVALID_ARGUMENT);
        assert_int_equal(search_pairs(broad, &soup->set, 1, consume_none, NULL, NULL),
                         TULLE_ERROR_INVALID_ARGUMENT);
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, 0.02, 1), TULLE_OK);
        key_list const after = search_keys(broad, &soup->set, 1);
        assert_same_keys(&before, &after);
        free(before.keys);
        free(after.keys);
        broad_phase_destroy(broad);
    }
    free_scene(&heap, soup);
}

/* A search begins with the pairs of surfaces that may meet and whose boxes do, and no others. */
static void roots_are_those_that_meet(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 17;
    size_t met = 0, parted = 0;
    for (int round = 0; round < 40; round++) {
        soup_scene *const soup = calloc(1, sizeof *soup);
        assert_non_null(soup);
        for (int s = 0; s < MAX_SURFACES; s++) {
            size_t const begin = 3 * soup->vertex_count;
            soup_scene_add(soup, SOUP_RANDOM, 30, 0.05, &seed);
            double const way[3] = {4.0 * random_uniform(&seed), 4.0 * random_uniform(&seed),
                                   4.0 * random_uniform(&seed)};
            for (size_t i = begin; i < 3 * soup->vertex_count; i++) {
                soup->x0[i] += way[i % 3];
                soup->x1[i] += way[i % 3];
            }
        }
        soup_scene_finish(&heap, soup);
        broad_phase *const broad = make_trees(&heap, soup, (broad_phase_method)(round % 2));
        assert_true(list_root_pairs(broad, &soup->set));
        size_t at = 0;
        for (uint32_t a = 0; a < MAX_SURFACES; a++)
            for (uint32_t b = a; b < MAX_SURFACES; b++) {
                const surface_tree *const trees[2] = {&broad->trees[a], &broad->trees[b]};
                const tree_node *const roots[2] = {
                    &trees[0]->nodes.data[trees[0]->nodes.count - 1],
                    &trees[1]->nodes.data[trees[1]->nodes.count - 1]};
                if (!surfaces_may_meet(&soup->set, a, b)) continue;
                bool const meets = boxes_meet(roots[0]->box, roots[1]->box);
                met += meets, parted += !meets;
                if (!meets) continue;
                assert_true(at < broad->search_tasks[0].count);
                const search_task *const task = &broad->search_tasks[0].data[at++];
                assert_true(task->surface[0] == a && task->surface[1] == b);
            }
        assert_int_equal(at, broad->search_tasks[0].count);
        broad_phase_destroy(broad);
        free_scene(&heap, soup);
    }
    assert_true(met > 100 && parted > 100);
}

/* Missing pairs, all of which must lie within one patch. */
static size_t count_missing(const soup_scene *of, const uint32_t *labels, const key_list *all,
                            const key_list *kept) {
    size_t at = 0, missing = 0;
    for (size_t i = 0; i < all->count; i++) {
        if (at < kept->count && kept->keys[at] == all->keys[i]) {
            at++;
            continue;
        }
        assert_true(pair_is_within_patch(of, labels, all->keys[i]));
        missing++;
    }
    assert_int_equal(at, kept->count);
    return missing;
}

/* Labels in long runs of triangles, so that whole nodes bear one. */
static void fill_labels(uint32_t *labels, size_t count, size_t longest_run, uint64_t *seed) {
    for (size_t i = 0; i < count;) {
        uint32_t const label = (uint32_t)(random_next(seed) % 4);
        size_t const end = i + 1 + random_next(seed) % longest_run;
        for (; i < count && i < end; i++) labels[i] = label;
    }
}

static void leaves_out_only_pairs_within_a_patch(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 13;
    size_t missing = 0;
    uint32_t *const labels = calloc(MAX_TRIANGLES, sizeof *labels);
    for (int round = 0; round < 60; round++) {
        soup_scene *const soup = make_scene(&heap, &seed, 120);
        broad_phase *const broad = make_trees(&heap, soup, BROAD_PHASE_REFIT);
        key_list const all = search_keys(broad, &soup->set, 2);
        fill_labels(labels, soup->triangle_count, round % 2 ? 1000 : 60, &seed);
        broad_phase_set_patches(broad, (patch_labels){.labels = labels, .label_count = 3});
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, 0.02, 2), TULLE_OK);
        key_list const kept = search_keys(broad, &soup->set, 2);
        missing += count_missing(soup, labels, &all, &kept);
        /* No patches again: nothing missing. */
        broad_phase_set_patches(broad, (patch_labels){0});
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, 0.02, 2), TULLE_OK);
        key_list const again = search_keys(broad, &soup->set, 2);
        assert_same_keys(&all, &again);
        free(all.keys);
        free(kept.keys);
        free(again.keys);
        broad_phase_destroy(broad);
        free_scene(&heap, soup);
    }
    free(labels);
    assert_true(missing > 1000);
    assert_int_equal(heap.bytes_held, 0);
}

/* More leaves than a worker keeps blocks of, one surface static. Labels that leave out nothing make
 * blocks be fitted when they are needed. */
static void blocks_fitted_when_needed_are_the_same(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 15;
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint32_t *const labels = calloc(MAX_TRIANGLES, sizeof *labels);
    assert_true(soup && labels);
    soup_scene_add(soup, SOUP_SHEET, 2700, 0.02, &seed);
    soup_scene_add(soup, SOUP_SHEET, 2700, 0.0, &seed);
    soup_scene_finish(&heap, soup);
    soup->surfaces[1].is_static = true;
    broad_phase *const broad = make_trees(&heap, soup, BROAD_PHASE_REFIT);
    key_list const all = search_keys(broad, &soup->set, 2);
    assert_true(all.count > 1000);
    kernel_target const widest = kernel_target_get();
    for (int round = 0; round < 4 * KERNEL_TARGET_COUNT; round++) {
        if (!kernel_target_force((kernel_target)(round / 4))) continue;
        patch_labels const none = {.labels = round % 2 == 0 ? labels : NULL, .label_count = 1};
        broad_phase_set_patches(broad, none);
        int const threads = 1 + round % 4 / 2;
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, 0.02, threads),
                         TULLE_OK);
        key_list const again = search_keys(broad, &soup->set, threads);
        assert_same_keys(&all, &again);
        free(again.keys);
    }
    kernel_target_force(widest);
    free(all.keys);
    free(labels);
    broad_phase_destroy(broad);
    free_scene(&heap, soup);
    assert_int_equal(heap.bytes_held, 0);
}

/* A surface is one pair of roots. Workers need more to share, so its nodes are opened before. */
static void one_surface_is_split_for_workers(void **state) {
    (void)state;
    memory heap = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint64_t seed = 14;
    soup_scene_add(soup, SOUP_SHEET, 2700, 0.02, &seed);
    soup_scene_finish(&heap, soup);
    broad_phase *const broad = make_trees(&heap, soup, BROAD_PHASE_REFIT);
    free(search_keys(broad, &soup->set, 1).keys);
    size_t const one = broad->search_tasks[0].count, other = broad->search_tasks[1].count;
    assert_true((one > other ? one : other) > 200);
    broad_phase_destroy(broad);
    free_scene(&heap, soup);
}

/* One patch over all: nothing is left of a single surface. */
static void a_patch_over_everything_leaves_nothing(void **state) {
    (void)state;
    memory heap = memory_default();
    soup_scene *const soup = calloc(1, sizeof *soup);
    uint64_t seed = 14;
    soup_scene_add(soup, SOUP_SHEET, 2000, 0.05, &seed);
    soup_scene_finish(&heap, soup);
    uint32_t *const labels = malloc(MAX_TRIANGLES * sizeof *labels);
    for (size_t i = 0; i < MAX_TRIANGLES; i++) labels[i] = 7;
    broad_phase *const broad = make_trees(&heap, soup, BROAD_PHASE_REFIT);
    broad_phase_set_patches(broad, (patch_labels){.labels = labels, .label_count = 9});
    assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, 0.02, 2), TULLE_OK);
    key_list const none = search_keys(broad, &soup->set, 2);
    assert_int_equal(none.count, 0);
    free(none.keys);
    free(labels);
    broad_phase_destroy(broad);
    free_scene(&heap, soup);
}

/* What of `all` is between surfaces that may meet. */
static key_list keep_meeting(const soup_scene *of, const key_list *all) {
    key_list kept = {.keys = malloc((all->count + 1) * sizeof *kept.keys)};
    for (size_t i = 0; i < all->count; i++) {
        uint32_t v[4];
        find_pair_vertices(of, all->keys[i], v);
        size_t const a = surface_of(of, v[0]), b = surface_of(of, v[3]);
        if (a == b && of->surfaces[a].ignores_self) continue;
        if (of->set.collides && !of->set.collides[a * of->set.surface_count + b]) continue;
        kept.keys[kept.count++] = all->keys[i];
    }
    return kept;
}

static void honours_which_surfaces_meet(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 15;
    for (int round = 0; round < 40; round++) {
        soup_scene *const soup = make_scene(&heap, &seed, 80);
        broad_phase *const broad = make_trees(&heap, soup, (broad_phase_method)(round % 2));
        key_list const all = search_keys(broad, &soup->set, 1);
        unsigned char collides[MAX_SURFACES * MAX_SURFACES];
        size_t const count = soup->surface_count;
        for (size_t a = 0; a < count; a++) {
            soup->surfaces[a].ignores_self = random_next(&seed) % 3 == 0;
            for (size_t b = a; b < count; b++)
                collides[a * count + b] = collides[b * count + a] = random_next(&seed) % 3 != 0;
        }
        if (round % 3 != 0) soup->set.collides = collides;
        key_list const kept = keep_meeting(soup, &all), found = search_keys(broad, &soup->set, 2);
        assert_same_keys(&kept, &found);
        free(all.keys);
        free(kept.keys);
        free(found.keys);
        broad_phase_destroy(broad);
        free_scene(&heap, soup);
    }
    assert_int_equal(heap.bytes_held, 0);
}

/* Whatever run of leaves one worker fits, what lies before and after is another's; lanes without a
 * feature meet nothing. */
static void fitting_a_run_of_leaves_leaves_the_others_alone(void **state) {
    (void)state;
    enum { LEAVES = 6, BLOCK = LEAF_HEADER + 2 * GROUP_FLOATS, GUARD = 32 };
    kernel_target const widest = kernel_target_get();
    uint32_t const corners[3] = {0, 1, 2};
    vertex_box boxes[3];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 8; k++) boxes[i].start[k] = boxes[i].end[k] = (float)(k < 4 ? i : -i);
    uint32_t all_corners[3 * LEAVES];
    tree_leaf leaves[LEAVES];
    memset(leaves, 0, sizeof leaves);
    for (uint32_t l = 0; l < LEAVES; l++) {
        memcpy(all_corners + 3 * l, corners, sizeof corners);
        leaves[l].triangle_begin = l;
        leaves[l].triangle_end = l + 1;
        leaves[l].group_begin = 2 * l;
    }
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        for (size_t begin = 0; begin < LEAVES; begin++)
            for (size_t end = begin + 1; end <= LEAVES; end++) {
                float blocks[LEAVES * BLOCK + GUARD];
                for (size_t i = 0; i < LEAVES * BLOCK + GUARD; i++) blocks[i] = 77.0F;
                leaf_fit const fit = {.leaves = leaves,
                                      .triangle_corners = all_corners,
                                      .vertex_corners = all_corners,
                                      .edge_corners = all_corners,
                                      .vertex_boxes = boxes,
                                      .blocks = blocks};
                TULLE_PICK_KERNEL(fit_leaves)(&fit, begin, end);
                for (size_t i = 0; i < LEAVES * BLOCK + GUARD; i++) {
                    bool const is_inside = i >= begin * BLOCK && i < end * BLOCK;
                    if (!is_inside) assert_true(blocks[i] == 77.0F);
                }
                for (size_t l = begin; l < end; l++)
                    for (size_t i = 0; i < 2 * GROUP_FLOATS; i++) {
                        float const side = blocks[l * BLOCK + LEAF_HEADER + i];
                        bool const is_low = i % GROUP_FLOATS < 3 * GROUP_LANES;
                        if (i < GROUP_FLOATS && i % GROUP_LANES == 0)
                            assert_true(side == (is_low ? 0.0F : 2.0F));
                        else
                            assert_true(isnan(side));
                    }
            }
    }
    kernel_target_force(widest);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(streams_what_the_list_holds),
        cmocka_unit_test(tables_lead_to_positions),
        cmocka_unit_test(trees_that_were_not_built_are_refused),
        cmocka_unit_test(roots_are_those_that_meet),
        cmocka_unit_test(leaves_out_only_pairs_within_a_patch),
        cmocka_unit_test(blocks_fitted_when_needed_are_the_same),
        cmocka_unit_test(fitting_a_run_of_leaves_leaves_the_others_alone),
        cmocka_unit_test(one_surface_is_split_for_workers),
        cmocka_unit_test(a_patch_over_everything_leaves_nothing),
        cmocka_unit_test(honours_which_surfaces_meet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
