/* A plane that turns with a pair: what it proves apart is so by rational arithmetic and by dense
 * sampling, and it proves pairs that rotate, where no fixed direction does. */
#include "base/hash.h"
#include "detect/impact/time_of_impact.h"
#include "support/exact_ccd.h"
#include "support/query_families.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

enum { SAMPLES = 64 };

/* Smallest sampled distance of the pair: at least its smallest distance. */
static double sample_distance(feature_kind kind, const moving_pair *pair) {
    double smallest2 = INFINITY;
    for (int i = 0; i <= SAMPLES; i++) {
        vec3 points[4];
        for (int k = 0; k < 4; k++)
            points[k] = vec3_lerp(pair->start[k], pair->end[k], (double)i / SAMPLES);
        smallest2 = fmin(smallest2, closest_of_pair(kind, points).distance2);
    }
    return sqrt(smallest2);
}

/* v turned about the unit axis. */
static vec3 turn(vec3 v, vec3 axis, double angle) {
    vec3 const along = vec3_scale(axis, vec3_dot(axis, v));
    vec3 const across = vec3_sub(v, along);
    vec3 const turned =
        vec3_add_scaled(vec3_scale(across, cos(angle)), vec3_cross(axis, across), sin(angle));
    return vec3_add(along, turned);
}

static double random_between(uint64_t *seed, double low, double high) {
    return low + (high - low) * random_uniform(seed);
}

/* A vertex over a triangle, or two edges that cross, at a distance of `gap`; both tumble together
 * by `angle` about a random axis while the edges turn about each other by `twist`. */
static moving_pair make_tumbling_pair(feature_kind kind, double gap, double angle, double twist,
                                      uint64_t *seed) {
    moving_pair pair;
    vec3 const up = {0.0, 0.0, 1.0};
    vec3 axis = {0.0, 0.0, 0.0};
    while (vec3_norm2(axis) < 0.01)
        axis = vec3_make(random_between(seed, -1, 1), random_between(seed, -1, 1),
                         random_between(seed, -1, 1));
    axis = vec3_normalize(axis);
    double const crossing = random_between(seed, 0.2, 2.9);
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        pair.start[0] = vec3_make(random_between(seed, -0.1, 0.1), 0.05, gap);
        for (int k = 0; k < 3; k++)
            pair.start[1 + k] = turn(vec3_make(0.5, 0.0, 0.0), up, 2.0943951 * k + crossing);
    } else {
        pair.start[0] = vec3_make(-0.5, 0.0, gap);
        pair.start[1] = vec3_make(0.6, 0.0, gap);
        pair.start[2] = turn(vec3_make(-0.4, 0.0, 0.0), up, crossing);
        pair.start[3] = turn(vec3_make(0.5, 0.0, 0.0), up, crossing);
    }
    for (int k = 0; k < 4; k++) {
        bool const is_first = k < (kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2);
        pair.end[k] = turn(is_first ? turn(pair.start[k], up, twist) : pair.start[k], axis, angle);
    }
    return pair;
}

static void proofs_hold_for_the_smallest_sampled_distance(void **state) {
    (void)state;
    uint64_t seed = 21;
    for (int i = 0; i < 20000; i++) {
        feature_kind const kind = (feature_kind)(i % 2);
        double const gap = random_between(&seed, 0.01, 0.2);
        moving_pair const pair =
            i % 3 == 0 ? make_query(QUERY_UNIFORM, kind, &seed)
                       : make_tumbling_pair(kind, gap, random_between(&seed, 0.0, 1.5),
                                            random_between(&seed, -1.0, 1.0), &seed);
        double const nearest = sample_distance(kind, &pair);
        assert_int_equal(prove_apart(kind, &pair, nearest * (1.0 + 1e-12)), APART_UNPROVEN);
    }
}

static void proofs_hold_by_rational_arithmetic(void **state) {
    (void)state;
    uint64_t seed = 22;
    size_t proven = 0;
    for (int i = 0; i < 6000; i++) {
        feature_kind const kind = (feature_kind)(i % 2);
        moving_pair const pair = make_tumbling_pair(kind, random_between(&seed, 0.01, 0.1),
                                                    random_between(&seed, 0.1, 1.2),
                                                    random_between(&seed, -0.6, 0.6), &seed);
        double const nearest = sample_distance(kind, &pair);
        double const separation = nearest * random_between(&seed, 0.5, 1.0);
        if (prove_apart(kind, &pair, separation) != APART_BY_TURNING) continue;
        proven++;
        assert_false(exact_pair_touches(kind, &pair, 1.0));
        for (int k = 0; k < 4; k++)
            assert_true(exact_pair_is_farther(kind, &pair, random_uniform(&seed), separation));
    }
    print_message("%zu of 6000 proven by a turning plane\n", proven);
    assert_true(proven > 1000);
}

/* To the last bit: two edges whose gap along z is the same number at all times. */
static void the_separation_itself_is_not_proven(void **state) {
    (void)state;
    double const gap = 0.0625; /* exact */
    moving_pair pair = {
        .start = {{-1, 0, gap}, {1, 0, gap}, {0, -1, 0}, {0, 1, 0}},
        .end = {{-1, 0.5, gap}, {1, -0.5, gap}, {-0.5, -1, 0}, {0.5, 1, 0}},
    };
    assert_int_equal(prove_apart(FEATURE_EDGE_EDGE, &pair, gap), APART_UNPROVEN);
    assert_int_equal(prove_apart(FEATURE_EDGE_EDGE, &pair, nextafter(gap, 1.0)), APART_UNPROVEN);
    assert_int_not_equal(prove_apart(FEATURE_EDGE_EDGE, &pair, gap * (1.0 - 1e-13)),
                         APART_UNPROVEN);
}

/* Contacts that tumble by up to 0.3 rad in a step, twist, and keep half of their gap: fixed
 * directions fail for most, turning ones hardly. */
static void rotating_contacts_are_proven(void **state) {
    (void)state;
    uint64_t seed = 23;
    size_t apart = 0, fixed = 0, turning = 0;
    int const count = 4000;
    for (int i = 0; i < count; i++) {
        feature_kind const kind = (feature_kind)(i % 2);
        moving_pair const pair = make_tumbling_pair(kind, 0.02, random_between(&seed, 0.1, 0.3),
                                                    random_between(&seed, -0.3, 0.3), &seed);
        if (sample_distance(kind, &pair) < 0.01) continue;
        apart++;
        apart_proof const proof = prove_apart(kind, &pair, 0.005);
        fixed += proof == APART_BY_DIRECTION;
        turning += proof == APART_BY_TURNING;
    }
    print_message(
        "of %zu rotating contacts %zu proven by a fixed direction, %zu by a turning one\n", apart,
        fixed, turning);
    assert_true(10 * (fixed + turning) > 9 * apart && turning > 10 * fixed);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(proofs_hold_for_the_smallest_sampled_distance),
        cmocka_unit_test(proofs_hold_by_rational_arithmetic),
        cmocka_unit_test(the_separation_itself_is_not_proven),
        cmocka_unit_test(rotating_contacts_are_proven),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
