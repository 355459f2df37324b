/* Searches that may leave out what straight paths keep apart: whatever is left out stays farther
 * apart than the margin at all sampled times, and every kernel target and number of threads leaves
 * out the same. */
#include "geom/distance.h"
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

/* Ends of the paths of a pair, each within a box of `reach` around that of now: both features
 * towards each other. */
static void bend_ends(feature_kind kind, double reach, vec3 ends[4]) {
    int const own = kind == FEATURE_EDGE_EDGE ? 2 : 1; /* points of the first feature */
    vec3 middles[2] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    for (int k = 0; k < 4; k++)
        middles[k >= own] =
            vec3_add(middles[k >= own], vec3_scale(ends[k], 1.0 / (k < own ? own : 4 - own)));
    vec3 const way = vec3_sub(middles[1], middles[0]);
    vec3 const bend = {copysign(reach, way.x), copysign(reach, way.y), copysign(reach, way.z)};
    for (int k = 0; k < 4; k++) ends[k] = vec3_add_scaled(ends[k], bend, k < own ? 1.0 : -1.0);
}

/* The least distance of a pair at some times on its paths, which end off by `reach`. */
static double sample_distance(const soup_scene *of, double reach, uint64_t key) {
    enum { TIMES = 33 };
    feature_kind const kind = (feature_kind)(key >> 62);
    feature_pair const pair = {(uint32_t)(key >> 31 & 0x7fffffff), (uint32_t)(key & 0x7fffffff)};
    uint32_t v[4];
    vec3 ends[4];
    feature_pair_vertices(&of->topo, kind, pair, v);
    for (int k = 0; k < 4; k++) ends[k] = vec3_load(of->x1, v[k]);
    bend_ends(kind, reach, ends);
    double least = INFINITY;
    for (int i = 0; i < TIMES; i++) {
        vec3 points[4];
        for (int k = 0; k < 4; k++)
            points[k] = vec3_lerp(vec3_load(of->x0, v[k]), ends[k], (double)i / (TIMES - 1));
        closest_points const closest = kind == FEATURE_VERTEX_TRIANGLE
                                           ? closest_vertex_triangle(points)
                                           : closest_edge_edge(points);
        least = fmin(least, vec3_norm(closest.difference));
    }
    return least;
}

/* Every pair of the list is in the stream, which may have others, or stays farther apart than
 * `distance` on paths that end off by `reach`. Returns how many are not in it. */
static size_t count_left_out(const soup_scene *of, double reach, const key_list *list,
                             const key_list *stream, double distance) {
    size_t at = 0, missing = 0;
    for (size_t i = 0; i < list->count; i++) {
        while (at < stream->count && stream->keys[at] < list->keys[i]) at++;
        if (at < stream->count && stream->keys[at] == list->keys[i]) continue;
        missing++;
        assert_true(sample_distance(of, reach, list->keys[i]) > distance * (1.0 - 1e-9));
    }
    return missing;
}

static void following_paths_leaves_out_only_what_stays_apart(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 16;
    kernel_target const widest = kernel_target_get();
    size_t missing = 0, all = 0;
    for (int round = 0; round < 40; round++) {
        soup_scene *const soup = make_scene(&heap, &seed, 120);
        double const margin = round % 2 ? 0.02 : 0.0;
        move_together(soup, 0.6 * (round % 5));
        broad_phase *const broad = make_trees(&heap, soup, BROAD_PHASE_REFIT);
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, 1), TULLE_OK);
        key_list const list = search_keys(broad, &soup->set, 1);
        broad_phase_follow_paths(broad, PATHS_ALWAYS);
        key_list first = {0};
        for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
            if (!kernel_target_force((kernel_target)target)) continue;
            int const threads = 1 + round % 3;
            assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, threads),
                             TULLE_OK);
            key_list const stream = search_keys(broad, &soup->set, threads);
            if (!first.keys) {
                first = stream;
                missing += count_left_out(soup, 0.0, &list, &stream, margin);
                all += list.count;
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
    print_message("%zu of %zu pairs left out\n", missing, all);
    assert_true(missing > all / 100 && missing < all);
    assert_int_equal(heap.bytes_held, 0);
}

/* Only where paths are long, and those nearby alike, is anything left out; then what is left out
 * keeps a smaller gap too where paths end off by half of what the margin exceeds it. */
static void long_paths_alone_are_followed(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 17;
    double const margin = 0.03, gap = 0.01;
    size_t missing = 0, straight_count = 0;
    for (int round = 0; round < 120; round++) {
        soup_scene *const soup = make_scene(&heap, &seed, 120);
        if (round % 4 == 0) memcpy(soup->x1, soup->x0, 3 * soup->vertex_count * sizeof(double));
        move_together(soup, round % 4 == 0 ? 1e-6 : 0.6 * (round % 4));
        broad_phase *const broad = make_trees(&heap, soup, BROAD_PHASE_REFIT);
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, 1), TULLE_OK);
        key_list const list = search_keys(broad, &soup->set, 1);
        assert_false(broad_phase_is_straight(broad));
        broad_phase_follow_paths(broad, PATHS_WHERE_LONG);
        /* from one length of paths to the other and back: static trees keep their boxes */
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x0, margin, 1), TULLE_OK);
        assert_false(broad_phase_is_straight(broad));
        assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, margin, 2), TULLE_OK);
        bool const is_straight = broad_phase_is_straight(broad);
        assert_false(is_straight && round % 4 == 0);
        key_list const stream = search_keys(broad, &soup->set, 2);
        size_t const left_out = count_left_out(soup, 0.5 * (margin - gap), &list, &stream, gap);
        assert_true(is_straight || left_out == 0);
        missing += left_out, straight_count += is_straight;
        free(list.keys);
        free(stream.keys);
        broad_phase_destroy(broad);
        free_scene(&heap, soup);
    }
    print_message("%zu pairs left out of %zu scenes\n", missing, straight_count);
    assert_true(straight_count > 10 && straight_count < 90); /* some move every which way */
    assert_true(missing > 1000);
    assert_int_equal(heap.bytes_held, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(following_paths_leaves_out_only_what_stays_apart),
        cmocka_unit_test(long_paths_alone_are_followed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
