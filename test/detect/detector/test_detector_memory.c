/* How much memory a detector holds beyond the mesh, at its end and at most, by an allocator that
 * counts: on a cloth folded over itself, of three sizes. */
#include "base/hash.h"
#include "support/test_support.h"
#include "tulle/detect.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

enum {
    MOST_SIDE = 200, /* squares of two triangles */
    MOST_VERTICES = (MOST_SIDE + 1) * (MOST_SIDE + 1),
    CALLS = 6,
    BYTES_A_TRIANGLE = 400
};

static uint32_t triangles[6 * MOST_SIDE * MOST_SIDE];
static double start[3 * MOST_VERTICES], end[3 * MOST_VERTICES];

typedef struct counting_heap {
    size_t held, most;
    int left; /* allocations before one that fails; below 0 none does */
} counting_heap;

static void *allocate(void *context, size_t byte_count) {
    counting_heap *const heap = context;
    if (heap->left-- == 0) return NULL;
    heap->held += byte_count;
    if (heap->held > heap->most) heap->most = heap->held;
    return malloc(byte_count);
}

static void release(void *context, void *pointer, size_t byte_count) {
    ((counting_heap *)context)->held -= byte_count;
    free(pointer);
}

static void make_triangles(uint32_t side) {
    uint32_t *at = triangles;
    for (uint32_t row = 0; row < side; row++)
        for (uint32_t column = 0; column < side; column++) {
            uint32_t const a = row * (side + 1) + column, b = a + side + 1;
            const uint32_t corners[6] = {a, a + 1, b, b, a + 1, b + 1};
            for (int k = 0; k < 6; k++) *at++ = corners[k];
        }
}

/* A square of 1 m, folded once along the middle round half a circle, with waves that move on with
 * time. */
static void fold(uint32_t side, double time, double bend, double *positions) {
    double const half = 0.5 * (1.0 - 3.141592653589793 * bend);
    for (uint32_t i = 0; i < (side + 1) * (side + 1); i++) {
        double const u = (double)(i % (side + 1)) / side, v = (double)(i / (side + 1)) / side;
        double const wave = 0.004 * sin(15.0 * u + 9.0 * v + time);
        double const angle = fmin(fmax((u - half) / bend, 0.0), 3.141592653589793);
        double const straight = u < half ? u : u < 1.0 - half ? half : 1.0 - u;
        positions[3 * i] = straight + bend * sin(angle);
        positions[3 * i + 1] = v;
        positions[3 * i + 2] = bend * (1.0 - cos(angle)) + wave;
    }
}

static void place(uint32_t side, double time, double *positions) {
    fold(side, time, 0.06, positions);
}

/* Layers so near that small meshes search faster without patches. */
static void place_near(uint32_t side, double time, double *positions) {
    fold(side, time, 0.01, positions);
}

/* A square, every vertex of which is up or down, so that no patch grows beyond a few triangles. */
static void crumple(uint32_t side, double time, double *positions) {
    uint64_t seed = 7;
    for (uint32_t i = 0; i < (side + 1) * (side + 1); i++) {
        positions[3 * i] = (double)(i % (side + 1)) / side;
        positions[3 * i + 1] = (double)(i / (side + 1)) / side;
        positions[3 * i + 2] = time + (random_uniform(&seed) < 0.5 ? -1.0 : 1.0) / side;
    }
}

typedef struct memory_case {
    const char *name;
    tulle_detect_method method;
    void (*place)(uint32_t side, double time, double *positions);
} memory_case;

