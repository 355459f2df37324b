/* settling.c - energy of cloth that settles on needles, with and without work from outside.
 *
 * Implicit integration, damping, friction and inelastic contact take energy; nothing may add some
 * but wind and moving obstacles, whose work is summed up step by step: the energy less that work
 * never rises. The work of an obstacle is that of its contact impulses on its own motion, the work
 * of wind the law of drag of tulle_wind at the mean velocity of the step. */
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>

static const double SIDE = 1.0; /* [m] */
static const double NEEDLE_HEIGHT = 0.2;
static const double LIFT = 0.15;      /* [m] */
static const double DRAG = 0.6;       /* [kg/m^3] */
static const double WIND_SPEED = 2.0; /* [m/s] */
enum { ROW = 3, NEEDLES = ROW * ROW };

typedef struct settling {
    tulle_world *world;
    tulle_cloth_id sheet;
    const tulle_mesh *mesh;
    double wind[3]; /* [m/s] */
    tulle_obstacle_id obstacles[NEEDLES + 1];
} settling;

/* Nine needles on the ground. With `motion` they all move. */
static settling make_settling(validation_run *run, uint32_t count, const tulle_motion *motion,
                              double wind) {
    tulle_world_def def = validate_world_def(run);
    if (wind > 0.0) {
        def.wind.velocity[0] = wind;
        def.wind.velocity[2] = 0.5 * wind;
        def.wind.drag_coefficient = DRAG;
    }
    settling made = {.world = validate_make_world(run, &def), .wind = {wind, 0.0, 0.5 * wind}};
    tulle_mesh *const mesh =
        stage_make_sheet(run, (stage_sheet){.size = {SIDE, SIDE},
                                            .counts = {count, count},
                                            .middle = {0.013, 0.007, NEEDLE_HEIGHT + 0.1}});
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(mesh);
    made.mesh = mesh;
    made.sheet = validate_add_cloth(run, made.world, &cloth);
    for (int i = 0; i <= NEEDLES; i++) {
        tulle_mesh *obstacle;
        if (i < NEEDLES) {
            tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_NEEDLE);
            shape.radius = 0.006;
            shape.height = NEEDLE_HEIGHT;
            shape.tip_height = 0.06;
            obstacle = validate_make_shape(run, &shape);
            stage_move(obstacle, 0.25 * (i % ROW - 1), 0.25 * (i / ROW - 1), 0.0);
        } else {
            obstacle = stage_make_sheet(run, (stage_sheet){.size = {4.0, 4.0}, .counts = {2, 2}});
        }
        tulle_obstacle_def needle = tulle_obstacle_def_default();
        needle.mesh = tulle_mesh_get_view(obstacle);
        needle.friction = 0.4;
        if (motion && i < NEEDLES) needle.motion = *motion;
        made.obstacles[i] = validate_add_obstacle(run, made.world, &needle);
    }
    return made;
}

/* Work [J] of the obstacles in the step that was just made: impulse on the cloth times velocity of
 * the obstacle at the contact. */
static double find_obstacle_work(validation_run *run, const settling *made) {
    const tulle_contact *contacts = NULL;
    size_t count = 0;
    double work = 0.0;
    if (tulle_world_get_contacts(made->world, &contacts, &count, NULL) != TULLE_OK)
        validate_give_up(run, "no contacts");
    for (size_t i = 0; i < count; i++) {
        const tulle_contact *const contact = &contacts[i];
        bool const is_edges = contact->kind == TULLE_CONTACT_EDGE_EDGE;
        for (int k = 0; k < 4; k++) {
            bool const is_first = k < (is_edges ? 2 : 1);
            uint32_t const object = is_first ? contact->object_a : contact->object_b;
            if (object == 0) continue; /* the cloth */
            const double *const velocity =
                tulle_obstacle_get_velocities(made->world, made->obstacles[object - 1], NULL) +
                3 * (size_t)contact->vertices[k];
            /* weights bear the sign of the side: weight times impulse acts on the vertex, and the
             * obstacle works with the opposite */
            for (int c = 0; c < 3; c++)
                work -= contact->weights[k] * contact->impulse[c] * velocity[c];
        }
    }
    return work;
}

