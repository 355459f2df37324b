/* tulle_check_intersections against all pairs, its promises on order, threads, memory and bad
 * input, and its time on a cloth of the size it is meant for. */
#include "check/check.h"
#include "check/triangle_pair.h"

#include "base/hash.h"
#include "base/timer.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

enum { MANY = 1 << 20 };

typedef struct soup {
    double *positions;
    uint32_t *triangles;
    tulle_check_body body;
} soup;

static soup make_soup(size_t vertex_count, size_t triangle_count, int is_obstacle) {
    soup s = {.positions = calloc(3 * vertex_count, sizeof(double)),
              .triangles = calloc(3 * triangle_count, sizeof(uint32_t))};
    assert_true(s.positions && s.triangles);
    s.body = (tulle_check_body){.mesh = {s.positions, vertex_count, s.triangles, triangle_count},
                                .is_obstacle = is_obstacle};
    return s;
}

static void free_soup(soup *s) {
    free(s->positions);
    free(s->triangles);
}

/* Triangles of about `size` in the unit cube with vertices shared at random. */
static soup make_random_soup(uint64_t *state, size_t triangle_count, double size, int is_obstacle) {
    soup s = make_soup(2 * triangle_count, triangle_count, is_obstacle);
    for (size_t v = 0; v < 2 * triangle_count; v += 8) {
        double centre[3];
        for (int c = 0; c < 3; c++) centre[c] = random_uniform(state);
        for (size_t i = v; i < v + 8 && i < 2 * triangle_count; i++)
            for (size_t c = 0; c < 3; c++)
                s.positions[3 * i + c] = centre[c] + size * (random_uniform(state) - 0.5);
    }
    for (size_t t = 0; t < triangle_count; t++)
        for (size_t k = 0; k < 3; k++)
            s.triangles[3 * t + k] =
                (uint32_t)(2 * t / 8 * 8 + random_next(state) % 8) % (uint32_t)(2 * triangle_count);
    return s;
}

/* columns x rows vertices at (i, j) / (columns - 1) placed by place(u, v, x). */
static soup make_sheet(size_t columns, size_t rows, void (*place)(double, double, double[3])) {
    soup s = make_soup(columns * rows, 2 * (columns - 1) * (rows - 1), 0);
    for (size_t j = 0; j < rows; j++)
        for (size_t i = 0; i < columns; i++)
            place((double)i / (double)(columns - 1), (double)j / (double)(rows - 1),
                  &s.positions[3 * (j * columns + i)]);
    uint32_t *t = s.triangles;
    for (size_t j = 0; j + 1 < rows; j++)
        for (size_t i = 0; i + 1 < columns; i++) {
            uint32_t const a = (uint32_t)(j * columns + i), b = a + 1;
            uint32_t const c = a + (uint32_t)columns, d = c + 1;
            uint32_t const corners[6] = {a, b, d, a, d, c};
            memcpy(t, corners, sizeof corners);
            t += 6;
        }
    return s;
}

/* Folded to and fro six times, the layers 1 mm apart. */
static void place_folded(double u, double v, double x[3]) {
    double const turns = 6.0 * u, within = turns - floor(turns);
    x[0] = 0.2 * ((int)turns % 2 ? 1.0 - within : within) + 0.003 * sin(37.0 * v);
    x[1] = v + 0.001 * sin(11.0 * u);
    x[2] = 0.001 * turns + 0.0002 * sin(20.0 * v);
}

static void place_tilted(double u, double v, double x[3]) {
    x[0] = u;
    x[1] = v;
    x[2] = 0.3 * u + 0.7 * v + 0.123;
}

static check_triangle get_corners(const soup *s, size_t t) {
    check_triangle triangle;
    for (size_t k = 0; k < 3; k++) {
        triangle.vertices[k] = s->triangles[3 * t + k];
        triangle.corners[k] = &s->positions[3 * (size_t)triangle.vertices[k]];
    }
    return triangle;
}

