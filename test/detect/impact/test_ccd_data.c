/* Published queries with their symbolic truth: the unit tests and spikes of the CCD data set of
 * Wang, Ferguson, Schneider, Jiang, Attene, Panozzo, A Large-Scale Benchmark and an Inclusion-Based
 * Algorithm for Continuous Collision Detection, 2021, and one frame of its cloth scene. The exact
 * oracle agrees with each truth; no true collision is called separated; bounds are safe; under 5 %
 * of the cloth's queries are false alarms.
 * Reads TULLE_DATA_DIR; exit code 77 without it. */
#include "detect/impact/time_of_impact.h"
#include "support/exact_ccd.h"
#include "support/query_file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct data_counts {
    int total, collisions, filtered, false_alarms, unresolved;
} data_counts;

static void check_query(feature_kind kind, const moving_pair *pair, bool collides,
                        data_counts *counts) {
    assert_int_equal(exact_pair_touches(kind, pair, 1.0), collides);
    toi_result const result = time_of_impact(kind, pair, 0.0);
    bool const is_filtered =
        pair_cannot_cross(kind, pair) || prove_apart(kind, pair, 0.0) == APART_BY_DIRECTION;
    if (collides) {
        assert_int_not_equal(result.state, TOI_SEPARATED);
        assert_false(is_filtered);
        if (result.lower_bound > 0.0)
            assert_false(exact_pair_touches(kind, pair, result.lower_bound));
    }
    counts->total++;
    counts->collisions += collides;
    counts->filtered += is_filtered;
    counts->unresolved += result.state == TOI_UNRESOLVED;
    counts->false_alarms += !collides && !is_filtered && result.state != TOI_SEPARATED;
}

static void print_counts(const char *name, const data_counts *counts) {
    print_message("%-40s %4d queries, %3d collide, 0 missed, %4d filtered, %3d false alarms, "
                  "%d unresolved\n",
                  name, counts->total, counts->collisions, counts->filtered, counts->false_alarms,
                  counts->unresolved);
}

static void published_queries_are_decided(void **state) {
    (void)state;
    static const char *const names[] = {
        "unit-tests/vertex-face/data_0_0.csv",     "unit-tests/vertex-face/data_0_1.csv",
        "unit-tests/edge-edge/data_0_0.csv",       "unit-tests/edge-edge/data_0_1.csv",
        "erleben-spikes/vertex-face/data_0_0.csv", "erleben-spikes/vertex-face/data_0_1.csv",
        "erleben-spikes/edge-edge/data_0_0.csv",   "erleben-spikes/edge-edge/data_0_1.csv"};
    int total = 0;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char name[128];
        snprintf(name, sizeof name, "ccd-queries/%s", names[i]);
        FILE *const file = open_data(name);
        feature_kind const kind =
            strstr(name, "vertex-face") ? FEATURE_VERTEX_TRIANGLE : FEATURE_EDGE_EDGE;
        data_counts counts = {0};
        moving_pair pair;
        int truth;
        while (read_query(file, &pair, &truth)) {
            assert_true(truth >= 0);
            check_query(kind, &pair, truth == 1, &counts);
        }
        fclose(file);
        print_counts(names[i], &counts);
        total += counts.total;
    }
    assert_int_equal(total, 824);
}

static void cloth_frame_is_decided(void **state) {
    (void)state;
    static const char *const names[2][2] = {
        {"cloth-funnel/queries/227vf.csv", "cloth-funnel/mma_bool/227vf_mma_bool.json"},
        {"cloth-funnel/queries/227ee.csv", "cloth-funnel/mma_bool/227ee_mma_bool.json"}};
    int passed = 0, false_alarms = 0;
    for (int kind = 0; kind < 2; kind++) {
        FILE *const queries = open_data(names[kind][0]), *const truths = open_data(names[kind][1]);
        data_counts counts = {0};
        moving_pair pair;
        int truth;
        while (read_query(queries, &pair, &truth)) {
            int const collides = read_boolean(truths);
            assert_true(collides >= 0);
            check_query((feature_kind)kind, &pair, collides == 1, &counts);
        }
        assert_int_equal(read_boolean(truths), -1);
        assert_true(counts.total > 50);
        fclose(queries);
        fclose(truths);
        print_counts(names[kind][0], &counts);
        passed += counts.total - counts.filtered;
        false_alarms += counts.false_alarms;
    }
    print_message("false alarms: %d of %d that pass the filters, %.2f %%\n", false_alarms, passed,
                  100.0 * false_alarms / passed);
    assert_true(false_alarms < 0.05 * passed);
}

int main(void) {
    if (!find_data_path("ccd-queries/unit-tests/vertex-face/data_0_0.csv")) {
        printf("skipped: TULLE_DATA_DIR names no folder with ccd-queries\n");
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(published_queries_are_decided),
        cmocka_unit_test(cloth_frame_is_decided),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
