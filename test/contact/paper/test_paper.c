/* The paper's response on small scenes: static and sliding friction on a slope, layers, spikes.
 * What it does worse than the coupled response is asserted too, where it is a matter of rule. */
#include "support/mini_world.h"
#include "support/test_support.h"

#define TIME_STEP (1.0 / 90.0)
#define CONTACT_DISTANCE 3e-3
#define DEGREE 0.017453292519943295

static const char *const space_names[] = {"cone", "polyhedral"};

static mini_world make_world(tulle_motion_space space) {
    mini_world world = mini_world_make();
    world.uses_paper = true;
    world.motion_space = space;
    world.contact_distance = CONTACT_DISTANCE;
    return world;
}

static void add_grid(mini_world *world, uint32_t n, double size, double height, bool is_obstacle) {
    mini_grid grid = make_mini_grid(n, n, vec3_make(-0.5 * size, -0.5 * size, height),
                                    vec3_make(size, 0.0, 0.0), vec3_make(0.0, size, 0.0));
    add_mini_surface(world, grid.mesh, is_obstacle);
    free_mini_grid(&grid);
}

/* Means over the vertices of a surface. */
static vec3 mean_of(const mini_world *world, size_t surface, const double *values) {
    const surface_range *const range = &world->surfaces[surface];
    vec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = range->vertex_begin; i < range->vertex_end; i++)
        sum = vec3_add(sum, vec3_load(values, i));
    return vec3_scale(sum, 1.0 / (range->vertex_end - range->vertex_begin));
}

/* Every state is judged. */
static void take_steps(mini_world *world, int count, double time_step) {
    for (int i = 0; i < count; i++) {
        assert_int_equal(step_mini_world(world, time_step), TULLE_OK);
        assert_int_equal(judge_mini_world(world), 0);
        assert_true(world->commit.smallest_gap >= world->settings.minimum_gap);
    }
}

typedef struct slope_result {
    double drift, speed, acceleration;
} slope_result;

/* A patch on a plane at the contact distance; gravity is tilted instead of the plane. */
static slope_result run_slope(tulle_motion_space space, double degrees, double seconds) {
    mini_world world = make_world(space);
    world.gravity[0] = 9.81 * sin(degrees * DEGREE);
    world.gravity[2] = -9.81 * cos(degrees * DEGREE);
    add_grid(&world, 9, 0.3, CONTACT_DISTANCE, false);
    mini_grid plane = make_mini_grid(12, 8, vec3_make(-1.0, -1.03, 0.0), vec3_make(6.0, 0.0, 0.0),
                                     vec3_make(0.0, 2.0, 0.0));
    add_mini_surface(&world, plane.mesh, true);
    free_mini_grid(&plane);
    start_mini_world(&world);
    int const steps = (int)(seconds / TIME_STEP + 0.5);
    take_steps(&world, 9, TIME_STEP);
    double const settled = mean_of(&world, 0, world.x0).x;
    take_steps(&world, steps / 2 - 9, TIME_STEP);
    double const half_speed = mean_of(&world, 0, world.velocities).x;
    take_steps(&world, steps - steps / 2, TIME_STEP);
    slope_result result = {.drift = mean_of(&world, 0, world.x0).x - settled,
                           .speed = mean_of(&world, 0, world.velocities).x};
    result.acceleration = (result.speed - half_speed) / ((steps - steps / 2) * TIME_STEP);
    print_message("%s, %.4g deg, %.3g s: drift %.3g m, speed %.5g m/s, acceleration %.5g m/s^2, "
                  "height %.3g, rescues %llu\n",
                  space_names[space], degrees, seconds, result.drift, result.speed,
                  result.acceleration, mean_of(&world, 0, world.x0).z,
                  (unsigned long long)world.rescue_count);
    mini_world_destroy(&world);
    return result;
}

static double expected_acceleration(double degrees) {
    return 9.81 * (sin(degrees * DEGREE) - 0.5 * cos(degrees * DEGREE));
}

/* Static friction is exact on a slope, sliding follows Coulomb's law. */
static void slope(void **state) {
    (void)state;
    for (int space = 0; space < 2; space++) {
        slope_result const held = run_slope((tulle_motion_space)space, 26.0, 2.0);
        assert_true(held.drift == 0.0 && held.speed == 0.0);
        slope_result const slow = run_slope((tulle_motion_space)space, 27.0, 2.0);
        assert_true(fabs(slow.acceleration / expected_acceleration(27.0) - 1.0) < 0.03);
        slope_result const fast = run_slope((tulle_motion_space)space, 40.0, 1.0);
        assert_true(fabs(fast.acceleration / expected_acceleration(40.0) - 1.0) < 1e-3);
    }
}

/* Two layers that touch and fall together: planes that are fixed in space hold the upper one back.
 */
