/* Searches that may leave out what straight paths keep apart: whatever is left out stays farther
 * apart than the margin at all sampled times, and nothing comes beside what boxes around whole
 * paths give. Every kernel target and number of threads leaves out the same. Beside static
 * surfaces, too. */
#include "math/kernel_target.h"
#include "support/pair_keys.h"
#include "support/wide_normals.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Turns and shears all paths alike, and adds what they had before. */
static void move_together(soup_scene *soup, double size) {
    for (size_t v = 0; v < soup->vertex_count; v++) {
        double *const x0 = soup->x0 + 3 * v, *const x1 = soup->x1 + 3 * v;
        x1[0] += size * (0.3 - 0.5 * x0[1] + 0.2 * x0[2]);
        x1[1] += size * (0.5 * x0[0] - 0.4);
        x1[2] += size * (0.1 * x0[0] + 0.2 * x0[1]);
    }
}

static bool is_static(const soup_scene *of, uint32_t vertex) {
    size_t s = 0;
    while (vertex >= of->surfaces[s].vertex_end) s++;
    return of->surfaces[s].is_static;
}

/* Whether one feature of a pair is of a static surface. */
static bool has_static(const soup_scene *of, uint64_t key) {
    uint32_t v[4];
    find_pair_vertices(of, key, v);
    return is_static(of, v[0]) || is_static(of, v[3]);
}

/* Every pair of the list is in the stream, which may have others, or stays farther apart than
 * `distance` on paths that end off by `reach`. Returns how many are not in it, and adds those with
 * a static surface to *static_count. */
static size_t count_left_out(const soup_scene *of, double reach, const key_list *list,
                             const key_list *stream, double distance, size_t *static_count) {
    size_t at = 0, missing = 0;
    for (size_t i = 0; i < list->count; i++) {
        while (at < stream->count && stream->keys[at] < list->keys[i]) at++;
        if (at < stream->count && stream->keys[at] == list->keys[i]) continue;
        missing++;
        *static_count += has_static(of, list->keys[i]);
        assert_true(sample_pair_distance(of, list->keys[i], reach) > distance * (1.0 - 1e-9));
    }
    return missing;
}

/* Trees without boxes yet, so that all boxes are made for the paths. */
static broad_phase *make_following(memory *heap, const soup_scene *of, path_following how) {
    broad_phase *broad;
    assert_int_equal(broad_phase_create(heap, &of->set, of->x0, BROAD_PHASE_REFIT, &broad),
                     TULLE_OK);
    broad_phase_configure(broad, (broad_phase_options){.following = how});
    return broad;
}

static void following_paths_leaves_out_only_what_stays_apart(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 16;
    kernel_target const widest = kernel_target_get();
    size_t missing = 0, all = 0, others = 0, static_count = 0;
    for (int round = 0; round < 40; round++) {
        soup_scene *const soup = make_scene(&heap, &seed, 120);
        double const margin = round % 2 ? 0.02 : 0.0;
        move_together(soup, 0.6 * (round % 5));
        broad_phase *broad = make_trees(&heap, soup, BROAD_PHASE_REFIT);
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, 1), TULLE_OK);
        key_list const list = search_keys(broad, &soup->set, 1);
        if (round % 4 == 3) { /* from now on only */
            broad_phase_configure(broad, (broad_phase_options){.following = PATHS_ALWAYS});
        } else {
            broad_phase_destroy(broad);
            broad = make_following(&heap, soup, PATHS_ALWAYS);
        }
        key_list first = {0};
        for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
            if (!kernel_target_force((kernel_target)target)) continue;
            int const threads = 1 + round % 3;
            assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, threads),
                             TULLE_OK);
            key_list const stream = search_keys(broad, &soup->set, threads);
            if (!first.keys) {
                first = stream;
                size_t const left_out =
                    count_left_out(soup, 0.0, &list, &stream, margin, &static_count);
                missing += left_out;
                all += list.count;
                others += stream.count + left_out - list.count;
                continue;
            }
            assert_same_keys(&first, &stream);
            free(stream.keys);
        }
        kernel_target_force(widest);
        free(list.keys);
        free(first.keys);
        broad_phase_destroy(broad);
        free_scene(&heap, soup);
    }
    print_message("%zu of %zu pairs left out, %zu others\n", missing, all, others);
    assert_true(missing > all / 100 && missing < all);
    /* boxes around whole paths that do not meet: rounding alone lets such pairs through */
    assert_true(others <= all / 10000);
    assert_int_equal(heap.bytes_held, 0);
}

