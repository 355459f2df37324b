/* Nothing is missed: every method, cone and way to keep patches, with the certificate, against
 * brute force with rational arithmetic on many small random scenes. TULLE_TEST_LONG=1 takes more of
 * them. */
#include "base/hash.h"
#include "detect/detector/detector_parts.h"
#include "support/detect_scene.h"
#include "support/test_support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct variant {
    const char *name;
    tulle_detect_method method;
    tulle_detect_cone cone;
    int grows_anew, skips_certificate;
} variant;

/* The first one is the reference for the others. */
static const variant variants[] = {
    {"refit", TULLE_DETECT_REFIT, TULLE_CONE_BERNSTEIN, 0, 0},
    {"bvox", TULLE_DETECT_BVOX, TULLE_CONE_BERNSTEIN, 0, 0},
    {"patches", TULLE_DETECT_PATCHES, TULLE_CONE_BERNSTEIN, 0, 0},
    {"patches, anew", TULLE_DETECT_PATCHES, TULLE_CONE_BERNSTEIN, 1, 0},
    {"patches, paper's cone", TULLE_DETECT_PATCHES, TULLE_CONE_PAPER, 0, 0},
    {"patches, paper's cone, anew", TULLE_DETECT_PATCHES, TULLE_CONE_PAPER, 1, 0},
    {"patches, no certificate", TULLE_DETECT_PATCHES, TULLE_CONE_BERNSTEIN, 0, 1},
    {"paper", TULLE_DETECT_PAPER, TULLE_CONE_PAPER, 1, 0},
    {"paper, bernstein", TULLE_DETECT_PAPER, TULLE_CONE_BERNSTEIN, 1, 0},
};
enum { VARIANT_COUNT = sizeof variants / sizeof variants[0] };

static detect_scene scene;
static detect_truths truths;
/* What the variants missed, patches in use, triangles in them; for the summary. */
static uint64_t patch_triangles[VARIANT_COUNT], all_triangles, uncertified_misses;

static int is_long(void) { return getenv("TULLE_TEST_LONG") != NULL; }

static bool uses_patches(const variant *of) {
    return of->method == TULLE_DETECT_PATCHES || of->method == TULLE_DETECT_PAPER;
}

/* All of `events` are, bit for bit, among the reference's. */
static bool is_subset(const tulle_detect_event *events, size_t count,
                      const tulle_detect_result *reference) {
    size_t at = 0;
    for (size_t i = 0; i < count; i++) {
        while (at < reference->event_count &&
               memcmp(&events[i], &reference->events[at], sizeof events[i]) != 0)
            at++;
        if (at++ == reference->event_count) return false;
    }
    return true;
}

static void check_result(const variant *with, const tulle_detect_result *result,
                         const tulle_detect_result *reference) {
    if (!with->skips_certificate)
        assert_true(detect_events_contain(&truths, result->events, result->event_count));
    else
        uncertified_misses += reference->event_count - result->event_count;
    assert_true(is_subset(result->events, result->event_count, reference));
    if (!uses_patches(with)) assert_int_equal(result->event_count, reference->event_count);
    double earliest = 1.0;
    for (size_t i = 0; i < result->event_count; i++)
        earliest = fmin(earliest, result->events[i].time);
    assert_true(earliest == result->earliest_time);
    patch_triangles[with - variants] += result->statistics.patch_triangles;
}

/* Two calls: what is kept was grown on the scene at rest, and has to be checked for the motion. */
static void check_variant(const variant *with, double max_angle,
                          const tulle_detect_result *reference) {
    tulle_detect_def def = detect_scene_get_def(&scene);
    def.method = with->method;
    def.cone = with->cone;
    def.grows_patches_anew = with->grows_anew;
    def.has_certificate = !with->skips_certificate;
    def.max_angle = max_angle;
    def.threads = 1;
    tulle_detector *detector;
    tulle_error error;
    assert_int_equal(tulle_detector_create(&def, &detector, &error), TULLE_OK);
    detector->keeps_all_patches = true;
    for (int call = 0; call < 2; call++) {
        bool const is_at_rest = call == 0 && !with->grows_anew;
        const double *const end = is_at_rest ? scene.start : scene.end;
        tulle_detect_result result;
        assert_int_equal(tulle_detector_find_events(detector, scene.start, end, &result, &error),
                         TULLE_OK);
        if (!is_at_rest) check_result(with, &result, reference);
    }
    tulle_detector_destroy(detector);
}