static void check_size(uint32_t side, const memory_case *how) {
    counting_heap heap = {.left = -1};
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = triangles;
    def.triangle_count = 2 * (size_t)side * side;
    def.vertex_count = (size_t)(side + 1) * (side + 1);
    def.method = how->method;
    def.threads = 2;
    def.allocator = (tulle_allocator){allocate, release, &heap, 0};
    make_triangles(side);
    tulle_detector *detector;
    tulle_detect_result result;
    assert_int_equal(tulle_detector_create(&def, &detector, NULL), TULLE_OK);
    for (int call = 0; call < CALLS; call++) {
        how->place(side, 0.02 * call, start);
        how->place(side, 0.02 * (call + 1), end);
        assert_int_equal(tulle_detector_find_events(detector, start, end, &result, NULL), TULLE_OK);
        if (call == 0)
            assert_int_equal(result.statistics.patch_triangles, 0); /* not yet worth it */
    }
    double const each = 1.0 / (double)def.triangle_count;
    print_message("%zu triangles, %s: %.0f bytes a triangle, %.0f at most; %.0f%% in patches\n",
                  def.triangle_count, how->name, (double)heap.held * each, (double)heap.most * each,
                  100.0 * (double)result.statistics.patch_triangles * each);
    assert_true(heap.most < BYTES_A_TRIANGLE * def.triangle_count);
    assert_true(heap.held > 100 * def.triangle_count);
    int const has_patches = how->method == TULLE_DETECT_PATCHES && how->place == place;
    if (has_patches)
        assert_true(2 * result.statistics.patch_triangles > def.triangle_count);
    else if (how->place != place_near)
        assert_int_equal(result.statistics.patch_triangles, 0);
    tulle_detector_destroy(detector);
    assert_int_equal(heap.held, 0);
}

static void holds_few_bytes_a_triangle(void **state) {
    (void)state;
    static const uint32_t sides[] = {50, 100, MOST_SIDE};
    static const memory_case cases[] = {{"patches", TULLE_DETECT_PATCHES, place},
                                        {"patches, near layers", TULLE_DETECT_PATCHES, place_near},
                                        {"refit", TULLE_DETECT_REFIT, place},
                                        {"patches that are let go", TULLE_DETECT_PATCHES, crumple}};
    for (int i = 0; i < 3; i++)
        for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) check_size(sides[i], &cases[k]);
}

/* Events of a fold whose layers meet, with one allocation that fails; negative: none. */
static tulle_status find_events(tulle_detect_method method, int flaw, uint64_t *event_count,
                                bool *has_failed) {
    enum { SIDE = 12 };
    counting_heap heap = {.left = flaw};
    tulle_detect_def def = tulle_detect_def_default();
    make_triangles(SIDE);
    fold(SIDE, 0.0, 0.06, start);
    fold(SIDE, 0.0, 0.001, end);
    def.triangles = triangles;
    def.triangle_count = 2 * SIDE * SIDE;
    def.vertex_count = (SIDE + 1) * (SIDE + 1);
    def.method = method;
    def.threads = 1;
    def.allocator = (tulle_allocator){allocate, release, &heap, 0};
    tulle_detector *detector = NULL;
    tulle_detect_result result = {0};
    tulle_status status = tulle_detector_create(&def, &detector, NULL);
    if (status == TULLE_OK)
        status = tulle_detector_find_events(detector, start, end, &result, NULL);
    *event_count = status == TULLE_OK ? result.event_count : 0;
    *has_failed = flaw >= 0 && heap.left < 0;
    tulle_detector_destroy(detector);
    assert_int_equal(heap.held, 0);
    return status;
}

/* Each allocation fails by itself: the call says so, or finds what it finds with memory. */
static void one_allocation_that_fails_hides_nothing(void **state) {
    (void)state;
    static const tulle_detect_method methods[] = {TULLE_DETECT_PATCHES, TULLE_DETECT_REFIT,
                                                  TULLE_DETECT_BVOX, TULLE_DETECT_PAPER};
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
        uint64_t whole, count;
        bool has_failed = true;
        int failures = 0;
        assert_int_equal(find_events(methods[m], -1, &whole, &has_failed), TULLE_OK);
        assert_true(whole > 0);
        has_failed = true;
        for (int flaw = 0; has_failed; flaw++) {
            tulle_status const status = find_events(methods[m], flaw, &count, &has_failed);
            assert_true(status == TULLE_OK || status == TULLE_ERROR_OUT_OF_MEMORY);
            if (status == TULLE_OK) assert_int_equal(count, whole);
            failures += status != TULLE_OK;
        }
        assert_true(failures > 10);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(holds_few_bytes_a_triangle),
                                       cmocka_unit_test(one_allocation_that_fails_hides_nothing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
