/* dynamics/material.c - material presets and the ranges of material values. docs/guide/materials.md
 * explains the numbers.
 *
 * Area density and bending rigidity lie in the ranges that fabric-testing textbooks print for such
 * cloth (KES-F bending rigidity, 1 gf cm^2/cm = 9.81e-5 N m). The model is isotropic, its shear
 * modulus 3/8 of the stretch stiffness. Woven cloth is ten times stiffer and more along its yarns
 * than the stretch stiffness here, and about half as stiff in shear as the model. Cloth drapes by
 * shear, so the values stay near its shear stiffness; with that of the yarns a draped cloth would
 * stand like paper.
 * Friction is typical of such cloth on a smooth hard surface; damping is chosen, not measured. */
#include "base/error.h"
#include "dynamics/cloth_model.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define FABRIC_SOURCE                                                                              \
    "area density and bending rigidity: middle of the ranges in textbooks on fabric hand "         \
    "(Kawabata, The Standardization and Analysis of Hand Evaluation, 1980; Hu, Structure and "     \
    "Mechanics of Woven Fabrics, 2004); stretch stiffness chosen for drape: 3/8 of it, the "       \
    "model's shear modulus, lies somewhat above what they print; friction typical; damping "       \
    "chosen"
#define NET_SOURCE                                                                                 \
    "area density: commercial polyester tulle and mosquito netting, 20 to 50 g/m^2; stretch and "  \
    "bending estimated, between cotton and silk of that weight; friction typical; damping chosen"
#define RUBBER_SOURCE                                                                              \
    "natural rubber sheet of 1 mm computed from bulk values (950 kg/m^3, Young's modulus 1.5 "     \
    "MPa, Poisson ratio 0.5; Treloar, The Physics of Rubber Elasticity, 1975); friction typical; " \
    "damping chosen"

typedef struct preset {
    const char *name, *source;
    tulle_material material;
} preset;

/* Isotropic in bending: the rigidity of warp and weft, and half of it for twist. */
#define BEND(rigidity)                                                                             \
    .bend_warp = (rigidity), .bend_weft = (rigidity), .bend_twist = 0.5 * (rigidity)
/* Stretch, bending, stiffening strain. */
#define SPRINGS(stretch, bend, strain) .springs = {(stretch), (bend), (strain)}
/* Stretch, bending, air. */
#define DAMPING(stretch, bend, air)                                                                \
    .stretch_damping = (stretch), .bend_damping = (bend), .air_damping = (air)
#define FRICTION(value) .friction = (value), .dynamic_friction = -1.0, .friction_across = 1.0

static const preset PRESETS[] = {
    {"cotton",
     FABRIC_SOURCE,
     {.area_density = 0.150,
      .warp = {4500.0, 0.05, 0.14},
      .weft = {2800.0, 0.05, 0.14},
      .shear = {50.0, 0.2, 0.6},
      .poisson = 0.1,
      BEND(1.0e-5),
      SPRINGS(300.0, 1.0e-5, 0.1),
      DAMPING(5e-4, 2e-3, 0.05),
      FRICTION(0.40)}},
    {"silk",
     FABRIC_SOURCE,
     {.area_density = 0.070,
      .warp = {3000.0, 0.05, 0.15},
      .weft = {2000.0, 0.05, 0.15},
      .shear = {25.0, 0.2, 0.6},
      .poisson = 0.1,
      BEND(1.2e-6),
      SPRINGS(150.0, 4.0e-6, 0.1),
      DAMPING(5e-4, 2e-3, 0.10),
      FRICTION(0.25)}},
    {"wool",
     FABRIC_SOURCE,
     {.area_density = 0.220,
      .warp = {3000.0, 0.05, 0.2},
      .weft = {2000.0, 0.05, 0.2},
      .shear = {40.0, 0.2, 0.6},
      .poisson = 0.1,
      BEND(1.2e-5),
      SPRINGS(250.0, 1.5e-5, 0.1),
      DAMPING(1e-3, 4e-3, 0.05),
      FRICTION(0.45)}},
    {"denim",
     FABRIC_SOURCE,
     {.area_density = 0.400,
      .warp = {6000.0, 0.05, 0.14},
      .weft = {3200.0, 0.05, 0.14},
      .shear = {150.0, 0.2, 0.6},
      .poisson = 0.1,
      BEND(1.0e-4),
      SPRINGS(900.0, 1.0e-4, 0.1),
      DAMPING(5e-4, 2e-3, 0.02),
      FRICTION(0.50)}},
    {"net",
     NET_SOURCE,
     {.area_density = 0.035,
      .warp = {500.0, 0.1, 0.5},
      .weft = {500.0, 0.1, 0.5},
      .shear = {10.0, 0.3, 1.0},
      .poisson = 0.3,
      BEND(2.5e-6),
      SPRINGS(100.0, 2.5e-6, 0.1),
      DAMPING(5e-4, 2e-3, 0.10),
      FRICTION(0.30)}},
    {"rubber-sheet",
     RUBBER_SOURCE,
     {.area_density = 0.950,
      .warp = {2000.0, 0.0, 3.0},
      .weft = {2000.0, 0.0, 3.0},
      .shear = {500.0, 0.0, 3.0},
      .poisson = 0.5,
      BEND(1.7e-4),
      SPRINGS(1500.0, 1.7e-4, 0.0),
      DAMPING(2e-3, 5e-3, 0.02),
      FRICTION(0.80)}},
};
enum { PRESET_COUNT = sizeof PRESETS / sizeof *PRESETS };