/* Every variant against the truth of `scene`. */
static void check_scene(double max_angle) {
    tulle_detect_def def = detect_scene_get_def(&scene);
    def.method = TULLE_DETECT_REFIT;
    def.threads = 1;
    tulle_detector *detector;
    tulle_error error;
    tulle_detect_result reference;
    detect_scene_find_truths(&scene, &truths);
    assert_int_equal(tulle_detector_create(&def, &detector, &error), TULLE_OK);
    assert_int_equal(
        tulle_detector_find_events(detector, scene.start, scene.end, &reference, &error), TULLE_OK);
    detect_events_check(&scene, reference.events, reference.event_count);
    all_triangles += 2 * scene.triangle_count;
    for (size_t i = 0; i < VARIANT_COUNT; i++) check_variant(&variants[i], max_angle, &reference);
    tulle_detector_destroy(detector);
}

static double random_angle(uint64_t *seed) {
    static const double degrees[] = {30.0, 45.0, 60.0, 75.0, 85.0, 89.0};
    return degrees[random_next(seed) % 6] * 3.14159265358979 / 180.0;
}

static void every_method_finds_all_of_one_surface(void **state) {
    (void)state;
    int const rounds = is_long() ? 2000 : 16;
    for (int family = 0; family < DETECT_FAMILY_COUNT; family++) {
        uint64_t truth_count = 0;
        for (int round = 0; round < rounds; round++) {
            uint64_t seed = hash_mix((uint64_t)(family * 100003 + round + 1));
            memset(&scene, 0, sizeof scene);
            unsigned const size = 1 + (unsigned)(random_next(&seed) % (is_long() ? 7 : 5));
            detect_scene_add(&scene, (detect_family)family, size, &seed);
            check_scene(random_angle(&seed));
            truth_count += truths.count;
        }
        print_message("%-9s %d scenes, %llu true pairs, none missed\n", detect_family_names[family],
                      rounds, (unsigned long long)truth_count);
        assert_true(truth_count > 0);
    }
}

/* Large enough that patches are worth keeping. */
static void every_method_finds_all_of_larger_sheets(void **state) {
    (void)state;
    static const struct {
        detect_family family;
        unsigned size;
    } sheets[] = {{DETECT_WAVE, 16}, {DETECT_CURL, 8}, {DETECT_RAMP, 4}, {DETECT_RING, 12}};
    int const rounds = is_long() ? 60 : 1;
    for (int round = 0; round < 4 * rounds; round++) {
        uint64_t seed = hash_mix((uint64_t)(round + 31337));
        memset(&scene, 0, sizeof scene);
        detect_scene_add(&scene, sheets[round % 4].family,
                         sheets[round % 4].size + (unsigned)(random_next(&seed) % 4), &seed);
        if (random_next(&seed) % 3 == 0) scene.minimum_separation = 1e-3;
        check_scene(random_angle(&seed));
    }
}

static void every_method_finds_all_at_any_scale(void **state) {
    (void)state;
    static const double scales[][2] = {{1e100, 0.0},  {1e-100, 0.0}, {0x1.0p-400, 0.0},
                                       {1.0, 1e3},    {1.0, 1e9},    {1e-6, 1e6},
                                       {1e100, 1e10}, {1e-300, 1e2}, {1e300, 0.0}};
    int const rounds = is_long() ? 40 : 1;
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++)
        for (int round = 0; round < rounds * DETECT_FAMILY_COUNT; round++) {
            uint64_t seed = hash_mix((uint64_t)(i * 100019 + (unsigned)round));
            memset(&scene, 0, sizeof scene);
            detect_scene_add(&scene, (detect_family)(round % DETECT_FAMILY_COUNT), 3, &seed);
            detect_scene_place(&scene, scales[i][0], scales[i][1]);
            check_scene(random_angle(&seed));
        }
}

