/* layers.c - sheets on sheets: a stack on a slope, a tablecloth pulled out from under another
 * cloth, two layers that fall.
 *
 * All sheets of a stack that lie over an interface press on it with their common weight, so an
 * interface slips where its coefficient is under the slope's tangent, whatever lies on top; what is
 * above the lowest one that slips goes with g (sin - mu cos). */
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>

static const double CONTACT_DISTANCE = 3e-3; /* [m] */
static const double SLOPE = 31.0;            /* [degrees] tangent 0.6 */
enum { SHEETS = 5 };

typedef struct stack {
    tulle_world *world;
    tulle_cloth_id sheets[SHEETS];
} stack;

/* Sheets up to `long_count` are longer, so that those above find no end while they slide. */
static stack make_stack(validation_run *run, double on_ground, double between, int long_count) {
    tulle_world_def def = validate_world_def(run);
    def.gravity[0] = VALIDATION_GRAVITY * sin(SLOPE * VALIDATION_DEGREE);
    def.gravity[2] = -VALIDATION_GRAVITY * cos(SLOPE * VALIDATION_DEGREE);
    def.contact_distance = CONTACT_DISTANCE;
    def.friction_cloth_cloth = between;
    stack made = {.world = validate_make_world(run, &def)};
    uint32_t const count = validate_options(run)->is_quick ? 7 : 10;
    for (int i = 0; i < SHEETS; i++) {
        bool const is_long = i < long_count;
        tulle_mesh *const mesh = stage_make_sheet(
            run, (stage_sheet){.size = {is_long ? 0.6 : 0.3, 0.3},
                               .counts = {is_long ? 2 * count - 1 : count, count},
                               .middle = {(is_long ? 0.1 : 0.0) + 0.0031 * i, 0.0017 * i,
                                          (i + 1) * CONTACT_DISTANCE}});
        tulle_cloth_def cloth = stage_cloth_def(mesh);
        cloth.material.friction = on_ground;
        made.sheets[i] = validate_add_cloth(run, made.world, &cloth);
    }
    tulle_mesh *const plane = stage_make_sheet(
        run, (stage_sheet){.size = {6.0, 2.0}, .counts = {13, 5}, .middle = {2.013, 0.017, 0.0}});
    stage_add_obstacle(run, made.world, plane, on_ground);
    return made;
}

static double find_x(const stack *made, int sheet) {
    double mean[3];
    validate_mean_position(made->world, made->sheets[sheet], mean);
    return mean[0];
}

static double find_speed(const stack *made, int sheet) {
    double mean[3];
    validate_mean_velocity(made->world, made->sheets[sheet], mean);
    return mean[0];
}

/* A slide of 0.3 s: the sheets below `slipping` must stay, the others go by their friction. */
typedef struct stack_slide {
    const char *name;
    int slipping;
    double friction;
    bool is_marginal; /* the interfaces above would slip with the same coefficient: only their
                         common momentum is known */
} stack_slide;

static void report_slide(validation_run *run, const stack_slide *slide,
                         const double acceleration[SHEETS], const double way[SHEETS]) {
    double const angle = SLOPE * VALIDATION_DEGREE;
    double const expected = VALIDATION_GRAVITY * (sin(angle) - slide->friction * cos(angle));
    double stayed = 0.0, apart = 0.0, mean = 0.0, worst = expected;
    for (int i = 0; i < SHEETS; i++) {
        if (i < slide->slipping) {
            stayed = fmax(stayed, fabs(way[i]));
            continue;
        }
        apart = fmax(apart, fabs(way[i] - way[slide->slipping]));
        mean += acceleration[i] / (SHEETS - slide->slipping);
        if (fabs(acceleration[i] - expected) > fabs(worst - expected)) worst = acceleration[i];
    }
    char what[120];
    snprintf(what, sizeof what, "%s: acceleration, mean of sheets %d to 5", slide->name,
             slide->slipping + 1);
    validate_row(run, what, mean, "m/s^2", within(expected, 0.01), "g (sin - mu cos)");
    if (slide->slipping > 0) {
        snprintf(what, sizeof what, "%s: farthest way of those below", slide->name);
        validate_row(run, what, stayed, "m", at_most(1e-6), "they stick");
    }
    if (slide->is_marginal) return;
    snprintf(what, sizeof what, "%s: acceleration of the sheet that is farthest off", slide->name);
    validate_row(run, what, worst, "m/s^2", within(expected, 0.01), "g (sin - mu cos)");
    snprintf(what, sizeof what, "%s: how far those above come apart", slide->name);
    validate_row(run, what, apart, "m", at_most(1e-4), "they stick to each other");
}

