/* laws.c - woven cloth against closed forms: tension by strain, shear by pull along the bias, how a
 * hanging strip swings and comes to rest, how fast a sheet falls. */
#include "validation/stage.h"
#include "validation/strips.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static double const PI = 3.14159265358979323846;

/* A fabric without air damping: closed forms do not know it. */
static tulle_material take_bare_fabric(validation_run *run, const char *name) {
    tulle_material material = stage_take_fabric(run, name);
    material.air_damping = 0.0;
    return material;
}

/* ---- tension by strain ---- */

static double find_tension(tulle_curve curve, double strain) {
    double const knee = curve.knee > 0.0 && strain > 0.0 ? strain / curve.knee : 0.0;
    return curve.stiffness * strain * (1.0 + knee * knee);
}

/* Tension [N/m] of a strip whose yarns are stretched by `strain`, free to narrow: the other yarns
 * are slack, so that their law is straight. */
static double find_free_tension(const tulle_material *material, bool is_weft, double strain) {
    tulle_curve const along = is_weft ? material->weft : material->warp;
    tulle_curve const across = is_weft ? material->warp : material->weft;
    double const coupling = material->poisson * sqrt(along.stiffness * across.stiffness);
    return find_tension(along, strain) - coupling * coupling / across.stiffness * strain;
}

/* A strip hangs so heavy that it is stretched by `most` at its top. The weight below a row of
 * vertices is the tension there. Gives the largest deviation of the tension that the law says for
 * the strain of a row, over that weight. */
static double measure_curve(validation_run *run, const char *fabric, bool is_weft, double most) {
    strip const sample = {
        .begin = 0.0, .end = 0.5, .width = 0.06, .columns = 50, .rows = 6, .pattern = ALIKE};
    tulle_mesh *const mesh = strips_make(run, &sample);
    tulle_world_def world_def = validate_world_def(run);
    world_def.membrane = TULLE_MEMBRANE_WOVEN;
    tulle_cloth_def def = tulle_cloth_def_default();
    def.material = take_bare_fabric(run, fabric);
    double const weight = find_free_tension(&def.material, is_weft, most) / sample.end; /* a m^2 */
    world_def.gravity[0] = weight / def.material.area_density;
    world_def.gravity[2] = 0.0;
    tulle_world *const world = validate_make_world(run, &world_def);
    def.mesh = tulle_mesh_get_view(mesh);
    def.material.air_damping = 60.0;
    if (is_weft) memcpy(def.grain, (double[]){0.0, 1.0, 0.0}, sizeof def.grain);
    tulle_pin const pin = strips_pin_between(run, mesh, 0.0, 0.0);
    def.pins = &pin;
    def.pin_count = 1;
    tulle_cloth_id const id = validate_add_cloth(run, world, &def);
    validate_simulate(run, world, 4.0);
    const double *const x = tulle_cloth_get_positions(world, id, NULL);
    /* The middle line of vertices; away from the pin, which does not narrow. A cell's tension is
     * that at its middle. */
    size_t const line = sample.columns + 1, middle = line * (sample.rows / 2);
    double const cell = sample.end / sample.columns;
    double off = 0.0;
    for (size_t i = 10; i + 5 < line; i++) {
        const double *const a = x + 3 * (middle + i);
        double const strain = hypot(a[3] - a[0], a[4] - a[1]) / cell - 1.0;
        double const held = weight * (sample.end - cell * ((double)i + 0.5));
        char series[48];
        snprintf(series, sizeof series, "%s, %s", fabric, is_weft ? "weft" : "warp");
        validate_plot_point(run, series, 100.0 * strain,
                            find_free_tension(&def.material, is_weft, strain));
        snprintf(series, sizeof series, "*%s, %s, measured", fabric, is_weft ? "weft" : "warp");
        if (i % 4 == 0) validate_plot_point(run, series, 100.0 * strain, held);
        off = fmax(off, fabs(find_free_tension(&def.material, is_weft, strain) / held - 1.0));
    }
    return off;
}

