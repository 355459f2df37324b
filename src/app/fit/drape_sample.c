/* app/fit/drape_sample.c - see drape_sample.h. */
#include "app/fit/drape_sample.h"

#include "base/error.h"

#include "tulle/shapes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double SAMPLE_RADIUS = 0.15, DISC_RADIUS = 0.09; /* [m] of Cusick's drapemeter */
static const double REST_SPEED = 2e-3;                        /* [m/s] */
static const double PI = 3.14159265358979323846;
enum { DIRECTIONS = 720 };

/* Area [m^2] of the shadow: how far it reaches in each direction from the middle. */
static double measure_shadow(const tulle_mesh *mesh, const double *x) {
    double reach[DIRECTIONS] = {0.0}, area = 0.0;
    double const slice = 2.0 * PI / DIRECTIONS;
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

double drape_measure_coefficient(const drape_sample *sample, const double *positions) {
    double const disc = PI * DISC_RADIUS * DISC_RADIUS;
    return 100.0 * (measure_shadow(&sample->mesh, positions) - disc) / (sample->area - disc);
}

int drape_count_folds(const drape_sample *sample, const double *positions) {
    enum { SECTORS = 90 };
    double height[SECTORS] = {0.0}, mean = 0.0;
    int count[SECTORS] = {0};
    for (size_t v = 0; v < sample->mesh.vertex_count; v++) {
        const double *const start = sample->mesh.positions + 3 * v;
        if (hypot(start[0], start[1]) < 0.93 * SAMPLE_RADIUS) continue;
        double const turn = atan2(start[1], start[0]) / (2.0 * PI) + 0.5;
        int const sector = (int)(turn * SECTORS) % SECTORS;
        height[sector] += positions[3 * v + 2];
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

/* Leaves of a square lattice the cells whose middles lie within the circle. */
static tulle_status cut_out(const tulle_mesh *square, tulle_mesh *mesh, tulle_error *error) {
    uint32_t *const numbers = malloc(square->vertex_count * sizeof *numbers);
    if (!numbers) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for a sample");
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
    tulle_status const status = tulle_mesh_create(vertices, triangles, mesh, error);
    if (status == TULLE_OK) {
        for (size_t v = 0; v < square->vertex_count; v++)
            if (numbers[v] != UINT32_MAX)
                memcpy(mesh->positions + 3 * (size_t)numbers[v], square->positions + 3 * v,
                       3 * sizeof(double));
        for (size_t k = 0; k < 3 * (size_t)triangles; k++)
            mesh->triangles[k] = numbers[square->triangles[k]];
    }
    free(numbers);
    return status;
}

static tulle_status make_mesh(drape_pattern pattern, double cell, uint32_t seed, tulle_mesh *mesh,
                              tulle_error *error) {
    /* The disc's radius is three fifths of the sample's: then a ring lies on its edge. */
    uint32_t const rings = 5 * (uint32_t)fmax(round(SAMPLE_RADIUS / (5.0 * cell)), 1.0);
    if (pattern != DRAPE_LATTICE) {
        tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_DISC);
        def.radius = SAMPLE_RADIUS;
        def.resolution[0] = rings;
        def.resolution[1] = 6 * rings;
        def.is_irregular = pattern == DRAPE_IRREGULAR_RINGS;
        def.seed = seed;
        return tulle_shape_generate(&def, mesh, error);
    }
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.size[0] = def.size[1] = 2.0 * SAMPLE_RADIUS;
    def.resolution[0] = def.resolution[1] = 2 * rings + 1;
    tulle_mesh square = {0};
    tulle_status status = tulle_shape_generate(&def, &square, error);
    if (status == TULLE_OK) status = cut_out(&square, mesh, error);
    tulle_mesh_destroy(&square);
    return status;
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

tulle_status drape_sample_make(drape_pattern pattern, double cell, uint32_t seed,
                               drape_sample *sample, tulle_error *error) {
    *sample = (drape_sample){0};
    tulle_mesh *const mesh = &sample->mesh;
    tulle_status const status = make_mesh(pattern, cell, seed, mesh, error);
    if (status != TULLE_OK) return status;
    fit_to_disc(mesh, cell);
    sample->area = measure_shadow(mesh, mesh->positions);
    sample->held = malloc(mesh->vertex_count * sizeof *sample->held);
    if (!sample->held) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for a sample");
    for (size_t v = 0; v < mesh->vertex_count; v++)
        if (hypot(mesh->positions[3 * v], mesh->positions[3 * v + 1]) <= DISC_RADIUS + 1e-9)
            sample->held[sample->held_count++] = (uint32_t)v;
    make_uneven(mesh, seed);
    return TULLE_OK;
}

void drape_sample_destroy(drape_sample *sample) {
    tulle_mesh_destroy(&sample->mesh);
    free(sample->held);
    *sample = (drape_sample){0};
}

tulle_cloth_def drape_sample_get_cloth(drape_sample *sample, const tulle_material *material) {
    sample->pin = tulle_pin_default();
    sample->pin.vertices = sample->held;
    sample->pin.vertex_count = sample->held_count;
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&sample->mesh);
    def.has_flat_rest = 1;
    def.material = *material;
    def.material.air_damping = 1.0;
    def.pins = &sample->pin;
    def.pin_count = 1;
    return def;
}

bool drape_is_at_rest(const double *velocities, size_t vertex_count) {
    for (size_t k = 0; k < 3 * vertex_count; k++)
        if (fabs(velocities[k]) > REST_SPEED) return false;
    return true;
}
