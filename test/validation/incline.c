/* incline.c - a patch on an inclined plane against Coulomb's law.
 *
 * The patch lies at the contact distance over a level plane and gravity is tilted, so that the
 * start has no motion of its own. Below the critical angle atan(mu) it stays; above it the mean
 * acceleration is g (sin - mu cos). */
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>

static const double CONTACT_DISTANCE = 3e-3; /* [m] */
static const double PATCH_SIDE = 0.3;        /* [m] */

/* Coefficients of the patch and of the plane, and how the patch starts. */
typedef struct slope_setting {
    double degrees, static_friction, dynamic_friction;
    double speed; /* [m/s] at the start, down the slope */
} slope_setting;
static const double FRICTION = 0.5;

typedef struct incline {
    tulle_world *world;
    tulle_cloth_id patch;
} incline;

static incline make_slope(validation_run *run, const slope_setting *setting) {
    tulle_world_def def = validate_world_def(run);
    def.gravity[0] = VALIDATION_GRAVITY * sin(setting->degrees * VALIDATION_DEGREE);
    def.gravity[2] = -VALIDATION_GRAVITY * cos(setting->degrees * VALIDATION_DEGREE);
    def.contact_distance = CONTACT_DISTANCE;
    incline made = {.world = validate_make_world(run, &def)};

    uint32_t const count = validate_options(run)->is_quick ? 9 : 16;
    tulle_mesh *const patch =
        stage_make_sheet(run, (stage_sheet){.size = {PATCH_SIDE, PATCH_SIDE},
                                            .counts = {count, count},
                                            .middle = {0.0, 0.0, CONTACT_DISTANCE}});
    tulle_cloth_def cloth = stage_cloth_def(patch);
    cloth.material.friction = setting->static_friction;
    cloth.material.dynamic_friction = setting->dynamic_friction;
    cloth.velocity[0] = setting->speed;
    made.patch = validate_add_cloth(run, made.world, &cloth);

    tulle_mesh *const plane = stage_make_sheet(
        run, (stage_sheet){.size = {8.0, 2.0}, .counts = {17, 5}, .middle = {3.013, 0.017, 0.0}});
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(plane);
    obstacle.friction = setting->static_friction;
    obstacle.dynamic_friction = setting->dynamic_friction;
    validate_add_obstacle(run, made.world, &obstacle);
    return made;
}

static double find_x(const incline *slope) {
    double mean[3];
    validate_mean_position(slope->world, slope->patch, mean);
    return mean[0];
}

static double find_speed(const incline *slope) {
    double mean[3];
    validate_mean_velocity(slope->world, slope->patch, mean);
    return mean[0];
}

static double coulomb_acceleration(double degrees, double friction) {
    double const angle = degrees * VALIDATION_DEGREE;
    return VALIDATION_GRAVITY * (sin(angle) - friction * cos(angle));
}

static void stays_at_26_degrees(validation_run *run) {
    incline slope = make_slope(run, &(slope_setting){26.0, FRICTION, FRICTION, 0.0});
    double const seconds = validate_options(run)->is_quick ? 4.0 : 60.0;
    validate_start_plot(run, &(validation_plot){.name = "incline_drift",
                                                .title = "Patch at 26 degrees, friction 0.5",
                                                .x_label = "time [s]",
                                                .y_label = "drift [m]"});
    validate_simulate(run, slope.world, 0.1);
    double const start = find_x(&slope);
    long const steps = lround(seconds / VALIDATION_STEP);
    validate_plan(run, steps);
    for (long i = 0; i < steps; i++) {
        validate_step(run, slope.world, VALIDATION_STEP);
        if (i % 30 == 0)
            validate_plot_point(run, "drift", tulle_world_get_time(slope.world),
                                find_x(&slope) - start);
    }
    char what[64];
    snprintf(what, sizeof what, "drift in %g s at 26 degrees, friction 0.5", seconds);
    validate_row(run, what, fabs(find_x(&slope) - start), "m", at_most(1e-6),
                 "Coulomb: below atan 0.5 = 26.57 degrees");
}

