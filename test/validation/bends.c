/* bends.c - strips of woven cloth that bend far, against the elastica: a loop that hangs as a
 * heart, a strip that buckles. */
#include "validation/elastica.h"
#include "validation/stage.h"
#include "validation/strips.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static double const PI = 3.14159265358979323846;
static double const WIDTH = 0.025; /* [m] as of strips in laboratories */

static double *copy_positions(validation_run *run, const tulle_mesh *mesh) {
    size_t const bytes = 3 * mesh->vertex_count * sizeof(double);
    return memcpy(validate_allocate(run, bytes), mesh->positions, bytes);
}

/* ---- a loop hangs as a heart ---- */

enum { POINTS = 401 }; /* along half of a heart */

/* Where a loop of that length starts: as a heart without weight, its ends in jaws. */
static void bend_to_heart(double *x, double length, double gap, const double *points) {
    double const from_end = fmin(x[0], length - x[0]), side = 2.0 * x[0] < length ? 1.0 : -1.0;
    double across = gap, up = from_end;
    if (from_end > 0.0) {
        double const place = from_end / (0.5 * length) * (POINTS - 1);
        int const i = (int)fmin(place, POINTS - 2);
        double const part = place - i;
        across = length * ((1.0 - part) * points[2 * i] + part * points[2 * i + 2]);
        up = length * ((1.0 - part) * points[2 * i + 1] + part * points[2 * i + 3]);
    }
    x[0] = side * across;
    x[2] = up;
}

typedef struct loop {
    const char *fabric;
    pattern pattern;
    double cells; /* of the mesh in a bending length of the fabric */
} loop;

/* How far the loop hangs below its jaws over what the elastica says. It is as long as six bending
 * lengths, 114 mm of cotton, and as wide as half of one. */
static double measure_heart(validation_run *run, loop form) {
    tulle_material const material = stage_take_fabric(run, form.fabric);
    double const c = cbrt(material.bend_warp / (material.area_density * VALIDATION_GRAVITY));
    double const length = 6.0 * c, cell = c / form.cells;
    strip const sample = {.begin = -3.0 * cell,
                          .end = length + 3.0 * cell,
                          .width = 0.5 * c,
                          .columns = (uint32_t)lround(length / cell) + 6,
                          .rows = (uint32_t)lround(0.5 * form.cells),
                          .pattern = form.pattern,
                          .lines = {0.0, length}};
    tulle_mesh *const mesh = strips_make(run, &sample);
    double *const rest = copy_positions(run, mesh);
    /* The inner vertices of an irregular mesh do not lie on lines. */
    double const room = form.pattern == IRREGULAR ? 0.3 * cell : 0.0;
    tulle_pin const pins[2] = {strips_pin_between(run, mesh, sample.begin, room),
                               strips_pin_between(run, mesh, length - room, sample.end)};
    double const gap = 0.01;
    double points[2 * POINTS], drop = 0.0;
    heart shape = {.weight = 0.0, .gap = gap};
    if (!elastica_find_heart(shape, &drop, points, POINTS))
        validate_give_up(run, "the elastica was not found");
    for (size_t v = 0; v < mesh->vertex_count; v++)
        bend_to_heart(mesh->positions + 3 * v, length, gap * length, points);
    tulle_world *const world = stage_make_woven_world(run);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    def.rest_positions = rest;
    def.material = material;
    def.material.air_damping = 10.0;
    def.pins = pins;
    def.pin_count = 2;
    tulle_cloth_id const id = validate_add_cloth(run, world, &def);
    validate_simulate(run, world, 2.5);
    shape.weight = pow(length / c, 3.0);
    if (!elastica_find_heart(shape, &drop, points, POINTS))
        validate_give_up(run, "the elastica was not found");
    const double *const x = tulle_cloth_get_positions(world, id, NULL);
    double lowest = 0.0;
    for (size_t v = 0; v < mesh->vertex_count; v++) lowest = fmin(lowest, x[3 * v + 2]);
    if (form.pattern == ALTERNATING && form.cells > 10.0) {
        for (int i = 0; i < POINTS; i += 10)
            validate_plot_point(run, form.fabric, 1e3 * length * points[2 * i],
                                1e3 * length * points[2 * i + 1]);
        char series[48];
        snprintf(series, sizeof series, "*%s, measured", form.fabric);
        for (size_t i = 0; i < sample.columns / 2 + 1; i += 2)
            validate_plot_point(run, series, 1e3 * x[3 * i], 1e3 * x[3 * i + 2]);
    }
    return -lowest / (length * drop);
}

static const char elastica[] = "elastica with weight, integrated";

