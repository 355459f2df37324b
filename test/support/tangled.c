#include "support/tangled.h"

#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double PI = 3.14159265358979323846;
static const double SIDE = 1.0; /* [m] of a cloth */
enum { LENGTH_SWEEPS = 40, ATTEMPTS = 24, WAVES = 6 };

static const char *const FAMILY_NAMES[TANGLED_FAMILY_COUNT] = {
    "crumple",     "loop",    "sphere rim", "box rim", "lump rim",
    "interleaved", "corners", "thrust",     "sunk",    "slab",
};

const char *tangled_family_name(tangled_family family) { return FAMILY_NAMES[family]; }

/* ---- random numbers: splitmix64 ---- */

static uint64_t next_bits(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}
static double draw(uint64_t *state, double low, double high) {
    return low + (high - low) * (double)(next_bits(state) >> 11) * 0x1p-53;
}

/* ---- deformations ---- */

/* Adds waves along random directions to all coordinates; wavelengths from `shortest` to a side. */
static void add_waves(tulle_mesh *mesh, uint64_t *random, double amplitude, double shortest) {
    for (int w = 0; w < WAVES; w++) {
        double const angle = draw(random, 0.0, 2.0 * PI), phase = draw(random, 0.0, 2.0 * PI);
        double const wavelength = draw(random, shortest, SIDE);
        double const k = 2.0 * PI / wavelength;
        double push[3];
        for (int c = 0; c < 3; c++)
            push[c] = amplitude * draw(random, -1.0, 1.0) * wavelength / SIDE;
        for (size_t v = 0; v < mesh->vertex_count; v++) {
            double *const x = mesh->positions + 3 * v;
            double const s = sin(k * (cos(angle) * x[0] + sin(angle) * x[1]) + phase);
            for (int c = 0; c < 3; c++) x[c] += push[c] * s;
        }
    }
}

/* Brings the edges of triangles back to about their lengths in `rest`, blind to intersections. */
static void restore_lengths(tulle_mesh *mesh, const double *rest) {
    for (int sweep = 0; sweep < LENGTH_SWEEPS; sweep++) {
        for (size_t i = 0; i < 3 * mesh->triangle_count; i++) {
            size_t const a = mesh->triangles[i];
            size_t const b = mesh->triangles[i % 3 == 2 ? i - 2 : i + 1];
            double way[3], length2 = 0.0, wanted2 = 0.0;
            for (size_t c = 0; c < 3; c++) {
                way[c] = mesh->positions[3 * b + c] - mesh->positions[3 * a + c];
                double const flat = rest[3 * b + c] - rest[3 * a + c];
                length2 += way[c] * way[c];
                wanted2 += flat * flat;
            }
            double const share = 0.25 * (1.0 - sqrt(wanted2 / fmax(length2, 1e-12)));
            for (size_t c = 0; c < 3; c++) {
                mesh->positions[3 * a + c] += share * way[c];
                mesh->positions[3 * b + c] -= share * way[c];
            }
        }
    }
}

/* Rotates about x, then z, then moves. */
static void place(tulle_mesh *mesh, double tilt, double turn, const double move[3]) {
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *const x = mesh->positions + 3 * v;
        double const y = cos(tilt) * x[1] - sin(tilt) * x[2];
        double const z = sin(tilt) * x[1] + cos(tilt) * x[2];
        double const x0 = x[0];
        x[0] = cos(turn) * x0 - sin(turn) * y + move[0];
        x[1] = sin(turn) * x0 + cos(turn) * y + move[1];
        x[2] = z + move[2];
    }
}

/* Rolls the sheet along x into a spiral whose end crosses its beginning. */
static void roll_up(tulle_mesh *mesh, uint64_t *random, double strength) {
    double const turns = draw(random, 1.1, 1.6) * strength, drift = draw(random, -0.3, 0.3);
    enum { STEPS = 400 };
    double curve[STEPS + 1][2] = {{0.0, 0.0}};
    for (int i = 0; i < STEPS; i++) {
        double const s = (double)i / STEPS;
        /* slow, fast, slow: a loop with two straight ends */
        double const angle = 2.0 * PI * turns * 0.5 * (1.0 + tanh(4.0 * (s - 0.5)));
        curve[i + 1][0] = curve[i][0] + cos(angle) * SIDE / STEPS;
        curve[i + 1][1] = curve[i][1] + sin(angle) * SIDE / STEPS;
    }
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *const x = mesh->positions + 3 * v;
        double const s = fmin(fmax(x[0] / SIDE + 0.5, 0.0), 1.0) * STEPS;
        int const i = s < STEPS ? (int)s : STEPS - 1;
        double const part = s - i;
        x[0] = curve[i][0] + part * (curve[i + 1][0] - curve[i][0]);
        x[2] = curve[i][1] + part * (curve[i + 1][1] - curve[i][1]);
        x[1] += drift * x[0];
    }
}

/* ---- obstacles ---- */

