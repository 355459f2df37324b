/* Certified patches and straight paths in one search: against all pairs of features, whatever is
 * left out is either of one patch, and keeps what its certificate promises, or is kept apart by its
 * paths, also where these end elsewhere. */
#include "detect/patches/kept_patches.h"
#include "support/pair_keys.h"
#include "support/wide_normals.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

/* [m] of boxes; kept along all paths that may be tested; half of what patches keep. */
static const double MARGIN = 0.03, GAP = 0.01, REACH = 0.004;

enum { SHEET = 200, ROUNDS = 12, CALLS = 4 }; /* triangles of a sheet; scenes; searches of one */

typedef struct joint_sums {
    size_t joint_count;                 /* searches with patches and straight paths at once */
    size_t patch_missing, path_missing; /* pairs left out of these, each for its own reason */
    size_t near_count;                  /* pairs of these that come within the gap */
} joint_sums;

/* Sheets with a crease, one layer over the other, and waves; two of them, and a third that stands
 * still. */
static soup_scene *make_sheets(memory *heap, uint64_t *seed) {
    soup_scene *const soup = calloc(1, sizeof *soup);
    assert_non_null(soup);
    for (int s = 0; s < 3; s++) soup_scene_add(soup, SOUP_SHEET, SHEET, 0.0, seed);
    soup_scene_finish(heap, soup);
    for (size_t s = 0; s < 3; s++) {
        surface_range *const range = &soup->surfaces[s];
        double const phase = random_between(seed, 0.0, 6.0),
                     height = random_between(seed, 0.0, 0.3);
        double const steepness = random_between(seed, 0.05, 0.3);
        range->is_static = s == 2;
        for (size_t v = range->vertex_begin; v < range->vertex_end; v++) {
            double *const x = soup->x0 + 3 * v, along = 2.0 * x[0] - 1.0;
            x[0] = fabs(along) + 0.03 * cos(12.0 * x[1]);
            x[2] = height + steepness * along + 0.02 * sin(9.0 * x[1] + phase);
        }
    }
    return soup;
}

/* Sheets fly off together, some way towards one another; their layers close. */
static void move_sheets(soup_scene *soup, double size, uint64_t *seed) {
    vec3 const way = random_vector(seed, size);
    for (size_t s = 0; s < 3; s++) {
        const surface_range *const range = &soup->surfaces[s];
        vec3 const own = random_vector(seed, 0.3 * size);
        double const middle = soup->x0[3 * (size_t)range->vertex_begin + 2];
        double const closing = random_between(seed, 0.0, 0.2);
        for (size_t v = range->vertex_begin; v < range->vertex_end; v++) {
            vec3 const x = vec3_load(soup->x0, v);
            vec3 const moved = vec3_make(x.x, x.y, x.z - closing * (x.z - middle));
            vec3 const end =
                vec3_add(vec3_add(moved, way), vec3_add(own, random_vector(seed, 1e-3)));
            vec3_store(soup->x1, v, range->is_static ? x : end);
        }
    }
}

/* Whether the boxes of a pair's paths come within the margin: all others are apart. */
static bool boxes_meet(const soup_scene *of, feature_kind kind, const uint32_t v[4]) {
    int const own = kind == FEATURE_EDGE_EDGE ? 2 : 1; /* points of the first feature */
    for (size_t axis = 0; axis < 3; axis++) {
        double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
        for (int k = 0; k < 4; k++) {
            double const a = of->x0[3 * (size_t)v[k] + axis], b = of->x1[3 * (size_t)v[k] + axis];
            low[k >= own] = fmin(low[k >= own], fmin(a, b));
            high[k >= own] = fmax(high[k >= own], fmax(a, b));
        }
        if (low[0] > high[1] + MARGIN || low[1] > high[0] + MARGIN) return false;
    }
    return true;
}