tulle_status tulle_material_preset(const char *name, tulle_material *material) {
    if (!name || !material) return TULLE_ERROR_INVALID_ARGUMENT;
    for (size_t i = 0; i < PRESET_COUNT; i++) {
        if (strcmp(PRESETS[i].name, name) != 0) continue;
        *material = PRESETS[i].material;
        return TULLE_OK;
    }
    return TULLE_ERROR_INVALID_ARGUMENT;
}

const char *tulle_material_preset_name(size_t index) {
    return index < PRESET_COUNT ? PRESETS[index].name : NULL;
}

const char *tulle_material_preset_source(size_t index) {
    return index < PRESET_COUNT ? PRESETS[index].source : NULL;
}

/* ---- ranges ---- */

/* Largest sensible value [SI]. Beyond it doubles no longer resolve the contact distances. */
static const double LARGEST = 1e6;
static const double SMALLEST_POSITIVE = 1e-12;
/* [N/m], [N m] far beyond any cloth; they keep products finite. */
static const double LARGEST_STIFFNESS = 1e12, LARGEST_RIGIDITY = 1e9;
/* To a solver, cloth that gets stiff at less strain is a chain of rods. */
static const double LEAST_STRAIN = 1e-3;
/* [1/m] Largest hysteresis of bending over rigidity, and over stiffness of shear: far beyond cloth,
 * whose loops are narrower than the range of the test. */
static const double LARGEST_BEND_WIDTH = 1e6, LARGEST_SHEAR_WIDTH = 2.0;
/* Nearer to 1, cloth that is pulled one way gives way in the other without a force. */
static const double LARGEST_POISSON = 0.9;

typedef struct material_range {
    const char *name, *unit;
    double value, low, high;
} material_range;

static tulle_status check_ranges(const material_range *ranges, size_t count, const char *owner,
                                 tulle_error *error) {
    for (size_t i = 0; i < count; i++) {
        const material_range *const r = &ranges[i];
        if (r->value >= r->low && r->value <= r->high) continue;
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: %s is %g %s; it must lie between %g and %g", owner, r->name, r->value,
                         r->unit, r->low, r->high);
    }
    return TULLE_OK;
}

#define CHECK_RANGES(ranges, owner, error)                                                         \
    check_ranges((ranges), sizeof(ranges) / sizeof *(ranges), (owner), (error))

