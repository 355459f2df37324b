/* capstan.c - a ribbon around a fixed cylinder against the capstan equation.
 *
 * The ribbon is wrapped around the cylinder by phi, with straight tails along the tangents, and is
 * stretched alike everywhere. There is no gravity and nearly no bending stiffness. The end of one
 * tail is held; the end of the other is pulled slowly outwards. Slip begins at the pulled side and
 * eats its way through the wrap; until it has come through, the held tail feels nothing. Then the
 * tensions of the tails have the ratio exp(mu phi), and keep it while the pull goes on: both grow
 * alike. So the onset is read from the tails, as with two force gauges.
 *
 * Tensions are read from the tails' stretch: both are cut alike, so their strains have the ratio
 * of the tensions. The ribbon turns by 5 degrees at each column of vertices, the cylinder by 1.8 at
 * each of its own: numbers without a small common multiple, else the directions of contacts repeat
 * and their errors do not cancel (5 and 5 degrees: 10% too much). A chain that turns by a has the
 * ratio ((1 + mu tan(a/2)) / (1 - mu tan(a/2))) for each turn, together exp(mu phi (1 + a^2/12 +
 * ...)): 0.1% more in the exponent for 5 degrees.
 *
 * Steps are of 1/360 s. A ribbon in tension around a cylinder is the stiffest case for impulses
 * that are found in rounds: at 1/90 s the default three rounds let the tension flutter by a tenth,
 * twenty rounds do not. */
#include "support/pins.h"
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>

static const double RADIUS = 0.1;            /* [m] */
static const double CONTACT_DISTANCE = 1e-3; /* [m] */
static const double COLUMN_ANGLE = 5.0;      /* [degrees] between columns on the wrap */
static const double STRAIN = 3e-3;           /* at the start */
static const double FRICTION = 0.3;
static const double STEP = 1.0 / 360.0; /* [s] */
static const double SETTLING = 0.4;     /* [s] before the pull */
enum { TAIL_COLUMNS = 10, ROWS = 3, FACETS = 200 };
enum { RATE_STEPS = 18 }; /* rates of tensions are taken over 1/20 s */

typedef struct capstan {
    tulle_world *world;
    tulle_cloth_id ribbon;
    size_t columns;
    double rest_length; /* [m] of a column along the ribbon */
    double pull[3];     /* unit, outwards at the pulled end */
} capstan;

/* Where the middle line of the ribbon is `column` columns after the start of the wrap. The wrap
 * goes around z from the x axis on; columns lie on a circle whose radius leaves the contact
 * distance. */
static void find_column(double column, size_t wrapped, double place[2]) {
    double const radius = RADIUS + CONTACT_DISTANCE;
    double const angle = COLUMN_ANGLE * VALIDATION_DEGREE;
    double const chord = 2.0 * radius * sin(0.5 * angle);
    double const last = (double)wrapped;
    double const at = fmin(fmax(column, 0.0), last);
    double const around = at * angle;
    /* the tails go on along the tangents */
    double const tangent = column < 0.0 ? 0.0 : around;
    double const beyond = (column - at) * chord;
    place[0] = radius * cos(around) - sin(tangent) * beyond;
    place[1] = radius * sin(around) + cos(tangent) * beyond;
}