/* Work [J] of the wind on a triangle that moves from `before` to `after`. */
static double find_triangle_work(const double wind[3], const double *const before[3],
                                 const double *const after[3], double time_step) {
    double a[3], b[3], n[3], moved[3], against = 0.0, speed = 0.0, along = 0.0;
    for (int c = 0; c < 3; c++) {
        a[c] = before[1][c] - before[0][c];
        b[c] = before[2][c] - before[0][c];
        moved[c] = 0.0;
        for (int k = 0; k < 3; k++) moved[c] += (after[k][c] - before[k][c]) / (3.0 * time_step);
    }
    n[0] = a[1] * b[2] - a[2] * b[1];
    n[1] = a[2] * b[0] - a[0] * b[2];
    n[2] = a[0] * b[1] - a[1] * b[0];
    double const twice = hypot(hypot(n[0], n[1]), n[2]);
    for (int c = 0; c < 3; c++) {
        double const relative = moved[c] - wind[c];
        against += relative * n[c] / twice;
        speed += relative * relative;
        along += moved[c] * n[c] / twice;
    }
    return -DRAG * 0.5 * twice * sqrt(speed) * against * along * time_step;
}

/* Positions before the step are those in `before`, which takes the new ones. */
static double find_wind_work(const settling *made, double *before) {
    double work = 0.0;
    const double *const after = tulle_cloth_get_positions(made->world, made->sheet, NULL);
    for (size_t t = 0; t < made->mesh->triangle_count; t++) {
        const double *first[3], *last[3];
        for (int k = 0; k < 3; k++) {
            first[k] = before + 3 * (size_t)made->mesh->triangles[3 * t + (size_t)k];
            last[k] = after + 3 * (size_t)made->mesh->triangles[3 * t + (size_t)k];
        }
        work += find_triangle_work(made->wind, first, last, VALIDATION_STEP);
    }
    return work;
}

typedef struct energy_record {
    double start, end, peak_kinetic, last_kinetic; /* [J] */
    double work;                                   /* [J] from outside */
    double spent;                                  /* [J] sum of all work's magnitudes */
    double rise, worst_step; /* [J] of energy less work: over its least so far, in one step */
    double rise_time;        /* [s] when it was largest */
    double speed;            /* [m/s] of the fastest vertex at the end */
    uint64_t rescues;
} energy_record;

static double find_top_speed(const settling *made) {
    size_t count = 0;
    double top = 0.0;
    const double *const v = tulle_cloth_get_velocities(made->world, made->sheet, &count);
    for (size_t i = 0; i < count; i++)
        top = fmax(top, hypot(hypot(v[3 * i], v[3 * i + 1]), v[3 * i + 2]));
    return top;
}

static double *copy_positions(validation_run *run, const settling *made) {
    size_t count = 0;
    const double *const x = tulle_cloth_get_positions(made->world, made->sheet, &count);
    double *const copy = validate_allocate(run, 3 * count * sizeof(double));
    for (size_t i = 0; i < 3 * count; i++) copy[i] = x[i];
    return copy;
}

/* Plots the kinetic energy, or with `has_work` the energy less the work from outside. */
static energy_record settle(validation_run *run, const settling *made, double seconds,
                            const char *series, bool has_work) {
    energy_record record = {0};
    double *const before = copy_positions(run, made);
    size_t const size = 3 * made->mesh->vertex_count;
    double least = 0.0, last = 0.0;
    long const steps = lround(seconds / VALIDATION_STEP);
    validate_plan(run, steps);
    for (long i = 0; i < steps; i++) {
        tulle_step_report const report = validate_step(run, made->world, VALIDATION_STEP);
        double const energy = report.kinetic_energy + report.gravity_energy + report.elastic_energy;
        double work = find_obstacle_work(run, made);
        if (made->wind[0] > 0.0) work += find_wind_work(made, before);
        const double *const x = tulle_cloth_get_positions(made->world, made->sheet, NULL);
        for (size_t k = 0; k < size; k++) before[k] = x[k];
        record.work += i > 0 ? work : 0.0;
        record.spent += i > 0 ? fabs(work) : 0.0;
        double const balance = energy - record.work;
        if (i == 0) record.start = least = last = balance;
        record.worst_step = fmax(record.worst_step, balance - last);
        if (balance - least > record.rise) record.rise_time = report.time;
        record.rise = fmax(record.rise, balance - least);
        least = fmin(least, balance);
        last = balance;
        record.end = energy;
        record.peak_kinetic = fmax(record.peak_kinetic, report.kinetic_energy);
        record.last_kinetic = report.kinetic_energy;
        record.rescues += report.rescue_impact_zones + report.rescue_component_scalings +
                          report.rescue_global_scalings;
        if (i % 9 == 0)
            validate_plot_point(run, series, report.time,
                                has_work ? balance - record.start : report.kinetic_energy);
    }
    record.speed = find_top_speed(made);
    return record;
}