static void pulls_as_its_curve_says(validation_run *run) {
    static const char *const fabrics[] = {"cotton", "silk", "denim"};
    bool const is_quick = validate_options(run)->is_quick;
    validate_start_plot(run, &(validation_plot){.name = "tension",
                                                .title = "Tension of hanging strips",
                                                .x_label = "strain [%]",
                                                .y_label = "tension [N/m]"});
    for (size_t i = 0; i < (is_quick ? 1 : 3); i++)
        for (int is_weft = 0; is_weft < 2; is_weft++) {
            char what[96];
            snprintf(what, sizeof what, "tension of %s along the %s up to 8 %%: off by", fabrics[i],
                     is_weft ? "weft" : "warp");
            validate_row(run, what, 100.0 * measure_curve(run, fabrics[i], is_weft, 0.08), "%",
                         at_most(1.0), "k e (1 + (e / knee)^2), less what narrowing takes");
        }
}

/* ---- a strip is pulled along its bias ---- */

typedef struct edges2 {
    double a[2], b[2];
} edges2;

static edges2 get_edges(const tulle_mesh *mesh, const double *x, size_t triangle) {
    const uint32_t *const corners = mesh->triangles + 3 * triangle;
    edges2 edges;
    for (size_t c = 0; c < 2; c++) {
        edges.a[c] = x[3 * (size_t)corners[1] + c] - x[3 * (size_t)corners[0] + c];
        edges.b[c] = x[3 * (size_t)corners[2] + c] - x[3 * (size_t)corners[0] + c];
    }
    return edges;
}

/* What becomes of the direction (c, s) of the rest shape. */
static void carry(edges2 rest, edges2 now, double c, double s, double result[2]) {
    double const area = rest.a[0] * rest.b[1] - rest.a[1] * rest.b[0];
    double const p = (c * rest.b[1] - s * rest.b[0]) / area;
    double const q = (rest.a[0] * s - rest.a[1] * c) / area;
    for (size_t i = 0; i < 2; i++) result[i] = p * now.a[i] + q * now.b[i];
}

/* Mean angle [rad] by which warp and weft turn against each other in the middle of a strip of three
 * times its width that is pulled along its bias. */
static double measure_bias(validation_run *run, pattern division, double factor, double pull) {
    uint32_t const fineness = validate_options(run)->is_quick ? 1 : 2;
    strip const sample = {.begin = -0.15,
                          .end = 0.15,
                          .width = 0.1,
                          .columns = 24 * fineness,
                          .rows = 8 * fineness,
                          .pattern = division};
    tulle_mesh *const mesh = strips_make(run, &sample);
    tulle_world_def world_def = validate_world_def(run);
    world_def.membrane = TULLE_MEMBRANE_WOVEN;
    memset(world_def.gravity, 0, sizeof world_def.gravity);
    tulle_world *const world = validate_make_world(run, &world_def);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    def.material = stage_take_fabric(run, "cotton");
    def.material.air_damping = 2.0;
    def.material.warp.stiffness *= factor;
    def.material.weft.stiffness *= factor;
    memcpy(def.grain, (double[]){1.0, 1.0, 0.0}, sizeof def.grain);
    tulle_pin pins[2] = {strips_pin_between(run, mesh, -0.15, -0.15),
                         strips_pin_between(run, mesh, 0.15, 0.15)};
    tulle_keyframe const keys[2] = {stage_key(0.0, 0.0, 0.0, 0.0), stage_key(1.0, pull, 0.0, 0.0)};
    pins[1].motion = (tulle_motion){.keys = keys, .key_count = 2};
    def.pins = pins;
    def.pin_count = 2;
    tulle_cloth_id const id = validate_add_cloth(run, world, &def);
    validate_simulate(run, world, 2.0);
    const double *const x = tulle_cloth_get_positions(world, id, NULL);
    double const half = sqrt(0.5);
    double sum = 0.0;
    int count = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const double *const corner = mesh->positions + 3 * (size_t)mesh->triangles[3 * t];
        if (fabs(corner[0]) > 0.03 || fabs(corner[1]) > 0.03) continue;
        edges2 const rest = get_edges(mesh, mesh->positions, t), now = get_edges(mesh, x, t);
        double warp[2], weft[2];
        carry(rest, now, half, half, warp);
        carry(rest, now, -half, half, weft);
        double const turned =
            atan2(warp[0] * weft[1] - warp[1] * weft[0], warp[0] * weft[0] + warp[1] * weft[1]);
        sum += turned - 0.5 * PI;
        count++;
    }
    return sum / count;
}

