/* The cheap test of pairs keeps the same ones as its formula does one pair at a time, on every
 * vector width, and what it drops is as far apart as it says; distances are those of
 * closest_of_pair; what is kept is sorted. */
#include "base/hash.h"
#include "contact/pairs/apart_pairs.h"
#include "contact/pairs/pair_filter.h"
#include "contact/pairs/pair_rules.h"
#include "contact/pairs/sort_pairs.h"
#include "contact/rows/admissible_rows.h"
#include "support/test_support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { VERTICES = 400, FEATURES = 300, PAIRS = 1009 /* odd: the last lanes are empty */ };

typedef struct random_pairs {
    vertex_record records[VERTICES];
    uint32_t triangles[3 * FEATURES], edges[2 * FEATURES];
    topology topo;
    feature_pair pairs[PAIRS];
} random_pairs;

static uint32_t pick(uint32_t count, uint64_t *random) {
    return (uint32_t)(random_next(random) % count);
}

/* Most paths are short against the size of the features; some points are not finite or far off. */
static void make_random_pairs(random_pairs *to, uint64_t *random) {
    static const double odd[4] = {(double)NAN, (double)INFINITY, 1e200, 0.0};
    for (size_t i = 0; i < VERTICES; i++)
        for (size_t k = 0; k < 3; k++) {
            double const at = 2.0 * random_uniform(random) - 1.0;
            bool const is_odd = i % 50 == 0;
            to->records[i].start[k] = is_odd && k == 0 ? odd[pick(4, random)] : at;
            to->records[i].end[k] = at + 0.3 * (random_uniform(random) - 0.5);
        }
    /* points near one another have near indices: features are small */
    for (size_t i = 1; i < VERTICES; i++)
        for (size_t k = 0; k < 3 && i % 4; k++) {
            to->records[i].start[k] =
                0.9 * to->records[i - 1].start[k] + 0.1 * to->records[i].start[k];
            to->records[i].end[k] = 0.9 * to->records[i - 1].end[k] + 0.1 * to->records[i].end[k];
        }
    for (uint32_t i = 0; i < FEATURES; i++) {
        uint32_t const first = pick(VERTICES - 3, random);
        for (uint32_t k = 0; k < 3; k++) to->triangles[3 * i + k] = first + k;
        for (uint32_t k = 0; k < 2; k++) to->edges[2 * i + k] = first + k;
    }
    for (size_t i = 0; i < PAIRS; i++)
        to->pairs[i] = (feature_pair){pick(FEATURES, random), pick(FEATURES, random)};
    to->topo = (topology){.triangles = to->triangles, .edges = to->edges};
}

static void get_points(const random_pairs *of, feature_kind kind, feature_pair pair, double t,
                       vec3 points[4]) {
    uint32_t vertices[4];
    feature_pair_vertices(&of->topo, kind, pair, vertices);
    for (int k = 0; k < 4; k++) {
        vec3 const start = vec3_load(of->records[vertices[k]].start, 0);
        vec3 const end = vec3_load(of->records[vertices[k]].end, 0);
        points[k] = t == 0.0 ? start : t == 1.0 ? end : vec3_lerp(start, end, t);
    }
}

/* The gap along a direction, from vectors between the points. */
static double find_gap(feature_kind kind, vec3 direction, const vec3 p[4]) {
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        double gap = vec3_dot(direction, vec3_sub(p[0], p[3]));
        for (int k = 2; k > 0; k--) {
            double const other = vec3_dot(direction, vec3_sub(p[0], p[k]));
            gap = other < gap ? other : gap;
        }
        return gap;
    }
    double const first = vec3_dot(direction, vec3_sub(p[1], p[0]));
    double const second = vec3_dot(direction, vec3_sub(p[3], p[2]));
    return vec3_dot(direction, vec3_sub(p[0], p[2])) + (first < 0.0 ? first : 0.0) -
           (second > 0.0 ? second : 0.0);
}

