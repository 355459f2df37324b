/* Whole steps of contact on what tears cloth in weaker schemes: spike tips, and a plate that starts
 * to move at once. Every state is judged; rescue stays away. */
#include "support/contact_world.h"
#include "support/test_support.h"

#include <stdlib.h>

#define TIME_STEP (1.0 / 90.0)

/* Peak stretch, and at the end, of a sheet that falls on three spikes at a place of its own. */
static void drop_on_spikes(int place, double *peak, double *last) {
    contact_world world = contact_world_make();
    world.def.contact_distance = 4e-3;
    vec3 const corner = {-0.25 + 0.001 * place, -0.25 + 0.0007 * place, 0.24};
    contact_grid sheet =
        make_contact_grid(21, 21, corner, vec3_make(0.5, 0.0, 0.0), vec3_make(0.0, 0.5, 0.0));
    add_contact_surface(&world, sheet.mesh, false);
    free_contact_grid(&sheet);
    add_contact_spike(&world, vec3_make(-0.1, 0.013, 0.0), 0.2);
    add_contact_spike(&world, vec3_make(0.011, -0.03, 0.0), 0.2);
    add_contact_spike(&world, vec3_make(0.12, 0.05, 0.0), 0.2);
    start_contact_world(&world);
    *peak = 0.0;
    for (int step = 0; step < 60; step++) {
        assert_int_equal(step_contact_world(&world, TIME_STEP), TULLE_OK);
        assert_int_equal(judge_contact_world(&world), 0);
        assert_true(world.report.smallest_gap >= world.settings.minimum_gap);
        *peak = fmax(*peak, measure_contact_stretch(&world));
    }
    *last = measure_contact_stretch(&world);
    assert_int_equal(world.rescue_count, 0);
    contact_world_destroy(&world);
}

/* The tips stay outside without rescue, and the cloth takes back what the landing stretched. */
static void sheet_falls_on_spikes(void **state) {
    (void)state;
    enum { PLACES = 4 };
    for (int place = 0; place < PLACES; place++) {
        double peak, last;
        drop_on_spikes(2 * place, &peak, &last);
        print_message("spikes: peak stretch %.3f, at the end %.3f\n", peak, last);
        assert_true(last < 1.05);
    }
}

/* At rest for 0.2 s, then upwards at 2 m/s and a little sideways. */
static tulle_keyframe const lift[] = {
    {.rotation_vector = {0, 0, 0}},
    {.time = 0.2, .rotation_vector = {0, 0, 0}},
    {.time = 2.2, .translation = {0.4, 0.0, 4.0}, .rotation_vector = {0, 0, 0}}};

static void plate_throws_the_sheet_up(void **state) {
    (void)state;
    contact_world world = contact_world_make();
    contact_grid sheet = make_contact_grid(11, 11, vec3_make(-0.1, -0.1, 3e-3),
                                           vec3_make(0.2, 0.0, 0.0), vec3_make(0.0, 0.2, 0.0));
    contact_grid plate = make_contact_grid(5, 6, vec3_make(-0.2, -0.2, 0.0),
                                           vec3_make(0.4, 0.0, 0.0), vec3_make(0.0, 0.4, 0.0));
    add_contact_surface(&world, sheet.mesh, false);
    add_contact_surface(&world, plate.mesh, true);
    free_contact_grid(&sheet);
    free_contact_grid(&plate);
    world.motions[1] = (tulle_motion){.keys = lift, .key_count = 3};
    start_contact_world(&world);
    for (int step = 0; step < 45; step++) {
        assert_int_equal(step_contact_world(&world, TIME_STEP), TULLE_OK);
        assert_int_equal(judge_contact_world(&world), 0);
    }
    /* It rides on the plate: as fast, and at the contact distance. */
    for (size_t i = 0; i < world.cloth_vertex_count; i++) {
        assert_true(fabs(world.velocities[3 * i + 2] - 2.0) < 1e-3);
        assert_true(fabs(world.velocities[3 * i] - 0.2) < 1e-3);
        double const gap = world.x0[3 * i + 2] - world.x0[3 * world.cloth_vertex_count + 2];
        assert_true(fabs(gap - world.def.contact_distance) < 2e-4);
    }
    assert_int_equal(world.rescue_count, 0);
    contact_world_destroy(&world);
}

static double sum_normal_impulses(const contact_world *world) {
    double sum = 0.0;
    for (size_t i = 0; i < world->rows->rows.count; i++)
        sum += vec3_dot(world->rows->rows.data[i].solve.impulse,
                        world->rows->rows.data[i].frame.normal);
    return sum;
}

/* Two plates leave a sheet four fifths of its contact distance on either side. Both push; neither
 * can have its way, and what they push with must come to an end. */
static void push_out_between_plates_is_bounded(void **state) {
    (void)state;
    contact_world world = contact_world_make();
    double const gap = 0.8 * world.def.contact_distance;
    contact_grid sheet = make_contact_grid(7, 7, vec3_make(-0.1, -0.1, 0.0),
                                           vec3_make(0.2, 0.0, 0.0), vec3_make(0.0, 0.2, 0.0));
    contact_grid below = make_contact_grid(5, 6, vec3_make(-0.2, -0.2, -gap),
                                           vec3_make(0.4, 0.0, 0.0), vec3_make(0.0, 0.4, 0.0));
    contact_grid above = make_contact_grid(6, 5, vec3_make(-0.2, -0.2, gap),
                                           vec3_make(0.4, 0.0, 0.0), vec3_make(0.0, 0.4, 0.0));
    add_contact_surface(&world, sheet.mesh, false);
    add_contact_surface(&world, below.mesh, true);
    add_contact_surface(&world, above.mesh, true);
    free_contact_grid(&sheet);
    free_contact_grid(&below);
    free_contact_grid(&above);
    start_contact_world(&world);
    double largest[3] = {0.0};
    for (int step = 0; step < 900; step++) {
        assert_int_equal(step_contact_world(&world, TIME_STEP), TULLE_OK);
        largest[step / 300] = fmax(largest[step / 300], sum_normal_impulses(&world));
    }
    double fastest = 0.0;
    for (size_t i = 0; i < world.cloth_vertex_count; i++)
        fastest = fmax(fastest, vec3_norm(vec3_load(world.velocities, i)));
    print_message("between plates: normal impulses up to %.3g, %.3g, %.3g N s, fastest %.3g m/s\n",
                  largest[0], largest[1], largest[2], fastest);
    assert_true(largest[0] > 0.0 && largest[2] < 1.2 * largest[1]);
    assert_true(fastest < 1e-6);
    contact_world_destroy(&world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sheet_falls_on_spikes),
        cmocka_unit_test(plate_throws_the_sheet_up),
        cmocka_unit_test(push_out_between_plates_is_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