/* What straight paths kept apart. */
typedef struct path_sums {
    size_t straight_count, missing;
    size_t static_straight_count,
        static_missing; /* of scenes, and of pairs, with a static surface */
} path_sums;

static void make_static(soup_scene *soup, size_t surface) {
    surface_range *const range = &soup->surfaces[surface];
    range->is_static = true;
    memcpy(soup->x1 + 3 * (size_t)range->vertex_begin, soup->x0 + 3 * (size_t)range->vertex_begin,
           3 * (range->vertex_end - range->vertex_begin) * sizeof(double));
}

static void follow_long_paths(memory *heap, const soup_scene *soup, bool may_be_long,
                              path_sums *sums) {
    double const margin = 0.03, gap = 0.01;
    broad_phase *broad = make_trees(heap, soup, BROAD_PHASE_REFIT);
    assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, 1), TULLE_OK);
    key_list const list = search_keys(broad, &soup->set, 1);
    assert_false(broad_phase_is_straight(broad));
    broad_phase_destroy(broad);
    broad = make_following(heap, soup, PATHS_WHERE_LONG);
    /* from one length of paths to the other and back: static trees keep their boxes */
    assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x0, margin, 1), TULLE_OK);
    assert_false(broad_phase_is_straight(broad));
    assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, 2), TULLE_OK);
    bool const is_straight = broad_phase_is_straight(broad);
    assert_true(may_be_long || !is_straight);
    key_list const stream = search_keys(broad, &soup->set, 2);
    size_t const left_out =
        count_left_out(soup, 0.5 * (margin - gap), &list, &stream, gap, &sums->static_missing);
    assert_true(is_straight || left_out == 0);
    sums->missing += left_out, sums->straight_count += is_straight;
    /* the same where static trees are fitted in this call */
    broad_phase *const anew = make_following(heap, soup, PATHS_WHERE_LONG);
    assert_int_equal(build_trees(anew, &soup->set, soup->x0, soup->x1, margin, 1), TULLE_OK);
    assert_int_equal(broad_phase_is_straight(anew), is_straight);
    key_list const again = search_keys(anew, &soup->set, 1);
    assert_same_keys(&stream, &again);
    for (size_t s = 0; s < soup->surface_count; s++)
        sums->static_straight_count += is_straight && soup->surfaces[s].is_static;
    free(list.keys);
    free(stream.keys);
    free(again.keys);
    broad_phase_destroy(broad);
    broad_phase_destroy(anew);
}

/* Only where paths are long, and those nearby alike, is anything left out; then what is left out
 * keeps a smaller gap too where paths end off by half of what the margin exceeds it. A surface that
 * stands still in some scenes neither makes paths short nor decides what is left out. */
static void long_paths_alone_are_followed(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 17;
    path_sums sums = {0};
    for (int round = 0; round < 240; round++) {
        soup_scene *const soup = make_scene(&heap, &seed, 120);
        if (round % 4 == 0) memcpy(soup->x1, soup->x0, 3 * soup->vertex_count * sizeof(double));
        move_together(soup, round % 4 == 0 ? 1e-6 : 0.6 * (round % 4));
        if (round % 2 == 1 && soup->surface_count > 1) make_static(soup, soup->surface_count - 1);
        follow_long_paths(&heap, soup, round % 4 != 0, &sums);
        free_scene(&heap, soup);
    }
    print_message("%zu pairs left out of %zu scenes, %zu of these with a static surface\n",
                  sums.missing, sums.straight_count, sums.static_straight_count);
    assert_true(sums.straight_count > 10 &&
                sums.straight_count < 180); /* some move every which way */
    assert_true(sums.missing > 1000);
    assert_true(sums.static_straight_count > 10);
    assert_int_equal(heap.bytes_held, 0);
}

