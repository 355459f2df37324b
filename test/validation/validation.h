/* validation.h - experiments that hold the physics of contact against closed forms.
 *
 * An experiment builds worlds through the public API, runs them and reports rows: measured,
 * expected, and where the expected comes from. `tulle_validate` runs experiments and prints the
 * table; it fails where a row is off. One file holds the experiments of one group in an array that
 * ends with an empty entry; experiments.c lists the arrays.
 *
 * All that an experiment makes belongs to its run and is released after it. What cannot go on (a
 * step that fails, no memory) leaves the experiment and counts as a row that is off. */
#ifndef TULLE_TEST_VALIDATION_H
#define TULLE_TEST_VALIDATION_H

#include "tulle/tulle.h"

#include <stdbool.h>

#define VALIDATION_DEGREE 0.017453292519943295 /* [rad] */
#define VALIDATION_GRAVITY 9.81                /* [m/s^2] of the default world */
#define VALIDATION_STEP (1.0 / 90.0)           /* [s] step of all experiments that name no other */

/* What is run: the same for all experiments. */
typedef struct validation_options {
    bool is_quick; /* small sizes and short runs */
    int threads;
    const char *response, *motion_space, *integrator; /* names, never null */
} validation_options;

typedef struct validation_run validation_run;

typedef struct experiment {
    const char *name;  /* group.subject, unique; null ends an array */
    const char *shows; /* one sentence for the list */
    void (*run)(validation_run *run);
    bool is_long; /* left out of quick runs that do not name it */
} experiment;

/* The arrays of all groups, in the order of the table; ends with null. */
extern const experiment *const validation_groups[];

/* What a row must be. */
typedef enum expectation_kind {
    EXPECT_AT_MOST,
    EXPECT_AT_LEAST,
    EXPECT_WITHIN, /* value times (1 +- tolerance) */
    EXPECT_EQUALS, /* exactly, for counts */
    EXPECT_NOTHING /* a figure to be told, never off */
} expectation_kind;
typedef struct expectation {
    expectation_kind kind;
    double value, tolerance;
    bool is_open; /* known not to hold: see not_yet */
} expectation;
static inline expectation at_most(double value) {
    return (expectation){.kind = EXPECT_AT_MOST, .value = value};
}
static inline expectation at_least(double value) {
    return (expectation){.kind = EXPECT_AT_LEAST, .value = value};
}
static inline expectation within(double value, double relative_tolerance) {
    return (expectation){.kind = EXPECT_WITHIN, .value = value, .tolerance = relative_tolerance};
}
static inline expectation equals(double value) {
    return (expectation){.kind = EXPECT_EQUALS, .value = value};
}
static inline expectation nothing(void) { return (expectation){.kind = EXPECT_NOTHING}; }
/* What must hold and does not yet: off as any other in full runs, which fail; "open" in quick ones,
 * which go on to guard the rest. To be taken away with the defect. */
static inline expectation not_yet(expectation expected) {
    expected.is_open = true;
    return expected;
}

/* Reports a row. `reference` says where the expected value comes from; may be empty. */
void validate_row(validation_run *run, const char *what, double measured, const char *unit,
                  expectation expected, const char *reference);
/* A row that this build or these options cannot measure: shown, counts as neither. */
void validate_skip(validation_run *run, const char *what, const char *why);
/* Leaves the experiment; the row is off. */
_Noreturn void validate_give_up(validation_run *run, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

const validation_options *validate_options(const validation_run *run);
/* The second part of the experiment's name: sets those with one function apart. */
const char *validate_subject(const validation_run *run);
/* The world of every experiment: default values with the integrator and the response of the
 * options. Change other fields only. */
tulle_world_def validate_world_def(const validation_run *run);

/* Made for the run: the world, and meshes that may be moved before they are added. */
tulle_world *validate_make_world(validation_run *run, const tulle_world_def *def);
tulle_mesh *validate_make_shape(validation_run *run, const tulle_shape_def *def);
/* A mesh to be filled in. */
tulle_mesh *validate_make_mesh(validation_run *run, size_t vertex_count, size_t triangle_count);
tulle_cloth_id validate_add_cloth(validation_run *run, tulle_world *world,
                                  const tulle_cloth_def *def);
tulle_obstacle_id validate_add_obstacle(validation_run *run, tulle_world *world,
                                        const tulle_obstacle_def *def);
/* Memory that is released with the run. */
void *validate_allocate(validation_run *run, size_t byte_count);
/* Gives `object` to the run, which calls `release` with it at its end, what was given last first.
 */
void validate_own(validation_run *run, void *object, void (*release)(void *object));

/* Steps that are ahead, beyond those told before: for the line of progress. */
void validate_plan(validation_run *run, long steps);
/* One step; the run counts contacts, rescues and the smallest gap, and judges every third state, a
 * frame. */
tulle_step_report validate_step(validation_run *run, tulle_world *world, double time_step);
/* The same for a step and a judgement of a world that is not the run's. */
void validate_count_step(validation_run *run, const tulle_step_report *report, double minimum_gap);
void validate_count_judgement(validation_run *run, size_t crossing);
/* Steps of VALIDATION_STEP until `seconds` have passed. */
void validate_simulate(validation_run *run, tulle_world *world, double seconds);

/* Judges the state of now: pairs of triangles that cross. They count for the run too. */
size_t validate_judge(validation_run *run, const tulle_world *world);

/* Means over the vertices of a cloth, which all count the same. */
void validate_mean_position(const tulle_world *world, tulle_cloth_id id, double mean[3]);
void validate_mean_velocity(const tulle_world *world, tulle_cloth_id id, double mean[3]);

/* A plot of the experiment, drawn into the documentation. The name becomes a file's. */
typedef struct validation_plot {
    const char *name, *title, *x_label, *y_label;
    bool is_x_logarithmic, is_y_logarithmic;
} validation_plot;
void validate_start_plot(validation_run *run, const validation_plot *plot);
/* A point of the plot started last. Series appear in the order of their first points; a name that
 * begins with '*' is drawn by points, others by lines. */
void validate_plot_point(validation_run *run, const char *series, double x, double y);

#endif
