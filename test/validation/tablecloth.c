/* tablecloth.c - a cloth pulled by one edge from under another one.
 *
 * While the lower one runs, friction drives the upper one with mu g, whatever the speed; it has
 * the time t that the lower one's end takes to pass, goes mu g t^2 / 2, and slides as far again on
 * the table. So a fast pull leaves it where it is. A pull whose acceleration stays under mu g takes
 * it along. */
#include "support/pins.h"
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>

static const double CONTACT_DISTANCE = 3e-3; /* [m] */
static const double FRICTION = 0.3;
static const double LOWER_LENGTH = 0.8, UPPER_LENGTH = 0.25; /* [m] */
enum { EDGE_MAX = 64 };

typedef struct table {
    tulle_world *world;
    tulle_cloth_id lower, upper;
} table;

static table make_table(validation_run *run, const tulle_motion *pull) {
    tulle_world_def def = validate_world_def(run);
    def.contact_distance = CONTACT_DISTANCE;
    def.friction_cloth_cloth = FRICTION;
    table made = {.world = validate_make_world(run, &def)};
    bool const is_quick = validate_options(run)->is_quick;
    uint32_t const columns = is_quick ? 21 : 41, rows = is_quick ? 13 : 25;
    tulle_mesh *const lower = stage_make_sheet(run, (stage_sheet){.size = {LOWER_LENGTH, 0.48},
                                                                  .counts = {columns, rows},
                                                                  .middle = {0.0, 0.0, 3e-3}});
    uint32_t edge[EDGE_MAX];
    for (uint32_t j = 0; j < rows; j++) edge[j] = j * columns + columns - 1;
    tulle_pin pin = make_pin(edge, rows, (double)INFINITY);
    pin.motion = *pull;
    tulle_cloth_def cloth = stage_cloth_def(lower);
    cloth.material.friction = FRICTION;
    cloth.material.springs.stretch_stiffness = 3000.0; /* it is to follow its edge */
    cloth.pins = &pin;
    cloth.pin_count = 1;
    made.lower = validate_add_cloth(run, made.world, &cloth);

    uint32_t const count = is_quick ? 8 : 13;
    tulle_mesh *const upper = stage_make_sheet(run, (stage_sheet){.size = {UPPER_LENGTH, 0.25},
                                                                  .counts = {count, count},
                                                                  .middle = {0.003, 0.002, 6e-3}});
    cloth = stage_cloth_def(upper);
    cloth.material.friction = FRICTION;
    made.upper = validate_add_cloth(run, made.world, &cloth);
    tulle_mesh *const plane = stage_make_sheet(
        run, (stage_sheet){.size = {6.0, 2.0}, .counts = {13, 5}, .middle = {1.013, 0.017, 0.0}});
    stage_add_obstacle(run, made.world, plane, FRICTION);
    return made;
}

static double find_x(const table *made, tulle_cloth_id id) {
    double mean[3];
    validate_mean_position(made->world, id, mean);
    return mean[0];
}

typedef struct pull_result {
    double lower, upper; /* [m] ways */
} pull_result;

/* Pulls by `way` [m] in `seconds`, after 0.2 s of rest, and waits until all have come to rest. */
static pull_result pull(validation_run *run, double way, double seconds, double step,
                        const char *series) {
    tulle_keyframe const keys[2] = {stage_key(0.2, 0.0, 0.0, 0.0),
                                    stage_key(0.2 + seconds, way, 0.0, 0.0)};
    tulle_motion const motion = {.keys = keys, .key_count = 2, .is_eased = seconds > 1.0};
    table const made = make_table(run, &motion);
    double const start[2] = {find_x(&made, made.lower), find_x(&made, made.upper)};
    long const steps = lround((0.7 + seconds) / step);
    char names[2][64];
    snprintf(names[0], sizeof names[0], "lower, %s", series);
    snprintf(names[1], sizeof names[1], "upper, %s", series);
    validate_plan(run, steps);
    for (long i = 0; i < steps; i++) {
        validate_step(run, made.world, step);
        double const part = (tulle_world_get_time(made.world) - 0.2) / seconds;
        if (part < -0.1 || part > 2.0) continue;
        validate_plot_point(run, names[0], part, find_x(&made, made.lower) - start[0]);
        validate_plot_point(run, names[1], part, find_x(&made, made.upper) - start[1]);
    }
    return (pull_result){find_x(&made, made.lower) - start[0],
                         find_x(&made, made.upper) - start[1]};
}

static void is_pulled_out(validation_run *run) {
    validate_start_plot(run, &(validation_plot){.name = "tablecloth",
                                                .title = "A cloth pulled out from under another",
                                                .x_label = "time / time of the pull",
                                                .y_label = "way [m]"});
    double const speed = 10.0, way = 1.2, step = 1.0 / 360.0;
    pull_result const fast = pull(run, way, way / speed, step, "10 m/s");
    validate_row(run, "upper's way over lower's, pulled at 10 m/s", fast.upper / fast.lower, "",
                 at_most(0.05), "it stays");
    /* lower end at -0.4 m, upper's middle at 0.003 m: half of the upper one is free by then */
    double const time = (0.5 * LOWER_LENGTH + 0.003) / speed;
    validate_row(run, "way of the upper one", fast.upper, "m", nothing(), "about 2 (mu g t^2 / 2)");
    validate_row(run, "mu g t^2", FRICTION * VALIDATION_GRAVITY * time * time, "m", nothing(),
                 "t: the lower one's end passes the upper one's middle");
    pull_result const slow = pull(run, 0.5, 4.0, VALIDATION_STEP, "slowly");
    validate_row(run, "upper's way over lower's, pulled by 0.5 m in 4 s", slow.upper / slow.lower,
                 "", within(1.0, 0.001), "it comes along");
}

static void is_pulled_out_in_large_steps(validation_run *run) {
    pull_result const fast = pull(run, 1.2, 0.12, VALIDATION_STEP, "10 m/s");
    validate_row(run, "upper's way over lower's, 10 m/s in steps of 1/90 s (0.11 m)",
                 fast.upper / fast.lower, "", at_most(0.05), "it stays");
}

const experiment tablecloth_experiments[] = {
    {"tablecloth.pull", "pulled out fast the upper cloth stays, slowly it comes along",
     is_pulled_out, false},
    {"tablecloth.large_steps", "the fast pull in steps of five elements",
     is_pulled_out_in_large_steps, false},
    {0},
};