/* The ribbon's mesh in columns of ROWS vertices; flat at rest. */
static tulle_mesh *make_ribbon(validation_run *run, capstan *made, size_t wrapped, double **rest) {
    made->columns = wrapped + 1 + 2 * TAIL_COLUMNS;
    double const angle = COLUMN_ANGLE * VALIDATION_DEGREE;
    double const chord = 2.0 * (RADIUS + CONTACT_DISTANCE) * sin(0.5 * angle);
    made->rest_length = chord / (1.0 + STRAIN);
    tulle_mesh *const mesh =
        validate_make_mesh(run, ROWS * made->columns, 2 * (ROWS - 1) * (made->columns - 1));
    *rest = validate_allocate(run, 3 * mesh->vertex_count * sizeof **rest);
    for (size_t i = 0; i < made->columns; i++) {
        double place[2];
        find_column((double)i - TAIL_COLUMNS, wrapped, place);
        for (size_t j = 0; j < ROWS; j++) {
            double const across = ((double)j - 0.5 * (ROWS - 1)) * made->rest_length;
            double *const x = mesh->positions + 3 * (ROWS * i + j);
            x[0] = place[0];
            x[1] = place[1];
            x[2] = across;
            double *const flat = *rest + 3 * (ROWS * i + j);
            flat[0] = (double)i * made->rest_length;
            flat[1] = across;
        }
    }
    uint32_t *corner = mesh->triangles;
    for (size_t i = 0; i + 1 < made->columns; i++) {
        for (size_t j = 0; j + 1 < ROWS; j++) {
            uint32_t const a = (uint32_t)(ROWS * i + j), b = a + 1, c = a + ROWS, d = c + 1;
            bool const is_odd = (i + j) % 2 != 0;
            uint32_t const quad[6] = {
                a, c, is_odd ? b : d, is_odd ? b : a, is_odd ? c : d, is_odd ? d : b};
            for (size_t k = 0; k < 6; k++) *corner++ = quad[k];
        }
    }
    return mesh;
}

static void add_cylinder(validation_run *run, capstan *made) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_CYLINDER);
    shape.radius = RADIUS;
    shape.height = 0.03;
    shape.resolution[0] = FACETS;
    shape.resolution[1] = 2;
    tulle_mesh *const mesh = validate_make_shape(run, &shape);
    stage_move(mesh, 0.0, 0.0, -0.5 * shape.height);
    stage_add_obstacle(run, made->world, mesh, FRICTION);
}

static capstan make_capstan(validation_run *run, double degrees, double pull, double seconds) {
    tulle_world_def def = validate_world_def(run);
    def.gravity[2] = 0.0;
    def.contact_distance = CONTACT_DISTANCE;
    capstan made = {.world = validate_make_world(run, &def)};
    size_t const wrapped = (size_t)lround(degrees / COLUMN_ANGLE);
    double *rest;
    tulle_mesh *const mesh = make_ribbon(run, &made, wrapped, &rest);
    tulle_cloth_def cloth = stage_cloth_def(mesh);
    cloth.rest_positions = rest;
    cloth.material.friction = FRICTION;
    cloth.material.springs.bend_stiffness = 1e-9;
    cloth.material.springs.stiffening_strain = 0.0; /* strains are to tell tensions */
    cloth.material.air_damping = 5.0; /* [1/s] calms the start; under 0.1% of the tension */
    double const angle = degrees * VALIDATION_DEGREE;
    made.pull[0] = -sin(angle);
    made.pull[1] = cos(angle);
    tulle_keyframe const keys[2] = {
        stage_key(SETTLING, 0.0, 0.0, 0.0),
        stage_key(SETTLING + seconds, pull * made.pull[0], pull * made.pull[1], 0.0)};
    uint32_t ends[2][ROWS];
    for (uint32_t j = 0; j < ROWS; j++) {
        ends[0][j] = j;
        ends[1][j] = (uint32_t)(ROWS * (made.columns - 1)) + j;
    }
    tulle_pin pins[2] = {make_pin(ends[0], ROWS, (double)INFINITY),
                         make_pin(ends[1], ROWS, (double)INFINITY)};
    pins[1].motion = (tulle_motion){.keys = keys, .key_count = 2};
    cloth.pins = pins;
    cloth.pin_count = 2;
    made.ribbon = validate_add_cloth(run, made.world, &cloth);
    add_cylinder(run, &made);
    return made;
}

/* Strain of the middle line between two columns. */
static double find_strain(const capstan *made, size_t first, size_t last) {
    const double *const x = tulle_cloth_get_positions(made->world, made->ribbon, NULL);
    const double *const a = x + 3 * (ROWS * first + ROWS / 2);
    const double *const b = x + 3 * (ROWS * last + ROWS / 2);
    double const length = sqrt((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]) +
                               (b[2] - a[2]) * (b[2] - a[2]));
    return length / ((double)(last - first) * made->rest_length) - 1.0;
}

/* Strains of the tails' middles: two columns at each end are near the pin or the wrap. */
typedef struct tail_strains {
    double held, pulled;
} tail_strains;

