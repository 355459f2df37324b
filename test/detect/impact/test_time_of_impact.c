/* Time of impact and its filters against exact rational arithmetic on random pairs, most of them
 * degenerate: nothing that touches is called separated, every lower bound is safe. With
 * TULLE_TEST_LONG=1 a million pairs. */
#include "base/hash.h"
#include "detect/impact/time_of_impact.h"
#include "support/exact_ccd.h"
#include "support/query_families.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

static int scale_count(int quick, int full) { return getenv("TULLE_TEST_LONG") ? full : quick; }

static moving_pair make_pair(const double points[24]) {
    moving_pair pair;
    for (size_t i = 0; i < 4; i++) {
        pair.start[i] = vec3_load(points, i);
        pair.end[i] = vec3_load(points, 4 + i);
    }
    return pair;
}

/* The oracle itself, on cases that are plain to see. */
static void oracle_decides_plain_cases(void **state) {
    (void)state;
    /* A vertex falls onto an edge of a triangle, at t = 1 exactly, and just not. */
    moving_pair falls = make_pair((const double[]){0.5, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0,
                                                   0.5, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0});
    assert_true(exact_pair_touches(FEATURE_VERTEX_TRIANGLE, &falls, 1.0));
    assert_false(exact_pair_touches(FEATURE_VERTEX_TRIANGLE, &falls, nextafter(1.0, 0.0)));
    falls.end[0].y = -0x1p-60;
    assert_false(exact_pair_touches(FEATURE_VERTEX_TRIANGLE, &falls, 1.0));
    /* Two edges on one line run into each other; apart in the same line. */
    moving_pair lines = make_pair(
        (const double[]){0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 2, 0, 0});
    assert_true(exact_pair_touches(FEATURE_EDGE_EDGE, &lines, 1.0));
    lines.end[2].x = nextafter(1.0, 2.0);
    assert_false(exact_pair_touches(FEATURE_EDGE_EDGE, &lines, 1.0));
    /* Crossing at t = 1/3: the time is no binary fraction. */
    moving_pair cross = make_pair((const double[]){-1, 0, 1,  1, 0, 1,  0, -1, 0, 0, 1, 0,
                                                   -1, 0, -2, 1, 0, -2, 0, -1, 0, 0, 1, 0});
    assert_true(exact_pair_touches(FEATURE_EDGE_EDGE, &cross, 1.0));
    assert_false(exact_pair_touches(FEATURE_EDGE_EDGE, &cross, 0.333));
    assert_true(exact_pair_touches(FEATURE_EDGE_EDGE, &cross, 0.334));
    assert_true(exact_pair_is_farther(FEATURE_EDGE_EDGE, &cross, 0.25, 0.2499));
    assert_false(exact_pair_is_farther(FEATURE_EDGE_EDGE, &cross, 0.25, 0.25));
    /* A triangle without area, swept over by a vertex. */
    moving_pair flat = make_pair((const double[]){0.25, 1,  0, 0, 0, 0, 1, 0, 0, 0.5, 0, 0,
                                                  0.25, -1, 0, 0, 0, 0, 1, 0, 0, 0.5, 0, 0});
    assert_true(exact_pair_touches(FEATURE_VERTEX_TRIANGLE, &flat, 1.0));
    assert_false(exact_pair_touches(FEATURE_VERTEX_TRIANGLE, &flat, 0.4999));
}

typedef struct query_counts {
    int total, touching, false_alarms, filtered, filter_passed, unresolved;
} query_counts;

/* One pair with separation 0 against the oracle. */
static void check_touching(feature_kind kind, const moving_pair *pair, query_counts *counts) {
    bool const touches = exact_pair_touches(kind, pair, 1.0);
    toi_result const result = time_of_impact(kind, pair, 0.0);
    bool const is_filtered =
        pair_cannot_cross(kind, pair) || prove_apart(kind, pair, 0.0) == APART_BY_DIRECTION;
    if (touches) {
        assert_int_not_equal(result.state, TOI_SEPARATED);
        assert_false(is_filtered);
    }
    assert_true(result.lower_bound >= 0.0 && result.lower_bound <= 1.0);
    if (result.state == TOI_SEPARATED) assert_true(result.lower_bound == 1.0);
    if (result.state == TOI_TOUCHING_AT_START) assert_true(result.lower_bound == 0.0);
    if (result.lower_bound > 0.0 && touches)
        assert_false(exact_pair_touches(kind, pair, result.lower_bound));
    counts->total++;
    counts->touching += touches;
    counts->filtered += is_filtered;
    counts->unresolved += result.state == TOI_UNRESOLVED;
    counts->filter_passed += !is_filtered && !touches;
    counts->false_alarms += !touches && !is_filtered && result.state != TOI_SEPARATED;
}

