/* turning.c - edges that turn while they touch. A narrow ribbon is drawn taut over the ridge of a
 * roof, which turns from square across it to ten degrees along it, without friction.
 *
 * Statics without friction know no history as long as there is one equilibrium: then a ribbon that
 * was turned into a place must lie as one that was drawn tight there. A strip that is folded along
 * a ridge at the angle a to it goes down from there with a slope of sin(slope) = sin(a) sin(fold),
 * so with a slope of up to a. Steeper arms twist it, and it has several equilibria: drawn down by
 * 0.06 m (16 degrees) it lies at 10 degrees in one of two places, 1.65 mm apart, from wherever it
 * was turned (12, 30, 60, 90 degrees in the one; 5, 8, 11, 15, 20 degrees in the other). */
#include "support/pins.h"
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>

static const double LENGTH = 0.4, WIDTH = 0.008; /* [m] of the ribbon, along x */
static const double RIDGE_LENGTH = 0.3;          /* [m] */
static const double CONTACT_DISTANCE = 2e-3;     /* [m] */
static const double TIGHTEN = 0.025;             /* [m] by which the ribbon's ends go down */
static const double FIRST_ANGLE = 90.0, LAST_ANGLE = 10.0;     /* [degrees] between the edges */
static const double TURN_FROM = 1.0, TURN_TO = 4.0, END = 6.0; /* [s] */
enum { ALONG = 41, ACROSS = 2, KEYS = 17 };

typedef struct turning {
    tulle_world *world;
    tulle_cloth_id ribbon;
} turning;

/* A roof with its ridge along x at z = 0. */
static tulle_mesh *make_roof(validation_run *run) {
    tulle_mesh *const mesh = validate_make_mesh(run, 6, 8);
    for (int i = 0; i < 6; i++) {
        int const corner = i % 3; /* the ridge, then the eaves */
        mesh->positions[3 * i] = (i < 3 ? -0.5 : 0.5) * RIDGE_LENGTH;
        mesh->positions[3 * i + 1] = corner == 0 ? 0.0 : corner == 1 ? -0.03 : 0.03;
        mesh->positions[3 * i + 2] = corner == 0 ? 0.0 : -0.2;
    }
    static const uint32_t faces[24] = {0, 2, 1, 3, 4, 5, 0, 1, 4, 0, 4, 3,
                                       0, 3, 5, 0, 5, 2, 1, 2, 5, 1, 5, 4};
    for (int i = 0; i < 24; i++) mesh->triangles[i] = faces[i];
    return mesh;
}

static tulle_keyframe make_turned_key(double time, double degrees) {
    return (tulle_keyframe){.time = time,
                            .rotation_vector = {0.0, 0.0, degrees * VALIDATION_DEGREE}};
}

/* The roof at an angle, or turned from one to another. */
static turning make_turning(validation_run *run, double from, double to) {
    tulle_world_def def = validate_world_def(run);
    def.contact_distance = CONTACT_DISTANCE;
    turning made = {.world = validate_make_world(run, &def)};
    tulle_mesh *const mesh =
        stage_make_sheet(run, (stage_sheet){.size = {LENGTH, WIDTH},
                                            .counts = {ALONG, ACROSS},
                                            .middle = {0.0013, 0.0007, 1.2 * CONTACT_DISTANCE}});
    tulle_keyframe const down[2] = {stage_key(0.0, 0.0, 0.0, 0.0),
                                    stage_key(0.8, 0.0, 0.0, -TIGHTEN)};
    uint32_t const ends[4] = {0, ALONG - 1, ALONG, 2 * ALONG - 1};
    tulle_pin pin = make_pin(ends, 4, (double)INFINITY);
    pin.motion = (tulle_motion){.keys = down, .key_count = 2, .is_eased = 1};
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(mesh);
    cloth.material.friction = 0.0;
    cloth.material.air_damping = 2.0;
    cloth.pins = &pin;
    cloth.pin_count = 1;
    made.ribbon = validate_add_cloth(run, made.world, &cloth);
    tulle_keyframe keys[KEYS];
    for (int i = 0; i < KEYS; i++) {
        double const share = (double)i / (KEYS - 1);
        keys[i] =
            make_turned_key(TURN_FROM + share * (TURN_TO - TURN_FROM), from + share * (to - from));
    }
    tulle_obstacle_def roof = tulle_obstacle_def_default();
    roof.mesh = tulle_mesh_get_view(make_roof(run));
    roof.friction = 0.0;
    roof.motion = (tulle_motion){.keys = keys, .key_count = KEYS};
    validate_add_obstacle(run, made.world, &roof);
    return made;
}