static void goes_at_27_degrees(validation_run *run) {
    incline slope = make_slope(run, &(slope_setting){27.0, FRICTION, FRICTION, 0.0});
    validate_simulate(run, slope.world, 1.0);
    double const before = find_speed(&slope);
    validate_simulate(run, slope.world, 1.0);
    double const acceleration = find_speed(&slope) - before;
    validate_row(run, "speed after 2 s at 27 degrees", find_speed(&slope), "m/s", at_least(0.1),
                 "it goes");
    validate_row(run, "acceleration at 27 degrees over Coulomb's",
                 acceleration / coulomb_acceleration(27.0, FRICTION), "", nothing(),
                 "a small difference of large forces");
}

static void accelerates_at_40_degrees(validation_run *run) {
    incline slope = make_slope(run, &(slope_setting){40.0, FRICTION, FRICTION, 0.0});
    validate_start_plot(run, &(validation_plot){.name = "incline_speed",
                                                .title = "Patch at 40 degrees, friction 0.5",
                                                .x_label = "time [s]",
                                                .y_label = "speed [m/s]"});
    double const expected = coulomb_acceleration(40.0, FRICTION);
    double speed_at_half = 0.0;
    for (int i = 1; i <= 90; i++) {
        validate_step(run, slope.world, VALIDATION_STEP);
        validate_plot_point(run, "measured", i * VALIDATION_STEP, find_speed(&slope));
        validate_plot_point(run, "g (sin - mu cos) t", i * VALIDATION_STEP,
                            expected * i * VALIDATION_STEP);
        if (i == 45) speed_at_half = find_speed(&slope);
    }
    validate_row(run, "acceleration at 40 degrees, 0.5 s to 1 s",
                 2.0 * (find_speed(&slope) - speed_at_half), "m/s^2", within(expected, 0.01),
                 "g (sin - mu cos)");
    validate_row(run, "way in 1 s at 40 degrees", find_x(&slope), "m", within(0.5 * expected, 0.03),
                 "g (sin - mu cos) / 2");
}

/* Static 0.6 (30.96 degrees), dynamic 0.4 (21.80 degrees). */
static void keeps_on_once_moving(validation_run *run) {
    slope_setting const settings[] = {
        {30.5, 0.6, 0.4, 0.0}, {31.0, 0.6, 0.4, 0.0}, {22.0, 0.6, 0.4, 0.5}, {21.0, 0.6, 0.4, 0.1}};
    incline slope = make_slope(run, &settings[0]);
    validate_simulate(run, slope.world, 0.1);
    double const start = find_x(&slope);
    validate_simulate(run, slope.world, 2.0);
    validate_row(run, "static 0.6, dynamic 0.4: drift in 2 s at 30.5 degrees",
                 fabs(find_x(&slope) - start), "m", at_most(1e-6), "atan 0.6 = 30.96 degrees");
    slope = make_slope(run, &settings[1]);
    validate_simulate(run, slope.world, 0.5);
    double before = find_speed(&slope);
    validate_simulate(run, slope.world, 0.5);
    validate_row(run, "acceleration at 31 degrees", 2.0 * (find_speed(&slope) - before), "m/s^2",
                 within(coulomb_acceleration(31.0, 0.4), 0.01),
                 "g (sin - mu_d cos): it has started");
    slope = make_slope(run, &settings[2]);
    validate_simulate(run, slope.world, 0.5);
    before = find_speed(&slope);
    validate_simulate(run, slope.world, 2.0);
    validate_row(run, "speed gained in 2 s at 22 degrees, started at 0.5 m/s",
                 find_speed(&slope) - before, "m/s",
                 within(2.0 * coulomb_acceleration(22.0, 0.4), 0.1),
                 "g (sin - mu_d cos) 2 s: it keeps on");
    slope = make_slope(run, &settings[3]);
    validate_simulate(run, slope.world, 2.0);
    validate_row(run, "speed after 2 s at 21 degrees, started at 0.1 m/s", fabs(find_speed(&slope)),
                 "m/s", at_most(1e-9), "atan 0.4 = 21.80 degrees: it stops");
}

const experiment incline_experiments[] = {
    {"incline.sticks", "a patch on a slope of 26 degrees stays for a minute", stays_at_26_degrees,
     false},
    {"incline.goes", "at 27 degrees it goes", goes_at_27_degrees, false},
    {"incline.slides", "at 40 degrees it slides with Coulomb's acceleration",
     accelerates_at_40_degrees, false},
    {"incline.keeps_on", "with less dynamic friction it starts at 31 degrees and keeps on at 22",
     keeps_on_once_moving, true},
    {0},
};