static void nothing_that_touches_is_separated(void **state) {
    (void)state;
    uint64_t seed = 11;
    int const count = scale_count(40000, 1000000) / (2 * QUERY_FAMILY_COUNT);
    query_counts sum = {0};
    for (int family = 0; family < QUERY_FAMILY_COUNT; family++) {
        query_counts counts = {0};
        for (int i = 0; i < 2 * count; i++) {
            feature_kind const kind = (feature_kind)(i % 2);
            moving_pair const pair = make_query((query_family)family, kind, &seed);
            check_touching(kind, &pair, &counts);
        }
        print_message("%-10s %6d pairs, %6d touch, %6d filtered, %5d false alarms of %5d passed, "
                      "%d unresolved\n",
                      query_family_names[family], counts.total, counts.touching, counts.filtered,
                      counts.false_alarms, counts.filter_passed, counts.unresolved);
        sum.total += counts.total;
        sum.touching += counts.touching;
        sum.false_alarms += counts.false_alarms;
    }
    print_message("all: %d pairs, %d touch, 0 missed, %d false alarms\n", sum.total, sum.touching,
                  sum.false_alarms);
    assert_true(sum.touching > sum.total / 20);
}

/* With a separation: at the lower bound and at times before, the exact distance is more. */
static void lower_bounds_are_safe(void **state) {
    (void)state;
    uint64_t seed = 12;
    int const count = scale_count(300, 6000);
    int separated = 0, hits = 0;
    for (int i = 0; i < count; i++) {
        feature_kind const kind = (feature_kind)(i % 2);
        query_family const family = (query_family)(i / 2 % QUERY_FAMILY_COUNT);
        moving_pair const pair = make_query(family, kind, &seed);
        double size = 0.0;
        for (int k = 1; k < 4; k++)
            size = fmax(size, vec3_norm(vec3_sub(pair.start[k], pair.start[0])));
        double const separation =
            i % 10 == 0 ? 0.0 : size * pow(10.0, -1.0 - 9.0 * random_uniform(&seed));
        toi_result const result = time_of_impact(kind, &pair, separation);
        bool const stays = prove_apart(kind, &pair, separation) == APART_BY_DIRECTION;
        separated += result.state == TOI_SEPARATED;
        hits += result.state == TOI_HIT;
        /* another direction may prove apart what the closest one cannot within rounding */
        if (result.state == TOI_TOUCHING_AT_START && !stays) continue;
        assert_true(exact_pair_is_farther(kind, &pair, result.lower_bound, separation));
        for (int k = 0; k < 200; k++) {
            double const t =
                stays ? random_uniform(&seed) : result.lower_bound * random_uniform(&seed);
            assert_true(exact_pair_is_farther(kind, &pair, t, separation));
        }
    }
    print_message("%d pairs with a separation: %d separated, %d hits\n", count, separated, hits);
    assert_true(separated > count / 10 && hits > count / 10);
}

/* Separations within a few roundings of the true distance, for thin gaps between large features:
 * what is called apart is apart. */
static void bounds_hold_to_the_last_bit(void **state) {
    (void)state;
    uint64_t seed = 15;
    int apart = 0;
    int const count = scale_count(20000, 200000);
    for (int i = 0; i < count; i++) {
        feature_kind const kind = (feature_kind)(i % 2);
        moving_pair pair = make_query(QUERY_UNIFORM, kind, &seed);
        /* Brings the features together until a millionth of the distance is left. */
        closest_points const closest = closest_of_pair(kind, pair.start);
        for (int k = 0; k < (kind == FEATURE_EDGE_EDGE ? 2 : 1); k++)
            pair.start[k] = vec3_add_scaled(pair.start[k], closest.difference, 1e-6 - 1.0);
        for (int k = 0; k < 4; k++) pair.end[k] = pair.start[k];
        double const distance = sqrt(closest_of_pair(kind, pair.start).distance2);
        double const separation =
            fmax(0.0, distance + 4e-15 * (random_uniform(&seed) - 0.75) * random_uniform(&seed));
        if (prove_apart(kind, &pair, separation) != APART_BY_DIRECTION) continue;
        apart++;
        assert_true(exact_pair_is_farther(kind, &pair, 0.0, separation));
    }
    assert_true(apart > count / 20);
}