static tulle_mesh make_sphere(double radius, unsigned resolution) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    def.radius = radius;
    def.resolution[0] = def.resolution[1] = resolution; /* 20 resolution^2 triangles */
    return small_shape(def, 0.0, 0.0, 0.0);
}

static tulle_mesh make_box(double x, double y, double z) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_BOX);
    def.size[0] = x;
    def.size[1] = y;
    def.size[2] = z;
    return small_shape(def, 0.0, 0.0, -0.5 * z);
}

/* A sphere with knobs and dents. */
static tulle_mesh make_lump(uint64_t *random, double radius, unsigned resolution) {
    tulle_mesh mesh = make_sphere(radius, resolution);
    for (int knob = 0; knob < 6; knob++) {
        double const a = draw(random, 0.0, 2.0 * PI), h = draw(random, -1.0, 1.0);
        double const r = sqrt(1.0 - h * h), size = draw(random, -0.35, 0.8);
        double const axis[3] = {r * cos(a), r * sin(a), h};
        for (size_t v = 0; v < mesh.vertex_count; v++) {
            double *const x = mesh.positions + 3 * v;
            double const norm = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
            double const c = (x[0] * axis[0] + x[1] * axis[1] + x[2] * axis[2]) / norm;
            double const grow = 1.0 + size * exp(-12.0 * (1.0 - c));
            for (int k = 0; k < 3; k++) x[k] *= grow;
        }
    }
    return mesh;
}

/* ---- families ---- */

static void add_sheet(tangled_start *start, unsigned n) {
    size_t const i = start->cloth_count++;
    start->cloths[i] = small_sheet(SIDE, n, 0.0);
    size_t const bytes = 3 * start->cloths[i].vertex_count * sizeof(double);
    start->rest[i] = malloc(bytes);
    assert_non_null(start->rest[i]);
    memcpy(start->rest[i], start->cloths[i].positions, bytes);
}

static void wrinkle(tangled_start *start, size_t i, uint64_t *random, double amplitude) {
    add_waves(&start->cloths[i], random, amplitude, 0.3);
    restore_lengths(&start->cloths[i], start->rest[i]);
}

/* The sheet's border, or a corner of it, in an obstacle at the origin. */
static void thrust_rim(tangled_start *start, uint64_t *random, double depth) {
    wrinkle(start, 0, random, 0.15);
    bool const is_corner = draw(random, 0.0, 1.0) < 0.5;
    double const reach = is_corner ? SIDE / sqrt(2.0) : 0.5 * SIDE;
    double const turn = is_corner ? PI / 4.0 : 0.0, tilt = draw(random, -0.6, 0.6);
    double const none[3] = {0.0, 0.0, 0.0};
    place(&start->cloths[0], 0.0, turn, none);
    double const move[3] = {reach + 0.25 - depth, draw(random, -0.1, 0.1),
                            draw(random, -0.08, 0.08)};
    place(&start->cloths[0], tilt, 0.0, move);
}

static void make_pair_of_cloths(tangled_start *start, uint64_t *random, double strength,
                                unsigned n) {
    add_sheet(start, n);
    add_sheet(start, n);
    double move[3] = {draw(random, -0.2, 0.2), draw(random, -0.2, 0.2), 0.0};
    if (start->family == TANGLED_INTERLEAVED) {
        wrinkle(start, 0, random, 0.3 * strength);
        wrinkle(start, 1, random, 0.3 * strength);
        move[2] = draw(random, 0.01, 0.04);
        place(&start->cloths[1], draw(random, -0.1, 0.1), draw(random, 0.0, PI), move);
        return;
    }
    /* a wrinkled sheet may cross itself too often, however it lies */
    wrinkle(start, 0, random, 0.15 * fmin(strength, 1.0));
    wrinkle(start, 1, random, 0.2 * fmin(strength, 1.0));
    double const turn = draw(random, 0.0, PI);
    if (start->family == TANGLED_CORNERS) {
        /* upright on a corner, the lowest part below the other */
        double const none[3] = {0.0, 0.0, 0.0};
        place(&start->cloths[1], 0.0, PI / 4.0, none);
        move[2] = SIDE / sqrt(2.0) - 0.12 * strength;
    } else {
        move[2] = 0.5 * SIDE - 0.2 * strength;
    }
    place(&start->cloths[1], PI / 2.0 + draw(random, -0.5, 0.5), turn, move);
}

static void make_with_obstacle(tangled_start *start, uint64_t *random, double strength,
                               unsigned n) {
    add_sheet(start, n);
    if (start->family == TANGLED_SPHERE_RIM) {
        start->obstacle = make_sphere(0.25, n / 3 + 2);
        thrust_rim(start, random, 0.12 * strength);
    } else if (start->family == TANGLED_BOX_RIM) {
        start->obstacle = make_box(0.5, 0.6, 0.4);
        thrust_rim(start, random, 0.12 * strength);
    } else if (start->family == TANGLED_LUMP_RIM) {
        start->obstacle = make_lump(random, 0.2, n / 3 + 2);
        thrust_rim(start, random, 0.1 * strength);
    } else if (start->family == TANGLED_SLAB) {
        start->obstacle = make_box(0.02, 1.2, 0.8);
        thrust_rim(start, random, 0.3 * strength);
    } else {
        start->obstacle = make_lump(random, 0.3, n / 3 + 2);
        wrinkle(start, 0, random, 0.3);
        double const move[3] = {draw(random, -0.2, 0.2), draw(random, -0.2, 0.2),
                                0.3 - 0.1 * strength};
        place(&start->cloths[0], draw(random, -0.2, 0.2), draw(random, 0.0, PI), move);
    }
}