/* The fabric itself gives way along its yarns; with ten times stiffer ones it comes near to theory,
 * which knows no such thing. The mesh must not matter to the fabric. */
static void shears_as_yarns_turn(validation_run *run) {
    /* Between the ends lies a square of yarns that reach from one side to the other. */
    double const diagonal = 0.3 - 0.1, pull = 0.03;
    double const theory =
        (0.5 * PI - 2.0 * acos((diagonal + pull) / (sqrt(2.0) * diagonal))) / VALIDATION_DEGREE;
    static const char *const what_of[] = {"cotton", "yarns 10 times as stiff"};
    for (int is_stiff = 0; is_stiff < 2; is_stiff++) {
        double least = INFINITY, most = 0.0;
        for (int p = 0; p < PATTERN_COUNT; p++) {
            double const angle =
                measure_bias(run, (pattern)p, is_stiff ? 10.0 : 1.0, pull) / VALIDATION_DEGREE;
            least = fmin(least, angle), most = fmax(most, angle);
            char what[128];
            snprintf(what, sizeof what, "angle of shear, %s, %s", what_of[is_stiff],
                     strips_pattern_names[p]);
            validate_row(run, what, angle, "deg", is_stiff ? within(theory, 0.2) : nothing(),
                         "yarns that turn and do not stretch: Cao et al. 2008");
        }
        if (is_stiff) continue;
        validate_row(run, "its spread over the meshes", 100.0 * (most / least - 1.0), "%",
                     at_most(5.0), "no mesh is better than another");
    }
}

/* ---- a strip swings ---- */

typedef struct swing {
    double period;  /* [s] */
    double damping; /* damping ratio of that motion */
    double told;    /* what the world tells of its integrator for that period */
} swing;

/* A strip hangs by one row and is pushed a little, as it would swing by itself. Its width does not
 * matter; its period and loss are told by where its end crosses the middle and turns. */
static swing measure_swing(validation_run *run, tulle_integrator integrator, double air) {
    strip const sample = {
        .begin = 0.0, .end = 0.5, .width = 0.04, .columns = 50, .rows = 4, .pattern = ALIKE};
    tulle_mesh *const mesh = strips_make(run, &sample);
    tulle_world_def world_def = validate_world_def(run);
    world_def.membrane = TULLE_MEMBRANE_WOVEN;
    world_def.integrator = integrator;
    world_def.gravity[0] = VALIDATION_GRAVITY;
    world_def.gravity[2] = 0.0;
    tulle_world *const world = validate_make_world(run, &world_def);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.material = stage_take_fabric(run, "silk");
    def.material.air_damping = air;
    def.material.stretch_damping = def.material.bend_damping = 0.0;
    /* The first shape of a hanging chain is J0(2.4048 sqrt(s / L)), s from its end; here its
     * series. */
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double const s = 1.0 - mesh->positions[3 * v] / sample.end;
        double const q = 0.25 * 2.404825557695773 * 2.404825557695773 * s;
        mesh->positions[3 * v + 2] = 5e-3 * (1.0 - q + q * q / 4.0 - q * q * q / 36.0 +
                                             q * q * q * q / 576.0 - q * q * q * q * q / 14400.0);
    }
    def.has_flat_rest = 1;
    def.mesh = tulle_mesh_get_view(mesh);
    tulle_pin const pin = strips_pin_between(run, mesh, 0.0, 0.0);
    def.pins = &pin;
    def.pin_count = 1;
    tulle_cloth_id const id = validate_add_cloth(run, world, &def);
    size_t const end = sample.columns; /* of the first line of vertices */
    double last = 5e-3, crossed[12], tops[12], top = 0.0;
    int count = 0;
    for (int step = 1; step < 2000 && count < 12; step++) {
        validate_step(run, world, VALIDATION_STEP);
        double const now = tulle_cloth_get_positions(world, id, NULL)[3 * end + 2];
        top = fmax(top, fabs(now));
        if (now * last < 0.0) {
            crossed[count] = VALIDATION_STEP * (step - now / (now - last));
            tops[count++] = top;
            top = 0.0;
        }
        last = now;
    }
    if (count < 12) validate_give_up(run, "the strip crossed its middle %d times only", count);
    swing found = {.period = (crossed[11] - crossed[1]) / 5.0};
    double const loss = log(tops[2] / tops[11]) / (9.0 * PI);
    found.damping = loss / hypot(loss, 1.0);
    found.told = tulle_world_get_numerical_damping(world, VALIDATION_STEP, found.period);
    return found;
}