static void slide_stack(validation_run *run, const stack *made, const stack_slide *slide) {
    double way[SHEETS], acceleration[SHEETS];
    for (int i = 0; i < SHEETS; i++) way[i] = -find_x(made, i);
    validate_simulate(run, made->world, 0.1);
    for (int i = 0; i < SHEETS; i++) acceleration[i] = -find_speed(made, i);
    validate_simulate(run, made->world, 0.2);
    for (int i = 0; i < SHEETS; i++) {
        way[i] += find_x(made, i);
        acceleration[i] = (acceleration[i] + find_speed(made, i)) / 0.2;
    }
    report_slide(run, slide, acceleration, way);
}

static void slips_on_ground(validation_run *run) {
    stack const made = make_stack(run, 0.3, 0.8, 0);
    slide_stack(run, &made, &(stack_slide){"0.3 on the ground, 0.8 between", 0, 0.3, false});
}

static void slips_on_lowest(validation_run *run) {
    stack const made = make_stack(run, 0.8, 0.3, 1);
    slide_stack(run, &made, &(stack_slide){"0.8 on the ground, 0.3 between", 1, 0.3, true});
}

/* Only the third interface from below slips: three sheets stay, two go as one. */
static void slips_in_the_middle(validation_run *run) {
    stack const made = make_stack(run, 0.8, 0.8, 3);
    tulle_contact_law const law = {.static_friction = 0.3, .dynamic_friction = -1.0};
    tulle_error error = {0};
    if (tulle_world_set_cloth_cloth_law(made.world, made.sheets[2], made.sheets[3], &law, &error))
        validate_give_up(run, "law: %s", error.message);
    slide_stack(run, &made, &(stack_slide){"0.3 between sheets 3 and 4, else 0.8", 3, 0.3, false});
}

static void sticks(validation_run *run) {
    stack const made = make_stack(run, 0.7, 0.7, 0);
    double const seconds = validate_options(run)->is_quick ? 1.0 : 60.0;
    double drift = 0.0, start[SHEETS];
    validate_start_plot(run,
                        &(validation_plot){.name = "stack_drift",
                                           .title = "Five sheets on a slope of 31 degrees, 0.7",
                                           .x_label = "time [s]",
                                           .y_label = "drift [m]"});
    validate_simulate(run, made.world, 0.1);
    for (int i = 0; i < SHEETS; i++) start[i] = find_x(&made, i);
    long const steps = lround(seconds / VALIDATION_STEP);
    validate_plan(run, steps);
    for (long step = 1; step <= steps; step++) {
        validate_step(run, made.world, VALIDATION_STEP);
        if (step % 30 != 0) continue;
        static const char *const names[SHEETS] = {"lowest", "second", "third", "fourth", "top"};
        for (int i = 0; i < SHEETS; i++)
            validate_plot_point(run, names[i], tulle_world_get_time(made.world),
                                find_x(&made, i) - start[i]);
    }
    for (int i = 0; i < SHEETS; i++) drift = fmax(drift, fabs(find_x(&made, i) - start[i]));
    char what[80];
    snprintf(what, sizeof what, "0.7 everywhere: largest drift of a sheet in %g s", seconds);
    validate_row(run, what, drift, "m", at_most(1e-6), "tan 31 degrees = 0.60");
}

/* Two layers a contact distance apart, or one. */
static double fall(validation_run *run, int layers, double seconds) {
    tulle_world_def def = validate_world_def(run);
    def.contact_distance = CONTACT_DISTANCE;
    tulle_world *const world = validate_make_world(run, &def);
    tulle_cloth_id id = {0};
    for (int i = 0; i < layers; i++) {
        tulle_mesh *const mesh = stage_make_sheet(
            run, (stage_sheet){.size = {0.3, 0.3},
                               .counts = {13, 13},
                               .middle = {0.0031 * i, 0.0017 * i, i * CONTACT_DISTANCE}});
        tulle_cloth_def const cloth = stage_cloth_def(mesh);
        id = validate_add_cloth(run, world, &cloth);
    }
    double before[3], after[3];
    validate_mean_position(world, id, before);
    validate_simulate(run, world, seconds);
    validate_mean_position(world, id, after);
    return before[2] - after[2];
}

static void fall_together(validation_run *run) {
    double const one = fall(run, 1, 1.0), two = fall(run, 2, 1.0);
    validate_row(run, "way of one sheet in 1 s", one, "m",
                 within(0.5 * VALIDATION_GRAVITY * (1.0 + VALIDATION_STEP), 0.0001),
                 "g t (t + h) / 2, implicit Euler");
    validate_row(run, "way of two sheets less that of one, over it", fabs(two - one) / one, "",
                 at_most(1e-6), "they fall as fast; tolerance of the solve: 1e-4 a step");
}

const experiment layers_experiments[] = {
    {"layers.stack_sticks", "five sheets stay on a slope", sticks, false},
    {"layers.stack_on_ground", "five sheets slip as one on the ground", slips_on_ground, false},
    {"layers.stack_on_lowest", "four sheets slip on the lowest", slips_on_lowest, false},
    {"layers.stack_in_middle", "two sheets slip on three that stay", slips_in_the_middle, false},
    {"layers.fall_together", "two layers fall as fast as one", fall_together, false},
    {0},
};
