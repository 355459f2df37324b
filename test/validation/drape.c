/* drape.c - a round sample of woven cloth drapes over a disc, as on Cusick's drapemeter: how much
 * of the ring around the disc its shadow covers, and its folds, beside what is published. */
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double SAMPLE_RADIUS = 0.15, DISC_RADIUS = 0.09; /* [m] of Cusick's drapemeter */
enum { DIRECTIONS = 720 };

/* Area [m^2] of the shadow: how far it reaches in each direction from the middle. */
static double measure_shadow(const tulle_mesh *mesh, const double *x) {
    double reach[DIRECTIONS] = {0.0}, area = 0.0;
    double const slice = 2.0 * 3.14159265358979323846 / DIRECTIONS;
    for (size_t e = 0; e < 3 * mesh->triangle_count; e++) {
        size_t const next = e % 3 == 2 ? e - 2 : e + 1;
        const double *const a = x + 3 * (size_t)mesh->triangles[e];
        const double *const b = x + 3 * (size_t)mesh->triangles[next];
        double const begin = atan2(a[1], a[0]);
        double turn = atan2(b[1], b[0]) - begin;
        turn -= slice * DIRECTIONS * round(turn / (slice * DIRECTIONS));
        double const low = turn > 0.0 ? begin : begin + turn;
        for (double k = ceil(low / slice); k * slice <= low + fabs(turn); k += 1.0) {
            double const c = cos(k * slice), s = sin(k * slice);
            double const u = c * a[1] - s * a[0], v = c * b[1] - s * b[0];
            if (u == v) continue;
            double const part = u / (u - v);
            double const far =
                c * (a[0] + part * (b[0] - a[0])) + s * (a[1] + part * (b[1] - a[1]));
            size_t const at = (size_t)(((long)k % DIRECTIONS + DIRECTIONS) % DIRECTIONS);
            reach[at] = fmax(reach[at], far);
        }
    }
    for (size_t k = 0; k < DIRECTIONS; k++) area += 0.5 * slice * reach[k] * reach[k];
    return area;
}

/* Times that the height of the rim goes above its mean, once round: its folds. */
static int count_folds(const tulle_mesh *mesh, const double *x) {
    enum { SECTORS = 90 };
    double height[SECTORS] = {0.0}, mean = 0.0;
    int count[SECTORS] = {0};
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        const double *const rest = mesh->positions + 3 * v;
        if (hypot(rest[0], rest[1]) < 0.93 * SAMPLE_RADIUS) continue;
        double const turn = atan2(rest[1], rest[0]) / (2.0 * 3.14159265358979323846) + 0.5;
        int const sector = (int)(turn * SECTORS) % SECTORS;
        height[sector] += x[3 * v + 2];
        count[sector]++;
    }
    for (int i = 0; i < SECTORS; i++) {
        height[i] = count[i] > 0 ? height[i] / count[i] : height[(i + SECTORS - 1) % SECTORS];
        mean += height[i] / SECTORS;
    }
    int folds = 0;
    for (int i = 0; i < SECTORS; i++)
        folds += height[i] <= mean && height[(i + 1) % SECTORS] > mean;
    return folds;
}

typedef enum sample_mesh { RINGS, IRREGULAR_RINGS, LATTICE, SAMPLE_MESHES } sample_mesh;