/* All pairs of all bodies without any tree, in the promised order. */
static size_t find_all_pairs(const soup *soups, size_t count, tulle_check_pair *pairs) {
    size_t found = 0;
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t t = 0; t < soups[i].body.mesh.triangle_count; t++)
            for (uint32_t j = i; j < count; j++)
                for (uint32_t w = i == j ? t + 1 : 0; w < soups[j].body.mesh.triangle_count; w++) {
                    if (soups[i].body.is_obstacle && soups[j].body.is_obstacle) continue;
                    check_triangle const a = get_corners(&soups[i], t);
                    check_triangle const b = get_corners(&soups[j], w);
                    if (!triangles_intersect(&a, &b, i == j, NULL)) continue;
                    assert_true(found < MANY);
                    pairs[found++] = (tulle_check_pair){i, t, j, w};
                }
    return found;
}

static void judge_or_fail(const soup *soups, size_t count, int threads,
                          tulle_check_result *result) {
    tulle_check_body bodies[8];
    for (size_t i = 0; i < count; i++) bodies[i] = soups[i].body;
    tulle_error error;
    if (tulle_check_intersections(bodies, count, threads, result, &error) != TULLE_OK)
        fail_msg("%s", error.message);
}

static void trees_find_what_all_pairs_find(void **unused) {
    (void)unused;
    uint64_t state = 3;
    tulle_check_pair *const expected = malloc(MANY * sizeof *expected);
    assert_non_null(expected);
    for (int round = 0; round < 12; round++) {
        double const size = round % 3 == 0 ? 0.05 : round % 3 == 1 ? 0.3 : 3.0;
        soup soups[4];
        for (size_t i = 0; i < 4; i++)
            soups[i] = make_random_soup(&state, 60 + 40 * i, size, i % 2 == (size_t)(round % 2));
        if (round >= 6) /* on a grid, so that boxes and triangles just touch */
            for (size_t i = 0; i < 4; i++)
                for (size_t k = 0; k < 3 * soups[i].body.mesh.vertex_count; k++)
                    soups[i].positions[k] = 0.125 * floor(8.0 * soups[i].positions[k]);
        size_t const count = find_all_pairs(soups, 4, expected);
        for (int threads = 1; threads <= 4; threads++) {
            tulle_check_result result;
            judge_or_fail(soups, 4, threads, &result);
            assert_int_equal(result.pair_count, count);
            if (count > 0) assert_memory_equal(result.pairs, expected, count * sizeof *expected);
            assert_true(result.tested_pair_count >= count);
            tulle_check_result_destroy(&result);
        }
        assert_true(count > 0);
        for (size_t i = 0; i < 4; i++) free_soup(&soups[i]);
    }
    free(expected);
}

static void obstacles_are_left_alone(void **unused) {
    (void)unused;
    uint64_t state = 4;
    soup soups[2] = {make_random_soup(&state, 100, 2.0, 1), make_random_soup(&state, 100, 2.0, 1)};
    tulle_check_result result;
    judge_or_fail(soups, 2, 1, &result);
    assert_int_equal(result.pair_count, 0);
    assert_int_equal(result.tested_pair_count, 0);
    tulle_check_result_destroy(&result);
    soups[1].body.is_obstacle = 0;
    judge_or_fail(soups, 2, 1, &result);
    assert_true(result.pair_count > 100);
    for (size_t i = 0; i < result.pair_count; i++) assert_int_equal(result.pairs[i].body_b, 1);
    tulle_check_result_destroy(&result);
    free_soup(&soups[0]);
    free_soup(&soups[1]);
}

static void nothing_gives_nothing(void **unused) {
    (void)unused;
    tulle_check_result result;
    assert_int_equal(tulle_check_intersections(NULL, 0, 0, &result, NULL), TULLE_OK);
    assert_int_equal(result.pair_count, 0);
    tulle_check_result_destroy(&result);
    tulle_check_body const empty = {0};
    assert_int_equal(tulle_check_intersections(&empty, 1, 0, &result, NULL), TULLE_OK);
    assert_null(result.pairs);
    tulle_check_result_destroy(NULL);
}