static void report_balance(validation_run *run, const char *name, const energy_record *record,
                           expectation most) {
    double const lost = record->start + record->work - record->end;
    char what[120];
    snprintf(what, sizeof what, "%s: energy that went", name);
    validate_row(run, what, lost, "J", at_least(0.0), "");
    snprintf(what, sizeof what, "%s: work from outside", name);
    validate_row(run, what, record->work, "J", nothing(), "");
    snprintf(what, sizeof what, "%s: rise of energy less work, over what went", name);
    validate_row(run, what, record->rise / lost, "", most, "never more than the work, within 1%");
    snprintf(what, sizeof what, "%s: when it is largest", name);
    validate_row(run, what, record->rise_time, "s", nothing(), "");
    snprintf(what, sizeof what, "%s: largest rise in one step, over what went", name);
    validate_row(run, what, record->worst_step / lost, "", nothing(), "");
    snprintf(what, sizeof what, "%s: rescues", name);
    validate_row(run, what, (double)record->rescues, "", nothing(), "");
}

static void comes_to_rest(validation_run *run) {
    uint32_t const count = validate_options(run)->is_quick ? 17 : 41;
    validate_start_plot(run, &(validation_plot){.name = "settling",
                                                .title = "Cloth settling on nine needles",
                                                .x_label = "time [s]",
                                                .y_label = "kinetic energy [J]",
                                                .is_y_logarithmic = true});
    settling const made = make_settling(run, count, NULL, 0.0);
    energy_record const record = settle(run, &made, 20.0, "still needles", false);
    report_balance(run, "still needles", &record, at_most(1e-6));
    validate_row(run, "still needles: kinetic energy after 20 s, over its peak",
                 record.last_kinetic / record.peak_kinetic, "", at_most(1e-9), "at rest");
    validate_row(run, "still needles: fastest vertex after 20 s", record.speed, "m/s", nothing(),
                 "");
}

static void takes_work(validation_run *run) {
    bool const is_quick = validate_options(run)->is_quick;
    uint32_t const count = is_quick ? 17 : 33;
    validate_start_plot(run, &(validation_plot){.name = "settling_work",
                                                .title = "Cloth on needles: energy less work",
                                                .x_label = "time [s]",
                                                .y_label = "less that after the first step [J]"});
    tulle_keyframe const keys[4] = {stage_key(1.0, 0.0, 0.0, 0.0), stage_key(2.0, 0.05, 0.0, LIFT),
                                    stage_key(2.5, 0.05, 0.0, LIFT),
                                    stage_key(3.0, 0.05, 0.0, 0.5 * LIFT)};
    tulle_motion const motion = {.keys = keys, .key_count = 4, .is_eased = 1};
    settling const lifted = make_settling(run, count, &motion, 0.0);
    energy_record const by_needles =
        settle(run, &lifted, is_quick ? 4.0 : 20.0, "moving needles", true);
    report_balance(run, "moving needles", &by_needles, at_most(0.01));
    settling const blown = make_settling(run, count, NULL, WIND_SPEED);
    energy_record const by_wind = settle(run, &blown, is_quick ? 4.0 : 20.0, "wind", true);
    report_balance(run, "wind", &by_wind, at_most(0.01));
}

const experiment settling_experiments[] = {
    {"settling.rest", "cloth on needles loses energy until it is at rest", comes_to_rest, false},
    {"settling.work", "wind and moving needles give no more than their work", takes_work, false},
    {0},
};
