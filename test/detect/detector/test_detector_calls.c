/* What holds over many calls of one detector: patches that are kept miss nothing, threads and
 * vector widths change nothing, streaming and the earliest event agree with the list, and memory
 * that runs out at any moment leaves a detector that works and leaks nothing. */
#include "base/hash.h"
#include "detect/detector/detector_parts.h"
#include "math/kernel_target.h"
#include "support/detect_scene.h"
#include "support/test_support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static detect_scene scene;
static detect_truths truths;
static const tulle_detect_method methods[] = {TULLE_DETECT_PATCHES, TULLE_DETECT_REFIT,
                                              TULLE_DETECT_BVOX, TULLE_DETECT_PAPER};
enum { METHOD_COUNT = sizeof methods / sizeof methods[0] };

static int is_long(void) { return getenv("TULLE_TEST_LONG") != NULL; }

/* Its patches are kept, however small. */
static tulle_detector *make_detector(const tulle_detect_def *def) {
    tulle_error error;
    tulle_detector *detector;
    assert_int_equal(tulle_detector_create(def, &detector, &error), TULLE_OK);
    detector->keeps_all_patches = true;
    return detector;
}

static tulle_detect_result find(tulle_detector *detector) {
    tulle_error error;
    tulle_detect_result result;
    tulle_status const status =
        tulle_detector_find_events(detector, scene.start, scene.end, &result, &error);
    if (status != TULLE_OK) print_error("%s\n", error.message);
    assert_int_equal(status, TULLE_OK);
    return result;
}

static bool uses_patches(tulle_detect_method method) {
    return method == TULLE_DETECT_PATCHES || method == TULLE_DETECT_PAPER;
}

/* The next step of a sheet: it goes on from where it is, with a speed that changes slowly. */
static void step_sheet(const detect_scene *shapes, int call) {
    memcpy(scene.start, call == 0 ? shapes->start : scene.end,
           3 * scene.vertex_count * sizeof(double));
    for (size_t i = 0; i < 3 * scene.vertex_count; i++) {
        double const span = shapes->end[i] - shapes->start[i],
                     way = 0.5 - 0.5 * cos(0.4 * (call + 1));
        scene.end[i] = shapes->start[i] + way * span;
    }
}

enum { KEEPER_COUNT = 4 }; /* two cones and two angles */

static void make_keepers(tulle_detector *keepers[KEEPER_COUNT]) {
    static const double degrees[] = {60.0, 85.0};
    for (int i = 0; i < KEEPER_COUNT; i++) {
        tulle_detect_def def = detect_scene_get_def(&scene);
        def.method = TULLE_DETECT_PATCHES;
        def.cone = i % 2 ? TULLE_CONE_PAPER : TULLE_CONE_BERNSTEIN;
        def.max_angle = degrees[i / 2] * 3.14159265358979 / 180.0;
        def.threads = 1;
        keepers[i] = make_detector(&def);
    }
}

typedef struct keeping_counts {
    uint64_t truths, patch_triangles, triangles, checked_again, given_up;
} keeping_counts;

/* A surface that moves on over 20 calls, there and back. */
static void keep_over_calls(const detect_scene *shapes, keeping_counts *counts) {
    tulle_detector *keepers[KEEPER_COUNT];
    scene = *shapes;
    make_keepers(keepers);
    for (int call = 0; call < 20; call++) {
        step_sheet(shapes, call);
        detect_scene_find_truths(&scene, &truths);
        counts->truths += truths.count;
        for (int i = 0; i < KEEPER_COUNT; i++) {
            tulle_detect_result const result = find(keepers[i]);
            assert_true(detect_events_contain(&truths, result.events, result.event_count));
            counts->patch_triangles += result.statistics.patch_triangles;
            counts->triangles += scene.triangle_count;
            counts->given_up += result.statistics.uncertified_count;
            counts->checked_again += result.statistics.checked_again;
        }
    }
    for (int i = 0; i < KEEPER_COUNT; i++) tulle_detector_destroy(keepers[i]);
}