/* A sheet goes through one that stands still, on a slant: what it passes by is left out, though
 * boxes meet. */
static void what_passes_a_static_surface_is_left_out(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 18;
    path_sums sums = {0};
    for (int round = 0; round < 8; round++) {
        soup_scene *const soup = calloc(1, sizeof *soup);
        assert_non_null(soup);
        double const way = random_between(&seed, 0.5, 0.7);
        for (int s = 0; s < 2; s++) soup_scene_add(soup, SOUP_SHEET, 300, 1e-3, &seed);
        soup_scene_finish(&heap, soup);
        for (size_t v = 0; v < soup->vertex_count; v++) {
            soup->x1[3 * v] += round & 1 ? way : -way;
            soup->x1[3 * v + 1] += round & 2 ? way : -way;
            soup->x1[3 * v + 2] += round & 4 ? -way : way;
        }
        make_static(soup, round & 4 ? 0 : 1);
        follow_long_paths(&heap, soup, true, &sums);
        free_scene(&heap, soup);
    }
    print_message("%zu pairs left out, %zu with a static surface\n", sums.missing,
                  sums.static_missing);
    assert_int_equal(sums.static_straight_count, 8);
    assert_true(sums.static_missing > 10000);
    assert_int_equal(heap.bytes_held, 0);
}

/* Some vertices go so far that what their leaves sweep has no bounds, not even in boxes of floats:
 * such a leaf meets all features of others, each once, and nothing else. */
static void paths_without_bounds_meet_features_alone(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 19;
    size_t met = 0, missing = 0;
    kernel_target const widest = kernel_target_get();
    for (int round = 0; round < 40; round++) {
        soup_scene *const soup = make_scene(&heap, &seed, 60);
        double const margin = round % 2 ? 0.02 : 0.0;
        for (size_t v = 0; v < soup->vertex_count; v++)
            if (random_next(&seed) % 20 == 0)
                soup->x1[3 * v + random_next(&seed) % 3] = random_next(&seed) % 2 ? 1e38 : -1e38;
        broad_phase *broad = make_trees(&heap, soup, BROAD_PHASE_REFIT);
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, 1), TULLE_OK);
        key_list const list = search_keys(broad, &soup->set, 1);
        broad_phase_destroy(broad);
        broad = make_following(&heap, soup, PATHS_ALWAYS);
        for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
            if (!kernel_target_force((kernel_target)target)) continue;
            assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, 2),
                             TULLE_OK);
            key_list const stream = search_keys(broad, &soup->set, 2);
            size_t static_count = 0;
            missing += count_left_out(soup, 0.0, &list, &stream, margin, &static_count);
            met += stream.count;
            for (size_t i = 0; i < stream.count; i++) {
                uint32_t v[4];
                find_pair_vertices(soup, stream.keys[i], v);
                for (int k = 0; k < 4; k++)
                    for (int m = 0; m < k; m++) assert_int_not_equal(v[k], v[m]);
            }
            free(stream.keys);
        }
        kernel_target_force(widest);
        free(list.keys);
        broad_phase_destroy(broad);
        free_scene(&heap, soup);
    }
    print_message("%zu pairs met, %zu left out\n", met, missing);
    assert_true(met > 10000 && missing > 0);
    assert_int_equal(heap.bytes_held, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(following_paths_leaves_out_only_what_stays_apart),
        cmocka_unit_test(long_paths_alone_are_followed),
        cmocka_unit_test(what_passes_a_static_surface_is_left_out),
        cmocka_unit_test(paths_without_bounds_meet_features_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