/* The formula of pair_filter.h. */
static bool is_separated(const random_pairs *of, feature_kind kind, feature_pair pair,
                         double at_start, double at_end) {
    vec3 p[4], end[4], directions[2];
    get_points(of, kind, pair, 0.0, p);
    get_points(of, kind, pair, 1.0, end);
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        vec3 const d[3] = {vec3_sub(p[0], p[1]), vec3_sub(p[0], p[2]), vec3_sub(p[0], p[3])};
        directions[0] = vec3_scale(vec3_add(vec3_add(d[0], d[1]), d[2]), 1.0 / 3.0);
        directions[1] = vec3_cross(vec3_sub(d[0], d[1]), vec3_sub(d[0], d[2]));
        if (vec3_dot(directions[1], d[0]) < 0.0) directions[1] = vec3_neg(directions[1]);
    } else {
        vec3 const across = vec3_sub(p[0], p[2]);
        vec3 const first = vec3_sub(p[1], p[0]), second = vec3_sub(p[3], p[2]);
        directions[0] = vec3_add_scaled(across, vec3_sub(first, second), 0.5);
        directions[1] = vec3_cross(first, second);
        if (vec3_dot(directions[1], across) < 0.0) directions[1] = vec3_neg(directions[1]);
    }
    for (int i = 0; i < 2; i++) {
        double const norm2 = vec3_norm2(directions[i]);
        double const gap0 = find_gap(kind, directions[i], p);
        double const gap1 = find_gap(kind, directions[i], end);
        if (gap0 > 0.0 && gap0 * gap0 > at_start * at_start * norm2 && gap1 > 0.0 &&
            gap1 * gap1 > at_end * at_end * norm2)
            return true;
    }
    return false;
}

static void check_distances(const random_pairs *of, feature_kind kind, feature_pair pair,
                            const pair_filter *filter) {
    for (int i = 0; i <= 8; i++) {
        vec3 points[4];
        get_points(of, kind, pair, i / 8.0, points);
        double const distance = sqrt(closest_of_pair(kind, points).distance2);
        assert_true(distance > filter->at_end * (1.0 - 1e-12));
        if (i == 0) assert_true(distance > filter->at_start * (1.0 - 1e-12));
    }
}

/* Returns how many pairs were dropped. */
static size_t check_filter(const random_pairs *of, feature_kind kind, const pair_filter *filter) {
    feature_pair kept[PAIRS];
    size_t const count = TULLE_PICK_KERNEL(filter_pairs)(filter, kind, of->pairs, PAIRS, kept);
    size_t found = 0;
    for (size_t i = 0; i < PAIRS; i++) {
        if (is_separated(of, kind, of->pairs[i], filter->at_start, filter->at_end)) {
            check_distances(of, kind, of->pairs[i], filter);
            continue;
        }
        assert_true(found < count);
        assert_memory_equal(&kept[found++], &of->pairs[i], sizeof(feature_pair));
    }
    assert_int_equal(found, count);
    return PAIRS - count;
}

static void keeps_what_the_formula_keeps(void **state) {
    (void)state;
    random_pairs *const pairs = calloc(1, sizeof *pairs);
    assert_non_null(pairs);
    uint64_t random = 1;
    for (int round = 0; round < 20; round++) {
        make_random_pairs(pairs, &random);
        double const at_start = round == 0 ? 0.0 : 0.4 * random_uniform(&random);
        pair_filter const filter = {&pairs->topo, pairs->records, at_start,
                                    at_start * random_uniform(&random)};
        for (int kind = 0; kind < 2; kind++) {
            for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
                if (!kernel_target_force((kernel_target)target)) continue;
                size_t const dropped = check_filter(pairs, (feature_kind)kind, &filter);
                assert_in_range(dropped, PAIRS / 20, PAIRS - PAIRS / 20);
            }
        }
    }
    free(pairs);
}

/* Points of small whole coordinates: most features are degenerate or touch. */
static void make_degenerate_pairs(random_pairs *to, uint64_t *random) {
    make_random_pairs(to, random);
    for (size_t i = 0; i < VERTICES; i++)
        for (size_t k = 0; k < 3; k++) {
            to->records[i].start[k] = pick(3, random);
            to->records[i].end[k] = pick(3, random) + (i % 3 ? 0.0 : 1e-9 * pick(3, random));
        }
}

static void check_measured(const random_pairs *of, feature_kind kind) {
    double distances[PAIRS];
    bool is_at_end[PAIRS];
    TULLE_PICK_KERNEL(measure_distances)
    (&of->topo, of->records, kind, of->pairs, PAIRS, &(pair_measures){distances, is_at_end});
    for (size_t i = 0; i < PAIRS; i++) {
        vec3 points[4];
        get_points(of, kind, of->pairs[i], 0.0, points);
        bool is_finite = true;
        for (int k = 0; k < 4; k++)
            is_finite = is_finite && isfinite(vec3_norm2(points[k])) && fabs(points[k].x) < 1e3;
        if (!is_finite) continue;
        closest_points const closest = closest_of_pair(kind, points);
        assert_true(distances[i] == sqrt(closest.distance2));
        bool const is_edge_edge = kind == FEATURE_EDGE_EDGE;
        assert_int_equal(is_at_end[i], is_edge_edge && is_on_rim(closest.weights));
    }
}

