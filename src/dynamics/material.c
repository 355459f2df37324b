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

/* kg/m^2, N/m, N m, s, s, 1/s, friction, dynamic friction (-1: the same), restitution, friction
 * across, stiffening strain */
static const preset PRESETS[] = {
    {"cotton", FABRIC_SOURCE, {0.150, 300.0, 1.0e-5, 5e-4, 2e-3, 0.05, 0.40, -1.0, 0.0, 1.0, 0.1}},
    {"silk", FABRIC_SOURCE, {0.070, 150.0, 4.0e-6, 5e-4, 2e-3, 0.10, 0.25, -1.0, 0.0, 1.0, 0.1}},
    {"wool", FABRIC_SOURCE, {0.220, 250.0, 1.5e-5, 1e-3, 4e-3, 0.05, 0.45, -1.0, 0.0, 1.0, 0.1}},
    {"denim", FABRIC_SOURCE, {0.400, 900.0, 1.0e-4, 5e-4, 2e-3, 0.02, 0.50, -1.0, 0.0, 1.0, 0.1}},
    {"net", NET_SOURCE, {0.035, 100.0, 2.5e-6, 5e-4, 2e-3, 0.10, 0.30, -1.0, 0.0, 1.0, 0.1}},
    {"rubber-sheet",
     RUBBER_SOURCE,
     {0.950, 1500.0, 1.7e-4, 2e-3, 5e-3, 0.02, 0.80, -1.0, 0.0, 1.0, 0.0}},
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

tulle_status material_validate(const tulle_material *material, tulle_error *error) {
    /* Upper ends are far beyond any cloth; they keep products finite. */
    const struct {
        const char *name, *unit;
        double value, least, most;
        bool is_above_least;
    } ranges[] = {
        {"area_density", "kg/m^2", material->area_density, 0.0, 1e6, true},
        {"stretch_stiffness", "N/m", material->stretch_stiffness, 0.0, 1e12, true},
        {"bend_stiffness", "N m", material->bend_stiffness, 0.0, 1e12, false},
        {"stretch_damping", "s", material->stretch_damping, 0.0, 1e3, false},
        {"bend_damping", "s", material->bend_damping, 0.0, 1e3, false},
        {"air_damping", "1/s", material->air_damping, 0.0, 1e6, false},
        {"friction", "-", material->friction, 0.0, 10.0, false},
        {"dynamic_friction", "-", material->dynamic_friction, -10.0, 10.0, false},
        {"restitution", "-", material->restitution, 0.0, 1.0, false},
        {"friction_across", "-", material->friction_across, 0.0, 10.0, false},
        {"stiffening_strain", "-", material->stiffening_strain, 0.0, 1e6, false},
    };
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
        double const value = ranges[i].value, least = ranges[i].least;
        if ((ranges[i].is_above_least ? value > least : value >= least) && value <= ranges[i].most)
            continue;
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "material %s is %g %s; it must be %s %g and at most %g", ranges[i].name,
                         value, ranges[i].unit, ranges[i].is_above_least ? "above" : "at least",
                         least, ranges[i].most);
    }
    return TULLE_OK;
}
