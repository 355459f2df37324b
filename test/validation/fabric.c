/* fabric.c - woven cloth without contact, against what theory says: a strip that bends under its
 * weight, a strip that is pulled. */
#include "validation/stage.h"
#include "validation/strips.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- a strip bends under its weight ---- */

static const double STRIP_WIDTH = 0.025; /* [m] as in ASTM D1388 */

/* Angle [rad] below the horizontal at which the end of an overhanging strip is seen from the edge
 * that it hangs over. Its length is twice its bending length (B / (rho g))^(1/3). */
static double measure_droop(validation_run *run, pattern division, double cells_per_metre) {
    tulle_material material = stage_take_fabric(run, "cotton");
    double const c = cbrt(material.bend_warp / (material.area_density * VALIDATION_GRAVITY));
    double const length = 2.0 * c;
    uint32_t const columns = (uint32_t)fmax(1.0, round(length * cells_per_metre));
    double const cell = length / columns;
    strip const sample = {.begin = -2.0 * cell,
                          .end = length,
                          .width = STRIP_WIDTH,
                          .columns = columns + 2,
                          .rows = (uint32_t)fmax(1.0, round(STRIP_WIDTH / cell)),
                          .pattern = division};
    tulle_mesh *const mesh = strips_make(run, &sample);
    tulle_world *const world = stage_make_woven_world(run);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    material.air_damping = 5.0;
    def.material = material;
    /* The inner vertices of an irregular mesh do not lie on lines. */
    tulle_pin const pin =
        strips_pin_between(run, mesh, sample.begin, division == IRREGULAR ? 0.3 * cell : 0.0);
    def.pins = &pin;
    def.pin_count = 1;
    tulle_cloth_id const id = validate_add_cloth(run, world, &def);
    validate_simulate(run, world, 4.0);
    const double *const x = tulle_cloth_get_positions(world, id, NULL);
    double reach = 0.0, drop = 0.0;
    int count = 0;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        if (mesh->positions[3 * v] < length - 1e-9) continue;
        reach += x[3 * v];
        drop -= x[3 * v + 2];
        count++;
    }
    return count > 0 ? atan2(drop, reach) : (double)NAN;
}

static const char peirce[] = "Peirce 1930: length twice the bending length";

static void droops_on_any_mesh(validation_run *run) {
    for (int p = 0; p < PATTERN_COUNT; p++) {
        char what[96];
        snprintf(what, sizeof what, "angle of an overhanging strip, 480 cells a metre, %s",
                 strips_pattern_names[p]);
        validate_row(run, what, measure_droop(run, (pattern)p, 480.0) / VALIDATION_DEGREE, "deg",
                     within(41.5, 1.0 / 41.5), peirce);
    }
}

static void droops_at_any_fineness(validation_run *run) {
    static const double finenesses[] = {60.0, 120.0, 240.0, 480.0, 960.0};
    bool const is_quick = validate_options(run)->is_quick;
    for (size_t i = is_quick ? 1 : 0; i < (is_quick ? 3 : 5); i++) {
        char what[96];
        snprintf(what, sizeof what, "angle of an overhanging strip, %.0f cells a metre",
                 finenesses[i]);
        validate_row(run, what, measure_droop(run, ALTERNATING, finenesses[i]) / VALIDATION_DEGREE,
                     "deg", finenesses[i] >= 240.0 ? within(41.5, 1.0 / 41.5) : nothing(), peirce);
    }
}

/* ---- a strip is pulled ---- */

/* Largest way [m] of an inner vertex out of the mean of its neighbours: a zigzag of cell size. */
static double measure_zigzag(validation_run *run, const tulle_mesh *mesh, const double *x) {
    double *const sums = validate_allocate(run, 4 * mesh->vertex_count * sizeof *sums);
    memset(sums, 0, 4 * mesh->vertex_count * sizeof *sums);
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (size_t k = 0; k < 3; k++) {
            size_t const at = mesh->triangles[3 * t + k];
            for (size_t other = 1; other < 3; other++) {
                size_t const from = mesh->triangles[3 * t + (k + other) % 3];
                sums[4 * at] += x[3 * from + 2];
                sums[4 * at + 1] += 1.0;
            }
        }
    double largest = 0.0;
    for (size_t v = 0; v < mesh->vertex_count; v++)
        largest = fmax(largest, fabs(x[3 * v + 2] - sums[4 * v] / sums[4 * v + 1]));
    return largest;
}

static void stays_flat_when_pulled(validation_run *run) {
    static const double strains[] = {0.05, 0.10};
    bool const is_quick = validate_options(run)->is_quick;
    for (int p = 0; p < PATTERN_COUNT; p++)
        for (size_t s = 0; s < (is_quick ? 1 : 2); s++) {
            uint32_t const fineness = is_quick ? 1 : 3;
            strip const sample = {.begin = 0.0,
                                  .end = 0.5,
                                  .width = 0.2,
                                  .columns = 20 * fineness,
                                  .rows = 8 * fineness,
                                  .pattern = (pattern)p};
            tulle_mesh *const mesh = strips_make(run, &sample);
            tulle_cloth_def def = tulle_cloth_def_default();
            tulle_pin pins[2] = {strips_pin_between(run, mesh, 0.0, 0.0),
                                 strips_pin_between(run, mesh, 0.5, 0.5)};
            tulle_keyframe const keys[2] = {stage_key(0.0, 0.0, 0.0, 0.0),
                                            stage_key(1.0, strains[s] * 0.5, 0.0, 0.0)};
            pins[1].motion = (tulle_motion){.keys = keys, .key_count = 2};
            /* So that it may leave the plane, which it need not. */
            uint32_t noise = 1;
            for (size_t v = 0; v < mesh->vertex_count; v++) {
                noise = noise * 1664525u + 1013904223u;
                bool const is_held = fabs(mesh->positions[3 * v] - 0.25) > 0.25 - 1e-9;
                if (!is_held) mesh->positions[3 * v + 2] = 2e-4 * ((noise >> 8) / 16777216.0 - 0.5);
            }
            tulle_world_def world_def = validate_world_def(run);
            world_def.membrane = TULLE_MEMBRANE_WOVEN;
            world_def.gravity[2] = 0.0;
            tulle_world *const world = validate_make_world(run, &world_def);
            def.mesh = tulle_mesh_get_view(mesh);
            def.has_flat_rest = 1; /* the noise is none of its folds */
            def.material = stage_take_fabric(run, "cotton");
            def.material.air_damping = 2.0;
            def.pins = pins;
            def.pin_count = 2;
            tulle_cloth_id const id = validate_add_cloth(run, world, &def);
            validate_simulate(run, world, 2.0);
            char what[96];
            snprintf(what, sizeof what, "strip pulled by %.0f %%, %s: zigzag", 100.0 * strains[s],
                     strips_pattern_names[p]);
            validate_row(run, what,
                         1e3 *
                             measure_zigzag(run, mesh, tulle_cloth_get_positions(world, id, NULL)),
                         "mm", at_most(0.01), "flat: Cerda & Mahadevan 2003");
        }
}

const experiment fabric_experiments[] = {
    {"fabric.meshed", "a strip overhangs as its bending length says, on any mesh",
     droops_on_any_mesh, true},
    {"fabric.finer", "the same by fineness", droops_at_any_fineness, false},
    {"fabric.pulled", "a strip that is pulled stays flat", stays_flat_when_pulled, false},
    {0},
};
