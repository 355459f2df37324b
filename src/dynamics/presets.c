/* dynamics/presets.c - the fabrics that have a name: values, thickness, where they come from.
 * docs/guide/materials.md explains the numbers.
 *
 * A value counts as measured where it was read in the work that measured it, in a standard or in
 * the maker's data sheet. What others quote and what is usual for such cloth are estimates. Rules
 * for estimates of what no source gives:
 *   - width of the loop of bending over rigidity: 90 1/m for cotton (the median of six denims is
 *     88), 45 1/m for the smoother yarns of wool and filaments (as quoted: 49 and 37);
 *   - width of the loop of shear over stiffness: 0.04 (the median of six denims), wool 0.03;
 *   - springs: 3/8 of their stretch stiffness, their shear modulus, is the fabric's stiffness of
 *     shear, and their rigidity the mean of warp and weft;
 *   - friction is typical of such cloth on a smooth hard surface, damping is chosen.
 * The six first presets are older; their springs are softer or stiffer than by that rule. */
#include "tulle/world.h"

#include <string.h>

typedef struct preset {
    const char *name, *source;
    double thickness;  /* [m] */
    unsigned measured; /* set of tulle_measured */
    tulle_material material;
} preset;

#define KUMARI                                                                                     \
    " of Kumari and Khurana, Regenerated Cellulose-Based Denim Fabric for Tropical Regions, "      \
    "Journal of Textiles 2016, 4614168, table 5, one value for warp and weft; limit, weight and "  \
    "friction are estimates"
#define USUAL "estimates: usual values of such a cloth; springs chosen for drape"
#define FENG "Feng, Huang, Xu and Wang, ACM Transactions on Graphics 41(6), 2022"
#define LI                                                                                         \
    "Li, Kaufman and Jiang, Codimensional Incremental Potential Contact, 2021, whose code does "   \
    "not say who measured it"
#define PENAVA "Penava et al. 2014, as quoted by others"
#define MATSUDAIRA "Matsudaira, Masuda, Wada and Yokura 2015, as quoted by others"

#define M(what) TULLE_MEASURED_##what
#define BEND(warp, weft)                                                                           \
    .bend_warp = (warp), .bend_weft = (weft), .bend_twist = 0.25 * ((warp) + (weft))
/* Stretch, bending, stiffening strain. */
#define SPRINGS(stretch, bend, strain) .springs = {(stretch), (bend), (strain)}
/* Shear, bending and the springs that go with them. */
#define YARNS(stiffness, warp, weft)                                                               \
    .shear = {(stiffness), 0.2, 0.6}, BEND(warp, weft),                                            \
    SPRINGS((stiffness)*8.0 / 3.0, 0.5 * ((warp) + (weft)), 0.1)
#define SHEET(stiffness, limit_, rigidity)                                                         \
    .shear = {(stiffness), 0.0, (limit_)}, BEND(rigidity, rigidity),                               \
    SPRINGS((stiffness)*8.0 / 3.0, rigidity, 0.0)
/* Width of the loops of bending along warp and weft, and of shear. */
#define LOOPS(warp, weft, shear_)                                                                  \
    .bend_hysteresis_warp = (warp), .bend_hysteresis_weft = (weft), .shear_hysteresis = (shear_)
/* Stretch, bending, air. */
#define DAMPING(stretch, bend, air)                                                                \
    .stretch_damping = (stretch), .bend_damping = (bend), .air_damping = (air)
#define FRICTION(value) .friction = (value), .dynamic_friction = -1.0, .friction_across = 1.0

#define FABRIC(name, thickness, measured, source, ...)                                             \
    {                                                                                              \
        name, source, thickness, measured, { __VA_ARGS__ }                                         \
    }

