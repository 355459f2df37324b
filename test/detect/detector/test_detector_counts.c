/* The counts of a result: pairs come through each stage in turn, each stage drops some, and the
 * counts say so, with a separation and without, for any number of threads. */
#include "base/hash.h"
#include "support/test_support.h"
#include "tulle/detect.h"

enum { TRIANGLE_COUNT = 150, VERTEX_COUNT = 3 * TRIANGLE_COUNT };

static uint32_t triangles[3 * TRIANGLE_COUNT];
static double start[3 * VERTEX_COUNT], end[3 * VERTEX_COUNT];

/* Small triangles strewn in a unit box, each on its own way. */
static void strew_triangles(void) {
    uint64_t seed = 7;
    for (size_t t = 0; t < TRIANGLE_COUNT; t++) {
        for (size_t k = 0; k < 3; k++) triangles[3 * t + k] = (uint32_t)(3 * t + k);
        for (size_t axis = 0; axis < 3; axis++) {
            double const centre = random_uniform(&seed), way = 0.4 * random_uniform(&seed) - 0.2;
            for (size_t k = 0; k < 3; k++) {
                size_t const i = 3 * (3 * t + k) + axis;
                start[i] = centre + 0.2 * random_uniform(&seed);
                end[i] = start[i] + way + 0.1 * random_uniform(&seed);
            }
        }
    }
}

static tulle_detect_statistics count(double separation, int threads, size_t *event_count) {
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = triangles;
    def.triangle_count = TRIANGLE_COUNT;
    def.vertex_count = VERTEX_COUNT;
    def.minimum_separation = separation;
    def.method = TULLE_DETECT_REFIT;
    def.threads = threads;
    tulle_detector *detector;
    tulle_detect_result result;
    tulle_error error;
    assert_int_equal(tulle_detector_create(&def, &detector, &error), TULLE_OK);
    assert_int_equal(tulle_detector_find_events(detector, start, end, &result, &error), TULLE_OK);
    *event_count = result.event_count;
    tulle_detector_destroy(detector);
    return result.statistics;
}

static void each_stage_drops_pairs(void **state) {
    (void)state;
    static const double separations[] = {0.0, 0.01};
    strew_triangles();
    for (size_t i = 0; i < 2; i++) {
        size_t event_count, event_count_3;
        tulle_detect_statistics const one = count(separations[i], 1, &event_count);
        tulle_detect_statistics const three = count(separations[i], 3, &event_count_3);
        print_message("separation %g: %llu box pairs, %llu filtered, %llu tested, %zu events\n",
                      separations[i], (unsigned long long)one.box_pairs,
                      (unsigned long long)one.filtered_pairs, (unsigned long long)one.tested_pairs,
                      event_count);
        assert_true(one.box_pairs > one.filtered_pairs);
        assert_true(one.filtered_pairs > one.tested_pairs);
        assert_true(one.tested_pairs >= event_count && event_count > 0);
        assert_int_equal(one.box_pairs, three.box_pairs);
        assert_int_equal(one.filtered_pairs, three.filtered_pairs);
        assert_int_equal(one.tested_pairs, three.tested_pairs);
        assert_int_equal(event_count, event_count_3);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_stage_drops_pairs)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