static void kept_patches_miss_nothing(void **state) {
    (void)state;
    static detect_scene shapes;
    static const struct {
        detect_family family;
        unsigned size;
    } sheets[] = {{DETECT_WAVE, 22},
                  {DETECT_CURL, 14},
                  {DETECT_FOLD, 4},
                  {DETECT_RING, 20},
                  {DETECT_RAMP, 10}};
    int const rounds = is_long() ? 40 : 1;
    keeping_counts counts = {0};
    for (int round = 0; round < 5 * rounds; round++) {
        uint64_t seed = hash_mix((uint64_t)(round + 99));
        memset(&shapes, 0, sizeof shapes);
        detect_scene_add(&shapes, sheets[round % 5].family, sheets[round % 5].size, &seed);
        shapes.surfaces[0].thickness = random_next(&seed) % 2 ? 0.0 : 1e-3;
        keep_over_calls(&shapes, &counts);
    }
    double const share = (double)counts.patch_triangles / (double)counts.triangles;
    print_message("%llu true pairs, none missed; %.1f%% of the triangles in patches, %llu patches "
                  "held, %llu dissolved\n",
                  (unsigned long long)counts.truths, 100.0 * share,
                  (unsigned long long)counts.checked_again, (unsigned long long)counts.given_up);
    assert_true(counts.truths > 0 && share > 0.3);
    assert_true(counts.checked_again > 0 && counts.given_up > 0);
}

static uint64_t hash_result(const tulle_detect_result *result) {
    uint64_t const hash =
        hash_bytes(HASH_SEED, result->events, result->event_count * sizeof *result->events);
    return hash_bytes(hash, &result->earliest_time, sizeof(double));
}

/* Five surfaces with some hundred triangles, different ones for each seed. */
static void make_mixed_scene(uint64_t seed) {
    memset(&scene, 0, sizeof scene);
    detect_scene_add(&scene, DETECT_WAVE, 8, &seed);
    detect_scene_add(&scene, DETECT_CURL, 7, &seed);
    detect_scene_add(&scene, DETECT_ROUGH, 5, &seed);
    detect_scene_add(&scene, DETECT_FREE, 20, &seed);
    scene.surfaces[1].thickness = 0.02;
    scene.surfaces[3].is_obstacle = 1;
}

static void threads_and_widths_change_nothing(void **state) {
    (void)state;
    static const int threads[] = {1, 2, 5, 8};
    for (int method = 0; method < METHOD_COUNT; method++)
        for (uint64_t seed = 1; seed <= (is_long() ? 10 : 1); seed++) {
            make_mixed_scene(seed);
            uint64_t expected = 0;
            for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
                if (!kernel_target_force((kernel_target)target)) continue;
                for (size_t i = 0; i < sizeof threads / sizeof threads[0]; i++) {
                    tulle_detect_def def = detect_scene_get_def(&scene);
                    def.method = methods[method];
                    def.threads = threads[i];
                    tulle_detector *const detector = make_detector(&def);
                    for (int call = 0; call < 2; call++) {
                        tulle_detect_result const result = find(detector);
                        assert_true(result.event_count > 100);
                        if (expected == 0) expected = hash_result(&result);
                        assert_true(hash_result(&result) == expected);
                        uint64_t const patched = result.statistics.patch_triangles;
                        assert_true((patched > scene.triangle_count / 10) ==
                                    uses_patches(methods[method]));
                    }
                    tulle_detector_destroy(detector);
                }
            }
            (void)kernel_target_force(KERNEL_TARGET_COUNT - 1);
        }
}

typedef struct received {
    const tulle_detect_result *expected;
    size_t count, calls, stop_after;
} received;

static int receive(void *context, const tulle_detect_event *events, size_t count) {
    received *const got = context;
    assert_true(count > 0 && count <= 1024);
    assert_true(got->count + count <= got->expected->event_count);
    assert_memory_equal(events, got->expected->events + got->count, count * sizeof *events);
    got->count += count;
    return ++got->calls == got->stop_after;
}

/* The whole list, then one that is stopped after the first batch. */
static void check_stream(tulle_detector *streaming, const tulle_detect_result *list) {
    tulle_error error;
    tulle_detect_result stream = {0};
    received got = {.expected = list};
    tulle_detect_receiver const receiver = {receive, &got};
    assert_int_equal(
        tulle_detector_stream_events(streaming, scene.start, scene.end, receiver, &stream, &error),
        TULLE_OK);
    assert_int_equal(got.count, list->event_count);
    assert_int_equal(stream.event_count, list->event_count);
    assert_true(stream.earliest_time == list->earliest_time && !stream.events);
    assert_true(got.calls == (list->event_count + 1023) / 1024);
    tulle_detect_result const before = stream;
    got = (received){.expected = list, .stop_after = 1};
    assert_int_equal(
        tulle_detector_stream_events(streaming, scene.start, scene.end, receiver, &stream, &error),
        TULLE_ERROR_INTERRUPTED);
    assert_memory_equal(&before, &stream, sizeof stream);
    assert_int_equal(got.calls, 1);
}