static void bad_input_is_named(void **unused) {
    (void)unused;
    double positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    uint32_t triangle[3] = {0, 1, 3};
    tulle_check_body const body = {.mesh = {positions, 3, triangle, 1}};
    tulle_check_body const no_arrays = {.mesh = {NULL, 3, triangle, 1}};
    tulle_check_body const huge = {.mesh = {positions, 3, triangle, (size_t)1 << 40}};
    tulle_check_result result;
    tulle_error error;
    assert_int_equal(tulle_check_intersections(&body, 1, 1, &result, &error),
                     TULLE_ERROR_INVALID_MESH);
    assert_non_null(strstr(error.message, "triangle 0 uses vertex 3"));
    triangle[2] = 2;
    positions[4] = NAN;
    assert_int_equal(tulle_check_intersections(&body, 1, 1, &result, &error),
                     TULLE_ERROR_INVALID_MESH);
    assert_non_null(strstr(error.message, "coordinate y of vertex 1"));
    positions[4] = 0;
    assert_int_equal(tulle_check_intersections(&body, 1, -1, &result, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_check_intersections(&body, 1, 257, &result, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_check_intersections(&no_arrays, 1, 1, &result, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_check_intersections(NULL, 1, 1, &result, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_check_intersections(&body, 1, 1, NULL, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_check_intersections(&huge, 1, 1, &result, &error), TULLE_ERROR_LIMIT);
    assert_int_equal(tulle_check_intersections(&body, 1, 1, &result, &error), TULLE_OK);
    tulle_check_result_destroy(&result);
}

typedef struct failing_heap {
    long calls_left, held;
} failing_heap;

static void *allocate_or_fail(void *context, size_t byte_count) {
    failing_heap *const heap = context;
    if (heap->calls_left-- <= 0) return NULL;
    heap->held++;
    return malloc(byte_count);
}

static void release_counted(void *context, void *pointer, size_t byte_count) {
    failing_heap *const heap = context;
    (void)byte_count;
    heap->held--;
    free(pointer);
}

static void every_allocation_may_fail(void **unused) {
    (void)unused;
    uint64_t state = 6;
    soup s = make_random_soup(&state, 200, 2.0, 0);
    long failures = 0;
    for (long calls = 0;; calls++) {
        failing_heap counter = {.calls_left = calls};
        memory heap = {.allocator = {.allocate = allocate_or_fail,
                                     .release = release_counted,
                                     .context = &counter}};
        tulle_check_result result;
        tulle_status const status =
            check_intersections(&(check_settings){&heap, 2, MANY, MANY}, &s.body, 1, &result, NULL);
        if (status == TULLE_OK) {
            memory_release(&heap, result.pairs, result.pair_count * sizeof *result.pairs);
            assert_int_equal(counter.held, 0);
            break;
        }
        assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
        assert_null(result.pairs);
        assert_int_equal(counter.held, 0);
        failures++;
    }
    assert_true(failures > 10);
    free_soup(&s);
}

static void too_many_pairs_are_refused(void **unused) {
    (void)unused;
    soup s = make_soup(3, 1000, 0); /* one triangle, a thousand times */
    s.positions[3] = s.positions[7] = 1.0;
    for (size_t t = 0; t < 1000; t++)
        for (size_t k = 0; k < 3; k++) s.triangles[3 * t + k] = (uint32_t)k;
    memory heap = memory_default();
    tulle_check_result result;
    tulle_error error;
    for (int threads = 1; threads <= 3; threads++) {
        /* pairs that are looked at have a limit, too */
        assert_int_equal(check_intersections(&(check_settings){&heap, threads, MANY, 499499},
                                             &s.body, 1, &result, &error),
                         TULLE_ERROR_LIMIT);
        assert_non_null(strstr(error.message, "lie in each other's boxes"));
        assert_int_equal(heap.bytes_held, 0);
        assert_int_equal(check_intersections(&(check_settings){&heap, threads, 499499, SIZE_MAX},
                                             &s.body, 1, &result, &error),
                         TULLE_ERROR_LIMIT);
        assert_int_equal(heap.bytes_held, 0);
        assert_int_equal(check_intersections(&(check_settings){&heap, threads, 499500, 499500},
                                             &s.body, 1, &result, &error),
                         TULLE_OK);
        assert_int_equal(result.pair_count, 499500);
        for (size_t i = 0; i + 1 < result.pair_count; i++)
            assert_true(result.pairs[i].triangle_a < result.pairs[i + 1].triangle_a ||
                        result.pairs[i].triangle_b < result.pairs[i + 1].triangle_b);
        memory_release(&heap, result.pairs, result.pair_count * sizeof *result.pairs);
    }
    free_soup(&s);
}

/* Triangles on one another, each with vertices of its own: a corner in common is found before any
 * sign that floating point cannot decide. */
static void coincident_triangles_need_no_exact_signs(void **unused) {
    (void)unused;
    size_t const count = 400;
    soup s = make_soup(3 * count, count, 0);
    for (size_t i = 0; i < 3 * count; i++) {
        size_t const corner = (i + i / 3) % 3; /* turned from one to the next */
        s.positions[3 * i] = 0.1 + (double)(corner == 1);
        s.positions[3 * i + 1] = 0.3 + (double)(corner == 2);
        s.positions[3 * i + 2] = 0.7 + 0.1 * (double)corner;
        s.triangles[i] = (uint32_t)i;
    }
    tulle_check_result result;
    judge_or_fail(&s, 1, 2, &result);
    assert_int_equal(result.pair_count, count * (count - 1) / 2);
    assert_int_equal(result.exact_count, 0);
    tulle_check_result_destroy(&result);
    free_soup(&s);
}

/* Processor time [s] until a limit on pairs is reached. */
static double time_limit(const soup *s, size_t pair_limit) {
    memory heap = memory_default();
    tulle_check_result result;
    clock_t const start = clock();
    assert_int_equal(check_intersections(&(check_settings){&heap, 1, pair_limit, SIZE_MAX},
                                         &s->body, 1, &result, NULL),
                     TULLE_ERROR_LIMIT);
    return (double)(clock() - start) / CLOCKS_PER_SEC;
}

/* Pairs beyond the limit are not put in order first: a few times the work of building the trees,
 * where sorting alone is more than ten times that. */
static void the_limit_is_reached_without_sorting(void **unused) {
    (void)unused;
    size_t const count = 50000;
    soup s = make_soup(3, count, 0);
    s.positions[3] = s.positions[7] = 1.0;
    for (size_t i = 0; i < 3 * count; i++) s.triangles[i] = (uint32_t)(i % 3);
    double const trees_seconds = time_limit(&s, 1), seconds = time_limit(&s, 16 * count);
    print_message("to one pair %.1f ms, to %zu pairs %.1f ms\n", 1e3 * trees_seconds, 16 * count,
                  1e3 * seconds);
    assert_true(seconds < 8.0 * trees_seconds);
    free_soup(&s);
}

/* Prints what the judge did; returns its processor time [s] in terms of a release build. */
static double time_judge(const char *name, const soup *soups, size_t count, int threads,
                         size_t expected) {
    tulle_check_result result;
    double const start = timer_now();
    clock_t const clock_start = clock();
    judge_or_fail(soups, count, threads, &result);
    double const processor_seconds = (double)(clock() - clock_start) / CLOCKS_PER_SEC;
    double const seconds = timer_now() - start;
    size_t triangles = 0;
    for (size_t i = 0; i < count; i++) triangles += soups[i].body.mesh.triangle_count;
    print_message(
        "%s: %zu triangles, %zu pairs tested, %zu undecided by the filter, %zu intersect, "
        "%d threads: %.1f ms\n",
        name, triangles, result.tested_pair_count, result.exact_count, result.pair_count, threads,
        1e3 * seconds);
    if (expected != SIZE_MAX) assert_int_equal(result.pair_count, expected);
    tulle_check_result_destroy(&result);
    return processor_seconds / TULLE_TIME_FACTOR;
}

/* A cloth of 19,208 triangles in six layers over an obstacle of 20,000: the size of a test scene.
 */
static void a_frame_takes_less_than_a_second(void **unused) {
    (void)unused;
    soup soups[2] = {make_sheet(99, 99, place_folded), make_sheet(101, 101, place_tilted)};
    for (size_t i = 0; i < 101 * 101; i++) soups[1].positions[3 * i + 2] = -0.01;
    soups[1].body.is_obstacle = 1;
    for (int threads = 1; threads <= 2; threads++)
        assert_true(time_judge("folded cloth", soups, 2, threads, 0) < 1.0);
    for (size_t i = 0; i < 101 * 101; i++) soups[1].positions[3 * i + 2] = 0.0025;
    tulle_check_result result;
    judge_or_fail(soups, 2, 1, &result);
    assert_true(result.pair_count > 100);
    tulle_check_result_destroy(&result);
    free_soup(&soups[0]);
    free_soup(&soups[1]);
    soup tilted = make_sheet(99, 99, place_tilted); /* flat, but for rounding of the heights */
    assert_true(time_judge("tilted sheet", &tilted, 1, 1, 0) < 1.0);
    free_soup(&tilted);
}

/* Inputs that defeat careless trees: a far outlier, equal centres, and the worst for any tree of
 * boxes, slivers along a diagonal of which all boxes meet and no two triangles do. */
static void adversarial_soups_stay_fast(void **unused) {
    (void)unused;
    uint64_t state = 8;
    soup outlier = make_random_soup(&state, 50000, 0.01, 0);
    outlier.positions[0] = 1e300;
    assert_true(time_judge("far outlier", &outlier, 1, 1, SIZE_MAX) < 5.0);
    free_soup(&outlier);

    size_t const count = 3000;
    soup stacked = make_soup(3 * count, count, 0);
    for (size_t t = 0; t < count; t++)
        for (size_t k = 0; k < 3; k++) { /* all centred at the origin but for the height */
            double *const x = &stacked.positions[9 * t + 3 * k];
            stacked.triangles[3 * t + k] = (uint32_t)(3 * t + k);
            x[0] = k == 1 ? 1.0 : -1.0;
            x[1] = k == 2 ? 1.0 : -1.0;
            x[2] = 1e-3 * (double)t;
        }
    assert_true(time_judge("stacked", &stacked, 1, 1, 0) < 5.0);
    for (size_t t = 0; t < count; t++)
        for (size_t k = 0; k < 3; k++) {
            double *const x = &stacked.positions[9 * t + 3 * k];
            double const along = k == 1 ? 1000.0 : 0.0, aside = 0.01 * (double)t;
            x[0] = along + aside;
            x[1] = along - aside;
            x[2] = along + (k == 2 ? 0.001 : 0.0);
        }
    assert_true(time_judge("diagonal slivers", &stacked, 1, 1, 0) < 5.0);
    free_soup(&stacked);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_find_what_all_pairs_find),
        cmocka_unit_test(obstacles_are_left_alone),
        cmocka_unit_test(nothing_gives_nothing),
        cmocka_unit_test(bad_input_is_named),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(too_many_pairs_are_refused),
        cmocka_unit_test(coincident_triangles_need_no_exact_signs),
        cmocka_unit_test(the_limit_is_reached_without_sorting),
        cmocka_unit_test(a_frame_takes_less_than_a_second),
        cmocka_unit_test(adversarial_soups_stay_fast),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
