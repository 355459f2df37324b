/* shears.c - woven cloth in a square frame whose sides turn about its corners: its shear against
 * the fabric's curve, and the wrinkles that it makes. */
#include "support/pins.h"
#include "validation/stage.h"
#include "validation/strips.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static double const PI = 3.14159265358979323846;

/* A square of cloth in its frame; the warp lies along x. */
typedef struct frame {
    const char *fabric;
    pattern pattern;
    uint32_t cells; /* along a side */
    double side;    /* [m] */
} frame;

static tulle_mesh *make_square(validation_run *run, frame of) {
    strip const sample = {.begin = -0.5 * of.side,
                          .end = 0.5 * of.side,
                          .width = of.side,
                          .columns = of.cells,
                          .rows = of.cells,
                          .pattern = of.pattern};
    return strips_make(run, &sample);
}

static bool is_on_border(const double *rest, double side) {
    return fmax(fabs(rest[0]), fabs(rest[1])) > 0.5 * side - 1e-9;
}

/* Numbers from -1 to 1, the same in every run. */
static double draw(uint32_t *noise) {
    *noise = *noise * 1664525u + 1013904223u;
    return (*noise >> 8) / 8388608.0 - 1.0;
}

static tulle_world *make_weightless_world(validation_run *run) {
    tulle_world_def def = validate_world_def(run);
    def.membrane = TULLE_MEMBRANE_WOVEN;
    def.gravity[2] = 0.0;
    return validate_make_world(run, &def);
}

/* ---- shear by its curve ---- */

/* Energy by area [N/m] of flat cloth at rest whose frame is sheared by `angle`. The vertices within
 * start a tenth of a cell off at random. */
static double measure_sheared_energy(validation_run *run, frame of, double angle) {
    tulle_mesh *const mesh = make_square(run, of);
    size_t const bytes = 3 * mesh->vertex_count * sizeof(double);
    double *const rest = memcpy(validate_allocate(run, bytes), mesh->positions, bytes);
    uint32_t *const held = validate_allocate(run, mesh->vertex_count * sizeof *held);
    size_t count = 0;
    uint32_t noise = 1;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *const x = mesh->positions + 3 * v;
        x[0] += sin(angle) * rest[3 * v + 1];
        x[1] *= cos(angle);
        if (is_on_border(rest + 3 * v, of.side))
            held[count++] = (uint32_t)v;
        else
            for (size_t c = 0; c < 2; c++) x[c] += 0.1 * of.side / of.cells * draw(&noise);
    }
    tulle_pin const pin = make_pin(held, count, (double)INFINITY);
    tulle_world *const world = make_weightless_world(run);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    def.rest_positions = rest;
    def.material = stage_take_fabric(run, of.fabric);
    def.material.air_damping = 5.0;
    def.pins = &pin;
    def.pin_count = 1;
    validate_add_cloth(run, world, &def);
    validate_simulate(run, world, 1.0);
    return validate_step(run, world, VALIDATION_STEP).elastic_energy / (of.side * of.side);
}

/* Force by length [N/m] along the sides of the frame, from the work that a little more takes: the
 * sines of the angle say how far the sides' ends go along the other sides. */
static double measure_shear(validation_run *run, frame of, double angle) {
    double const change = 0.25 * VALIDATION_DEGREE;
    return (measure_sheared_energy(run, of, angle + change) -
            measure_sheared_energy(run, of, angle - change)) /
           (sin(angle + change) - sin(angle - change));
}

static double find_shear(tulle_curve curve, double angle) {
    double const s = sin(angle), part = s / curve.knee;
    return curve.stiffness * s * (1.0 + part * part);
}

static void shears_by_its_curve(validation_run *run) {
    static const double angles[] = {2.5, 5.0, 10.0, 15.0, 20.0, 30.0}; /* [deg] */
    bool const is_quick = validate_options(run)->is_quick;
    tulle_curve const curve = stage_take_fabric(run, "cotton").shear;
    validate_start_plot(run, &(validation_plot){.name = "shear",
                                                .title = "Shear of cotton in a frame",
                                                .x_label = "angle of shear [deg]",
                                                .y_label = "force along a side [N/m]"});
    for (int i = 0; i <= 60; i++)
        validate_plot_point(run, "G s (1 + (s / knee)^2)", 0.5 * i,
                            find_shear(curve, 0.5 * i * VALIDATION_DEGREE));
    for (int p = 0; p < (is_quick ? 1 : TURNED); p++) {
        double off = 0.0;
        for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) {
            frame const of = {"cotton", (pattern)p, 10, 0.1};
            double const angle = angles[i] * VALIDATION_DEGREE;
            double const measured = measure_shear(run, of, angle);
            char series[48];
            snprintf(series, sizeof series, "*%s", strips_pattern_names[p]);
            validate_plot_point(run, series, angles[i], measured);
            off = fmax(off, fabs(measured / find_shear(curve, angle) - 1.0));
        }
        char what[96];
        snprintf(what, sizeof what, "shear of cotton up to 30 degrees, %s: off by",
                 strips_pattern_names[p]);
        validate_row(run, what, 100.0 * off, "%", at_most(0.2),
                     "G s (1 + (s / knee)^2), s the sine of the angle");
    }
}