static void falling_layers(void **state) {
    (void)state;
    enum { STEPS = 20 };
    double const alone = -9.81 * STEPS * TIME_STEP;
    for (int space = 0; space < 2; space++) {
        mini_world world = make_world((tulle_motion_space)space);
        add_grid(&world, 9, 0.3, 0.0, false);
        add_grid(&world, 8, 0.28, CONTACT_DISTANCE, false);
        start_mini_world(&world);
        take_steps(&world, STEPS, TIME_STEP);
        double const lower = mean_of(&world, 0, world.velocities).z;
        double const upper = mean_of(&world, 1, world.velocities).z;
        print_message("%s: two layers fall at %.5g and %.5g m/s, alone %.5g\n", space_names[space],
                      lower, upper, alone);
        assert_true(fabs(lower / alone - 1.0) < 1e-4);
        if (space == TULLE_MOTION_SPACE_POLYHEDRAL) assert_true(fabs(upper / alone - 1.0) < 1e-4);
        if (space == TULLE_MOTION_SPACE_CONE) assert_true(upper / alone < 0.95);
        mini_world_destroy(&world);
    }
}

/* A sheet between floor and ceiling, pulled without friction: in the cone of no width it locks. */
static void sheet_between_two_layers(void **state) {
    (void)state;
    double speeds[2];
    for (int space = 0; space < 2; space++) {
        mini_world world = make_world((tulle_motion_space)space);
        world.friction = 0.0;
        world.gravity[0] = 1.0;
        world.gravity[2] = -1.0;
        add_grid(&world, 9, 0.3, CONTACT_DISTANCE, false);
        add_grid(&world, 5, 1.6, 0.0, true);
        add_grid(&world, 6, 1.6, 2.0 * CONTACT_DISTANCE, true);
        start_mini_world(&world);
        take_steps(&world, 45, TIME_STEP);
        speeds[space] = mean_of(&world, 0, world.velocities).x;
        print_message("%s: between two layers %.4g m/s, free 0.5\n", space_names[space],
                      speeds[space]);
        mini_world_destroy(&world);
    }
    assert_true(speeds[TULLE_MOTION_SPACE_CONE] < 1e-3);
    assert_true(fabs(speeds[TULLE_MOTION_SPACE_POLYHEDRAL] / 0.5 - 1.0) < 1e-3);
}

/* Peak stretch of a sheet that falls on three spikes. */
static double run_spikes(tulle_motion_space space, double stiffness, double time_step, int steps) {
    mini_world world = make_world(space);
    world.material.stretch_stiffness = stiffness;
    mini_grid sheet = make_mini_grid(21, 21, vec3_make(-0.25, -0.25, 0.24),
                                     vec3_make(0.5, 0.0, 0.0), vec3_make(0.0, 0.5, 0.0));
    add_mini_surface(&world, sheet.mesh, false);
    free_mini_grid(&sheet);
    add_mini_spike(&world, vec3_make(-0.1, 0.013, 0.0), 0.2);
    add_mini_spike(&world, vec3_make(0.011, -0.03, 0.0), 0.2);
    add_mini_spike(&world, vec3_make(0.12, 0.05, 0.0), 0.2);
    start_mini_world(&world);
    double peak = 0.0;
    for (int step = 0; step < steps; step++) {
        take_steps(&world, 1, time_step);
        peak = fmax(peak, find_mini_stretch(&world));
    }
    print_message(
        "%s, %g N/m, %.3g s: peak stretch on spikes %.4g, at the end %.4g, rescues %llu\n",
        space_names[space], stiffness, time_step, peak, find_mini_stretch(&world),
        (unsigned long long)world.rescue_count);
    mini_world_destroy(&world);
    return peak;
}

/* Contact answers to forces that are a step old: as stable as an explicit integrator. Whatever the
 * physics, every state is free of intersection. */
static void spikes_carry_soft_cloth_in_short_steps_only(void **state) {
    (void)state;
    for (int space = 0; space < 2; space++) {
        assert_true(run_spikes((tulle_motion_space)space, 300.0, TIME_STEP / 4.0, 150) < 3.0);
        assert_true(run_spikes((tulle_motion_space)space, 1500.0, TIME_STEP, 18) > 4.0);
    }
}

static void threads_change_no_bit(void **state) {
    (void)state;
    uint64_t hashes[3];
    for (int i = 0; i < 3; i++) {
        mini_world world = make_world(TULLE_MOTION_SPACE_POLYHEDRAL);
        world.threads = 1 + i;
        world.gravity[0] = 3.0;
        add_grid(&world, 21, 0.3, 0.005, false);
        add_grid(&world, 5, 0.4, 0.0, true);
        start_mini_world(&world);
        take_steps(&world, 10, TIME_STEP);
        hashes[i] = hash_mini_world(&world);
        mini_world_destroy(&world);
    }
    assert_true(hashes[0] == hashes[1] && hashes[0] == hashes[2]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slope),
        cmocka_unit_test(falling_layers),
        cmocka_unit_test(sheet_between_two_layers),
        cmocka_unit_test(spikes_carry_soft_cloth_in_short_steps_only),
        cmocka_unit_test(threads_change_no_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
