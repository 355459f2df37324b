/* pinched.c - a sheet that hangs from the point at which two crossed cylinders press on it.
 *
 * The sheet hangs by its upper edge while the cylinders close on it to less than its two contact
 * distances; then the edge is let go, and friction at the point bears the weight. */
#include "support/pins.h"
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>

static const double CONTACT_DISTANCE = 3e-3; /* [m] */
static const double SIDE = 0.3;              /* [m] of the sheet */
static const double RADIUS = 0.02;           /* [m] of the cylinders */
static const double PINCH_HEIGHT = 0.0973;   /* [m] over the sheet's middle */
static const double LET_GO = 2.0;            /* [s] */
enum { COUNT_MAX = 32 };

/* A short cylinder beside the sheet (side: -1 or 1), along x or along z, that comes nearer. */
static void add_cylinder(validation_run *run, tulle_world *world, double side, bool is_upright) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_CYLINDER);
    shape.radius = RADIUS;
    shape.height = 0.06;
    shape.resolution[0] = 48;
    shape.resolution[1] = 3;
    tulle_mesh *const mesh = validate_make_shape(run, &shape);
    double const start = RADIUS + 1.5 * CONTACT_DISTANCE, end = RADIUS + 0.6 * CONTACT_DISTANCE;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *const x = mesh->positions + 3 * v;
        double const along = x[2] - 0.5 * shape.height;
        double const across = is_upright ? x[0] : x[1];
        x[1] = side * start + (is_upright ? x[1] : x[0]);
        x[0] = is_upright ? across : along;
        x[2] = PINCH_HEIGHT + (is_upright ? along : across);
    }
    tulle_keyframe const keys[2] = {stage_key(0.2, 0.0, 0.0, 0.0),
                                    stage_key(0.7, 0.0, side * (end - start), 0.0)};
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    def.friction = 0.5;
    def.motion = (tulle_motion){.keys = keys, .key_count = 2};
    validate_add_obstacle(run, world, &def);
}

static tulle_cloth_id add_sheet(validation_run *run, tulle_world *world, uint32_t count,
                                tulle_mesh **made) {
    tulle_mesh *const mesh =
        stage_make_sheet(run, (stage_sheet){.size = {SIDE, SIDE}, .counts = {count, count}});
    *made = mesh;
    for (size_t v = 0; v < mesh->vertex_count; v++) { /* upright */
        mesh->positions[3 * v + 2] = mesh->positions[3 * v + 1];
        mesh->positions[3 * v + 1] = 0.0;
    }
    uint32_t edge[COUNT_MAX];
    for (uint32_t i = 0; i < count; i++) edge[i] = count * (count - 1) + i;
    tulle_pin const pin = make_pin(edge, count, LET_GO);
    tulle_cloth_def cloth = stage_cloth_def(mesh);
    cloth.material.friction = 0.5;
    cloth.material.air_damping = 0.5; /* it has a minute to come to rest */
    cloth.pins = &pin;
    cloth.pin_count = 1;
    return validate_add_cloth(run, world, &cloth);
}

/* A point of the sheet: a place in a triangle. */
typedef struct sheet_point {
    uint32_t corners[3];
    double weights[3];
} sheet_point;

/* The point between the cylinders: the sheet still hangs upright. */
static sheet_point find_pinched_point(validation_run *run, const double *x,
                                      const tulle_mesh *mesh) {
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *const corner = mesh->triangles + 3 * t;
        double across[3], up[3];
        for (size_t k = 0; k < 3; k++) {
            across[k] = x[3 * corner[k]];
            up[k] = x[3 * corner[k] + 2] - PINCH_HEIGHT;
        }
        sheet_point point = {.corners = {corner[0], corner[1], corner[2]}};
        double const area =
            (across[1] - across[0]) * (up[2] - up[0]) - (across[2] - across[0]) * (up[1] - up[0]);
        for (size_t k = 0; k < 3; k++) {
            size_t const i = (k + 1) % 3, j = (k + 2) % 3;
            point.weights[k] = (across[i] * up[j] - across[j] * up[i]) / area;
        }
        if (point.weights[0] >= 0.0 && point.weights[1] >= 0.0 && point.weights[2] >= 0.0)
            return point;
    }
    validate_give_up(run, "no triangle of the sheet is between the cylinders");
}

static void find_place(const sheet_point *point, const double *x, double place[3]) {
    for (size_t c = 0; c < 3; c++) {
        place[c] = 0.0;
        for (size_t k = 0; k < 3; k++) place[c] += point->weights[k] * x[3 * point->corners[k] + c];
    }
}

static double find_distance(const double a[3], const double b[3]) {
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

static void hangs(validation_run *run) {
    bool const is_quick = validate_options(run)->is_quick;
    double const seconds = is_quick ? 6.0 : 60.0;
    tulle_world_def def = validate_world_def(run);
    def.contact_distance = CONTACT_DISTANCE;
    tulle_world *const world = validate_make_world(run, &def);
    tulle_mesh *mesh;
    tulle_cloth_id const sheet = add_sheet(run, world, is_quick ? 9 : 16, &mesh);
    add_cylinder(run, world, -1.0, true);
    add_cylinder(run, world, 1.0, false);
    validate_start_plot(run, &(validation_plot){.name = "pinched",
                                                .title = "Sheet hanging from a pinched point",
                                                .x_label = "time [s]",
                                                .y_label = "way of the point [m]"});
    validate_simulate(run, world, LET_GO);
    sheet_point const point =
        find_pinched_point(run, tulle_cloth_get_positions(world, sheet, NULL), mesh);
    double start[3], half[3] = {0}, now[3] = {0};
    find_place(&point, tulle_cloth_get_positions(world, sheet, NULL), start);
    long const steps = lround(seconds / VALIDATION_STEP);
    tulle_step_report report = {0};
    validate_plan(run, steps);
    for (long i = 1; i <= steps; i++) {
        report = validate_step(run, world, VALIDATION_STEP);
        find_place(&point, tulle_cloth_get_positions(world, sheet, NULL), now);
        if (i == steps / 2)
            for (size_t c = 0; c < 3; c++) half[c] = now[c];
        if (i % 30 == 0)
            validate_plot_point(run, "from the start", tulle_world_get_time(world),
                                find_distance(now, start));
    }
    char what[96];
    snprintf(what, sizeof what, "way of the pinched point of the sheet in %g s", seconds);
    validate_row(run, what, find_distance(now, start), "m", at_most(CONTACT_DISTANCE), "it hangs");
    snprintf(what, sizeof what, "of it in the last %g s", 0.5 * seconds);
    validate_row(run, what, find_distance(now, half), "m", is_quick ? nothing() : at_most(1e-6),
                 "it does not creep");
    validate_row(run, "kinetic energy at the end", report.kinetic_energy, "J", nothing(), "");
}

const experiment pinched_experiments[] = {
    {"pinched.hangs", "a sheet pinched at one point by two cylinders hangs for a minute", hangs,
     true},
    {0},
};