/* As laboratories say it: slope from 0.5 to 2.5 degrees. */
static void shears_as_in_laboratories(validation_run *run) {
    static const char *const fabrics[] = {"cotton", "silk", "wool", "denim"};
    bool const is_quick = validate_options(run)->is_quick;
    double const unit = 98.0665 * 0.01; /* [N/m] in a gf/cm */
    for (size_t i = 0; i < (is_quick ? 1 : 4); i++) {
        frame const of = {fabrics[i], IRREGULAR, 10, 0.1};
        double const low = 0.5 * VALIDATION_DEGREE, high = 2.5 * VALIDATION_DEGREE;
        tulle_curve const curve = stage_take_fabric(run, fabrics[i]).shear;
        char what[96];
        snprintf(what, sizeof what, "shear stiffness of %s, 0.5 to 2.5 degrees", fabrics[i]);
        validate_row(
            run, what, (measure_shear(run, of, high) - measure_shear(run, of, low)) / (2.0 * unit),
            "gf/(cm deg)",
            within((find_shear(curve, high) - find_shear(curve, low)) / (2.0 * unit), 2e-3),
            "its curve");
    }
}

/* ---- wrinkles ---- */

typedef struct wrinkles {
    double length, amplitude; /* [m] */
} wrinkles;

/* Of waves z = a sin(2 pi x / l) the mean of z^2 is a^2 / 2, and that of its slope squared
 * (2 pi / l)^2 times as much. */
static wrinkles measure_wrinkles(const tulle_mesh *mesh, const double *x) {
    double heights = 0.0, slopes = 0.0, area = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *const corners = mesh->triangles + 3 * t;
        const double *const o = mesh->positions + 3 * (size_t)corners[0];
        double edges[2][2], rises[2], squares = 0.0, sum = 0.0;
        for (size_t k = 0; k < 3; k++) {
            double const z = x[3 * (size_t)corners[k] + 2];
            sum += z;
            squares += z * z;
            if (k == 0) continue;
            for (size_t c = 0; c < 2; c++)
                edges[k - 1][c] = mesh->positions[3 * (size_t)corners[k] + c] - o[c];
            rises[k - 1] = z - x[3 * (size_t)corners[0] + 2];
        }
        double const twice = edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0];
        double const slope[2] = {(rises[0] * edges[1][1] - rises[1] * edges[0][1]) / twice,
                                 (rises[1] * edges[0][0] - rises[0] * edges[1][0]) / twice};
        heights += 0.5 * twice * (squares + sum * sum) / 12.0;
        slopes += 0.5 * twice * (slope[0] * slope[0] + slope[1] * slope[1]);
        area += 0.5 * twice;
    }
    return (wrinkles){2.0 * PI * sqrt(heights / slopes), sqrt(2.0 * heights / area)};
}

enum { MOVES = 41 }; /* keys of the side that goes along an arc */

/* Vertices of one side of the frame: `axis` and `sign` say which. */
static tulle_pin hold_side(validation_run *run, const tulle_mesh *mesh, double side, size_t axis,
                           double sign) {
    uint32_t *const held = validate_allocate(run, mesh->vertex_count * sizeof *held);
    size_t count = 0;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        const double *const x = mesh->positions + 3 * v;
        /* The corners belong to the sides that turn. */
        bool const is_corner = fmin(fabs(x[0]), fabs(x[1])) > 0.5 * side - 1e-9;
        if (sign * x[axis] > 0.5 * side - 1e-9 && !(axis == 1 && is_corner))
            held[count++] = (uint32_t)v;
    }
    return make_pin(held, count, (double)INFINITY);
}

