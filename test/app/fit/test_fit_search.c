/* The search of `tulle fit` on curves that are known: what it finds, how sure it says it is, what
 * it refuses. */
#include "app/fit/search.h"

#include "base/error.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>

#include <cmocka.h>

/* mean = offset + slope ln(unknown), bent, with some noise. */
typedef struct curve {
    double offset, slope, bend;
    double noise;
    size_t points;
    double least, most; /* of the values that were asked for */
    size_t fails_after;
} curve;

static double compute_mean(const curve *known, double unknown) {
    double const x = log(unknown);
    return known->offset + known->slope * x + known->bend * x * x * x;
}

static tulle_status measure_curve(void *context, search_point *points, size_t count,
                                  tulle_error *error) {
    curve *const known = context;
    for (size_t i = 0; i < count; i++) {
        if (known->fails_after && known->points >= known->fails_after)
            return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
        double const wave = sin(37.0 * (double)++known->points); /* as good as noise */
        points[i].mean = compute_mean(known, points[i].unknown) + known->noise * wave;
        points[i].deviation = known->noise;
        points[i].least = points[i].most = points[i].mean;
        known->least = fmin(known->least, points[i].unknown);
        known->most = fmax(known->most, points[i].unknown);
    }
    return TULLE_OK;
}

static search_result find(curve *known, const search_goal *goal) {
    search_result result;
    tulle_error error = {0};
    known->least = INFINITY, known->most = 0.0;
    assert_int_equal(search_find(goal, measure_curve, known, &result, &error), TULLE_OK);
    assert_int_equal(result.point_count, known->points);
    assert_true(known->least >= goal->least * (1.0 - 1e-12));
    assert_true(known->most <= goal->most * (1.0 + 1e-12));
    for (size_t i = 1; i < result.point_count; i++)
        assert_true(result.points[i].unknown > result.points[i - 1].unknown);
    return result;
}

static const search_goal wide = {.measure = 50.0,
                                 .error = 2.0,
                                 .least = 1.0,
                                 .most = 1e4,
                                 .first = {8.0, 12.0, 18.0},
                                 .first_count = 3,
                                 .samples = 4};

/* 20 + 10 ln x = 50 at e^3, and within the error from e^2.8 to e^3.2. */
static void a_straight_curve_is_found_exactly(void **state) {
    (void)state;
    curve known = {.offset = 20.0, .slope = 10.0};
    search_result const found = find(&known, &wide);
    assert_int_equal(found.verdict, SEARCH_FOUND);
    assert_true(fabs(log(found.unknown) - 3.0) < 1e-9);
    assert_true(fabs(found.slope - 10.0) < 1e-9);
    assert_true(fabs(found.error - hypot(2.0, 0.25)) < 1e-12); /* noise is never below 0.5 */
    assert_true(fabs(log(found.low) - 3.0 + found.error / 10.0) < 1e-9);
    assert_true(fabs(log(found.high) - 3.0 - found.error / 10.0) < 1e-9);
    assert_false(found.is_low_open || found.is_high_open);
}

static void a_goal_far_from_the_first_values_is_reached(void **state) {
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2) {
        curve known = {.offset = 50.0 - 10.0 * (log(12.0) + sign * 2.0), .slope = 10.0};
        search_result const found = find(&known, &wide);
        assert_int_equal(found.verdict, SEARCH_FOUND);
        assert_true(fabs(log(found.unknown / 12.0) - sign * 2.0) < 1e-9);
    }
}

/* Two divisions of a gap leave little of the bend of the curve. */
static void a_bent_curve_is_found(void **state) {
    (void)state;
    curve known = {.offset = 20.0, .slope = 6.0, .bend = 0.4};
    search_result const found = find(&known, &wide);
    assert_int_equal(found.verdict, SEARCH_FOUND);
    assert_true(fabs(compute_mean(&known, found.unknown) - 50.0) < 0.1);
    double const slope = (compute_mean(&known, found.unknown * exp(0.3)) -
                          compute_mean(&known, found.unknown * exp(-0.3))) /
                         0.6;
    assert_true(fabs(found.slope / slope - 1.0) < 0.2);
}

static void noise_counts_and_the_interval_holds_the_truth(void **state) {
    (void)state;
    curve noisy = {.offset = 20.0, .slope = 10.0, .noise = 3.0};
    search_result const unsure = find(&noisy, &wide);
    assert_true(fabs(unsure.error - hypot(2.0, 1.5)) < 1e-12);
    assert_true(unsure.low < exp(3.0) && unsure.high > exp(3.0));
}

static void a_flat_curve_is_vague(void **state) {
    (void)state;
    search_goal goal = wide;
    goal.first[0] = goal.least, goal.first[1] = 100.0, goal.first[2] = goal.most;
    curve known = {.offset = 49.0, .slope = 0.1};
    search_result const found = find(&known, &goal);
    assert_int_equal(found.verdict, SEARCH_VAGUE);
    assert_true(found.is_low_open && found.is_high_open);
    assert_true(fabs(found.low - goal.least) < 1e-9 && fabs(found.high - goal.most) < 1e-6);
    assert_true(found.point_count == 3); /* noise is all that more points would show */
}

/* The goal is reached only within the error, at the end of the range. */
static void an_end_of_the_range_is_vague(void **state) {
    (void)state;
    search_goal goal = wide;
    goal.most = exp(2.9);
    curve known = {.offset = 20.0, .slope = 10.0};
    search_result const found = find(&known, &goal);
    assert_int_equal(found.verdict, SEARCH_VAGUE);
    assert_true(found.is_high_open && !found.is_low_open);
    assert_true(fabs(found.unknown - goal.most) < 1e-9);
}

static void a_goal_out_of_reach_is_told(void **state) {
    (void)state;
    search_goal goal = wide;
    curve known = {.offset = 20.0, .slope = 2.0};
    goal.measure = 90.0;
    assert_int_equal(find(&known, &goal).verdict, SEARCH_TOO_HIGH);
    known.points = 0;
    goal.measure = 5.0;
    assert_int_equal(find(&known, &goal).verdict, SEARCH_TOO_LOW);
    known.points = 0;
    goal.measure = 19.0; /* 20 at the least of the range: within the error */
    assert_int_equal(find(&known, &goal).verdict, SEARCH_VAGUE);
}

static void an_error_of_the_measure_ends_it(void **state) {
    (void)state;
    for (size_t k = 1; k < 5; k++) {
        curve known = {.offset = 20.0, .slope = 10.0, .fails_after = k};
        search_result result;
        tulle_error error = {0};
        assert_int_equal(search_find(&wide, measure_curve, &known, &result, &error),
                         TULLE_ERROR_INTERRUPTED);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_straight_curve_is_found_exactly),
        cmocka_unit_test(a_goal_far_from_the_first_values_is_reached),
        cmocka_unit_test(a_bent_curve_is_found),
        cmocka_unit_test(noise_counts_and_the_interval_holds_the_truth),
        cmocka_unit_test(a_flat_curve_is_vague),
        cmocka_unit_test(an_end_of_the_range_is_vague),
        cmocka_unit_test(a_goal_out_of_reach_is_told),
        cmocka_unit_test(an_error_of_the_measure_ends_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
