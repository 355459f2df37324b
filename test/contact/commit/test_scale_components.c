/* What hits connect goes one part of its way: nine tenths of the earliest time of all its hits, in
 * whatever order these come. */
#include "contact/commit/scale_components.h"

#include "support/contact_world.h"
#include "support/test_support.h"

#include <string.h>

#define TIME_STEP (1.0 / 90.0)

enum { SIDE = 6, COUNT = SIDE * SIDE, HITS = 3 };

/* Vertices of the hits {vertex, triangle}; the third joins the components of the others. */
static void shorten(const double times[HITS], bool stop) {
    contact_world world = contact_world_make();
    contact_grid sheet = make_contact_grid(SIDE, SIDE, vec3_make(0.0, 0.0, 0.0),
                                           vec3_make(0.1, 0.0, 0.0), vec3_make(0.0, 0.1, 0.0));
    add_contact_surface(&world, sheet.mesh, false);
    start_contact_world(&world);
    free_contact_grid(&sheet);
    double base[3 * COUNT], x1[3 * COUNT];
    for (size_t i = 0; i < 3 * COUNT; i++) {
        world.u[i] = 0.1 + 0.01 * (double)(i % 7);
        base[i] = x1[i] = world.x0[i] + TIME_STEP * world.u[i];
    }
    contact_scene const scene = get_contact_scene(&world, TIME_STEP);
    scaled_components components = {0};
    assert_true(scaled_components_make(&components, &scene, x1, world.u));
    uint32_t const last = (uint32_t)world.triangle_count - 1;
    pair_event const events[HITS] = {
        {.kind = FEATURE_VERTEX_TRIANGLE, .pair = {COUNT - SIDE, last}, .time = times[0]},
        {.kind = FEATURE_VERTEX_TRIANGLE, .pair = {SIDE - 1, 0}, .time = times[1]},
        {.kind = FEATURE_VERTEX_TRIANGLE, .pair = {COUNT - SIDE, 0}, .time = times[2]}};
    bool is_in[COUNT] = {false};
    for (int i = 0; i < HITS; i++) {
        is_in[events[i].pair.first] = true;
        for (size_t k = 0; k < 3; k++)
            is_in[world.triangles[3 * (size_t)events[i].pair.second + k]] = true;
    }
    pair_events const hits = {.events = (pair_event *)(uintptr_t)events, .count = HITS};
    assert_int_equal(scale_components(&scene, &components, &hits, stop, world.u, x1), 1);
    double const part = stop ? 0.0 : 0.9 * fmin(times[0], fmin(times[1], times[2]));
    size_t count = 0;
    for (size_t v = 0; v < COUNT; v++) {
        count += is_in[v];
        for (size_t i = 3 * v; i < 3 * v + 3; i++) {
            double const end = world.x0[i] + (is_in[v] ? part : 1.0) * (base[i] - world.x0[i]);
            assert_true(fabs(x1[i] - end) < 1e-15);
            assert_true(fabs(world.u[i] - (end - world.x0[i]) / TIME_STEP) < 1e-12);
        }
    }
    assert_int_equal(count, 3 + 3 + 2);
    contact_world_destroy(&world);
}

static void the_earliest_hit_counts_for_all(void **state) {
    (void)state;
    for (int first = 0; first < HITS; first++) {
        double times[HITS] = {0.8, 0.8, 0.8};
        times[first] = 0.3;
        shorten(times, false);
        shorten(times, true);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_earliest_hit_counts_for_all)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