static tulle_status check_curve(const tulle_curve *curve, const char *what, const char *owner,
                                tulle_error *error) {
    char names[3][40];
    static const char *const values[3] = {"stiffness", "knee (0: none)", "limit"};
    for (int k = 0; k < 3; k++) snprintf(names[k], sizeof names[k], "%s %s", what, values[k]);
    material_range const ranges[] = {
        {names[0], "N/m", curve->stiffness, SMALLEST_POSITIVE, LARGEST_STIFFNESS},
        {names[1], "", curve->knee, curve->knee == 0.0 ? 0.0 : LEAST_STRAIN, LARGEST},
        {names[2], "", curve->limit, LEAST_STRAIN, LARGEST},
    };
    return CHECK_RANGES(ranges, owner, error);
}

/* Without it a state could have less energy than cloth at rest. */
static tulle_status check_shear(const tulle_material *m, const char *owner, tulle_error *error) {
    double const most = sqrt(m->warp.stiffness * m->weft.stiffness);
    if (m->shear.stiffness <= most) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "%s: shear stiffness is %g N/m; it must be at most %g, the geometric mean of "
                     "the stiffness of warp and weft",
                     owner, m->shear.stiffness, most);
}

static tulle_status check_woven(const tulle_material *m, const char *owner, tulle_error *error) {
    material_range const ranges[] = {
        {"Poisson's ratio", "", m->poisson, -LARGEST_POISSON, LARGEST_POISSON},
        {"bending rigidity of the warp", "N m", m->bend_warp, 0.0, LARGEST_RIGIDITY},
        {"bending rigidity of the weft", "N m", m->bend_weft, 0.0, LARGEST_RIGIDITY},
        {"twisting rigidity", "N m", m->bend_twist, 0.0, LARGEST_RIGIDITY},
        {"bending hysteresis of the warp (at most 1e6 1/m of its rigidity)", "N",
         m->bend_hysteresis_warp, 0.0, LARGEST_BEND_WIDTH * m->bend_warp},
        {"bending hysteresis of the weft (at most 1e6 1/m of its rigidity)", "N",
         m->bend_hysteresis_weft, 0.0, LARGEST_BEND_WIDTH * m->bend_weft},
        {"shear hysteresis (at most twice the stiffness)", "N/m", m->shear_hysteresis, 0.0,
         LARGEST_SHEAR_WIDTH * m->shear.stiffness},
    };
    tulle_status status = CHECK_RANGES(ranges, owner, error);
    if (status == TULLE_OK) status = check_curve(&m->warp, "warp", owner, error);
    if (status == TULLE_OK) status = check_curve(&m->weft, "weft", owner, error);
    if (status == TULLE_OK) status = check_curve(&m->shear, "shear", owner, error);
    return status == TULLE_OK ? check_shear(m, owner, error) : status;
}

static tulle_status check_springs(const tulle_springs *springs, const char *owner,
                                  tulle_error *error) {
    material_range const ranges[] = {
        {"stretch stiffness", "N/m", springs->stretch_stiffness, SMALLEST_POSITIVE,
         LARGEST_STIFFNESS},
        {"bend stiffness", "N m", springs->bend_stiffness, 0.0, LARGEST_RIGIDITY},
        {"stiffening strain (0: never)", "", springs->stiffening_strain,
         springs->stiffening_strain == 0.0 ? 0.0 : LEAST_STRAIN, LARGEST},
    };
    return CHECK_RANGES(ranges, owner, error);
}

tulle_status material_validate(const tulle_material *m, tulle_membrane membrane, const char *owner,
                               tulle_error *error) {
    material_range const ranges[] = {
        {"area density", "kg/m^2", m->area_density, SMALLEST_POSITIVE, LARGEST},
        {"stretch damping", "s", m->stretch_damping, 0.0, LARGEST},
        {"bend damping", "s", m->bend_damping, 0.0, LARGEST},
        {"air damping", "1/s", m->air_damping, 0.0, LARGEST},
        {"friction", "", m->friction, 0.0, 10.0},
        {"restitution", "", m->restitution, 0.0, 1.0},
        {"friction across", "", m->friction_across, 0.0, 10.0},
    };
    tulle_status const status = CHECK_RANGES(ranges, owner, error);
    if (status != TULLE_OK) return status;
    return membrane == TULLE_MEMBRANE_WOVEN ? check_woven(m, owner, error)
                                            : check_springs(&m->springs, owner, error);
}