/* Cloth whose frame is sheared by `angle` within 2 s, and stays so. */
static wrinkles wrinkle(validation_run *run, frame of, double angle) {
    tulle_mesh *const mesh = make_square(run, of);
    double const half = 0.5 * of.side;
    tulle_pin pins[4] = {
        hold_side(run, mesh, of.side, 0, -1.0), hold_side(run, mesh, of.side, 0, 1.0),
        hold_side(run, mesh, of.side, 1, -1.0), hold_side(run, mesh, of.side, 1, 1.0)};
    tulle_keyframe turn[2] = {stage_key(0.0, 0.0, 0.0, 0.0), stage_key(2.0, 0.0, 0.0, 0.0)};
    turn[1].rotation_vector[2] = -angle;
    tulle_keyframe along[MOVES];
    for (int i = 0; i < MOVES; i++) {
        double const part = (double)i / (MOVES - 1), now = part * angle;
        along[i] = stage_key(2.0 * part, of.side * sin(now), of.side * (cos(now) - 1.0), 0.0);
    }
    for (size_t i = 0; i < 2; i++)
        pins[i].motion = (tulle_motion){
            .keys = turn, .key_count = 2, .pivot = {i == 0 ? -half : half, -half, 0.0}};
    pins[3].motion = (tulle_motion){.keys = along, .key_count = MOVES};
    /* A height of 0.1 mm that does not depend on the mesh, so that it may leave the plane. */
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *const x = mesh->positions + 3 * v;
        double const a = PI * (x[0] / of.side + 0.5), b = PI * (x[1] / of.side + 0.5);
        uint32_t noise = 1;
        for (int i = 1; i <= 6; i++)
            for (int j = 1; j <= 6; j++) x[2] += 2e-5 * draw(&noise) * sin(i * a) * sin(j * b);
        if (is_on_border(x, of.side)) x[2] = 0.0;
    }
    tulle_world *const world = make_weightless_world(run);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    def.has_flat_rest = 1;
    def.material = stage_take_fabric(run, of.fabric);
    def.material.air_damping = 2.0;
    def.pins = pins;
    def.pin_count = 4;
    tulle_cloth_id const id = validate_add_cloth(run, world, &def);
    validate_simulate(run, world, 4.0);
    const double *const x = tulle_cloth_get_positions(world, id, NULL);
    char series[64];
    snprintf(series, sizeof series, "%u cells, %s", of.cells, strips_pattern_names[of.pattern]);
    /* From the corner that is pushed inwards to the one across. */
    if (of.pattern == ALTERNATING)
        for (size_t i = 0; i <= of.cells; i++) {
            size_t const v = (of.cells - i) * (of.cells + 1) + i;
            validate_plot_point(run, series, 100.0 * (double)i / of.cells, 1e3 * x[3 * v + 2]);
        }
    return measure_wrinkles(mesh, x);
}

static void wrinkles_alike_when_finer(validation_run *run) {
    static const frame frames[] = {{"cotton", ALTERNATING, 20, 0.2},
                                   {"cotton", ALTERNATING, 40, 0.2},
                                   {"cotton", ALTERNATING, 80, 0.2},
                                   {"cotton", ALIKE, 40, 0.2},
                                   {"cotton", IRREGULAR, 40, 0.2}};
    bool const is_quick = validate_options(run)->is_quick;
    validate_start_plot(run, &(validation_plot){.name = "wrinkles",
                                                .title = "Cotton in a frame of 0.2 m, 5 degrees",
                                                .x_label = "along the short diagonal [%]",
                                                .y_label = "height [mm]"});
    wrinkles found[sizeof frames / sizeof *frames];
    for (size_t i = 0; i < (is_quick ? 1 : sizeof frames / sizeof *frames); i++) {
        found[i] = wrinkle(run, frames[i], 5.0 * VALIDATION_DEGREE);
        char what[96];
        snprintf(what, sizeof what, "wavelength, %u cells a side, %s", frames[i].cells,
                 strips_pattern_names[frames[i].pattern]);
        validate_row(run, what, 1e3 * found[i].length, "mm", nothing(), "");
        validate_row(run, "amplitude", 1e3 * found[i].amplitude, "mm", nothing(), "");
    }
    if (is_quick) return;
    validate_row(run, "wavelength, 80 cells over 40 cells", found[2].length / found[1].length, "",
                 within(1.0, 0.05), "wrinkles of the fabric, not of the mesh");
    validate_row(run, "amplitude, 80 cells over 40 cells", found[2].amplitude / found[1].amplitude,
                 "", within(1.0, 0.05), "wrinkles of the fabric, not of the mesh");
    validate_row(run, "cells in a wavelength, 80 cells a side",
                 found[2].length / (frames[2].side / frames[2].cells), "", at_least(8.0),
                 "not of cell size");
}

const experiment shears_experiments[] = {
    {"shears.curve", "cloth in a frame shears by its curve", shears_by_its_curve, false},
    {"shears.slope", "the same, in the unit of laboratories", shears_as_in_laboratories, true},
    {"shears.wrinkles", "wrinkles in a frame do not depend on the mesh", wrinkles_alike_when_finer,
     true},
    {0},
};
