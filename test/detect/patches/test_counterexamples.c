/* A search by machine for motions in which a certified patch touches itself: none is found. The
 * search is tested by a rule that is wrong, the cone alone: for every family of surfaces it finds
 * a counterexample within seconds.
 *
 * TULLE_TEST_LONG=1 searches for an hour. TULLE_SEARCH_SECONDS sets another time,
 * TULLE_SEARCH_FIRST the first restart, TULLE_SEARCH_COUNT how many at most: what is printed with a
 * counterexample repeats it. Counterexamples are written to TMPDIR as two OBJ files. */
#include "base/timer.h"
#include "support/patch_search.h"
#include "tulle_io/mesh_files.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const char *const rule_names[] = {
    "cone", "contours without reach", "contours at the ends only", "contours", "kept", "kept anew",
    "held"};
static const char *const drive_names[] = {"to contact", "to acceptance"};

static double read_number(const char *name, double usual) {
    const char *const text = getenv(name);
    return text ? strtod(text, NULL) : usual;
}

static void write_surface(const open_surface *of, const double *positions, const char *path) {
    tulle_mesh_view const view = {positions, of->vertex_count, of->triangles, of->triangle_count};
    tulle_error error;
    if (tulle_mesh_write(path, view, &error)) printf("%s: %s\n", path, error.message);
}

static void report_violation(const search_plan *plan, const search_outcome *outcome,
                             const open_surface *of) {
    const char *const folder = getenv("TMPDIR");
    const uint32_t *const v = outcome->pair.vertices;
    printf("COUNTEREXAMPLE: restart %llu (%s, rule %s, drive %s), step %d, reach %.17g: %s "
           "vertices %u %u %u %u of patch %u\n",
           (unsigned long long)plan->seed, family_names[plan->family], rule_names[plan->rule],
           drive_names[plan->drive], outcome->step, outcome->reach,
           outcome->pair.kind == FEATURE_VERTEX_TRIANGLE ? "vertex/face" : "edge/edge", v[0], v[1],
           v[2], v[3], outcome->pair.label);
    for (int end = 0; end < 2; end++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/counterexample_%llu_%s.obj", folder ? folder : "/tmp",
                 (unsigned long long)plan->seed, end == 0 ? "start" : "end");
        write_surface(of, end == 0 ? of->x0 : of->x1, path);
        printf("  %s\n", path);
    }
}

/* ---- the search itself is tested ---- */

/* Restarts of one family by a wrong rule until one finds a counterexample. */
static bool find_by_wrong_rule(patch_rule rule, surface_family family, int steps,
                               int restarts_max) {
    memory heap = memory_default();
    static open_surface surface;
    double const began = timer_now();
    search_outcome outcome = {0};
    int restart = 0;
    for (; restart < restarts_max && !outcome.is_found; restart++) {
        search_plan const plan = {.family = family,
                                  .rule = rule,
                                  .seed = (uint64_t)(1000 * (int)family + restart),
                                  .steps = steps,
                                  .wishes = {.is_plain = true}};
        outcome = search_patches(&heap, &plan, &surface);
        topology_destroy(&heap, &surface.topo);
    }
    print_message("%-8s by %s: %s after %d restarts, step %d, %.2f s\n", family_names[family],
                  rule_names[rule], outcome.is_found ? "counterexample" : "nothing", restart,
                  outcome.step, timer_now() - began);
    return outcome.is_found;
}

static void the_cone_alone_fails_in_every_family(void **state) {
    (void)state;
    for (int family = 0; family < FAMILY_COUNT; family++)
        assert_true(find_by_wrong_rule(RULE_CONE, (surface_family)family, 60, 300));
}

/* Rules that are nearly right. The families left out in the short form take a minute. */
static void small_faults_are_found(void **state) {
    (void)state;
    static const surface_family quick[] = {FAMILY_C_RING, FAMILY_ANNULUS, FAMILY_SLIT, FAMILY_COMB,
                                           FAMILY_FAN};
    bool const is_long = getenv("TULLE_TEST_LONG") != NULL;
    int const count = is_long ? FAMILY_COUNT : (int)(sizeof quick / sizeof quick[0]);
    for (int i = 0; i < count; i++) {
        surface_family const family = is_long ? (surface_family)i : quick[i];
        assert_true(find_by_wrong_rule(RULE_WITHOUT_REACH, family, 100, 60));
        assert_true(find_by_wrong_rule(RULE_ENDS_ONLY, family, 100, 60));
    }
}

/* ---- and then it searches ---- */

typedef struct search_sums {
    uint64_t restart_count, found_count, motion_count, pair_count, exact_count;
    uint64_t patched_count, triangle_count;
    double nearest; /* [mean edges] */
} search_sums;

static const patch_rule right_rules[] = {RULE_CONTOURS, RULE_KEPT, RULE_KEPT_ANEW, RULE_HELD};
enum { RIGHT_RULE_COUNT = sizeof right_rules / sizeof right_rules[0] };

