/* scene/keys_material.c - the table of keys: materials. */
#include "scene/keys_table.h"

#define OF_PRESET .derived = "preset"
#define BY_PRESET OF_PRESET, .type = SCHEMA_NUMBER
#define RIGIDITY BY_PRESET, .unit = UNIT_BENDING, .minimum = 0, .maximum = 1e6

#define BEND_HYSTERESIS BY_PRESET, .unit = UNIT_LINE_MOMENT, .minimum = 0, .maximum = 1e3

static const schema_key curve_table[] = {
    KEY(curve_keys, stiffness, BY_PRESET, .unit = UNIT_STIFFNESS, .minimum = 0, .maximum = 1e9,
        .flags = SCHEMA_ABOVE_MINIMUM,
        .meaning = "force per width and strain; of shear: per radian"),
    KEY(curve_keys, knee, BY_PRESET, .minimum = 0, .maximum = 1e6,
        .meaning =
            "strain e_k, at least 0.001, at which the cloth pulls twice as hard as stiffness says; "
            "the factor is 1 + (strain / e_k)^2; 0: never; response paper ignores it"),
    KEY(curve_keys, limit, BY_PRESET, .minimum = 1e-3, .maximum = 1e6,
        .meaning = "strain up to which the fabric holds; from there on the force grows straight"),
};
const schema_map curve_map = MAP_OF(curve_table, curve_keys, .title = "Curve",
                                    .meaning = "How a material pulls where it is strained.");

static const schema_key material_table[] = {
    KEY(material_keys, file, .type = SCHEMA_PATH, .flags = SCHEMA_ALTERNATIVE, .derived = "none",
        .meaning = "a YAML file with these keys, in place of the preset; the other keys replace "
                   "its values"),
    KEY(material_keys, preset, .type = SCHEMA_TEXT, .flags = SCHEMA_ALTERNATIVE,
        .derived = "`cotton`",
        .meaning = "named material, see the table of presets; the other keys replace its values"),
    KEY(material_keys, name, .type = SCHEMA_NAME, .derived = "the preset's",
        .meaning = "its name in contact.materials"),
    KEY(material_keys, source, .type = SCHEMA_TEXT, .fallback = "''",
        .meaning = "where its values come from, for people; nothing depends on it"),
    KEY(material_keys, area_density, BY_PRESET, .unit = UNIT_AREA_DENSITY, .minimum = 0,
        .maximum = 1e4, .flags = SCHEMA_ABOVE_MINIMUM, .meaning = "mass per area"),
    KEY(material_keys, warp, MAP(curve_map),
        .meaning = "along the yarns of the warp, which lie along the cloth's grain"),
    KEY(material_keys, weft, MAP(curve_map), .meaning = "along the yarns of the weft"),
    KEY(material_keys, shear, MAP(curve_map),
        .meaning = "where the yarns turn against each other; its stiffness is at most the "
                   "geometric mean of the yarns'"),
    KEY(material_keys, poisson, BY_PRESET, .minimum = -0.9, .maximum = 0.9,
        .meaning = "how much cloth narrows where it is pulled: the geometric mean of both "
                   "Poisson's ratios"),
    KEY(material_keys, bend_warp, RIGIDITY, .meaning = "bending rigidity along the warp"),
    KEY(material_keys, bend_weft, RIGIDITY, .meaning = "bending rigidity along the weft"),
    KEY(material_keys, bend_twist, RIGIDITY,
        .meaning = "twisting rigidity; half of the others: the same in every direction"),
    KEY(material_keys, bend_hysteresis_warp, BEND_HYSTERESIS,
        .meaning = "width of the loop of moment over curvature along the warp, 2HB of KES; needs "
                   "bend_warp; 0: none; membrane springs has none"),
    KEY(material_keys, bend_hysteresis_weft, BEND_HYSTERESIS, .meaning = "the same along the weft"),
    KEY(material_keys, shear_hysteresis, BY_PRESET, .unit = UNIT_LINE_FORCE, .minimum = 0,
        .maximum = 1e6,
        .meaning = "width of the loop of force over the angle of shear, 2HG of KES; at most twice "
                   "the stiffness of shear; 0: none; membrane springs has none"),
    KEY(material_keys, stretch, BY_PRESET, .unit = UNIT_STIFFNESS, .minimum = 0, .maximum = 1e9,
        .flags = SCHEMA_ABOVE_MINIMUM, .meaning = "stiffness of warp and weft, and of springs"),
    KEY(material_keys, bend, RIGIDITY,
        .meaning = "bending rigidity the same in every direction, as of a plate; and of springs"),
    KEY(material_keys, stiffening_strain, BY_PRESET, .minimum = 0, .maximum = 1e6,
        .meaning = "knee of warp and weft, and of springs"),
    KEY(material_keys, stretch_damping, BY_PRESET, .unit = UNIT_TIME, .minimum = 0, .maximum = 1e3,
        .meaning = "damping of stretch per stiffness"),
    KEY(material_keys, bend_damping, BY_PRESET, .unit = UNIT_TIME, .minimum = 0, .maximum = 1e3,
        .meaning = "damping of bending per stiffness"),
    KEY(material_keys, air_damping, BY_PRESET, .unit = UNIT_RATE, .minimum = 0, .maximum = 1e4,
        .meaning = "viscous damping per mass"),
    KEY(material_keys, friction, OF_PRESET, FRICTION_VALUE,
        .meaning = "Coulomb coefficient against obstacles of a contact that does not slide; the "
                   "geometric mean of both sides counts"),
    KEY(material_keys, dynamic_friction, OF_PRESET, SAME_FRICTION,
        .meaning = "the coefficient of a contact that slides; at most friction"),
    KEY(material_keys, restitution, OF_PRESET, RESTITUTION_VALUE,
        .meaning = "share of an impact's speed at which the cloth rebounds; the geometric mean of "
                   "both sides counts, between cloths too"),
    KEY(material_keys, friction_across, OF_PRESET, FRICTION_VALUE,
        .meaning = "factor on friction at right angles to the cloth's grain, whichever law the "
                   "friction comes from; 1: the same all around; response paper ignores it"),
};
const schema_map material_map =
    MAP_OF(material_table, material_keys, .title = "Material",
           .meaning = "Values of the fabric, not of the mesh: a finer mesh drapes alike.");
