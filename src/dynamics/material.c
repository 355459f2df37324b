/* dynamics/material.c - the ranges of material values. docs/guide/materials.md explains them. */
#include "base/error.h"
#include "dynamics/cloth_model.h"

#include <math.h>
#include <stdio.h>

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
                         "%s: %s is %g%s%s; it must lie between %g and %g", owner, r->name,
                         r->value, r->unit[0] ? " " : "", r->unit, r->low, r->high);
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
    if (m->area_density == 0.0)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "%s: area density is 0 kg/m^2; it must be above that. Begin with a preset "
                         "(tulle_material_preset): what is left at 0 is 0",
                         owner);
    tulle_status const status = CHECK_RANGES(ranges, owner, error);
    if (status != TULLE_OK) return status;
    return membrane == TULLE_MEMBRANE_WOVEN ? check_woven(m, owner, error)
                                            : check_springs(&m->springs, owner, error);
}