/* Rules take turns, and each one goes through all families, drives and wishes. */
static search_plan make_plan(uint64_t restart, int steps) {
    uint64_t const turn = restart / RIGHT_RULE_COUNT, round = turn / FAMILY_COUNT;
    return (search_plan){.family = (surface_family)(turn % FAMILY_COUNT),
                         .rule = right_rules[restart % RIGHT_RULE_COUNT],
                         .drive = round % 3 == 2 ? DRIVE_TO_ACCEPTANCE : DRIVE_TO_CONTACT,
                         .seed = restart,
                         .steps = steps,
                         .wishes = {.is_plain = round / 3 % 3 == 0}};
}

static void add_outcome(search_sums *sums, const search_outcome *outcome) {
    sums->restart_count++;
    sums->found_count += outcome->is_found;
    sums->motion_count += outcome->motion_count;
    sums->pair_count += outcome->pair_count;
    sums->exact_count += outcome->exact_count;
    sums->patched_count += outcome->patched_count;
    sums->triangle_count += outcome->triangle_count;
    sums->nearest = fmin(sums->nearest, outcome->nearest);
}

static void print_sums(const char *name, const search_sums *of) {
    if (of->restart_count == 0) return;
    print_message("%-22s %6llu restarts %9llu motions, %4.1f%% of triangles in patches, %.3g pairs "
                  "(%llu by rationals), nearest %.2g edges, %llu counterexamples\n",
                  name, (unsigned long long)of->restart_count, (unsigned long long)of->motion_count,
                  100.0 * (double)of->patched_count / fmax((double)of->triangle_count, 1.0),
                  (double)of->pair_count, (unsigned long long)of->exact_count, of->nearest,
                  (unsigned long long)of->found_count);
}

/* Each rule that had as many restarts as there are families had patches to be wrong about. */
static void check_rules(const search_sums sums[RIGHT_RULE_COUNT]) {
    for (int i = 0; i < RIGHT_RULE_COUNT; i++) {
        print_sums(rule_names[right_rules[i]], &sums[i]);
        if (sums[i].restart_count < FAMILY_COUNT) continue;
        assert_true(sums[i].patched_count * 10 > sums[i].triangle_count);
        assert_true(sums[i].pair_count > 0);
    }
}

static void no_certified_patch_touches_itself(void **state) {
    (void)state;
    bool const is_long = getenv("TULLE_TEST_LONG") != NULL;
    double const seconds = read_number("TULLE_SEARCH_SECONDS", is_long ? 3600.0 : 4.0);
    double const count = read_number("TULLE_SEARCH_COUNT", 1e18);
    uint64_t const first = (uint64_t)read_number("TULLE_SEARCH_FIRST", is_long ? 1000000.0 : 0.0);
    memory heap = memory_default();
    static open_surface surface;
    search_sums sums[2][FAMILY_COUNT] = {0}, rule_sums[RIGHT_RULE_COUNT] = {0};
    for (int i = 0; i < 2 * FAMILY_COUNT; i++)
        sums[i / FAMILY_COUNT][i % FAMILY_COUNT].nearest = 1e9;
    for (int i = 0; i < RIGHT_RULE_COUNT; i++) rule_sums[i].nearest = 1e9;
    double const began = timer_now();
    uint64_t restart = first, found_count = 0;
    for (; (double)(restart - first) < count; restart++) {
        /* every rule gets its turn with every family, however slow the machine */
        if (restart - first >= RIGHT_RULE_COUNT * FAMILY_COUNT && timer_now() - began >= seconds)
            break;
        search_plan const plan = make_plan(restart, is_long ? 500 : 40);
        search_outcome const outcome = search_patches(&heap, &plan, &surface);
        if (outcome.is_found && found_count++ < 20) report_violation(&plan, &outcome, &surface);
        add_outcome(&sums[plan.drive][plan.family], &outcome);
        add_outcome(&rule_sums[restart % RIGHT_RULE_COUNT], &outcome);
        topology_destroy(&heap, &surface.topo);
        if (is_long && restart % 100 == 99)
            print_message("%.0f s: restart %llu, %llu counterexamples\n", (timer_now() - began),
                          (unsigned long long)restart, (unsigned long long)found_count);
    }
    for (int drive = 0; drive < 2; drive++)
        for (int family = 0; family < FAMILY_COUNT; family++) {
            char name[64];
            snprintf(name, sizeof name, "%-8s %s", family_names[family], drive_names[drive]);
            print_sums(name, &sums[drive][family]);
        }
    print_message("restarts %llu to %llu in %.0f s\n", (unsigned long long)first,
                  (unsigned long long)restart - 1, (timer_now() - began));
    assert_int_equal(found_count, 0);
    check_rules(rule_sums);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_cone_alone_fails_in_every_family),
        cmocka_unit_test(small_faults_are_found),
        cmocka_unit_test(no_certified_patch_touches_itself),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