/* What a cloth asks: centimetre edges, a separation of a tenth of a millimetre. A vertex or edge
 * that moves straight at the other is stopped in time, near the separation, and the bound is
 * sharp. */
static void stops_sharply_at_cloth_scale(void **state) {
    (void)state;
    uint64_t seed = 13;
    double const separation = 1e-4;
    int hits = 0;
    for (int i = 0; i < 20000; i++) {
        feature_kind const kind = (feature_kind)(i % 2);
        moving_pair pair = make_query(QUERY_TOUCHING, kind, &seed);
        for (int k = 0; k < 4; k++) {
            pair.start[k] = vec3_scale(pair.start[k], 0.01);
            pair.end[k] = vec3_scale(pair.end[k], 0.01);
        }
        toi_result const result = time_of_impact(kind, &pair, separation);
        assert_int_not_equal(result.state, TOI_SEPARATED);
        assert_int_not_equal(result.state, TOI_UNRESOLVED);
        if (result.state != TOI_HIT) continue;
        hits++;
        double const distance = sqrt(result.closest.distance2);
        double const start = sqrt(closest_of_pair(kind, pair.start).distance2);
        assert_true(distance > separation);
        assert_true(distance <= separation + fmax(0.0502 * separation, 1e-3 * start));
    }
    assert_true(hits > 15000);
}

static void parts_that_move_together_stay_apart(void **state) {
    (void)state;
    /* A common motion of any size, and one away from the other, with the gap just over the
     * separation. */
    moving_pair pair = make_pair((const double[]){0.3, 0.3, 1.001e-4, 0, 0, 0, 1, 0, 0, 0, 1, 0,
                                                  0.3, 0.3, 1.001e-4, 0, 0, 0, 1, 0, 0, 0, 1, 0});
    for (int k = 0; k < 4; k++) pair.end[k] = vec3_add(pair.end[k], vec3_make(1024.0, 8.0, -64.0));
    assert_int_equal(time_of_impact(FEATURE_VERTEX_TRIANGLE, &pair, 1e-4).state, TOI_SEPARATED);
    assert_true(prove_apart(FEATURE_VERTEX_TRIANGLE, &pair, 1e-4) == APART_BY_DIRECTION);
    assert_int_equal(time_of_impact(FEATURE_VERTEX_TRIANGLE, &pair, 1.002e-4).state,
                     TOI_TOUCHING_AT_START);
    pair.end[0].z += 1.0;
    assert_int_equal(time_of_impact(FEATURE_VERTEX_TRIANGLE, &pair, 1e-4).state, TOI_SEPARATED);
}

static void values_that_are_not_finite_are_never_separated(void **state) {
    (void)state;
    const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, 1.7e308};
    uint64_t seed = 14;
    for (int i = 0; i < 400; i++) {
        feature_kind const kind = (feature_kind)(i % 2);
        moving_pair pair = make_query(QUERY_UNIFORM, kind, &seed);
        vec3 *const point = i / 2 % 2 ? &pair.start[i / 4 % 4] : &pair.end[i / 4 % 4];
        point->y = bad[i / 16 % 3];
        assert_int_equal(time_of_impact(kind, &pair, 1e-4).state, TOI_TOUCHING_AT_START);
        assert_true(prove_apart(kind, &pair, 1e-4) != APART_BY_DIRECTION);
        assert_false(pair_cannot_cross(kind, &pair));
    }
    moving_pair pair = make_query(QUERY_UNIFORM, FEATURE_EDGE_EDGE, &seed);
    pair.start[0].x = bad[3];
    pair.start[2].x = -bad[3]; /* their difference overflows */
    assert_int_not_equal(time_of_impact(FEATURE_EDGE_EDGE, &pair, 0.0).state, TOI_SEPARATED);
    assert_int_not_equal(time_of_impact(FEATURE_EDGE_EDGE, &pair, bad[1]).state, TOI_SEPARATED);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(oracle_decides_plain_cases),
        cmocka_unit_test(nothing_that_touches_is_separated),
        cmocka_unit_test(lower_bounds_are_safe),
        cmocka_unit_test(bounds_hold_to_the_last_bit),
        cmocka_unit_test(stops_sharply_at_cloth_scale),
        cmocka_unit_test(parts_that_move_together_stay_apart),
        cmocka_unit_test(values_that_are_not_finite_are_never_separated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