/* A round sample; of a lattice the cells whose middles lie within the circle. */
static tulle_mesh *make_sample(validation_run *run, sample_mesh kind, double cell, uint32_t seed) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_DISC);
    def.radius = SAMPLE_RADIUS;
    def.resolution[0] = (uint32_t)lround(SAMPLE_RADIUS / cell);
    def.resolution[1] = 6 * def.resolution[0];
    def.is_irregular = kind == IRREGULAR_RINGS;
    def.seed = seed;
    if (kind != LATTICE) return validate_make_shape(run, &def);
    uint32_t const side = 2 * def.resolution[0] + 1;
    def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = def.size[1] = 2.0 * SAMPLE_RADIUS;
    def.resolution[0] = def.resolution[1] = side;
    tulle_mesh *const square = validate_make_shape(run, &def);
    uint32_t *const numbers = validate_allocate(run, square->vertex_count * sizeof *numbers);
    for (size_t v = 0; v < square->vertex_count; v++) numbers[v] = UINT32_MAX;
    uint32_t vertices = 0, triangles = 0;
    for (size_t t = 0; t < square->triangle_count; t++) {
        uint32_t *const corners = square->triangles + 3 * t;
        double middle[2] = {0.0, 0.0};
        for (size_t k = 0; k < 3; k++)
            for (size_t c = 0; c < 2; c++)
                middle[c] += square->positions[3 * (size_t)corners[k] + c] / 3.0;
        if (hypot(middle[0], middle[1]) > SAMPLE_RADIUS) continue;
        for (size_t k = 0; k < 3; k++) {
            if (numbers[corners[k]] == UINT32_MAX) numbers[corners[k]] = vertices++;
            square->triangles[3 * (size_t)triangles + k] = corners[k];
        }
        triangles++;
    }
    tulle_mesh *const mesh = validate_make_mesh(run, vertices, triangles);
    for (size_t v = 0; v < square->vertex_count; v++)
        if (numbers[v] != UINT32_MAX)
            memcpy(mesh->positions + 3 * (size_t)numbers[v], square->positions + 3 * v,
                   3 * sizeof(double));
    for (size_t k = 0; k < 3 * (size_t)triangles; k++)
        mesh->triangles[k] = numbers[square->triangles[k]];
    return mesh;
}

/* Moves vertices that lie less than 0.35 of a cell within or beyond the disc's edge onto it: what
 * is held then has the disc's outline, whatever the mesh. */
static void fit_to_disc(tulle_mesh *mesh, double cell) {
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *const x = mesh->positions + 3 * v;
        double const distance = hypot(x[0], x[1]);
        if (fabs(distance - DISC_RADIUS) > 0.35 * cell) continue;
        x[0] *= DISC_RADIUS / distance;
        x[1] *= DISC_RADIUS / distance;
    }
}

/* What is published of a fabric's drape coefficient; the mesh on which it is measured. */
typedef struct band {
    const char *fabric;
    double low, high; /* [%] */
    const char *source, *plot;
    double cell; /* [m] at most a third of the bending length: with longer edges yarns that hardly
                    stretch hinder folds, the more the stiffer they are */
} band;

/* The ring around the disc starts uneven: n waves around it are at most 4 mm / n high, as cloth is
 * the more uneven the longer the way. Noise from one vertex to the next would be gone at once and
 * leave it to the mesh which folds come. */
static void make_uneven(tulle_mesh *mesh, uint32_t seed) {
    enum { WAVES = 9 };
    double heights[2 * WAVES];
    uint32_t noise = seed * 2654435761u + 1;
    for (int i = 0; i < 2 * WAVES; i++) {
        noise = noise * 1664525u + 1013904223u;
        int const waves = i < 2 ? 1 : i / 2;
        heights[i] = 8e-3 / waves * ((noise >> 8) / 16777216.0 - 0.5);
    }
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *const x = mesh->positions + 3 * v;
        double const angle = atan2(x[1], x[0]);
        double const part =
            fmax(hypot(x[0], x[1]) - DISC_RADIUS, 0.0) / (SAMPLE_RADIUS - DISC_RADIUS);
        for (int i = 0; i < WAVES; i++)
            x[2] += part * part *
                    (heights[2 * i] * cos(i * angle) + heights[2 * i + 1] * sin(i * angle));
    }
}

typedef struct drape {
    double coefficient; /* [%] */
    int folds;
} drape;

/* Until nothing moves faster than 2 mm/s, which takes some 2 s. */
static void bring_to_rest(validation_run *run, tulle_world *world, tulle_cloth_id id) {
    double fastest = INFINITY;
    for (int i = 0; i < 12 && (i < 3 || fastest > 2e-3); i++) {
        validate_simulate(run, world, 0.5);
        size_t count = 0;
        const double *const v = tulle_cloth_get_velocities(world, id, &count);
        fastest = 0.0;
        for (size_t k = 0; k < 3 * count; k++) fastest = fmax(fastest, fabs(v[k]));
    }
}

