/* The paper's response on small scenes: static and sliding friction on a slope, layers, spikes.
 * What it does worse than the coupled response is asserted too, where it is a matter of rule. */
#include "support/contact_world.h"
#include "support/paper_options.h"
#include "support/test_support.h"

#include <string.h>

#define TIME_STEP (1.0 / 90.0)
#define CONTACT_DISTANCE 3e-3
#define DEGREE 0.017453292519943295

static const char *const space_names[] = {"cone", "polyhedral"};

static contact_world make_world(tulle_motion_space space) {
    contact_world world = contact_world_make();
    change_paper(&world.def)->response = TULLE_RESPONSE_PAPER;
    change_paper(&world.def)->motion_space = space;
    world.def.contact_distance = CONTACT_DISTANCE;
    return world;
}

static void add_grid(contact_world *world, uint32_t n, double size, double height,
                     bool is_obstacle) {
    contact_grid grid = make_contact_grid(n, n, vec3_make(-0.5 * size, -0.5 * size, height),
                                          vec3_make(size, 0.0, 0.0), vec3_make(0.0, size, 0.0));
    add_contact_surface(world, grid.mesh, is_obstacle);
    free_contact_grid(&grid);
}

/* Means over the vertices of a surface. */
static vec3 mean_of(const contact_world *world, size_t surface, const double *values) {
    const surface_range *const range = &world->surfaces[surface];
    vec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = range->vertex_begin; i < range->vertex_end; i++)
        sum = vec3_add(sum, vec3_load(values, i));
    return vec3_scale(sum, 1.0 / (range->vertex_end - range->vertex_begin));
}

/* Every state is judged. */
static void take_steps(contact_world *world, int count, double time_step) {
    for (int i = 0; i < count; i++) {
        assert_int_equal(step_contact_world(world, time_step), TULLE_OK);
        assert_int_equal(judge_contact_world(world), 0);
        assert_true(world->report.smallest_gap >= world->settings.minimum_gap);
    }
}

typedef struct slope_result {
    double drift, speed, acceleration;
} slope_result;

/* A patch on a plane at the contact distance; gravity is tilted instead of the plane. */
static slope_result run_slope(tulle_motion_space space, double degrees, double seconds) {
    contact_world world = make_world(space);
    world.def.gravity[0] = 9.81 * sin(degrees * DEGREE);
    world.def.gravity[2] = -9.81 * cos(degrees * DEGREE);
    add_grid(&world, 9, 0.3, CONTACT_DISTANCE, false);
    contact_grid plane = make_contact_grid(12, 8, vec3_make(-1.0, -1.03, 0.0),
                                           vec3_make(6.0, 0.0, 0.0), vec3_make(0.0, 2.0, 0.0));
    add_contact_surface(&world, plane.mesh, true);
    free_contact_grid(&plane);
    start_contact_world(&world);
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
    contact_world_destroy(&world);
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
        contact_world world = make_world((tulle_motion_space)space);
        add_grid(&world, 9, 0.3, 0.0, false);
        add_grid(&world, 8, 0.28, CONTACT_DISTANCE, false);
        start_contact_world(&world);
        take_steps(&world, STEPS, TIME_STEP);
        double const lower = mean_of(&world, 0, world.velocities).z;
        double const upper = mean_of(&world, 1, world.velocities).z;
        print_message("%s: two layers fall at %.5g and %.5g m/s, alone %.5g\n", space_names[space],
                      lower, upper, alone);
        assert_true(fabs(lower / alone - 1.0) < 1e-4);
        if (space == TULLE_MOTION_SPACE_POLYHEDRAL) assert_true(fabs(upper / alone - 1.0) < 1e-4);
        if (space == TULLE_MOTION_SPACE_CONE) assert_true(upper / alone < 0.95);
        contact_world_destroy(&world);
    }
}

/* A sheet between floor and ceiling, pulled without friction: in the cone of no width it locks. */
static void sheet_between_two_layers(void **state) {
    (void)state;
    double speeds[2];
    for (int space = 0; space < 2; space++) {
        contact_world world = make_world((tulle_motion_space)space);
        world.friction = 0.0;
        world.def.gravity[0] = 1.0;
        world.def.gravity[2] = -1.0;
        add_grid(&world, 9, 0.3, CONTACT_DISTANCE, false);
        add_grid(&world, 5, 1.6, 0.0, true);
        add_grid(&world, 6, 1.6, 2.0 * CONTACT_DISTANCE, true);
        start_contact_world(&world);
        take_steps(&world, 45, TIME_STEP);
        speeds[space] = mean_of(&world, 0, world.velocities).x;
        print_message("%s: between two layers %.4g m/s, free 0.5\n", space_names[space],
                      speeds[space]);
        contact_world_destroy(&world);
    }
    assert_true(speeds[TULLE_MOTION_SPACE_CONE] < 1e-3);
    assert_true(fabs(speeds[TULLE_MOTION_SPACE_POLYHEDRAL] / 0.5 - 1.0) < 1e-3);
}