static void streams_give_the_list(void **state) {
    (void)state;
    for (int method = 0; method < METHOD_COUNT; method++)
        for (int thick = 0; thick < 2; thick++) {
            make_mixed_scene(5);
            scene.minimum_separation = thick ? 0.05 : 0.0;
            tulle_detect_def def = detect_scene_get_def(&scene);
            def.method = methods[method];
            tulle_detector *const listing = make_detector(&def);
            tulle_detector *const streaming = make_detector(&def);
            tulle_detect_result const list = find(listing);
            assert_true(thick == 0 || list.event_count > 1024);
            check_stream(streaming, &list);
            tulle_detector_destroy(listing);
            tulle_detector_destroy(streaming);
        }
}

/* A receiver that calls its own detector. */
static int call_back(void *context, const tulle_detect_event *events, size_t count) {
    tulle_detector *const detector = context;
    tulle_error error;
    tulle_detect_result result = {0}, untouched = {0};
    tulle_detect_receiver const receiver = {call_back, context};
    tulle_detect_event const first = events[0];
    assert_true(count > 0);
    assert_int_equal(tulle_detector_find_events(detector, scene.start, scene.end, &result, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(
        tulle_detector_find_earliest(detector, scene.start, scene.end, &result, &error),
        TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(
        tulle_detector_stream_events(detector, scene.start, scene.end, receiver, &result, &error),
        TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "receiver"));
    assert_memory_equal(&result, &untouched, sizeof result);
    assert_memory_equal(&first, events, sizeof first);
    assert_non_null(tulle_detector_get_patches(detector));
    return 0;
}

static void receivers_may_not_call_back(void **state) {
    (void)state;
    make_mixed_scene(5);
    tulle_detect_def const def = detect_scene_get_def(&scene);
    tulle_detector *const detector = make_detector(&def), *const other = make_detector(&def);
    tulle_error error;
    tulle_detect_result result;
    tulle_detect_receiver const receiver = {call_back, detector};
    assert_int_equal(
        tulle_detector_stream_events(detector, scene.start, scene.end, receiver, &result, &error),
        TULLE_OK);
    assert_true(result.event_count > 0);
    tulle_detect_result const again = find(detector), expected = find(other);
    assert_int_equal(again.event_count, expected.event_count);
    tulle_detector_destroy(detector);
    tulle_detector_destroy(other);
}

static void check_earliest(tulle_detector *detector, const tulle_detect_result *all) {
    tulle_error error;
    tulle_detect_result one;
    assert_int_equal(tulle_detector_find_earliest(detector, scene.start, scene.end, &one, &error),
                     TULLE_OK);
    size_t first = 0;
    for (size_t i = 1; i < all->event_count; i++)
        if (all->events[i].time < all->events[first].time) first = i;
    assert_int_equal(one.event_count, all->event_count > 0);
    assert_true(one.earliest_time == all->earliest_time);
    if (all->event_count > 0)
        assert_memory_equal(&one.events[0], &all->events[first], sizeof *one.events);
}

static void earliest_is_the_first_of_the_list(void **state) {
    (void)state;
    for (uint64_t round = 0; round < 4 * 60; round++) {
        uint64_t seed = hash_mix(round);
        memset(&scene, 0, sizeof scene);
        detect_scene_add(&scene, (detect_family)(round % DETECT_FAMILY_COUNT), 4, &seed);
        if (random_next(&seed) % 2) scene.minimum_separation = 0.01;
        tulle_detect_def def = detect_scene_get_def(&scene);
        def.method = methods[round / DETECT_FAMILY_COUNT % METHOD_COUNT];
        def.threads = 1 + (int)(round % 4);
        tulle_detector *const detector = make_detector(&def), *const other = make_detector(&def);
        tulle_detect_result const all = find(detector);
        check_earliest(other, &all);
        tulle_detector_destroy(detector);
        tulle_detector_destroy(other);
    }
}

/* An allocator whose k-th call fails. */
typedef struct failing_heap {
    size_t bytes_held, call_count, fails_at;
} failing_heap;

static void *allocate(void *context, size_t byte_count) {
    failing_heap *const heap = context;
    if (++heap->call_count == heap->fails_at) return NULL;
    heap->bytes_held += byte_count;
    return malloc(byte_count);
}

static void release(void *context, void *pointer, size_t byte_count) {
    ((failing_heap *)context)->bytes_held -= byte_count;
    free(pointer);
}

/* Creates, calls twice with more events the second time; fails at most once. Returns whether it
 * failed. */
static bool survives_failure(failing_heap *heap, tulle_detect_method method, uint64_t expected[2]) {
    tulle_detect_def def = detect_scene_get_def(&scene);
    def.method = method;
    def.threads = 2;
    def.allocator = (tulle_allocator){allocate, release, heap, 0};
    tulle_error error;
    tulle_detector *detector;
    bool has_failed = false;
    while (tulle_detector_create(&def, &detector, &error) != TULLE_OK) {
        assert_int_equal(error.status, TULLE_ERROR_OUT_OF_MEMORY);
        assert_null(detector);
        assert_int_equal(heap->bytes_held, 0);
        assert_false(has_failed);
        has_failed = true;
    }
    detector->keeps_all_patches = true;
    for (int call = 0; call < 2; call++) {
        double *const end = call == 0 ? scene.start : scene.end;
        tulle_detect_result result = {0}, untouched = {0};
        tulle_status status;
        while ((status = tulle_detector_find_events(detector, scene.start, end, &result, &error))) {
            assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
            assert_memory_equal(&result, &untouched, sizeof result);
            assert_null(tulle_detector_get_patches(detector));
            assert_false(has_failed);
            has_failed = true;
        }
        uint64_t const hash = hash_result(&result);
        if (heap->fails_at == 0) expected[call] = hash;
        if (!has_failed || method == TULLE_DETECT_REFIT || method == TULLE_DETECT_BVOX)
            assert_true(hash == expected[call]);
        if (has_failed && call == 1)
            assert_true(detect_events_contain(&truths, result.events, result.event_count));
    }
    tulle_detector_destroy(detector);
    assert_int_equal(heap->bytes_held, 0);
    return has_failed;
}

static void failing_allocations_leave_it_sound(void **state) {
    (void)state;
    for (int method = 0; method < METHOD_COUNT; method++) {
        uint64_t seed = 11, expected[2];
        memset(&scene, 0, sizeof scene);
        detect_scene_add(&scene, DETECT_CURL, 5, &seed);
        detect_scene_add(&scene, DETECT_FAST, 6, &seed);
        detect_scene_find_truths(&scene, &truths);
        failing_heap heap = {0};
        assert_false(survives_failure(&heap, methods[method], expected));
        for (size_t k = 1;; k++) {
            heap = (failing_heap){.fails_at = k};
            if (!survives_failure(&heap, methods[method], expected)) break;
        }
        print_message("method %d: each of %zu allocations failed once\n", method, heap.call_count);
    }
}

static void half_an_allocator_is_refused(void **state) {
    (void)state;
    make_mixed_scene(3);
    failing_heap heap = {0};
    tulle_detect_def def = detect_scene_get_def(&scene);
    tulle_detector *detector;
    tulle_error error;
    for (int k = 0; k < 2; k++) {
        def.allocator =
            (tulle_allocator){k == 0 ? allocate : NULL, k == 1 ? release : NULL, &heap, 0};
        assert_int_equal(tulle_detector_create(&def, &detector, &error),
                         TULLE_ERROR_INVALID_ARGUMENT);
        assert_non_null(strstr(error.message, "allocator"));
        assert_null(detector);
    }
}

static void a_byte_limit_holds(void **state) {
    (void)state;
    make_mixed_scene(3);
    tulle_detect_def def = detect_scene_get_def(&scene);
    tulle_error error;
    size_t failures = 0;
    for (size_t limit = 1000;; limit += limit / 3) {
        def.allocator = (tulle_allocator){.byte_limit = limit};
        tulle_detector *detector;
        tulle_detect_result result;
        tulle_status status = tulle_detector_create(&def, &detector, &error);
        if (status == TULLE_OK)
            status = tulle_detector_find_events(detector, scene.start, scene.end, &result, &error);
        tulle_detector_destroy(detector);
        if (status == TULLE_OK) break;
        assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
        failures++;
    }
    assert_true(failures > 5);
}

/* The same states again need no more room than before, and no other patches. */
static void steady_calls_make_no_heap_call(void **state) {
    (void)state;
    for (int method = 0; method < METHOD_COUNT; method++) {
        make_mixed_scene(4);
        failing_heap heap = {0};
        tulle_detect_def def = detect_scene_get_def(&scene);
        def.method = methods[method];
        def.threads = 1;
        def.allocator = (tulle_allocator){allocate, release, &heap, 0};
        tulle_detector *const detector = make_detector(&def);
        for (int call = 0; call < 4; call++) (void)find(detector);
        size_t const before = heap.call_count;
        (void)find(detector);
        assert_int_equal(heap.call_count, before);
        tulle_detector_destroy(detector);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kept_patches_miss_nothing),
        cmocka_unit_test(threads_and_widths_change_nothing),
        cmocka_unit_test(streams_give_the_list),
        cmocka_unit_test(earliest_is_the_first_of_the_list),
        cmocka_unit_test(failing_allocations_leave_it_sound),
        cmocka_unit_test(receivers_may_not_call_back),
        cmocka_unit_test(half_an_allocator_is_refused),
        cmocka_unit_test(a_byte_limit_holds),
        cmocka_unit_test(steady_calls_make_no_heap_call),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
