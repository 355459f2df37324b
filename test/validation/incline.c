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
    double speed;           /* [m/s] at the start, down the slope */
    double fall;            /* [m] height over the contact distance at the start */
    uint32_t columns, rows; /* vertices of the plane; 0: 17 and 5 */
    bool is_split;          /* each triangle of the plane has vertices of its own */
    uint32_t box_count;     /* that many boxes, flush in a row, instead of a plane */
} slope_setting;
static const double FRICTION = 0.5;

typedef struct incline {
    tulle_world *world;
    tulle_cloth_id patch;
} incline;

static void add_slope(validation_run *run, tulle_world *world, const slope_setting *setting,
                      const tulle_mesh *mesh) {
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(mesh);
    obstacle.friction = setting->static_friction;
    obstacle.dynamic_friction = setting->dynamic_friction;
    validate_add_obstacle(run, world, &obstacle);
}

static tulle_mesh *split_triangles(validation_run *run, const tulle_mesh *mesh) {
    tulle_mesh *const split =
        validate_make_mesh(run, 3 * mesh->triangle_count, mesh->triangle_count);
    for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
        split->triangles[i] = (uint32_t)i;
        for (size_t k = 0; k < 3; k++)
            split->positions[3 * i + k] = mesh->positions[3 * (size_t)mesh->triangles[i] + k];
    }
    return split;
}

static void add_plane(validation_run *run, tulle_world *world, const slope_setting *setting) {
    uint32_t const columns = setting->columns ? setting->columns : 17;
    uint32_t const rows = setting->rows ? setting->rows : 5;
    tulle_mesh *const plane = stage_make_sheet(run, (stage_sheet){.size = {8.0, 2.0},
                                                                  .counts = {columns, rows},
                                                                  .middle = {3.013, 0.017, 0.0}});
    add_slope(run, world, setting, setting->is_split ? split_triangles(run, plane) : plane);
}

static void add_boxes(validation_run *run, tulle_world *world, const slope_setting *setting) {
    double const length = 8.0 / setting->box_count; /* [m] */
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
    def.size[0] = length;
    def.size[1] = 2.0;
    def.size[2] = 0.2;
    for (uint32_t i = 0; i < setting->box_count; i++) {
        tulle_mesh *const box = validate_make_shape(run, &def);
        stage_move(box, -1.0 + (i + 0.5) * length, 0.017, -0.1);
        add_slope(run, world, setting, box);
    }
}

static incline make_slope(validation_run *run, const slope_setting *setting) {
    tulle_world_def def = validate_world_def(run);
    def.gravity[0] = VALIDATION_GRAVITY * sin(setting->degrees * VALIDATION_DEGREE);
    def.gravity[2] = -VALIDATION_GRAVITY * cos(setting->degrees * VALIDATION_DEGREE);
    def.contact_distance = CONTACT_DISTANCE;
    incline made = {.world = validate_make_world(run, &def)};

    uint32_t const count = validate_options(run)->is_quick ? 9 : 16;
    tulle_mesh *const patch = stage_make_sheet(
        run, (stage_sheet){.size = {PATCH_SIDE, PATCH_SIDE},
                           .counts = {count, count},
                           .middle = {0.0, 0.0, CONTACT_DISTANCE + setting->fall}});
    tulle_cloth_def cloth = stage_cloth_def(patch);
    cloth.material.friction = setting->static_friction;
    cloth.material.dynamic_friction = setting->dynamic_friction;
    cloth.velocity[0] = setting->speed;
    made.patch = validate_add_cloth(run, made.world, &cloth);

    if (setting->box_count > 0)
        add_boxes(run, made.world, setting);
    else
        add_plane(run, made.world, setting);
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
    incline slope = make_slope(run, &(slope_setting){.degrees = 26.0, FRICTION, FRICTION});
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
    incline slope = make_slope(run, &(slope_setting){.degrees = 27.0, FRICTION, FRICTION});
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
    incline slope = make_slope(run, &(slope_setting){.degrees = 40.0, FRICTION, FRICTION});
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

/* Height of the highest vertex over the plane [m]. */
static double find_height(const incline *slope) {
    size_t count;
    const double *const x = tulle_cloth_get_positions(slope->world, slope->patch, &count);
    double highest = 0.0;
    for (size_t v = 0; v < count; v++) highest = fmax(highest, x[3 * v + 2]);
    return highest;
}

/* A patch that slides on a plane of many triangles or boxes, from the start or from 1 cm above; its
 * speed goes up to one and a half cells a step. */
static void slides_on_a_mesh(validation_run *run) {
    static const struct {
        const char *name;
        slope_setting setting; /* without the angle and friction that all have */
    } cases[] = {
        {"cells of 38 x 25 mm", {.columns = 211, .rows = 81}},
        {"cells of 27 x 17 mm", {.columns = 301, .rows = 121}},
        {"cells of 13 x 10 mm", {.columns = 601, .rows = 201}},
        {"cells of 38 x 25 mm, from 3 m/s", {.speed = 3.0, .columns = 211, .rows = 81}},
        {"cells of 38 x 25 mm, dropped", {.fall = 0.01, .columns = 211, .rows = 81}},
        {"cells of 38 x 25 mm, triangles apart", {.columns = 211, .rows = 81, .is_split = true}},
        {"forty boxes, flush", {.box_count = 40}},
    };
    double const expected = coulomb_acceleration(40.0, FRICTION);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        slope_setting setting = cases[i].setting;
        setting.degrees = 40.0;
        setting.static_friction = setting.dynamic_friction = FRICTION;
        incline slope = make_slope(run, &setting);
        validate_simulate(run, slope.world, 0.5);
        double const before = find_speed(&slope);
        double highest = 0.0;
        for (int step = 0; step < 45; step++) {
            validate_step(run, slope.world, VALIDATION_STEP);
            highest = fmax(highest, find_height(&slope));
        }
        char what[96];
        snprintf(what, sizeof what, "acceleration, %s", cases[i].name);
        validate_row(run, what, 2.0 * (find_speed(&slope) - before), "m/s^2",
                     within(expected, 0.01), "g (sin - mu cos)");
        snprintf(what, sizeof what, "most it rises there, over the contact distance");
        validate_row(run, what, highest / CONTACT_DISTANCE - 1.0, "", at_most(0.05),
                     "a plane has no bumps");
    }
}

/* Static 0.6 (30.96 degrees), dynamic 0.4 (21.80 degrees). */
static void keeps_on_once_moving(validation_run *run) {
    slope_setting const settings[] = {
        {.degrees = 30.5, .static_friction = 0.6, .dynamic_friction = 0.4, .speed = 0.0},
        {.degrees = 31.0, .static_friction = 0.6, .dynamic_friction = 0.4, .speed = 0.0},
        {.degrees = 22.0, .static_friction = 0.6, .dynamic_friction = 0.4, .speed = 0.5},
        {.degrees = 21.0, .static_friction = 0.6, .dynamic_friction = 0.4, .speed = 0.1}};
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
    {"incline.meshed", "the same on a slope of many triangles or boxes", slides_on_a_mesh, false},
    {"incline.keeps_on", "with less dynamic friction it starts at 31 degrees and keeps on at 22",
     keeps_on_once_moving, true},
    {0},
};
