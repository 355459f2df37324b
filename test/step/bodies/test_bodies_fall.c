/* Cloth and rigid bodies fall alike: by the integrator of the cloth, whatever the step. */
#include "support/body_world.h"
#include "support/pins.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* [m] what a gap may change by in a second */
static const double GAP_CHANGE_MAX = 1e-4;
static const double SECONDS = 1.0;

/* What differs from a box at rest 5 mm over a sheet, both let go. */
typedef struct fall_case {
    const char *name;
    tulle_integrator integrator;
    double step;                /* [s] */
    double other_step;          /* [s] of every third step; 0: all are alike */
    double held_until;          /* [s] the sheet hangs on pins, the box on its script */
    double throw[3];            /* [m/s] of both */
    double angular_velocity[3]; /* [rad/s] of the box */
    double jump;                /* [m/s] what the host adds to the box's velocity, up, at 0.2 s */
} fall_case;

enum { SHEET_SIDE = 9, SHEET_COUNT = SHEET_SIDE * SHEET_SIDE };

static double find_height(const tulle_world *world) {
    tulle_cloth_id const cloth = {0, 1};
    const double *const x = tulle_cloth_get_positions(world, cloth, NULL);
    double sum = 0.0;
    for (size_t i = 0; i < SHEET_COUNT; i++) sum += x[3 * i + 2];
    return sum / SHEET_COUNT;
}

/* [m] The largest change of the height of the box over the sheet, but for what a jump gives. */
static double measure_change(const fall_case *given, double *fallen) {
    tulle_error error = {0};
    tulle_world_def def = tulle_world_def_default();
    def.integrator = given->integrator;
    def.wind.drag_coefficient = 0.0;
    def.contact_distance = 0.002;
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh sheet = small_sheet(0.3, SHEET_SIDE, 0.0);
    tulle_mesh box = bodies_make_box(0.1, 0.06, 0.05, (double[3]){0.0, 0.0, 0.1});
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.material.air_damping = 0.0;
    memcpy(cloth.velocity, given->throw, sizeof cloth.velocity);
    uint32_t all[SHEET_COUNT];
    for (uint32_t i = 0; i < SHEET_COUNT; i++) all[i] = i;
    tulle_pin const pin = make_pin(all, SHEET_COUNT, given->held_until);
    cloth.pins = &pin;
    cloth.pin_count = given->held_until > 0.0;
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, &error), TULLE_OK);
    tulle_body body = {.is_dynamic = 1, .mass = 1.0, .start_time = given->held_until};
    memcpy(body.velocity, given->throw, sizeof body.velocity);
    memcpy(body.angular_velocity, given->angular_velocity, sizeof body.angular_velocity);
    tulle_obstacle_id const id = bodies_add_obstacle(world, &box, 0.3, &body);
    if (tulle_world_start(world, &error) != TULLE_OK) fail_msg("%s", error.message);
    double const start = find_height(world);
    double const gap = bodies_get_transform(world, id).position[2] - start;
    double time = 0.0, change = 0.0, jumped_at = INFINITY;
    for (int i = 0; time < SECONDS - 1e-9; i++) {
        if (given->jump != 0.0 && time >= 0.2 && !(jumped_at <= time)) {
            tulle_transform const now = bodies_get_transform(world, id);
            double const velocity[3] = {now.velocity[0], now.velocity[1],
                                        now.velocity[2] + given->jump};
            assert_int_equal(tulle_obstacle_set_velocity(world, id, velocity, NULL, &error),
                             TULLE_OK);
            jumped_at = time;
        }
        bool const is_other = given->other_step > 0.0 && i % 3 == 2;
        time = bodies_step_by(world, is_other ? given->other_step : given->step).time;
        double const height = bodies_get_transform(world, id).position[2] - find_height(world);
        double const flown = time > jumped_at ? given->jump * (time - jumped_at) : 0.0;
        change = fmax(change, fabs(height - flown - gap));
    }
    *fallen = start - find_height(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&box);
    tulle_world_destroy(world);
    return change;
}

static void expect_together(const fall_case *given) {
    double fallen;
    double const change = measure_change(given, &fallen);
    print_message("%s, integrator %d, 1/%g s: the gap changes by %.2g mm in %.3f m\n", given->name,
                  (int)given->integrator, 1.0 / given->step, 1e3 * change, fallen);
    assert_true(change < GAP_CHANGE_MAX);
    assert_true(fabs(fallen) > 1.0); /* it has fallen, or flown */
}

static void box_and_sheet_fall_together(void **state) {
    (void)state;
    static const double steps[] = {1.0 / 30.0, 1.0 / 60.0, 1.0 / 90.0, 1.0 / 240.0};
    for (int integrator = 0; integrator < 3; integrator++)
        for (int i = 0; i < 4; i++)
            expect_together(&(fall_case){
                .name = "let go", .integrator = (tulle_integrator)integrator, .step = steps[i]});
}

static void thrown_and_turning_they_stay_together(void **state) {
    (void)state;
    for (int integrator = 0; integrator < 3; integrator++)
        expect_together(&(fall_case){.name = "thrown",
                                     .integrator = (tulle_integrator)integrator,
                                     .step = 1.0 / 60.0,
                                     .throw = {0.5, 0.0, 2.0},
                                     .angular_velocity = {0.2, 5.0, 1.0}});
}

static void steps_that_vary_keep_them_together(void **state) {
    (void)state;
    for (int integrator = 0; integrator < 3; integrator++)
        expect_together(&(fall_case){.name = "steps vary",
                                     .integrator = (tulle_integrator)integrator,
                                     .step = 1.0 / 60.0,
                                     .other_step = 1.0 / 240.0});
}

static void let_go_later_they_fall_together(void **state) {
    (void)state;
    for (int integrator = 0; integrator < 3; integrator++)
        expect_together(&(fall_case){.name = "let go later",
                                     .integrator = (tulle_integrator)integrator,
                                     .step = 1.0 / 60.0,
                                     .held_until = 0.1});
}

/* The host gives the box a velocity: it flies by that, and falls as before. */
static void a_jump_of_velocity_is_no_force(void **state) {
    (void)state;
    for (int integrator = 0; integrator < 3; integrator++)
        expect_together(&(fall_case){.name = "pushed",
                                     .integrator = (tulle_integrator)integrator,
                                     .step = 1.0 / 60.0,
                                     .jump = 0.5});
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(box_and_sheet_fall_together),
        cmocka_unit_test(thrown_and_turning_they_stay_together),
        cmocka_unit_test(steps_that_vary_keep_them_together),
        cmocka_unit_test(let_go_later_they_fall_together),
        cmocka_unit_test(a_jump_of_velocity_is_no_force),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