static int compare_keys(const void *a, const void *b) {
    uint64_t const x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* What one search is judged by. labels: null without patches. */
typedef struct joint_search {
    const soup_scene *of;
    const uint32_t *labels;
    bool is_straight;
    key_list found;
} joint_search;

/* A pair that is not found is apart for a reason. */
static void judge_pair(const joint_search *search, feature_kind kind, feature_pair pair,
                       joint_sums *sums) {
    const soup_scene *const of = search->of;
    bool const is_joint = search->is_straight && search->labels;
    uint32_t v[4];
    feature_pair_vertices(&of->topo, kind, pair, v);
    for (int k = 1; k < 4; k++)
        if (v[0] == v[k] || (kind == FEATURE_EDGE_EDGE && k > 1 && v[1] == v[k])) return;
    if (!boxes_meet(of, kind, v)) return;
    uint64_t const key = make_key(kind, pair);
    const key_list *const found = &search->found;
    if (bsearch(&key, found->keys, found->count, sizeof key, compare_keys)) {
        sums->near_count += is_joint && sample_pair_distance(of, key, 0.0) < GAP;
        return;
    }
    if (search->labels && pair_is_within_patch(of, search->labels, key)) {
        assert_true(sample_pair_distance(of, key, 0.0) > 2.0 * REACH);
        sums->patch_missing += is_joint;
        return;
    }
    assert_true(search->is_straight);
    assert_true(sample_pair_distance(of, key, 0.5 * (MARGIN - GAP)) > GAP * (1.0 - 1e-9));
    sums->path_missing += is_joint;
}

static void judge_search(const joint_search *search, joint_sums *sums) {
    const topology *const topo = &search->of->topo;
    for (uint32_t v = 0; v < topo->vertex_count; v++)
        for (uint32_t t = 0; t < topo->triangle_count; t++)
            judge_pair(search, FEATURE_VERTEX_TRIANGLE, (feature_pair){v, t}, sums);
    for (uint32_t a = 0; a < topo->edge_count; a++)
        for (uint32_t b = a + 1; b < topo->edge_count; b++)
            judge_pair(search, FEATURE_EDGE_EDGE, (feature_pair){a, b}, sums);
}

/* One update of patches, building of trees and search, with another number of threads and other
 * patches each. */
static void search_jointly(soup_scene *soup, kept_patches *patches, broad_phase *broad, int call,
                           joint_sums *sums) {
    bool const is_kept = call % 3 == 0; /* else grown anew, and small */
    patch_rules const rules = {.cone = CONE_BERNSTEIN,
                               .max_angle = (is_kept ? 60.0 : 5.0) * DEGREE,
                               .has_certificate = true,
                               .grows_anew = !is_kept,
                               .reach = REACH,
                               .keeps_all = true};
    patch_counts counts;
    int const threads = 1 + call % 3;
    patch_step const step = {&soup->set, soup->x0, soup->x1, threads};
    assert_int_equal(update_patches(patches, &step, &rules, &counts), TULLE_OK);
    assert_int_equal(counts.star_count + counts.contour_count, counts.patch_count);
    bool const has_patches = call != CALLS - 2; /* without them in between */
    broad_phase_set_patches(broad,
                            has_patches ? kept_patches_get_labels(patches) : (patch_labels){0});
    assert_int_equal(build_trees(broad, &soup->set, soup->x0, soup->x1, MARGIN, threads), TULLE_OK);
    joint_search search = {.of = soup,
                           .labels = has_patches ? kept_patches_get_labels(patches).labels : NULL,
                           .is_straight = broad_phase_is_straight(broad)};
    search.found = search_keys(broad, &soup->set, threads);
    sums->joint_count += search.is_straight && has_patches && counts.patch_count > 0;
    judge_search(&search, sums);
    free(search.found.keys);
}

static void nothing_near_is_left_out(void **state) {
    (void)state;
    memory heap = memory_default();
    uint64_t seed = 19;
    joint_sums sums = {0};
    for (int round = 0; round < ROUNDS; round++) {
        soup_scene *const soup = make_sheets(&heap, &seed);
        kept_patches *patches;
        broad_phase *broad;
        assert_int_equal(kept_patches_create(&heap, &soup->set, NULL, &patches), TULLE_OK);
        assert_int_equal(broad_phase_create(&heap, &soup->set, soup->x0, BROAD_PHASE_REFIT, &broad),
                         TULLE_OK);
        broad_phase_configure(broad, (broad_phase_options){.following = PATHS_WHERE_LONG});
        for (int call = 0; call < CALLS; call++) {
            move_sheets(soup, call == 1 ? 0.003 : 0.2, &seed);
            search_jointly(soup, patches, broad, call, &sums);
        }
        broad_phase_destroy(broad);
        kept_patches_destroy(patches);
        free_scene(&heap, soup);
    }
    print_message("%zu searches with both: %zu pairs left out by patches, %zu by paths, %zu near\n",
                  sums.joint_count, sums.patch_missing, sums.path_missing, sums.near_count);
    assert_true(sums.joint_count > ROUNDS);
    assert_true(sums.patch_missing > 1000 && sums.path_missing > 1000 && sums.near_count > 1000);
    assert_int_equal(heap.bytes_held, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_near_is_left_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
