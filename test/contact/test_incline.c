/* Coulomb friction against closed forms: a 0.3 m patch on an inclined plane, friction 0.5 (critical
 * angle 26.565 degrees). */
#include "support/contact_world.h"
#include "support/test_support.h"

#include <stdio.h>
#include <stdlib.h>

#define TIME_STEP (1.0 / 90.0)
#define CONTACT_DISTANCE 3e-3
#define DEGREE 0.017453292519943295

typedef struct slope_result {
    double drift;        /* [m] of the mean position since the first tenth of a second */
    double speed;        /* [m/s] down the slope at the end */
    double acceleration; /* [m/s^2] over the second half */
    uint64_t rescues;
} slope_result;

/* The patch lies on a horizontal plane at the contact distance; gravity is tilted instead. */
static void make_slope(contact_world *world, double angle, uint32_t resolution, int threads) {
    *world = contact_world_make();
    world->def.contact_distance = CONTACT_DISTANCE;
    world->def.threads = threads;
    world->def.gravity[0] = 9.81 * sin(angle);
    world->def.gravity[2] = -9.81 * cos(angle);
    contact_grid patch =
        make_contact_grid(resolution, resolution, vec3_make(-0.15, -0.15, CONTACT_DISTANCE),
                          vec3_make(0.3, 0.0, 0.0), vec3_make(0.0, 0.3, 0.0));
    contact_grid plane = make_contact_grid(12, 8, vec3_make(-1.0, -1.03, 0.0),
                                           vec3_make(6.0, 0.0, 0.0), vec3_make(0.0, 2.0, 0.0));
    add_contact_surface(world, patch.mesh, false);
    add_contact_surface(world, plane.mesh, true);
    start_contact_world(world);
    free_contact_grid(&patch);
    free_contact_grid(&plane);
}

static double mean_of(const contact_world *world, const double *values) {
    double sum = 0.0;
    for (size_t i = 0; i < world->cloth_vertex_count; i++) sum += values[3 * i];
    return sum / (double)world->cloth_vertex_count;
}

static slope_result run_slope(double degrees, double seconds) {
    contact_world world;
    make_slope(&world, degrees * DEGREE, 16, 1);
    int const steps = (int)(seconds / TIME_STEP + 0.5);
    double settled = 0.0, half_speed = 0.0;
    for (int i = 0; i < steps; i++) {
        assert_int_equal(step_contact_world(&world, TIME_STEP), TULLE_OK);
        if (i == 8) settled = mean_of(&world, world.x0);
        if (i == steps / 2 - 1) half_speed = mean_of(&world, world.velocities);
    }
    assert_int_equal(judge_contact_world(&world), 0);
    slope_result result = {.drift = fabs(mean_of(&world, world.x0) - settled),
                           .speed = mean_of(&world, world.velocities),
                           .rescues = world.rescue_count};
    result.acceleration = (result.speed - half_speed) / ((steps - steps / 2) * TIME_STEP);
    print_message("%5.1f deg %4.1f s: drift %.3g m, speed %.5g m/s, acceleration %.5g, rows %zu, "
                  "rescues %llu, %.2f ms in the last step\n",
                  degrees, seconds, result.drift, result.speed, result.acceleration,
                  world.rows->rows.count, (unsigned long long)result.rescues,
                  1e3 * world.report.total_seconds);
    contact_world_destroy(&world);
    return result;
}

static double expected_acceleration(double degrees) {
    return 9.81 * (sin(degrees * DEGREE) - 0.5 * cos(degrees * DEGREE));
}

static void holds_below_the_critical_angle(void **state) {
    (void)state;
    slope_result const result = run_slope(26.0, getenv("TULLE_TEST_LONG") ? 60.0 : 4.0);
    assert_true(result.drift < 1e-6);
    assert_int_equal(result.rescues, 0);
}

static void slides_above_the_critical_angle(void **state) {
    (void)state;
    slope_result const result = run_slope(27.0, 2.0);
    assert_true(result.speed > 0.14 && result.speed < 0.17);
}

static void accelerates_as_coulomb_says(void **state) {
    (void)state;
    slope_result const result = run_slope(40.0, 1.0);
    assert_true(fabs(result.acceleration / expected_acceleration(40.0) - 1.0) < 0.01);
    assert_true(fabs(result.speed / (expected_acceleration(40.0) * 1.0) - 1.0) < 0.01);
    assert_int_equal(result.rescues, 0);
}

static void threads_change_no_bit(void **state) {
    (void)state;
    uint64_t hashes[3];
    for (int i = 0; i < 3; i++) {
        contact_world world;
        make_slope(&world, 40.0 * DEGREE, 16, 1 + i);
        for (int step = 0; step < 20; step++)
            assert_int_equal(step_contact_world(&world, TIME_STEP), TULLE_OK);
        hashes[i] = tulle_world_get_state_hash(world.world);
        contact_world_destroy(&world);
    }
    assert_true(hashes[0] == hashes[1] && hashes[0] == hashes[2]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(holds_below_the_critical_angle),
        cmocka_unit_test(slides_above_the_critical_angle),
        cmocka_unit_test(accelerates_as_coulomb_says),
        cmocka_unit_test(threads_change_no_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