typedef struct spikes_result {
    double peak;         /* largest stretch of all steps that went well */
    uint32_t substeps;   /* of these */
    tulle_status status; /* of the last step */
    tulle_error error;
} spikes_result;

/* A sheet that falls on three spikes, until a step fails. */
static spikes_result run_spikes(tulle_motion_space space, double stiffness, double time_step,
                                int steps) {
    contact_world world = make_world(space);
    world.material.springs.stretch_stiffness = stiffness;
    contact_grid sheet = make_contact_grid(21, 21, vec3_make(-0.25, -0.25, 0.24),
                                           vec3_make(0.5, 0.0, 0.0), vec3_make(0.0, 0.5, 0.0));
    add_contact_surface(&world, sheet.mesh, false);
    free_contact_grid(&sheet);
    add_contact_spike(&world, vec3_make(-0.1, 0.013, 0.0), 0.2);
    add_contact_spike(&world, vec3_make(0.011, -0.03, 0.0), 0.2);
    add_contact_spike(&world, vec3_make(0.12, 0.05, 0.0), 0.2);
    start_contact_world(&world);
    spikes_result result = {0};
    for (int step = 0; step < steps && result.status == TULLE_OK; step++) {
        result.status = step_contact_world(&world, time_step);
        result.error = world.error;
        assert_int_equal(judge_contact_world(&world), 0);
        if (result.status != TULLE_OK) break;
        assert_true(world.report.smallest_gap >= world.settings.minimum_gap);
        result.substeps += world.report.substeps;
        result.peak = fmax(result.peak, measure_contact_stretch(&world));
    }
    print_message("%s, %g N/m, %.3g s: peak stretch on spikes %.4g, at the end %.4g, %u substeps, "
                  "rescues %llu\n",
                  space_names[space], stiffness, time_step, result.peak,
                  measure_contact_stretch(&world), result.substeps,
                  (unsigned long long)world.rescue_count);
    contact_world_destroy(&world);
    return result;
}

/* Contact answers to forces that are a step old: as stable as an explicit integrator. Long steps
 * would stretch the cloth at once, so the world takes shorter ones; where the shortest is too long
 * for the cloth, an edge jumps to over four times its length, and the step fails. Whatever the
 * physics, every state is free of intersection. */
static void spikes_carry_soft_cloth_in_short_steps_only(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        tulle_motion_space const space = (tulle_motion_space)k;
        spikes_result const soft = run_spikes(space, 300.0, TIME_STEP / 4.0, 150);
        assert_int_equal(soft.status, TULLE_OK);
        assert_true(soft.peak < 3.0);
        spikes_result const medium = run_spikes(space, 1500.0, TIME_STEP, 18);
        assert_int_equal(medium.status, TULLE_OK);
        assert_true(medium.substeps > 18);
        spikes_result const stiff = run_spikes(space, 24000.0, TIME_STEP, 18);
        assert_int_equal(stiff.status, TULLE_ERROR_STEP_FAILED);
        assert_non_null(strstr(stiff.error.message, "tears cloth to over 4 times"));
    }
}

static void threads_change_no_bit(void **state) {
    (void)state;
    uint64_t hashes[3];
    for (int i = 0; i < 3; i++) {
        contact_world world = make_world(TULLE_MOTION_SPACE_POLYHEDRAL);
        world.def.threads = 1 + i;
        world.def.gravity[0] = 3.0;
        add_grid(&world, 21, 0.3, 0.005, false);
        add_grid(&world, 5, 0.4, 0.0, true);
        start_contact_world(&world);
        take_steps(&world, 10, TIME_STEP);
        hashes[i] = tulle_world_get_state_hash(world.world);
        contact_world_destroy(&world);
    }
    assert_true(hashes[0] == hashes[1] && hashes[0] == hashes[2]);
}

/* A sheet that hits a plane with 1 m/s leaves it as the law of impact says. */
static void sheets_rebound(void **state) {
    (void)state;
    for (int space = 0; space < 2; space++) {
        contact_world world = make_world((tulle_motion_space)space);
        world.restitution = 0.5;
        world.def.gravity[2] = 0.0;
        add_grid(&world, 9, 0.3, 0.03, false);
        add_grid(&world, 5, 0.4, 0.0, true);
        start_contact_world(&world);
        for (size_t v = 0; v < world.cloth_vertex_count; v++) world.velocities[3 * v + 2] = -1.0;
        take_steps(&world, 6, TIME_STEP);
        double const speed = mean_of(&world, 0, world.velocities).z;
        print_message("%s: a sheet comes with 1 m/s and leaves with %.4g m/s\n", space_names[space],
                      speed);
        assert_true(fabs(speed - 0.5) < 0.01);
        contact_world_destroy(&world);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slope),
        cmocka_unit_test(falling_layers),
        cmocka_unit_test(sheet_between_two_layers),
        cmocka_unit_test(spikes_carry_soft_cloth_in_short_steps_only),
        cmocka_unit_test(threads_change_no_bit),
        cmocka_unit_test(sheets_rebound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
