/* Bodies asleep on cloth: they sleep on as long as it presses as it did. */
#include "support/body_world.h"
#include "support/pins.h"
#include "support/test_support.h"
#include "tulle/tulle.h"

#include <math.h>

enum { STACK = 3 };
#define SLEEP_SPEED 0.01
#define SLEEP_TIME 0.3

/* A box sleeps on a sheet that is held at its corners. A light sheet that falls on it lets it
 * sleep, a heavy one does not; when its own lets go, it falls. */
static void cloth_wakes_as_it_presses(void **state) {
    (void)state;
    for (int is_heavy = 0; is_heavy < 2; is_heavy++) {
        tulle_world_def def = tulle_world_def_default();
        tulle_world *const world = bodies_make_world(&def, false);
        tulle_mesh sheet = small_sheet(0.6, 9, 0.0), cover = small_sheet(0.4, 7, 0.5);
        uint32_t const corners[4] = {0, 8, 72, 80};
        tulle_pin const pin = make_pin(corners, 4, 6.0);
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&sheet);
        cloth.pins = &pin;
        cloth.pin_count = 1;
        cloth.material.air_damping = 5.0;
        assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
        uint32_t all[49];
        for (uint32_t i = 0; i < 49; i++) all[i] = i;
        tulle_pin const hold = make_pin(all, 49, 4.0);
        cloth.mesh = tulle_mesh_get_view(&cover);
        cloth.pins = &hold;
        cloth.material.area_density = is_heavy ? 2.0 : 0.02;
        assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
        tulle_mesh box = bodies_make_box(0.15, 0.15, 0.1, (double[3]){0.0, 0.0, 0.06});
        tulle_body const body = {.is_dynamic = 1,
                                 .mass = 0.5,
                                 .linear_damping = 3.0,
                                 .angular_damping = 3.0,
                                 .sleep_speed = SLEEP_SPEED,
                                 .sleep_time = SLEEP_TIME};
        tulle_obstacle_id const id = bodies_add_obstacle(world, &box, 0.5, &body);
        int woken_at = 0, slept_at = 0, was_asleep = 0;
        for (int i = 1; i <= 6 * 90 + 20; i++) {
            bodies_step(world);
            int const is_asleep = tulle_obstacle_is_asleep(world, id);
            if (is_asleep && !was_asleep && slept_at == 0) slept_at = i;
            if (!is_asleep && was_asleep) woken_at = i;
            if (i == 5 * 90) {
                print_message("slept at step %d, woken at %d\n", slept_at, woken_at);
                assert_true(slept_at > 0 && slept_at < 4 * 90);
                assert_int_equal(woken_at > 4 * 90, is_heavy);
            }
            was_asleep = is_asleep;
        }
        assert_int_equal(was_asleep, 0);
        assert_true(bodies_get_transform(world, id).velocity[2] < -0.5);
        tulle_mesh_destroy(&sheet);
        tulle_mesh_destroy(&cover);
        tulle_mesh_destroy(&box);
        tulle_world_destroy(world);
    }
}

/* Three boxes on one another in a hollow of a sheet that is held at its corners: cloth carries all
 * of them at the lowest. They fall asleep and sleep on, until a ball that falls on the highest
 * wakes them. */
static void a_stack_on_cloth_sleeps_on(void **state) {
    (void)state;
    enum { SIDE = 31, BALL_STEP = 8 * 90, STEPS = 10 * 90 };
    tulle_world_def def = tulle_world_def_default();
    tulle_world *const world = bodies_make_world(&def, false);
    tulle_mesh sheet = small_sheet(1.2, SIDE, 0.0);
    uint32_t const corners[4] = {0, SIDE - 1, SIDE * (SIDE - 1), SIDE * SIDE - 1};
    tulle_pin const pin = make_pin(corners, 4, INFINITY);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    assert_int_equal(tulle_material_preset("denim", &cloth.material), TULLE_OK);
    assert_int_equal(tulle_world_add_cloth(world, &cloth, NULL, NULL), TULLE_OK);
    tulle_body body = {.is_dynamic = 1,
                       .mass = 0.2,
                       .linear_damping = 3.0,
                       .angular_damping = 3.0,
                       .sleep_speed = SLEEP_SPEED,
                       .sleep_time = SLEEP_TIME};
    tulle_obstacle_id boxes[STACK];
    for (int i = 0; i < STACK; i++) {
        tulle_mesh box =
            bodies_make_box(0.25, 0.25, 0.15, (double[3]){0.01 * i, 0.005 * i, 0.1 + 0.18 * i});
        boxes[i] = bodies_add_obstacle(world, &box, 0.5, &body);
        tulle_mesh_destroy(&box);
    }
    tulle_mesh ball = bodies_make_ball(0.05, 4, (double[3]){0.02, 0.0, 1.0});
    body.start_time = BALL_STEP * BODIES_STEP;
    bodies_add_obstacle(world, &ball, 0.5, &body);
    int first = 0, slept_for = 0, woken_at = 0;
    for (int i = 1; i <= STEPS && woken_at == 0; i++) {
        bodies_step(world);
        int sleepers = 0;
        for (int b = 0; b < STACK; b++) sleepers += tulle_obstacle_is_asleep(world, boxes[b]);
        assert_true(sleepers == 0 || sleepers == STACK);
        if (sleepers > 0 && first == 0) first = i;
        slept_for += sleepers > 0;
        if (sleepers == 0 && i > BALL_STEP) woken_at = i;
    }
    print_message("slept from step %d, %d steps; woken at %d by the ball let go at %d\n", first,
                  slept_for, woken_at, BALL_STEP);
    assert_true(first > 0 && first < BALL_STEP / 2);
    assert_true(woken_at > BALL_STEP + 9);         /* no sooner than it can arrive */
    assert_int_equal(slept_for, woken_at - first); /* without a break */
    bodies_step(world); /* it may have arrived at the very end of the step that wakes them */
    assert_true(bodies_get_transform(world, boxes[STACK - 1]).velocity[2] < -SLEEP_SPEED);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
    tulle_world_destroy(world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cloth_wakes_as_it_presses),
        cmocka_unit_test(a_stack_on_cloth_sleeps_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