static void swings_as_a_chain(validation_run *run) {
    static const char *const names[] = {"implicit Euler", "Crank-Nicolson", "BDF2"};
    static const tulle_integrator integrators[] = {
        TULLE_INTEGRATOR_IMPLICIT_EULER, TULLE_INTEGRATOR_CRANK_NICOLSON, TULLE_INTEGRATOR_BDF2};
    double const period = 2.0 * PI / (0.5 * 2.404825557695773 * sqrt(VALIDATION_GRAVITY / 0.5));
    for (size_t i = 0; i < 3; i++)
        for (int has_air = 0; has_air < 2; has_air++) {
            double const air = has_air ? 0.5 : 0.0;
            swing const found = measure_swing(run, integrators[i], air);
            double const theory = found.told + 0.5 * air * found.period / (2.0 * PI);
            char what[128];
            if (!has_air) {
                snprintf(what, sizeof what, "period of a hanging strip, %s", names[i]);
                validate_row(run, what, found.period, "s", within(period, 0.02),
                             "a hanging chain: 2.4048 sqrt(g / L) / 2 a second");
            }
            snprintf(what, sizeof what, "its damping ratio less %.4f, air damping %.1f/s, %s",
                     theory, air, names[i]);
            validate_row(run, what, fabs(found.damping - theory), "", at_most(1e-3),
                         "the integrator's, as told, and half the air's over omega");
        }
}

/* ---- a sheet falls ---- */

static void falls_at_its_terminal_speed(validation_run *run) {
    static const char *const fabrics[] = {"silk", "cotton", "denim"};
    for (size_t i = 0; i < 3; i++) {
        stage_sheet const sheet = {.size = {0.5, 0.5}, .counts = {9, 9}};
        tulle_mesh *const mesh = stage_make_sheet(run, sheet);
        tulle_world_def world_def = validate_world_def(run);
        world_def.membrane = TULLE_MEMBRANE_WOVEN;
        world_def.wind = (tulle_wind){.drag_coefficient = 0.7, .gust_length = 1, .gust_time = 1};
        tulle_world *const world = validate_make_world(run, &world_def);
        tulle_cloth_def def = tulle_cloth_def_default();
        def.mesh = tulle_mesh_get_view(mesh);
        def.material = take_bare_fabric(run, fabrics[i]);
        tulle_cloth_id const id = validate_add_cloth(run, world, &def);
        validate_simulate(run, world, 3.0);
        double velocity[3];
        validate_mean_velocity(world, id, velocity);
        char what[96];
        snprintf(what, sizeof what, "terminal speed of a level sheet of %s, drag 0.7", fabrics[i]);
        validate_row(run, what, -velocity[2], "m/s",
                     within(sqrt(def.material.area_density * VALIDATION_GRAVITY / 0.7), 0.01),
                     "weight over drag: sqrt(rho g / C)");
    }
}

const experiment laws_experiments[] = {
    {"laws.curves", "a strip is stretched by weight as its curve says", pulls_as_its_curve_says,
     false},
    {"laws.bias", "a strip pulled along its bias shears as its yarns turn", shears_as_yarns_turn,
     true},
    {"laws.swing", "a hanging strip swings and loses height as theory says", swings_as_a_chain,
     true},
    {"laws.falls", "a sheet falls at its terminal speed", falls_at_its_terminal_speed, false},
    {0},
};