static size_t judge(const tangled_start *start, const double *const cloth_positions[],
                    const double *obstacle_positions) {
    tulle_check_body bodies[TANGLED_BODIES_MAX + 1];
    size_t count = 0;
    for (size_t i = 0; i < start->cloth_count; i++) {
        bodies[count] = (tulle_check_body){tulle_mesh_get_view(&start->cloths[i]), 0};
        bodies[count++].mesh.positions = cloth_positions[i];
    }
    if (start->obstacle.vertex_count > 0) {
        bodies[count] = (tulle_check_body){tulle_mesh_get_view(&start->obstacle), 1};
        bodies[count++].mesh.positions = obstacle_positions;
    }
    tulle_check_result result = {0};
    tulle_error error = {0};
    if (tulle_check_intersections(bodies, count, 1, &result, &error) != TULLE_OK)
        fail_msg("judge: %s", error.message);
    size_t const pair_count = result.pair_count;
    tulle_check_result_destroy(&result);
    return pair_count;
}

static tangled_start make_once(tangled_family family, uint64_t seed, double strength, unsigned n) {
    tangled_start start = {.family = family};
    uint64_t random = seed * UINT64_C(0x2545f4914f6cdd1d) + (uint64_t)family;
    if (family == TANGLED_CRUMPLE) {
        add_sheet(&start, n);
        wrinkle(&start, 0, &random, 0.9 * strength);
    } else if (family == TANGLED_LOOP) {
        add_sheet(&start, n);
        wrinkle(&start, 0, &random, 0.1);
        roll_up(&start.cloths[0], &random, strength);
        restore_lengths(&start.cloths[0], start.rest[0]);
    } else if (family == TANGLED_INTERLEAVED || family == TANGLED_CORNERS ||
               family == TANGLED_THRUST) {
        make_pair_of_cloths(&start, &random, strength, n);
    } else {
        make_with_obstacle(&start, &random, strength, n);
    }
    const double *const positions[] = {start.cloths[0].positions, start.cloths[1].positions};
    start.pair_count = judge(&start, positions, start.obstacle.positions);
    return start;
}

tangled_start tangled_make(tangled_family family, uint64_t seed, unsigned vertices_per_side) {
    double strength = 1.0;
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        tangled_start start = make_once(family, seed, strength, vertices_per_side);
        if (start.pair_count >= TANGLED_PAIRS_MIN && start.pair_count <= TANGLED_PAIRS_MAX)
            return start;
        strength *= start.pair_count < TANGLED_PAIRS_MIN ? 1.1 : 0.93;
        tangled_destroy(&start);
    }
    fail_msg("no start of family %s with seed %llu", FAMILY_NAMES[family],
             (unsigned long long)seed);
    return (tangled_start){0};
}

void tangled_destroy(tangled_start *start) {
    for (size_t i = 0; i < start->cloth_count; i++) {
        tulle_mesh_destroy(&start->cloths[i]);
        free(start->rest[i]);
    }
    if (start->obstacle.vertex_count > 0) tulle_mesh_destroy(&start->obstacle);
    *start = (tangled_start){0};
}

tulle_world *tangled_make_world(const tangled_start *start, const tulle_world_def *def) {
    tulle_world *world = NULL;
    tulle_error error = {0};
    if (tulle_world_create(def, &world, &error) != TULLE_OK) fail_msg("%s", error.message);
    for (size_t i = 0; i < start->cloth_count; i++) {
        tulle_cloth_def cloth = tulle_cloth_def_default();
        cloth.mesh = tulle_mesh_get_view(&start->cloths[i]);
        cloth.rest_positions = start->rest[i];
        if (tulle_world_add_cloth(world, &cloth, NULL, &error) != TULLE_OK)
            fail_msg("cloth: %s", error.message);
    }
    if (start->obstacle.vertex_count > 0) small_add_obstacle(world, &start->obstacle);
    return world;
}

size_t tangled_judge(const tangled_start *start, const tulle_world *world) {
    const double *positions[TANGLED_BODIES_MAX] = {0};
    for (size_t i = 0; i < start->cloth_count; i++)
        positions[i] = tulle_cloth_get_positions(world, (tulle_cloth_id){(uint32_t)i, 1}, NULL);
    const double *const obstacle =
        start->obstacle.vertex_count > 0
            ? tulle_obstacle_get_positions(world, (tulle_obstacle_id){0, 1}, NULL)
            : NULL;
    return judge(start, positions, obstacle);
}