static void measures_distances_to_the_bit(void **state) {
    (void)state;
    random_pairs *const pairs = calloc(1, sizeof *pairs);
    assert_non_null(pairs);
    uint64_t random = 5;
    for (int round = 0; round < 40; round++) {
        if (round % 2)
            make_random_pairs(pairs, &random);
        else
            make_degenerate_pairs(pairs, &random);
        for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
            if (!kernel_target_force((kernel_target)target)) continue;
            for (int kind = 0; kind < 2; kind++) check_measured(pairs, (feature_kind)kind);
        }
    }
    free(pairs);
}

/* Returns how many pairs are marked; prove_apart finds a direction for each of them. */
static size_t check_apart(const random_pairs *of, feature_kind kind, double separation) {
    static uint32_t numbers[VERTICES];
    for (uint32_t i = 0; i < VERTICES; i++) numbers[i] = i;
    pair_tables const tables = {.vertex_corners = numbers,
                                .edge_corners = of->edges,
                                .triangle_corners = of->triangles,
                                .records = of->records};
    apart_query query = {.kind = kind, .count = SCAN_MOST - 3};
    bool is_apart[SCAN_MOST];
    size_t marked_count = 0;
    memcpy(query.pairs, of->pairs, sizeof query.pairs);
    for (size_t i = 0; i < SCAN_MOST; i++) query.separations[i] = separation * (double)(i % 3);
    mark_apart(&tables, &query, is_apart);
    for (size_t i = 0; i < query.count; i++) {
        moving_pair paths;
        get_points(of, kind, query.pairs[i], 0.0, paths.start);
        get_points(of, kind, query.pairs[i], 1.0, paths.end);
        if (is_apart[i])
            assert_true(prove_apart(kind, &paths, query.separations[i]) == APART_BY_DIRECTION);
        marked_count += is_apart[i];
    }
    return marked_count;
}

static void marks_what_stays_apart(void **state) {
    (void)state;
    random_pairs *const pairs = calloc(1, sizeof *pairs);
    assert_non_null(pairs);
    uint64_t random = 9;
    size_t marked_count = 0;
    for (int round = 0; round < 60; round++) {
        if (round % 2)
            make_random_pairs(pairs, &random);
        else
            make_degenerate_pairs(pairs, &random);
        size_t const before = marked_count;
        for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
            if (!kernel_target_force((kernel_target)target)) continue;
            marked_count = before;
            for (int kind = 0; kind < 2; kind++)
                marked_count +=
                    check_apart(pairs, (feature_kind)kind, 0.2 * random_uniform(&random));
        }
    }
    assert_in_range(marked_count, 1500, 60 * 2 * SCAN_MOST - 1500);
    free(pairs);
}

static int compare_pairs(const void *a, const void *b) {
    const feature_pair *const x = a, *const y = b;
    if (x->first != y->first) return x->first < y->first ? -1 : 1;
    return (x->second > y->second) - (x->second < y->second);
}

/* Few and many firsts for the pairs, so that buckets are empty, small and large. */
static void sorts_pairs(void **state) {
    (void)state;
    enum { MOST = 30000 };
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    feature_pair *const pairs = malloc(MOST * sizeof *pairs), *const sorted =
                                                                  malloc(MOST * sizeof *sorted);
    assert_true(pairs && sorted);
    uint64_t random = 3;
    for (int round = 0; round < 60; round++) {
        uint32_t const first_count = 1 + pick(1u << pick(20, &random), &random);
        size_t const count = pick(1u << pick(15, &random), &random) % MOST;
        for (size_t i = 0; i < count; i++) /* seconds are all different */
            pairs[i] = (feature_pair){pick(first_count, &random), (uint32_t)(i * 2654435761u)};
        memcpy(sorted, pairs, count * sizeof *pairs);
        qsort(sorted, count, sizeof *sorted, compare_pairs);
        assert_int_equal(sort_pairs(&scratch, 1 + round % 3, pairs, count, first_count), TULLE_OK);
        assert_memory_equal(pairs, sorted, count * sizeof *pairs);
    }
    free(pairs);
    free(sorted);
    arena_destroy(&scratch);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keeps_what_the_formula_keeps),
        cmocka_unit_test(measures_distances_to_the_bit),
        cmocka_unit_test(marks_what_stays_apart),
        cmocka_unit_test(sorts_pairs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