static const preset PRESETS[] = {
    FABRIC("cotton", 0.32e-3, 0, USUAL "; warp and weft after " LI, .area_density = 0.150,
           .poisson = 0.1, .warp = {4500.0, 0.05, 0.14}, .weft = {2800.0, 0.05, 0.14},
           .shear = {50.0, 0.2, 0.6}, BEND(1.0e-5, 1.0e-5), SPRINGS(300.0, 1.0e-5, 0.1),
           DAMPING(5e-4, 2e-3, 0.05), FRICTION(0.40)),
    FABRIC("silk", 0.16e-3, 0, USUAL "; bending chosen so that it drapes as silk is said to",
           .area_density = 0.070, .poisson = 0.1, .warp = {3000.0, 0.05, 0.15},
           .weft = {2000.0, 0.05, 0.15}, .shear = {25.0, 0.2, 0.6}, BEND(1.2e-6, 1.2e-6),
           SPRINGS(150.0, 4.0e-6, 0.1), DAMPING(5e-4, 2e-3, 0.10), FRICTION(0.25)),
    FABRIC("wool", 0.55e-3, 0, USUAL "; thickness after " PENAVA, .area_density = 0.220,
           .poisson = 0.1, .warp = {3000.0, 0.05, 0.2}, .weft = {2000.0, 0.05, 0.2},
           .shear = {40.0, 0.2, 0.6}, BEND(1.2e-5, 1.2e-5), SPRINGS(250.0, 1.5e-5, 0.1),
           DAMPING(1e-3, 4e-3, 0.05), FRICTION(0.45)),
    FABRIC("denim", 0.66e-3, 0, USUAL "; weight, thickness, warp and weft after " LI,
           .area_density = 0.400, .poisson = 0.1, .warp = {6000.0, 0.05, 0.14},
           .weft = {3200.0, 0.05, 0.14}, .shear = {150.0, 0.2, 0.6}, BEND(1.0e-4, 1.0e-4),
           SPRINGS(900.0, 1.0e-4, 0.1), DAMPING(5e-4, 2e-3, 0.02), FRICTION(0.50)),
    FABRIC("net", 0.25e-3, 0,
           "estimates: weight of polyester tulle and mosquito netting, 20 to 50 g/m^2; stretch and "
           "bending between cotton and silk of that weight",
           .area_density = 0.035, .poisson = 0.3, .warp = {500.0, 0.1, 0.5},
           .weft = {500.0, 0.1, 0.5}, .shear = {10.0, 0.3, 1.0}, BEND(2.5e-6, 2.5e-6),
           SPRINGS(100.0, 2.5e-6, 0.1), DAMPING(5e-4, 2e-3, 0.10), FRICTION(0.30)),
    FABRIC("rubber-sheet", 1.0e-3, 0,
           "estimates: 1 mm of natural rubber, computed from 950 kg/m^3, Young's modulus 1.5 MPa "
           "and Poisson's ratio 0.5",
           .area_density = 0.950, .poisson = 0.5, .warp = {2000.0, 0.0, 3.0},
           .weft = {2000.0, 0.0, 3.0}, .shear = {500.0, 0.0, 3.0}, BEND(1.7e-4, 1.7e-4),
           SPRINGS(1500.0, 1.7e-4, 0.0), DAMPING(2e-3, 5e-3, 0.02), FRICTION(0.80)),
    FABRIC("denim-soft", 1.01e-3, M(THICKNESS) | M(TENSION) | M(SHEAR) | M(BENDING) | M(HYSTERESIS),
           "tension, shear, bending, hysteresis and thickness: medians of the six denims" KUMARI,
           .area_density = 0.36, .poisson = 0.1, .warp = {3593.0, 0.0422, 0.09},
           .weft = {3593.0, 0.0422, 0.09}, YARNS(88.5, 1.57e-5, 1.57e-5),
           LOOPS(1.39e-3, 1.39e-3, 3.51), DAMPING(5e-4, 2e-3, 0.02), FRICTION(0.35)),
    FABRIC("denim-firm", 0.80e-3, M(THICKNESS) | M(TENSION) | M(SHEAR) | M(BENDING) | M(HYSTERESIS),
           "tension, shear, bending, hysteresis and thickness: fabric C" KUMARI,
           .area_density = 0.36, .poisson = 0.1, .warp = {5848.0, 0.0530, 0.08},
           .weft = {5848.0, 0.0530, 0.08}, YARNS(191.0, 2.23e-5, 2.23e-5),
           LOOPS(1.03e-3, 1.03e-3, 4.88), DAMPING(5e-4, 2e-3, 0.02), FRICTION(0.35)),
    FABRIC("cotton-broadcloth", 0.50e-3, 0,
           "estimates: bending and its hysteresis after the cotton broad of " MATSUDAIRA
           "; the rest usual for such a cloth",
           .area_density = 0.12, .poisson = 0.1, .warp = {12000.0, 0.020, 0.06},
           .weft = {9400.0, 0.026, 0.06}, YARNS(70.0, 1.16e-5, 1.16e-5),
           LOOPS(1.22e-3, 1.22e-3, 2.8), DAMPING(5e-4, 2e-3, 0.05), FRICTION(0.35)),
    FABRIC("canvas", 0.53e-3, 0,
           "estimates: weight, thickness, warp, weft and limits after the canvas of " LI
           "; bending the median of fabrics of that weight of " FENG
           "; the rest usual for such a cloth",
           .area_density = 0.294, .poisson = 0.1, .warp = {10500.0, 0.0, 0.067},
           .weft = {2840.0, 0.0, 0.11}, YARNS(170.0, 3.4e-5, 2.1e-5), LOOPS(3.1e-3, 1.9e-3, 6.8),
           DAMPING(5e-4, 2e-3, 0.02), FRICTION(0.40)),
    FABRIC("chiffon", 0.12e-3, 0,
           "estimates: weight and bending the mean and the medians of the eight lightest of 120 "
           "fabrics of " FENG "; the rest usual for such a cloth",
           .area_density = 0.024, .poisson = 0.1, .warp = {1500.0, 0.04, 0.15},
           .weft = {1000.0, 0.05, 0.15}, YARNS(15.0, 1.2e-6, 0.8e-6), LOOPS(5.4e-5, 3.6e-5, 0.6),
           DAMPING(5e-4, 2e-3, 0.10), FRICTION(0.25)),
    FABRIC("wool-tropical", 0.40e-3, 0,
           "estimates: bending and its hysteresis after the wool tropical of " MATSUDAIRA
           "; the rest usual of suiting",
           .area_density = 0.18, .poisson = 0.1, .warp = {1460.0, 0.019, 0.12},
           .weft = {690.0, 0.040, 0.20}, YARNS(33.0, 6.57e-6, 6.57e-6),
           LOOPS(3.24e-4, 3.24e-4, 1.0), DAMPING(1e-3, 4e-3, 0.05), FRICTION(0.30)),
    FABRIC("wool-coating", 1.28e-3, 0,
           "estimates: weight, thickness, warp, weft and limits after the wool of " LI
           "; bending the median of fabrics of that weight of " FENG
           "; the rest usual for such a cloth",
           .area_density = 0.481, .poisson = 0.1, .warp = {2840.0, 0.0, 0.62},
           .weft = {2930.0, 0.0, 0.50}, YARNS(45.0, 5.0e-5, 2.5e-5), LOOPS(2.3e-3, 1.1e-3, 1.4),
           DAMPING(1e-3, 4e-3, 0.02), FRICTION(0.40)),
    FABRIC("wool-stretch", 0.33e-3, 0,
           "estimates: weight and thickness of wool with 5 % of elastane after " PENAVA
           "; the rest usual for such a cloth",
           .area_density = 0.178, .poisson = 0.1, .warp = {1140.0, 0.024, 0.13},
           .weft = {340.0, 0.081, 0.30}, YARNS(28.0, 6.0e-6, 4.0e-6), LOOPS(2.7e-4, 1.8e-4, 0.84),
           DAMPING(1e-3, 4e-3, 0.05), FRICTION(0.30)),
    FABRIC("polyester-plain", 0.25e-3, 0,
           "estimates: weight and thickness after " PENAVA
           "; bending about the median of fabrics of that weight of " FENG
           "; the rest usual for such a cloth",
           .area_density = 0.165, .poisson = 0.1, .warp = {9800.0, 0.025, 0.065},
           .weft = {7000.0, 0.035, 0.065}, YARNS(50.0, 8.0e-6, 6.0e-6), LOOPS(3.6e-4, 2.7e-4, 2.0),
           DAMPING(5e-4, 2e-3, 0.05), FRICTION(0.25)),
    FABRIC("polyester-faille", 0.22e-3, 0,
           "estimates: bending and its hysteresis after the polyester faille of " MATSUDAIRA
           "; the rest usual for such a cloth",
           .area_density = 0.10, .poisson = 0.1, .warp = {4000.0, 0.04, 0.10},
           .weft = {2500.0, 0.05, 0.10}, YARNS(20.0, 1.86e-6, 1.86e-6),
           LOOPS(6.86e-5, 6.86e-5, 0.8), DAMPING(5e-4, 2e-3, 0.10), FRICTION(0.22)),
    FABRIC("jersey", 0.55e-3, 0,
           "estimates: usual values of knitted cotton, warp for wales and weft for courses; no "
           "measured knit was found",
           .area_density = 0.16, .poisson = 0.3, .warp = {300.0, 0.15, 0.6},
           .weft = {120.0, 0.25, 1.0}, YARNS(25.0, 1.0e-6, 0.7e-6), DAMPING(1e-3, 4e-3, 0.05),
           FRICTION(0.35)),
    FABRIC("felt", 1.59e-3, M(AREA_DENSITY) | M(THICKNESS) | M(FRICTION),
           "weight and thickness: SAE F-1 of 1/16 inch in the specification of American Bacon "
           "Boston Felt, the middle of 0.95 to 1.05 lb/yd^2; friction: Sutherland Felt; the rest "
           "are estimates",
           .area_density = 0.543, .poisson = 0.0, .warp = {30000.0, 0.0, 0.2},
           .weft = {25000.0, 0.0, 0.2}, SHEET(9000.0, 0.6, 2.0e-3), DAMPING(1e-3, 4e-3, 0.02),
           FRICTION(0.37)),
    FABRIC(
        "ripstop-nylon", 0.076e-3, M(AREA_DENSITY),
        "weight: parachute cloth of type I, 1.1 oz/yd^2, in MIL-C-7020H; the rest are estimates, "
        "thickness and the strength behind warp and weft after that standard, as quoted by others",
        .area_density = 0.0373, .poisson = 0.1, .warp = {18000.0, 0.0, 0.25},
        .weft = {18000.0, 0.0, 0.25}, YARNS(110.0, 1.5e-6, 1.5e-6), LOOPS(6.8e-5, 6.8e-5, 4.4),
        DAMPING(5e-4, 2e-3, 0.10), FRICTION(0.25)),
    FABRIC("glass-plain", 0.60e-3, 0,
           "estimates: shear and its hysteresis after the plain glass weave of Cao et al. 2008, as "
           "digitised by others; warp and weft less than a tenth of the values of glass of that "
           "weight, so that it can be solved; the rest usual for such a cloth",
           .area_density = 0.60, .poisson = 0.0, .warp = {6.0e5, 0.0, 0.02},
           .weft = {6.0e5, 0.0, 0.02}, .shear = {20.0, 0.7, 0.75}, BEND(5.0e-4, 5.0e-4),
           SPRINGS(20.0 * 8.0 / 3.0, 5.0e-4, 0.1), LOOPS(0.0, 0.0, 8.0), DAMPING(5e-4, 2e-3, 0.02),
           FRICTION(0.25)),
    FABRIC("coated-polyester", 0.82e-3, M(AREA_DENSITY) | M(THICKNESS) | M(TENSION),
           "weight, thickness and the moduli of warp and weft: coated polyester (Xing Yida) in An "
           "Impact Vibration Experimental Research on the Pretension Rectangular Membrane "
           "Structure, Advances in Materials Science and Engineering 2015, 387153, table 3; the "
           "rest are estimates",
           .area_density = 1.05, .poisson = 0.0, .warp = {1.246e6, 0.0, 0.088},
           .weft = {1.058e6, 0.0, 0.095}, SHEET(4.0e4, 0.6, 3.0e-3), DAMPING(5e-4, 2e-3, 0.02),
           FRICTION(0.40)),
    FABRIC("etfe-foil", 0.25e-3, M(AREA_DENSITY) | M(TENSION) | M(LIMIT),
           "weight, tension and limit: density 1750 kg/m^3, Young's modulus 1.1 GPa and yield at "
           "21 MPa on the maker's page etferoof.com, General properties of ETFE foil, for a "
           "thickness of 0.25 mm; the rest are estimates, shear and bending with a Poisson's ratio "
           "of 0.45, friction the middle of the page's 0.2 to 0.5",
           .area_density = 0.4375, .poisson = 0.45,
           .warp = {3.448e5, 0.0, 0.019}, /* E t / (1 - 0.45^2) */
           .weft = {3.448e5, 0.0, 0.019}, SHEET(9.48e4, 0.6, 1.8e-3), DAMPING(5e-4, 2e-3, 0.02),
           FRICTION(0.35)),
    FABRIC("geotextile", 1.0e-3, M(AREA_DENSITY) | M(TENSION) | M(LIMIT),
           "weight, tension at 2 % and limits: woven polyester in the data sheet of Dodom, 160/56 "
           "kN/m; the rest are estimates",
           .area_density = 0.326, .poisson = 0.0, .warp = {1.785e6, 0.0, 0.109},
           .weft = {7.10e5, 0.0, 0.104}, YARNS(2000.0, 3.0e-4, 2.0e-4), DAMPING(5e-4, 2e-3, 0.02),
           FRICTION(0.40)),
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

double tulle_material_preset_thickness(size_t index) {
    return index < PRESET_COUNT ? PRESETS[index].thickness : 0.0;
}

unsigned tulle_material_preset_measured(size_t index) {
    return index < PRESET_COUNT ? PRESETS[index].measured : 0;
}
