/* support/detect_scene.c - the families of detect_scene.h. */
#include "support/detect_scene.h"

#include "base/hash.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

const char *const detect_family_names[DETECT_FAMILY_COUNT] = {
    "free", "fast",  "grid", "coplanar", "needles", "shared",
    "wave", "rough", "fold", "curl",     "ramp",    "ring"};

static double uniform(uint64_t *seed, double low, double high) {
    return low + (high - low) * random_uniform(seed);
}

static double grid_coordinate(uint64_t *seed) { return (double)(random_next(seed) % 4); }

static uint32_t add_vertex(detect_scene *scene, const double start[3], const double end[3]) {
    assert_true(scene->vertex_count < DETECT_MAX_VERTICES);
    memcpy(scene->start + 3 * scene->vertex_count, start, 3 * sizeof(double));
    memcpy(scene->end + 3 * scene->vertex_count, end, 3 * sizeof(double));
    return (uint32_t)scene->vertex_count++;
}

static void add_triangle(detect_scene *scene, uint32_t a, uint32_t b, uint32_t c) {
    assert_true(scene->triangle_count < DETECT_MAX_TRIANGLES);
    uint32_t *const corners = scene->triangles + 3 * scene->triangle_count++;
    corners[0] = a, corners[1] = b, corners[2] = c;
}

/* One corner of a loose triangle about a place. */
static void place_loose(detect_family family, const double place[3], int corner, uint64_t *seed,
                        double start[3], double end[3]) {
    for (int k = 0; k < 3; k++) {
        switch (family) {
        case DETECT_GRID:
            start[k] = grid_coordinate(seed);
            end[k] = grid_coordinate(seed);
            break;
        case DETECT_COPLANAR:
            start[k] = k == 2 ? 0.0 : place[k] + uniform(seed, -0.4, 0.4);
            end[k] = k == 2 ? 0.0 : start[k] + uniform(seed, -0.3, 0.3);
            break;
        case DETECT_NEEDLES:
            start[k] = place[k] + (corner == 1 ? uniform(seed, -1, 1) : uniform(seed, -1e-6, 1e-6));
            end[k] = start[k] + uniform(seed, -0.2, 0.2);
            break;
        default: {
            double const motion = family == DETECT_FAST ? 2.0 : 0.1;
            start[k] = place[k] + uniform(seed, -0.4, 0.4);
            end[k] = start[k] + uniform(seed, -motion, motion);
        }
        }
    }
}

static void add_loose(detect_scene *scene, detect_family family, unsigned size, uint64_t *seed) {
    bool const is_flat = random_next(seed) % 4 == 0;
    for (unsigned i = 0; i < 2 * size; i++) {
        double const place[3] = {uniform(seed, -0.5, 0.5), uniform(seed, -0.5, 0.5),
                                 uniform(seed, -0.5, 0.5)};
        uint32_t corners[3];
        for (int c = 0; c < 3; c++) {
            double start[3], end[3];
            place_loose(family, place, c, seed, start, end);
            if (family == DETECT_GRID && is_flat) start[2] = end[2] = 0.0;
            corners[c] = add_vertex(scene, start, end);
        }
        add_triangle(scene, corners[0], corners[1], corners[2]);
    }
}

static void add_shared(detect_scene *scene, unsigned size, uint64_t *seed) {
    uint32_t const base = (uint32_t)scene->vertex_count, count = 4 + size;
    for (uint32_t i = 0; i < count; i++) {
        double start[3], end[3];
        for (int k = 0; k < 3; k++) {
            start[k] = uniform(seed, -1.0, 1.0);
            end[k] = start[k] + uniform(seed, -0.7, 0.7);
        }
        (void)add_vertex(scene, start, end);
    }
    for (unsigned i = 0; i < 2 * size; i++) {
        uint32_t const a = (uint32_t)(random_next(seed) % count);
        uint32_t const b = (a + 1 + (uint32_t)(random_next(seed) % (count - 1))) % count;
        uint32_t c = a;
        while (c == a || c == b) c = (uint32_t)(random_next(seed) % count);
        add_triangle(scene, base + a, base + b, base + c);
    }
}

/* What bends a sheet; the meaning of the numbers depends on the family. */
typedef struct sheet_shape {
    double amount[2]; /* at both ends of the step */
    double twist, sway[3], phase;
} sheet_shape;