static tail_strains find_strains(const capstan *made) {
    return (tail_strains){find_strain(made, 2, TAIL_COLUMNS - 2),
                          find_strain(made, made->columns - TAIL_COLUMNS + 1, made->columns - 3)};
}

typedef struct capstan_ratios {
    double at_onset, while_slipping;
    double at_last_stick; /* in the first step in which no contact sticks */
} capstan_ratios;

/* What comes through the wrap: the relative growth of the held tail's tension over that of the
 * pulled one's. 0 while any part of the wrap sticks, 1 once all of it slips. */
static double find_share(tail_strains before, tail_strains after) {
    double const growth = log(after.pulled / before.pulled);
    return growth > 0.0 ? log(after.held / before.held) / growth : 0.0;
}

/* Pulls. At the onset half comes through; slipping is measured over the last fifth. */
static capstan_ratios pull(validation_run *run, const capstan *made, double seconds, double ratio,
                           const char *series) {
    capstan_ratios ratios = {0};
    long const settling = lround(SETTLING / STEP), steps = lround(seconds / STEP);
    long const last = steps / 5;
    tail_strains past[RATE_STEPS];
    validate_plan(run, settling + steps);
    for (long i = -settling; i < steps; i++) {
        tulle_step_report const report = validate_step(run, made->world, STEP);
        tail_strains const now = find_strains(made);
        double const tensions = now.pulled / now.held;
        if (i % 4 == 0)
            validate_plot_point(run, series, tulle_world_get_time(made->world), tensions / ratio);
        if (i >= RATE_STEPS && !(ratios.at_onset > 0.0) &&
            find_share(past[i % RATE_STEPS], now) >= 0.5) {
            tail_strains const middle = past[(i - RATE_STEPS / 2) % RATE_STEPS];
            ratios.at_onset = middle.pulled / middle.held;
        }
        if (i >= 0) past[i % RATE_STEPS] = now;
        if (i > 0 && report.stick_contacts == 0 && !(ratios.at_last_stick > 0.0))
            ratios.at_last_stick = tensions;
        if (i >= steps - last) ratios.while_slipping += tensions / (double)last;
    }
    return ratios;
}

static void measure(validation_run *run, double degrees) {
    double const ratio = exp(FRICTION * degrees * VALIDATION_DEGREE);
    double const seconds = validate_options(run)->is_quick ? 0.6 : 2.5;
    /* one and a half times the strain that the ratio asks for */
    double const length = RADIUS * degrees * VALIDATION_DEGREE +
                          TAIL_COLUMNS * COLUMN_ANGLE * VALIDATION_DEGREE * RADIUS;
    capstan made = make_capstan(run, degrees, 1.5 * STRAIN * (ratio - 1.0) * length, seconds);
    char text[80];
    snprintf(text, sizeof text, "%g degrees", degrees);
    capstan_ratios const ratios = pull(run, &made, seconds, ratio, text);
    snprintf(text, sizeof text, "tension ratio at the onset of slip, %g degrees", degrees);
    validate_row(run, text, ratios.at_onset, "", within(ratio, 0.02), "exp(mu phi), mu = 0.3");
    snprintf(text, sizeof text, "that in the first step without a contact that sticks, %g degrees",
             degrees);
    validate_row(run, text, ratios.at_last_stick, "", within(ratio, 0.02), "exp(mu phi), mu = 0.3");
    snprintf(text, sizeof text, "tension ratio while it slips, %g degrees", degrees);
    validate_row(run, text, ratios.while_slipping, "", within(ratio, 0.02),
                 "exp(mu phi), mu = 0.3");
}

static void wraps(validation_run *run) {
    validate_start_plot(run, &(validation_plot){.name = "capstan",
                                                .title = "Ribbon around a cylinder, friction 0.3",
                                                .x_label = "time [s]",
                                                .y_label = "tension ratio / exp(mu phi)"});
    measure(run, 90.0);
    if (validate_options(run)->is_quick) return;
    measure(run, 180.0);
    measure(run, 270.0);
}

const experiment capstan_experiments[] = {
    {"capstan.wraps", "a ribbon pulled around a cylinder by 90, 180 and 270 degrees", wraps, false},
    {0},
};