typedef struct turning_record {
    double least_load, most_load; /* [N] while it turns */
    double end_load;
    double largest_gap; /* [m] least gap of a loaded contact, its largest in a step */
    uint64_t rescues;
} turning_record;

/* Load [N] of all contacts along z, and the least gap of a loaded one. */
static double find_load(validation_run *run, tulle_world *world, double *gap) {
    const tulle_contact *contacts = NULL;
    size_t count = 0;
    double load = 0.0;
    *gap = (double)INFINITY;
    if (tulle_world_get_contacts(world, &contacts, &count, NULL) != TULLE_OK)
        validate_give_up(run, "no contacts");
    for (size_t i = 0; i < count; i++) {
        if (contacts[i].state == TULLE_CONTACT_OPEN) continue;
        double const sign = contacts[i].object_a == 0 ? 1.0 : -1.0;
        load += sign * contacts[i].impulse[2] / VALIDATION_STEP;
        *gap = fmin(*gap, contacts[i].gap);
    }
    return load;
}

static turning_record turn(validation_run *run, const turning *made, const char *series) {
    turning_record record = {.least_load = (double)INFINITY};
    long const steps = lround(END / VALIDATION_STEP);
    validate_plan(run, steps);
    for (long i = 0; i < steps; i++) {
        tulle_step_report const report = validate_step(run, made->world, VALIDATION_STEP);
        double gap, load = find_load(run, made->world, &gap);
        record.rescues += report.rescue_impact_zones + report.rescue_component_scalings +
                          report.rescue_global_scalings;
        record.end_load = load;
        if (report.time < TURN_FROM) continue;
        record.least_load = fmin(record.least_load, load);
        record.most_load = fmax(record.most_load, load);
        record.largest_gap = fmax(record.largest_gap, gap);
        if (i % 3 == 0) validate_plot_point(run, series, report.time, load);
    }
    return record;
}

static void turns(validation_run *run) {
    validate_start_plot(run, &(validation_plot){.name = "turning",
                                                .title = "Ribbon over a ridge that turns under it",
                                                .x_label = "time [s]",
                                                .y_label = "load of the ridge [N]"});
    turning const turned = make_turning(run, FIRST_ANGLE, LAST_ANGLE);
    turning_record const record = turn(run, &turned, "from 90 to 10 degrees");
    turning const still = make_turning(run, LAST_ANGLE, LAST_ANGLE);
    turning_record const reference = turn(run, &still, "10 degrees");
    size_t count = 0;
    double apart = 0.0;
    const double *const x = tulle_cloth_get_positions(turned.world, turned.ribbon, &count);
    const double *const y = tulle_cloth_get_positions(still.world, still.ribbon, NULL);
    for (size_t v = 0; v < 3 * count; v++) apart = fmax(apart, fabs(x[v] - y[v]));
    validate_row(run, "least load while it turns, over the load at the end",
                 record.least_load / record.end_load, "", at_least(0.8), "never apart");
    validate_row(run, "most load while it turns, over the load at the end",
                 record.most_load / record.end_load, "", at_most(1.2), "nothing is caught");
    validate_row(run, "largest gap, over the contact distance",
                 record.largest_gap / CONTACT_DISTANCE, "", at_most(1.01), "never apart");
    validate_row(run, "load at the end over that of a ribbon laid there",
                 record.end_load / reference.end_load, "", within(1.0, 0.01), "no history");
    validate_row(run, "farthest vertex from where a ribbon laid there is", apart, "m",
                 at_most(1e-3), "no history; half a contact distance");
    validate_row(run, "rescues", (double)record.rescues, "", equals(0.0), "");
}

const experiment turning_experiments[] = {
    {"turning.ridge", "edges in contact turn from 90 to 10 degrees without friction", turns, false},
    {0},
};
