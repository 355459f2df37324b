/* The detector against a second one written for clarity: all pairs, each decided in rational
 * arithmetic (support/detect_truth.c, exact_approach.c). Motions are adversarial ones of many
 * kinds, of cloth with itself, with cloth and with obstacles, near and far from the origin, tiny
 * and huge. TULLE_TEST_LONG=1 takes more and larger scenes. */
#include "base/hash.h"
#include "detect/detector/detector_parts.h"
#include "support/adversarial_motion.h"
#include "support/test_support.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All but the paper's, which has no proof of its own. The first is the reference for the others. */
static const tulle_detect_method methods[] = {TULLE_DETECT_REFIT, TULLE_DETECT_BVOX,
                                              TULLE_DETECT_PATCHES};
enum { METHOD_COUNT = sizeof methods / sizeof methods[0] };

/* Of all events: those of pairs that are not proven to come within their separation. Up to three of
 * seven gaps that motions aim at lie just over it. */
static const double MOST_UNPROVEN = 0.25;

typedef struct counts {
    uint64_t scenes, events, truths, apart, unresolved, left_by_patches;
} counts;

static detect_scene scene;
static detect_truths truths;

static bool is_long(void) { return getenv("TULLE_TEST_LONG") != NULL; }

static tulle_detect_result find(tulle_detect_method method, tulle_detector **detector) {
    tulle_detect_def def = detect_scene_get_def(&scene);
    def.method = method;
    def.threads = 1;
    tulle_detect_result result;
    tulle_error error = {0};
    if (tulle_detector_create(&def, detector, &error) != TULLE_OK) fail_msg("%s", error.message);
    (*detector)->keeps_all_patches = true;
    if (tulle_detector_find_events(*detector, scene.start, scene.end, &result, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    return result;
}

/* No event of a true pair comes later than it is proven to come near, and so neither does the
 * earliest of all. */
static void check_times(const tulle_detect_result *result) {
    size_t at = 0;
    double earliest = 1.0;
    for (size_t i = 0; i < truths.count; i++) {
        const detect_truth *const truth = &truths.pairs[i];
        while (at < result->event_count &&
               (result->events[at].kind != truth->kind ||
                memcmp(result->events[at].vertices, truth->vertices, sizeof truth->vertices) != 0))
            at++;
        assert_true(at < result->event_count);
        double from, by;
        detect_scene_time_truth(&scene, truth, &from, &by);
        assert_true(from <= by && result->events[at].time <= by);
        earliest = fmin(earliest, by);
    }
    assert_true(result->earliest_time <= earliest);
    double first = 1.0;
    for (size_t i = 0; i < result->event_count; i++) first = fmin(first, result->events[i].time);
    assert_true(result->earliest_time == first);
}

static void check_reference(const tulle_detect_result *result, counts *sum) {
    detect_events_check(&scene, result->events, result->event_count);
    check_times(result);
    for (size_t i = 0; i < result->event_count; i++) {
        sum->apart += !detect_event_check_near(&scene, &result->events[i]);
        sum->unresolved += result->events[i].state == TULLE_DETECT_UNRESOLVED;
    }
    sum->events += result->event_count;
    sum->truths += truths.count;
    sum->scenes++;
}

/* All events are, bit for bit, among the reference's; without patches they are the same. */
static void check_method(tulle_detect_method method, const tulle_detect_result *reference,
                         counts *sum) {
    tulle_detector *detector = NULL;
    tulle_detect_result const result = find(method, &detector);
    size_t at = 0;
    for (size_t i = 0; i < result.event_count; i++, at++) {
        while (at < reference->event_count &&
               memcmp(&result.events[i], &reference->events[at], sizeof *result.events) != 0)
            at++;
        assert_true(at < reference->event_count);
    }
    assert_true(detect_events_contain(&truths, result.events, result.event_count));
    if (method == TULLE_DETECT_PATCHES)
        sum->left_by_patches += reference->event_count - result.event_count;
    else
        assert_int_equal(result.event_count, reference->event_count);
    tulle_detector_destroy(detector);
}

static void check_scene(counts *sum) {
    tulle_detector *detector = NULL;
    detect_scene_find_truths(&scene, &truths);
    tulle_detect_result const reference = find(methods[0], &detector);
    assert_true(detect_events_contain(&truths, reference.events, reference.event_count));
    check_reference(&reference, sum);
    for (int i = 1; i < METHOD_COUNT; i++) check_method(methods[i], &reference, sum);
    tulle_detector_destroy(detector);
}

/* Scenes of one family, everywhere and between all kinds of surfaces; of the quick form
 * half. */
static void check_family(adversary family, counts *sum) {
    int const rounds = is_long() ? 2 : 1, sides_count = is_long() ? ADVERSARY_SIDES_COUNT : 1;
    /* on a lattice nearly every pair meets */
    unsigned const largest = family == ADVERSARY_LATTICE ? 60 : 200,
                   most = is_long() ? largest : 20;
    for (int round = 0; round < rounds; round++)
        for (int place = is_long() ? 0 : (int)family % 2; place < ADVERSARY_PLACE_COUNT;
             place += is_long() ? 1 : 2)
            for (int i = 0; i < sides_count; i++) {
                int const sides = (round + place + (int)family + i) % ADVERSARY_SIDES_COUNT;
                uint64_t seed = hash_mix(
                    (uint64_t)(1 + sides + 10 * (place + 10 * ((int)family + 10 * round))));
                unsigned const size = 10 + (unsigned)(random_next(&seed) % (most - 10));
                adversarial_scene_make(&scene, family, (adversary_place)place,
                                       (adversary_sides)sides, size, &seed);
                check_scene(sum);
            }
}

static void both_detectors_agree(void **state) {
    (void)state;
    counts all = {0};
    for (int family = 0; family < ADVERSARY_COUNT; family++) {
        counts sum = {0};
        check_family((adversary)family, &sum);
        print_message("%-9s %3" PRIu64 " scenes, %6" PRIu64 " events, %6" PRIu64 " near, %" PRIu64
                      " apart, %" PRIu64 " unresolved; patches leave out %" PRIu64 "\n",
                      adversary_names[family], sum.scenes, sum.events, sum.truths, sum.apart,
                      sum.unresolved, sum.left_by_patches);
        all.events += sum.events;
        all.truths += sum.truths;
    }
    assert_true(all.truths > 500);
    assert_true((double)(all.events - all.truths) <= MOST_UNPROVEN * (double)all.events);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(both_detectors_agree)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
