/* pinched.c - a sheet that hangs from the point at which two crossed cylinders press on it.
 *
 * The sheet hangs by its upper edge while the cylinders close on it to less than its two contact
 * distances; then the edge is let go, and friction at the point bears the weight. */
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>

static const double CONTACT_DISTANCE = 3e-3; /* [m] */
static const double SIDE = 0.3;              /* [m] of the sheet */
static const double RADIUS = 0.02;           /* [m] of the cylinders */
static const double PINCH_HEIGHT = 0.0973;   /* [m] over the sheet's middle */
static const double LET_GO = 1.0;            /* [s] */
enum { COUNT_MAX = 32 };

/* A short cylinder beside the sheet (side: -1 or 1), along x or along z, that comes nearer. */
static void add_cylinder(validation_run *run, tulle_world *world, double side, bool is_upright) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_CYLINDER);
    shape.radius = RADIUS;
    shape.height = 0.06;
    shape.resolution[0] = 48;
    shape.resolution[1] = 3;
    tulle_mesh *const mesh = validate_make_shape(run, &shape);
    double const start = RADIUS + 1.5 * CONTACT_DISTANCE, end = RADIUS + 0.95 * CONTACT_DISTANCE;
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

static tulle_cloth_id add_sheet(validation_run *run, tulle_world *world, uint32_t count) {
    tulle_mesh *const mesh =
        stage_make_sheet(run, (stage_sheet){.size = {SIDE, SIDE}, .counts = {count, count}});
    for (size_t v = 0; v < mesh->vertex_count; v++) { /* upright */
        mesh->positions[3 * v + 2] = mesh->positions[3 * v + 1];
        mesh->positions[3 * v + 1] = 0.0;
    }
    uint32_t edge[COUNT_MAX];
    for (uint32_t i = 0; i < count; i++) edge[i] = count * (count - 1) + i;
    tulle_pin const pin = {.vertices = edge, .vertex_count = count, .release_time = LET_GO};
    tulle_cloth_def cloth = stage_cloth_def(mesh);
    cloth.material.friction = 0.5;
    cloth.material.air_damping = 0.5; /* it has a minute to come to rest */
    cloth.pins = &pin;
    cloth.pin_count = 1;
    return validate_add_cloth(run, world, &cloth);
}

/* The vertex nearest to the pinch. */
static size_t find_pinched_vertex(const tulle_world *world, tulle_cloth_id sheet) {
    size_t count = 0, nearest = 0;
    const double *const x = tulle_cloth_get_positions(world, sheet, &count);
    double least = (double)INFINITY;
    for (size_t v = 0; v < count; v++) {
        double const distance = hypot(x[3 * v], x[3 * v + 2] - PINCH_HEIGHT);
        if (distance < least) nearest = v;
        least = fmin(least, distance);
    }
    return nearest;
}

static void hangs(validation_run *run) {
    bool const is_quick = validate_options(run)->is_quick;
    double const seconds = is_quick ? 6.0 : 60.0;
    tulle_world_def def = validate_world_def(run);
    def.contact_distance = CONTACT_DISTANCE;
    tulle_world *const world = validate_make_world(run, &def);
    tulle_cloth_id const sheet = add_sheet(run, world, is_quick ? 9 : 16);
    add_cylinder(run, world, -1.0, true);
    add_cylinder(run, world, 1.0, false);
    validate_start_plot(run, &(validation_plot){.name = "pinched",
                                                .title = "Sheet hanging from a pinched point",
                                                .x_label = "time [s]",
                                                .y_label = "way of the pinched vertex [m]",
                                                .is_y_logarithmic = true});
    validate_simulate(run, world, LET_GO);
    size_t const vertex = find_pinched_vertex(world, sheet);
    double start[3], half[3] = {0}, now[3] = {0};
    for (size_t c = 0; c < 3; c++)
        start[c] = tulle_cloth_get_positions(world, sheet, NULL)[3 * vertex + c];
    long const steps = lround(seconds / VALIDATION_STEP);
    tulle_step_report report = {0};
    for (long i = 1; i <= steps; i++) {
        report = validate_step(run, world, VALIDATION_STEP);
        const double *const x = tulle_cloth_get_positions(world, sheet, NULL) + 3 * vertex;
        for (size_t c = 0; c < 3; c++) now[c] = x[c];
        if (i == steps / 2)
            for (size_t c = 0; c < 3; c++) half[c] = x[c];
        if (i % 30 == 0)
            validate_plot_point(run, "from the start", tulle_world_get_time(world),
                                hypot(hypot(x[0] - start[0], x[1] - start[1]), x[2] - start[2]));
    }
    char what[96];
    snprintf(what, sizeof what, "way down of the vertex at the pinch in %g s", seconds);
    validate_row(run, what, fabs(now[2] - start[2]), "m", at_most(1e-3), "it hangs");
    snprintf(what, sizeof what, "creep in the last %g s", 0.5 * seconds);
    validate_row(run, what, hypot(hypot(now[0] - half[0], now[1] - half[1]), now[2] - half[2]), "m",
                 is_quick ? nothing() : at_most(1e-6), "it does not creep");
    validate_row(run, "kinetic energy at the end", report.kinetic_energy, "J", nothing(), "");
}

const experiment pinched_experiments[] = {
    {"pinched.hangs", "a sheet pinched at one point by two cylinders hangs for a minute", hangs,
     true},
    {0},
};
