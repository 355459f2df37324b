/* A pair that starts just over the minimum gap is a hit if it comes under it, by however little.
 * One that starts under it may come nearer by a millionth. */
#include "contact/pairs/path_test.h"

#include "contact/pairs/pair_rules.h"
#include "support/contact_world.h"
#include "support/test_support.h"

#include <string.h>

#define TIME_STEP (1.0 / 90.0)

/* Hits of two sheets, one over the other: gaps of the start and the end, over the minimum gap. */
static size_t count_hits(double start, double end) {
    contact_world world = contact_world_make();
    for (int i = 0; i < 2; i++) {
        contact_grid sheet = make_contact_grid(3, 3, vec3_make(0.013 * i, 0.007 * i, 0.01 * i),
                                               vec3_make(0.1, 0.0, 0.0), vec3_make(0.0, 0.1, 0.0));
        add_contact_surface(&world, sheet.mesh, false);
        free_contact_grid(&sheet);
    }
    start_contact_world(&world);
    double const gap = world.settings.minimum_gap;
    memcpy(world.x1, world.x0, 3 * world.vertex_count * sizeof(double));
    for (size_t v = world.surfaces[1].vertex_begin; v < world.vertex_count; v++) {
        world.x0[3 * v + 2] = start * gap;
        world.x1[3 * v + 2] = end * gap;
    }
    contact_scene const scene = get_contact_scene(&world, TIME_STEP);
    pair_source *const source = find_contact_pairs(&world, world.x1);
    arena_mark const mark = arena_get_mark(scene.scratch);
    pair_events hits = {0};
    assert_int_equal(find_hits(&scene, source, world.x1, NULL, &hits), TULLE_OK);
    size_t const count = hits.count;
    arena_release(scene.scratch, mark);
    contact_world_destroy(&world);
    return count;
}

static void who_keeps_the_gap_may_not_lose_it(void **state) {
    (void)state;
    assert_int_equal(count_hits(1.0 + 5e-7, 1.0 + 2e-7), 0);
    assert_true(count_hits(1.0 + 5e-7, 1.0 - 3e-7) > 0);
    assert_true(count_hits(2.0, 1.0 - 3e-7) > 0);
}

static void who_starts_below_the_gap_may_come_nearer_by_a_millionth(void **state) {
    (void)state;
    assert_int_equal(count_hits(0.9, 0.9 * (1.0 - 5e-7)), 0);
    assert_true(count_hits(0.9, 0.9 * (1.0 - 2e-6)) > 0);
}

/* The slack for rounding is that of the largest coordinate, wherever it stands. */
static void the_largest_coordinate_sets_the_slack(void **state) {
    (void)state;
    enum { COORDINATES = 27 };
    double places[2][COORDINATES];
    for (int i = 0; i < COORDINATES; i++) places[0][i] = places[1][i] = i % 2 ? -1.0 : 0.5;
    contact_scene const scene = {.x0 = places[0], .vertex_count = COORDINATES / 3};
    double const slack = compute_rounding_slack(&scene, places[1]);
    assert_true(slack > 0.0 && slack < 1e-12);
    for (int array = 0; array < 2; array++)
        for (int i = 0; i < COORDINATES; i++) {
            double const kept = places[array][i];
            places[array][i] = i % 3 ? 8.0 : -8.0;
            assert_true(compute_rounding_slack(&scene, places[1]) == 8.0 * slack);
            places[array][i] = kept;
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(who_keeps_the_gap_may_not_lose_it),
        cmocka_unit_test(who_starts_below_the_gap_may_come_nearer_by_a_millionth),
        cmocka_unit_test(the_largest_coordinate_sets_the_slack),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
