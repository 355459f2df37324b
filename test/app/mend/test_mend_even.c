/* Departures evened out: where nothing departs the way is the given one to the bit; cloth that lies
 * still behind which the given one goes on stays; cloth that goes along with what is given stays
 * beside it; a stop becomes one over five frames; a tremble goes. */
#include "app/mend/even.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { FRAME_COUNT = 16 };

/* A cloth of one vertex whose given and followed heights are those of the arrays. */
static mend_surface surface = {.vertex_end = 1};
static mend_input const input = {.surfaces = &surface, .surface_count = 1, .vertex_count = 1};

/* The heights of the way; is_given tells of each frame whether the way is as given. */
static void make_way(const double *given, const double *followed, double *way, bool *is_given) {
    mend_even even;
    uint32_t done = 0;
    assert_int_equal(mend_even_open(&input, &even, NULL), TULLE_OK);
    for (uint32_t k = 0; k < FRAME_COUNT; k++) {
        double const place[3] = {0.25, -0.0, followed[k]};
        double *const next = mend_even_get_next(&even);
        next[0] = 0.25;
        next[1] = -0.0;
        next[2] = given[k];
        mend_even_add(&even, place);
        while (done < FRAME_COUNT && (done + EVEN_REACH <= k || k == FRAME_COUNT - 1)) {
            double point[3];
            assert_memory_equal(mend_even_get_given(&even, done) + 2, &given[done], sizeof *given);
            is_given[done] = mend_even_make(&even, done, 1e-6, point);
            assert_true(point[0] == 0.25 && point[1] == 0.0);
            if (is_given[done]) assert_true(signbit(point[1]));
            way[done++] = point[2];
        }
    }
    mend_even_close(&even);
}

static void clean_frames_stay(void **unused) {
    (void)unused;
    double given[FRAME_COUNT], followed[FRAME_COUNT], way[FRAME_COUNT];
    bool is_given[FRAME_COUNT];
    for (int k = 0; k < FRAME_COUNT; k++) given[k] = followed[k] = sin(3.0 * k) / 3.0;
    followed[9] += 0.1;
    make_way(given, followed, way, is_given);
    for (int k = 0; k < FRAME_COUNT; k++) {
        assert_int_equal(is_given[k],
                         k < 9 - EVEN_REACH || k > 9 + EVEN_REACH || way[k] == given[k]);
        if (is_given[k]) assert_memory_equal(&way[k], &given[k], sizeof *way);
    }
}

static void what_lies_or_goes_along_stays(void **unused) {
    (void)unused;
    double given[FRAME_COUNT], followed[FRAME_COUNT], way[FRAME_COUNT];
    bool is_given[FRAME_COUNT];
    for (int k = 0; k < FRAME_COUNT; k++) given[k] = -sin(1.7 * k) - 2.0;
    for (int k = 0; k < FRAME_COUNT; k++) followed[k] = 1.0;
    make_way(given, followed, way, is_given);
    for (int k = 0; k < FRAME_COUNT; k++) assert_true(fabs(way[k] - 1.0) < 1e-15);
    for (int k = 0; k < FRAME_COUNT; k++) followed[k] = given[k] + 0.5;
    make_way(given, followed, way, is_given);
    for (int k = 0; k < FRAME_COUNT; k++) assert_true(fabs(way[k] - followed[k]) < 1e-15);
}

static void stops_take_frames_and_trembles_go(void **unused) {
    (void)unused;
    double given[FRAME_COUNT], followed[FRAME_COUNT], way[FRAME_COUNT];
    bool is_given[FRAME_COUNT];
    for (int k = 0; k < FRAME_COUNT; k++) {
        given[k] = -k;
        followed[k] = fmax(-k, -8.0);
    }
    make_way(given, followed, way, is_given);
    for (int k = 1; k + 1 < FRAME_COUNT; k++) {
        double const acceleration = way[k - 1] - 2.0 * way[k] + way[k + 1];
        static const double stop[] = {1.0, 4.0, 6.0, 4.0, 1.0};
        double const expected = k < 6 || k > 10 ? 0.0 : stop[k - 6] / 16.0;
        if (k < FRAME_COUNT - 3) assert_true(fabs(acceleration - expected) < 1e-12);
        assert_true(way[k] >= followed[k]); /* above what stopped it */
    }
    for (int k = 0; k < FRAME_COUNT; k++) followed[k] = 3.0 - k + (k % 2 == 0 ? 0.1 : -0.1);
    make_way(given, followed, way, is_given);
    for (int k = EVEN_REACH; k < FRAME_COUNT - EVEN_REACH; k++)
        assert_true(fabs(way[k] - (3.0 - k)) < 1e-12);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(clean_frames_stay),
                                       cmocka_unit_test(what_lies_or_goes_along_stays),
                                       cmocka_unit_test(stops_take_frames_and_trembles_go)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