static drape measure_drape(validation_run *run, const band *wanted, sample_mesh kind,
                           uint32_t seed) {
    double const cell = validate_options(run)->is_quick ? 0.015 : wanted->cell;
    tulle_mesh *const mesh = make_sample(run, kind, cell, seed);
    fit_to_disc(mesh, cell);
    double const whole = measure_shadow(mesh, mesh->positions);
    uint32_t *const held = validate_allocate(run, mesh->vertex_count * sizeof *held);
    size_t count = 0;
    for (size_t v = 0; v < mesh->vertex_count; v++)
        if (hypot(mesh->positions[3 * v], mesh->positions[3 * v + 1]) <= DISC_RADIUS + 1e-9)
            held[count++] = (uint32_t)v;
    make_uneven(mesh, seed);
    tulle_pin const pin = {
        .vertices = held, .vertex_count = count, .release_time = (double)INFINITY};
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    def.has_flat_rest = 1;
    def.material = stage_take_fabric(run, wanted->fabric);
    def.material.air_damping = 1.0;
    def.pins = &pin;
    def.pin_count = 1;
    tulle_world *const world = stage_make_woven_world(run);
    tulle_cloth_id const id = validate_add_cloth(run, world, &def);
    bring_to_rest(run, world, id);
    const double *const x = tulle_cloth_get_positions(world, id, NULL);
    double const disc = 3.14159265358979323846 * DISC_RADIUS * DISC_RADIUS;
    return (drape){100.0 * (measure_shadow(mesh, x) - disc) / (whole - disc), count_folds(mesh, x)};
}

static void drapes_as_fabric_does(validation_run *run) {
    static const band bands[] = {
        {"cotton", 60.0, 76.0, "Gan, Ly, Steven 1991, as quoted by others", "drape_cotton", 5e-3},
        {"silk", 20.0, 40.0, "Matsudaira & Yang 2003, as quoted by others", "drape_silk", 3.75e-3},
        {"wool", 40.0, 70.0, "loosely sourced", "drape_wool", 5e-3},
        {"denim", 70.0, 90.0, "loosely sourced", "drape_denim", 7.5e-3},
    };
    static const char *const mesh_names[] = {"rings", "irregular rings", "lattice"};
    const char *const fabric = validate_subject(run);
    const band *wanted = bands;
    while (strcmp(wanted->fabric, fabric) != 0) wanted++;
    bool const is_quick = validate_options(run)->is_quick;
    uint32_t const seeds = is_quick ? 1 : 5;
    int within_count = 0, all = 0;
    validate_start_plot(run, &(validation_plot){.name = wanted->plot,
                                                .title = "Drape of round samples",
                                                .x_label = "sample",
                                                .y_label = "drape coefficient [%]"});
    for (uint32_t seed = 1; seed <= seeds; seed++) {
        validate_plot_point(run, "published, from", seed, wanted->low);
        validate_plot_point(run, "published, to", seed, wanted->high);
    }
    for (int kind = 0; kind < (is_quick ? 1 : SAMPLE_MESHES); kind++) {
        double sum = 0.0, least = 100.0, most = 0.0, folds = 0.0;
        for (uint32_t seed = 1; seed <= seeds; seed++, all++) {
            drape const found = measure_drape(run, wanted, (sample_mesh)kind, seed);
            char series[48];
            snprintf(series, sizeof series, "*%s", mesh_names[kind]);
            validate_plot_point(run, series, seed, found.coefficient);
            sum += found.coefficient / seeds;
            folds += (double)found.folds / seeds;
            least = fmin(least, found.coefficient), most = fmax(most, found.coefficient);
            within_count += found.coefficient >= wanted->low && found.coefficient <= wanted->high;
        }
        char what[128];
        snprintf(what, sizeof what, "drape coefficient of %s on %s, mean (%.1f to %.1f)", fabric,
                 mesh_names[kind], least, most);
        validate_row(run, what, sum, "%", nothing(), wanted->source);
        snprintf(what, sizeof what, "its folds on %s", mesh_names[kind]);
        validate_row(run, what, folds, "", nothing(), "");
    }
    char what[96];
    snprintf(what, sizeof what, "samples of %d within %.0f to %.0f %%", all, wanted->low,
             wanted->high);
    validate_row(run, what, within_count, "", is_quick ? nothing() : at_least(0.9 * all),
                 wanted->source);
}

const experiment drape_experiments[] = {
    {"drape.cotton", "a round sample drapes over a disc", drapes_as_fabric_does, false},
    {"drape.silk", "the same of silk", drapes_as_fabric_does, true},
    {"drape.wool", "the same of wool", drapes_as_fabric_does, true},
    {"drape.denim", "the same of denim", drapes_as_fabric_does, true},
    {0},
};