static void every_method_keeps_separations(void **state) {
    (void)state;
    int const rounds = is_long() ? 100 : 2;
    uint64_t truth_count = 0;
    for (int round = 0; round < rounds * DETECT_FAMILY_COUNT; round++) {
        uint64_t seed = hash_mix((uint64_t)(round + 777));
        memset(&scene, 0, sizeof scene);
        detect_scene_add(&scene, (detect_family)(round % DETECT_FAMILY_COUNT),
                         1 + (unsigned)(random_next(&seed) % 4), &seed);
        scene.surfaces[0].thickness = random_next(&seed) % 3 ? 0.1 * random_uniform(&seed) : 0.0;
        scene.minimum_separation = random_next(&seed) % 2 ? 0.05 * random_uniform(&seed) : 1e-9;
        check_scene(random_angle(&seed));
        truth_count += truths.count;
    }
    assert_true(truth_count > 0);
}

static void add_random_surfaces(uint64_t *seed) {
    size_t const count = 2 + random_next(seed) % (DETECT_MAX_SURFACES - 1);
    for (size_t s = 0; s < count; s++) {
        detect_scene_add(&scene, (detect_family)(random_next(seed) % DETECT_FAMILY_COUNT),
                         1 + (unsigned)(random_next(seed) % 3), seed);
        tulle_detect_surface *const surface = &scene.surfaces[s];
        surface->is_obstacle = random_next(seed) % 3 == 0;
        surface->ignores_self = random_next(seed) % 4 == 0;
        surface->is_static = random_next(seed) % 4 == 0;
        surface->thickness = random_next(seed) % 3 == 0 ? 0.05 * random_uniform(seed) : 0.0;
        size_t const begin = 3 * (size_t)surface->vertex_begin;
        if (surface->is_static)
            memcpy(scene.end + begin, scene.start + begin,
                   (3 * (size_t)surface->vertex_end - begin) * sizeof(double));
    }
    scene.has_collides = random_next(seed) % 2;
    for (size_t a = 0; a < count; a++)
        for (size_t b = 0; b <= a; b++)
            scene.collides[a * count + b] = scene.collides[b * count + a] =
                random_next(seed) % 3 != 0;
}

static void every_method_heeds_surfaces(void **state) {
    (void)state;
    int const rounds = is_long() ? 2000 : 40;
    uint64_t truth_count = 0;
    for (int round = 0; round < rounds; round++) {
        uint64_t seed = hash_mix((uint64_t)(round + 4711));
        memset(&scene, 0, sizeof scene);
        add_random_surfaces(&seed);
        check_scene(random_angle(&seed));
        truth_count += truths.count;
    }
    assert_true(truth_count > 0);
}

/* Else the tests above would say nothing about patches. */
static void patches_were_at_work(void **state) {
    (void)state;
    for (size_t i = 0; i < VARIANT_COUNT; i++) {
        double const share = (double)patch_triangles[i] / (double)all_triangles;
        print_message("%-28s %.1f%% of the triangles in patches\n", variants[i].name,
                      100.0 * share);
        if (uses_patches(&variants[i])) assert_true(share > (variants[i].grows_anew ? 0.3 : 0.1));
    }
    print_message("without certificate %llu events were lost\n",
                  (unsigned long long)uncertified_misses);
    assert_true(uncertified_misses > 1000);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_method_finds_all_of_one_surface),
        cmocka_unit_test(every_method_finds_all_of_larger_sheets),
        cmocka_unit_test(every_method_finds_all_at_any_scale),
        cmocka_unit_test(every_method_keeps_separations),
        cmocka_unit_test(every_method_heeds_surfaces),
        cmocka_unit_test(patches_were_at_work),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