/* Where point (u, v) of the unit square lies at one end of the step. */
static void place_sheet(detect_family family, const sheet_shape *shape, int end, double u, double v,
                        double x[3]) {
    double const a = shape->amount[end], tau = 6.283185307179586;
    double angle, radius;
    switch (family) {
    case DETECT_WAVE:
        angle = tau * (1.5 * u + shape->phase * v);
        x[0] = u - a * sin(2.0 * angle), x[1] = v; /* steep waves lean over */
        x[2] = a * sin(angle) * (1.0 + shape->twist * u);
        break;
    case DETECT_FOLD:
        x[0] = end == 1 && u > 0.5 ? 1.0 - u : u;
        x[1] = v + shape->twist * u;
        x[2] = end == 1 && u > 0.5 ? a : 0.0;
        break;
    case DETECT_CURL:
        angle = a * u;
        x[0] = sin(angle) / a, x[1] = v + shape->twist * u, x[2] = (1.0 - cos(angle)) / a;
        break;
    case DETECT_RAMP: /* `amount` is the pitch */
        angle = tau * (1.2 + shape->phase) * u;
        radius = 0.5 + 0.5 * v;
        x[0] = radius * cos(angle), x[1] = radius * sin(angle);
        x[2] = a * angle / tau + shape->twist * v;
        break;
    case DETECT_RING: /* `amount` is the whole angle */
        angle = a * (u - 0.5);
        radius = 0.6 + 0.4 * v;
        x[0] = radius * cos(angle), x[1] = radius * sin(angle);
        x[2] = shape->twist * (end == 0 ? -1.0 : 1.0) * u * v;
        break;
    default: x[0] = u, x[1] = v, x[2] = 0.0;
    }
    for (int k = 0; end == 1 && k < 3; k++) x[k] += shape->sway[k];
}

static sheet_shape make_sheet_shape(detect_family family, uint64_t *seed) {
    sheet_shape shape = {.twist = uniform(seed, -0.3, 0.3), .phase = uniform(seed, 0.0, 0.5)};
    for (int k = 0; k < 3; k++) shape.sway[k] = uniform(seed, -0.5, 0.5);
    for (int end = 0; end < 2; end++) {
        double const sign = end == 0 ? 1.0 : -1.0;
        switch (family) {
        case DETECT_WAVE: shape.amount[end] = uniform(seed, -0.4, 0.4); break;
        case DETECT_FOLD: shape.amount[end] = uniform(seed, -0.02, 0.02); break;
        case DETECT_CURL: shape.amount[end] = uniform(seed, 3.0, 10.0); break;
        case DETECT_RAMP: shape.amount[end] = sign * uniform(seed, 0.02, 0.4); break;
        case DETECT_RING: shape.amount[end] = 6.283 - sign * uniform(seed, 0.05, 0.8); break;
        default: break;
        }
    }
    if (family == DETECT_FOLD && random_next(seed) % 2 == 0) shape.amount[1] = 0.0;
    if (family == DETECT_RING) shape.twist *= 0.1;
    return shape;
}

static void add_sheet(detect_scene *scene, detect_family family, unsigned size, uint64_t *seed) {
    sheet_shape const shape = make_sheet_shape(family, seed);
    bool const is_strip = family == DETECT_RAMP || family == DETECT_RING;
    uint32_t const columns = is_strip ? 4 * size : 1 + size, rows = is_strip ? 1 + size / 4 : size;
    uint32_t const base = (uint32_t)scene->vertex_count;
    for (uint32_t i = 0; i <= columns; i++)
        for (uint32_t j = 0; j <= rows; j++) {
            double const u = (double)i / (double)columns, v = (double)j / (double)rows;
            double start[3], end[3];
            place_sheet(family, &shape, 0, u, v, start);
            place_sheet(family, &shape, 1, u, v, end);
            for (int k = 0; k < 3 && family == DETECT_ROUGH; k++) {
                start[k] += uniform(seed, -0.3, 0.3) / size;
                end[k] = start[k] + uniform(seed, -0.5, 0.5);
            }
            (void)add_vertex(scene, start, end);
        }
    for (uint32_t i = 0; i < columns; i++)
        for (uint32_t j = 0; j < rows; j++) {
            uint32_t const a = base + i * (rows + 1) + j, b = a + rows + 1;
            add_triangle(scene, a, b, a + 1);
            add_triangle(scene, b, b + 1, a + 1);
        }
}

void detect_scene_add(detect_scene *scene, detect_family family, unsigned size, uint64_t *seed) {
    assert_true(scene->surface_count < DETECT_MAX_SURFACES);
    tulle_detect_surface surface = {.vertex_begin = (uint32_t)scene->vertex_count,
                                    .triangle_begin = (uint32_t)scene->triangle_count};
    if (family < DETECT_SHARED)
        add_loose(scene, family, size, seed);
    else if (family == DETECT_SHARED)
        add_shared(scene, size, seed);
    else
        add_sheet(scene, family, size, seed);
    surface.vertex_end = (uint32_t)scene->vertex_count;
    surface.triangle_end = (uint32_t)scene->triangle_count;
    scene->surfaces[scene->surface_count++] = surface;
}

void detect_scene_place(detect_scene *scene, double scale, double offset) {
    for (size_t i = 0; i < 3 * scene->vertex_count; i++) {
        scene->start[i] = scale * (scene->start[i] + offset);
        scene->end[i] = scale * (scene->end[i] + offset);
    }
}

tulle_detect_def detect_scene_get_def(const detect_scene *scene) {
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = scene->triangles;
    def.triangle_count = scene->triangle_count;
    def.vertex_count = scene->vertex_count;
    def.surfaces = scene->surfaces;
    def.surface_count = scene->surface_count;
    def.collides = scene->has_collides ? scene->collides : NULL;
    def.minimum_separation = scene->minimum_separation;
    return def;
}