static void hangs_as_a_heart(validation_run *run) {
    /* The first four in pairs, the first half as fine as the second. */
    static const loop loops[] = {{"cotton", ALTERNATING, 6.0}, {"cotton", ALTERNATING, 12.0},
                                 {"cotton", CROSSED, 6.0},     {"cotton", CROSSED, 12.0},
                                 {"cotton", IRREGULAR, 12.0},  {"cotton", TURNED, 12.0},
                                 {"silk", ALTERNATING, 12.0},  {"denim", ALTERNATING, 12.0}};
    enum { LOOPS = sizeof loops / sizeof *loops, PAIRED = 4 };
    double found[LOOPS];
    bool const is_quick = validate_options(run)->is_quick;
    validate_start_plot(run, &(validation_plot){.name = "heart",
                                                .title = "Half of a loop that hangs as a heart",
                                                .x_label = "from the middle [mm]",
                                                .y_label = "above the jaws [mm]"});
    double drop = 0.0;
    if (!elastica_find_heart((heart){0}, &drop, NULL, 0))
        validate_give_up(run, "the elastica was not found");
    validate_row(run, "elastica: a loop without weight hangs by, in its length", drop, "",
                 within(0.1337, 2e-3), "Peirce 1930: 0.1337");
    for (size_t i = 0; i < (is_quick ? 1 : LOOPS); i++) {
        found[i] = measure_heart(run, loops[i]);
        bool const is_judged = loops[i].cells > 10.0 && loops[i].pattern != CROSSED;
        char what[128];
        snprintf(what, sizeof what,
                 "loop of %s, %.0f cells a bending length, %s: hangs by, over it", loops[i].fabric,
                 loops[i].cells, strips_pattern_names[loops[i].pattern]);
        validate_row(run, what, found[i], "", is_judged ? within(1.0, 0.01) : nothing(), elastica);
        if (i >= PAIRED || i % 2 == 0) continue;
        /* The error goes to a quarter when cells are halved. */
        snprintf(what, sizeof what, "the same, extrapolated from 6 and 12 cells, %s",
                 strips_pattern_names[loops[i].pattern]);
        validate_row(run, what, (4.0 * found[i] - found[i - 1]) / 3.0, "", within(1.0, 0.005),
                     elastica);
    }
}

/* ---- a strip buckles ---- */

typedef struct buckling {
    pattern pattern;
    bool is_clamped; /* at both ends by jaws; else both ends are hinges */
    double fineness; /* [1/m] cells */
} buckling;

static double const STRUT = 0.1; /* [m] length of the strip that buckles */

/* Energy [J] of the strip at rest when its ends have come nearer by that share of its length. */
static double measure_buckled_energy(validation_run *run, buckling form, double shortening) {
    double const cell = 1.0 / form.fineness, jaws = form.is_clamped ? 3.0 * cell : 0.0;
    strip const sample = {.begin = -jaws,
                          .end = STRUT + jaws,
                          .width = WIDTH,
                          .columns = (uint32_t)lround((STRUT + 2.0 * jaws) / cell),
                          .rows = (uint32_t)lround(WIDTH / cell),
                          .pattern = form.pattern,
                          .lines = {0.0, STRUT}};
    tulle_mesh *const mesh = strips_make(run, &sample);
    double *const rest = copy_positions(run, mesh);
    tulle_pin const pins[2] = {strips_pin_between(run, mesh, sample.begin, 0.0),
                               strips_pin_between(run, mesh, STRUT, sample.end)};
    double const height = 2.0 * STRUT * sqrt(shortening) / PI;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *const x = mesh->positions + 3 * v;
        double const part = fmin(fmax(x[0] / STRUT, 0.0), 1.0);
        x[0] -= shortening * STRUT * part;
        x[2] = height * (form.is_clamped ? 0.5 * (1.0 - cos(2.0 * PI * part)) : sin(PI * part));
    }
    tulle_world_def world_def = validate_world_def(run);
    world_def.membrane = TULLE_MEMBRANE_WOVEN;
    world_def.gravity[2] = 0.0;
    tulle_world *const world = validate_make_world(run, &world_def);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    def.rest_positions = rest;
    def.material = stage_take_fabric(run, "cotton");
    def.material.air_damping = 10.0;
    def.pins = pins;
    def.pin_count = 2;
    validate_add_cloth(run, world, &def);
    validate_simulate(run, world, 4.0);
    return validate_step(run, world, VALIDATION_STEP).elastic_energy;
}

/* The load does the work that the strip takes up while its ends come nearer. */
static double measure_load(validation_run *run, buckling form, double shortening) {
    double const change = 1e-3;
    double const work = measure_buckled_energy(run, form, shortening + change) -
                        measure_buckled_energy(run, form, shortening - change);
    tulle_material const material = stage_take_fabric(run, "cotton");
    double const euler =
        (form.is_clamped ? 4.0 : 1.0) * PI * PI * material.bend_warp * WIDTH / (STRUT * STRUT);
    return work / (2.0 * change * STRUT) / euler;
}

static void buckles_under_eulers_load(validation_run *run) {
    static const buckling forms[] = {{ALTERNATING, false, 480.0}, {ALIKE, false, 480.0},
                                     {IRREGULAR, false, 480.0},   {CROSSED, false, 480.0},
                                     {TURNED, false, 480.0},      {ALTERNATING, false, 120.0},
                                     {ALTERNATING, true, 480.0},  {CROSSED, true, 480.0}};
    bool const is_quick = validate_options(run)->is_quick;
    double const shortening = 0.03, theory = elastica_find_load(shortening);
    for (size_t i = 0; i < (is_quick ? 1 : sizeof forms / sizeof *forms); i++) {
        char what[128];
        snprintf(what, sizeof what, "load over Euler's, %s ends, %.0f cells a metre, %s",
                 forms[i].is_clamped ? "clamped" : "hinged", forms[i].fineness,
                 strips_pattern_names[forms[i].pattern]);
        validate_row(run, what, measure_load(run, forms[i], shortening), "",
                     within(theory, forms[i].fineness < 200.0 ? 0.01 : 0.005),
                     "elastica shortened by 3 %: (2 K / pi)^2");
    }
}

const experiment bends_experiments[] = {
    {"bends.heart", "a loop hangs as a heart as the elastica does", hangs_as_a_heart, true},
    {"bends.buckles", "a strip buckles under Euler's load", buckles_under_eulers_load, true},
    {0},
};
