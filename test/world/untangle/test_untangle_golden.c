/* Untangling has the same bits everywhere: hashes of the states that it makes of small starts, for
 * one and three threads, against constants that hold for every build. Many ways lead to a clean
 * start, so that a clean one does not show that this one was taken. The starts are made without the
 * system's mathematics library, whose last bits differ between versions. A hash that moves means
 * that results changed: see test/world/test_golden.c. */
#include "support/small_world.h"

#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>

#include <cmocka.h>

enum { SIDE = 13 };
static const double WIDTH = 0.3; /* [m] of a sheet */

/* Makes a sheet's rest shape a start: x and y are -1 .. 1, the point is in metres. */
typedef void place_vertex(double x, double y, double *point);

/* Leans by 3 : 4 and has ripples, through the sheet in the plane. */
static void thrust(double x, double y, double *point) {
    point[0] = 0.8 * 0.15 * x + 0.09;
    point[1] = 0.15 * y + 0.01;
    point[2] = 0.6 * 0.15 * x - 0.03 + 0.02 * y * (1.0 - y * y) + 0.01 * x * y;
}

/* Over the border of the plane with one corner only. */
static void poke(double x, double y, double *point) {
    point[0] = 0.15 * x + 0.21;
    point[1] = 0.15 * y + 0.2;
    point[2] = 0.06 + 0.05 * (x + y) + 0.01 * x * y;
}

/* In one plane with the other, a little aside. */
static void overlay(double x, double y, double *point) {
    point[0] = 0.15 * x + 0.013;
    point[1] = 0.15 * y + 0.007;
    point[2] = 0.0;
}

static void lie_flat(double x, double y, double *point) {
    point[0] = 0.15 * x;
    point[1] = 0.15 * y;
    point[2] = 0.0;
}

/* Through itself along a line, as the loop of a nodal cubic. */
static void loop(double x, double y, double *point) {
    double const t = 1.3 * x;
    point[0] = 0.09 * t * (t * t - 1.0) + 0.004 * y;
    point[1] = 0.15 * y;
    point[2] = 0.09 * t * t + 0.02 * y * x;
}

/* Crumpled: folded through itself in both directions. */
static void crumple(double x, double y, double *point) {
    point[0] = 0.12 * x * (1.6 * x * x - 0.7) + 0.02 * y * y;
    point[1] = 0.12 * y + 0.03 * x * x * y;
    point[2] = 0.03 * x * x + 0.02 * y * (x - y);
}

/* A border in a box of a few large triangles. */
static void dip(double x, double y, double *point) {
    point[0] = 0.15 * x + 0.17;
    point[1] = 0.15 * y + 0.013;
    point[2] = 0.04 * x * x + 0.01 * y;
}

/* A small dome that comes through the plane with over half of its area. By itself that half would
 * be the right one; along it lies the smaller part of the plane. */
static void bulge(double x, double y, double *point) {
    point[0] = 0.11 * x + 0.006;
    point[1] = 0.11 * y + 0.004;
    point[2] = 0.012 * (1.0 - (point[0] * point[0] + point[1] * point[1]) / 0.0091);
}

/* Through two bars that are longer than it is wide. */
static void lie_in_bars(double x, double y, double *point) {
    point[0] = 0.15 * x + 0.003;
    point[1] = 0.15 * y;
    point[2] = 0.004 * y + 0.003 * x * y;
}

typedef struct golden_start {
    const char *name;
    place_vertex *first, *second; /* second: may be null */
    int box_count;
    uint64_t hash;
} golden_start;

static tulle_mesh make_sheet(place_vertex *place) {
    tulle_mesh sheet = small_sheet(WIDTH, SIDE, 0.0);
    for (size_t v = 0; v < sheet.vertex_count; v++) {
        double *const point = sheet.positions + 3 * v;
        place(point[0] / (0.5 * WIDTH), point[1] / (0.5 * WIDTH), point);
    }
    return sheet;
}

static uint64_t untangle(const golden_start *start, int threads) {
    tulle_world_def def = tulle_world_def_default();
    def.start_intersections = TULLE_START_UNTANGLE;
    def.threads = threads;
    tulle_world *world = NULL;
    assert_int_equal(tulle_world_create(&def, &world, NULL), TULLE_OK);
    tulle_mesh flat = small_sheet(WIDTH, SIDE, 0.0);
    tulle_mesh sheets[2] = {make_sheet(start->first), {0}};
    size_t const count = start->second ? 2 : 1;
    if (count == 2) sheets[1] = make_sheet(start->second);
    for (size_t i = 0; i < count; i++) {
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&sheets[i]);
        cloth.rest_positions = flat.positions;
        assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    }
    tulle_mesh boxes[2];
    for (int k = 0; k < start->box_count; k++) {
        bool const is_bar = start->box_count == 2;
        tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_BOX);
        shape.size[0] = is_bar ? 0.04 : 0.24;
        shape.size[1] = is_bar ? 0.4 : 0.24;
        shape.size[2] = is_bar ? 0.03 : 0.1;
        boxes[k] = small_shape(shape, is_bar ? 0.16 * k - 0.08 : 0.0, 0.0, is_bar ? 0.006 : 0.0);
        small_add_obstacle(world, &boxes[k]);
    }
    tulle_error error = {0};
    if (tulle_world_start(world, &error) != TULLE_OK)
        fail_msg("%s: %s", start->name, error.message);
    tulle_untangle_report const report = tulle_world_get_untangle_report(world);
    if (threads == 1)
        print_message("%s: %d pairs, %d rounds\n", start->name, (int)report.intersections,
                      (int)report.rounds);
    assert_true(report.intersections > 10 && report.rounds > 1);
    assert_int_equal(small_judge(world, sheets, count, boxes, (size_t)start->box_count), 0);
    uint64_t const hash = tulle_world_get_state_hash(world);
    tulle_world_destroy(world);
    for (size_t i = 0; i < count; i++) tulle_mesh_destroy(&sheets[i]);
    tulle_mesh_destroy(&flat);
    for (int k = 0; k < start->box_count; k++) tulle_mesh_destroy(&boxes[k]);
    return hash;
}

static void hashes_are_the_golden_ones(void **state) {
    (void)state;
    static const golden_start starts[] = {
        {"thrust", lie_flat, thrust, 0, UINT64_C(0x6d5d64547d5a2b78)},
        {"poke", lie_flat, poke, 0, UINT64_C(0xa8b2aa1c18d05dfb)},
        {"overlay", lie_flat, overlay, 0, UINT64_C(0xa6182768099c3952)},
        {"loop", loop, NULL, 0, UINT64_C(0xf68c1775540f2735)},
        {"crumple", crumple, NULL, 0, UINT64_C(0x699342081e65f84c)},
        {"dip", dip, NULL, 1, UINT64_C(0x5ba8fdb3803f1331)},
        {"bulge", lie_flat, bulge, 0, UINT64_C(0x72421fce2a88937c)},
        {"bars", lie_in_bars, NULL, 2, UINT64_C(0x85ef72cf162422fd)},
    };
    int wrong_count = 0;
    for (size_t i = 0; i < sizeof starts / sizeof *starts; i++) {
        for (int threads = 1; threads <= 3; threads += 2) {
            uint64_t const hash = untangle(&starts[i], threads);
            if (hash == starts[i].hash) continue;
            print_message("%s, %d threads: the hash is UINT64_C(0x%016" PRIx64 ")\n",
                          starts[i].name, threads, hash);
            wrong_count++;
        }
    }
    assert_int_equal(wrong_count, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(hashes_are_the_golden_ones)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
