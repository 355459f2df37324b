/* scene/keys_table.h - shorthand for the entries of the table of keys. */
#ifndef TULLE_SCENE_KEYS_TABLE_H
#define TULLE_SCENE_KEYS_TABLE_H

#include "scene/keys.h"

#include <math.h>

#define FIELD(type, field) .offset = offsetof(type, field)
#define MAP_OF(table, type)                                                                        \
    .keys = table, .key_count = sizeof table / sizeof table[0], .size = sizeof(type)
/* [m] Far beyond, doubles are too coarse for cloth. */
#define ANY_SIZE .minimum = -1e6, .maximum = 1e6
#define POINT                                                                                      \
    .type = SCHEMA_VECTOR, .unit = UNIT_LENGTH, .least_count = 3, .most_count = 3, ANY_SIZE
#define POSITIVE_LENGTH(more_flags)                                                                \
    .type = SCHEMA_NUMBER, .unit = UNIT_LENGTH, .minimum = 0, .maximum = 1e6,                      \
    .flags = SCHEMA_ABOVE_MINIMUM | (more_flags)
#define ANY_TIME .type = SCHEMA_NUMBER, .unit = UNIT_TIME, .minimum = -1e6, .maximum = 1e6
#define COUNT_OF_COPIES                                                                            \
    .type = SCHEMA_INTEGER, .minimum = 1, .maximum = 4096, .flags = SCHEMA_REQUIRED
/* Up to 2^53: exact as a double, too. */
#define ANY_SEED .type = SCHEMA_INTEGER, .minimum = 0, .maximum = 9007199254740992.0
#define AUTO_SEED ANY_SEED, .fallback = "auto", .word = "auto", .word_value = (double)SEED_AUTO

/* Coulomb coefficients, and the coefficient of restitution. */
#define FRICTION_VALUE .type = SCHEMA_NUMBER, .minimum = 0, .maximum = 10
#define SAME_FRICTION FRICTION_VALUE, .word = "same", .word_value = -1
#define DYNAMIC_FRICTION(owner, text)                                                              \
    {                                                                                              \
        .name = "dynamic_friction", SAME_FRICTION, .fallback = "same",                             \
        FIELD(owner, dynamic_friction), .meaning = text                                            \
    }
#define RESTITUTION_VALUE .type = SCHEMA_NUMBER, .minimum = 0, .maximum = 1
#define RESTITUTION(owner, text)                                                                   \
    {                                                                                              \
        .name = "restitution", RESTITUTION_VALUE, .fallback = "0", FIELD(owner, restitution),      \
        .meaning = text                                                                            \
    }

/* The keys of which one chooses vertices of a cloth; the texts are ends of sentences: what lies
 * somewhere, what belongs to some part, what has numbers. */
#define CHOICE_MAP(owner, key, map_name, text)                                                     \
    {                                                                                              \
        .name = #key, .type = SCHEMA_MAP, .map = &map_name,                                        \
        .flags = SCHEMA_ALTERNATIVE | SCHEMA_OPTIONAL, FIELD(owner, where.key), .meaning = text    \
    }
#define CHOICE_PART(owner, key, text)                                                              \
    {                                                                                              \
        .name = #key, .type = SCHEMA_TEXT, .flags = SCHEMA_ALTERNATIVE, FIELD(owner, where.key),   \
        .meaning = text                                                                            \
    }
#define VERTEX_CHOICE(owner, lying, belonging, numbered)                                           \
    CHOICE_MAP(owner, box, box_map, lying "in a box"),                                             \
        CHOICE_MAP(owner, line, line_map, lying "along a segment"),                                \
        CHOICE_MAP(owner, sphere, sphere_map, lying "in a sphere"),                                \
        CHOICE_MAP(owner, near, near_map, lying "near an obstacle"),                               \
        CHOICE_PART(owner, group, belonging "of a group or an object (g, o) of the OBJ file"),     \
        CHOICE_PART(owner, material, belonging "of a material (usemtl) of the OBJ file"), {        \
        .name = "vertices", .type = SCHEMA_INDICES, .flags = SCHEMA_ALTERNATIVE,                   \
        FIELD(owner, where.vertices), .meaning = numbered ", as in [0, 12, 40-49]"                 \
    }

/* sRGB, as color pickers give it. */
#define COLOR                                                                                      \
    .type = SCHEMA_VECTOR, .least_count = 3, .most_count = 3, .minimum = 0, .maximum = 1,          \
    .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE

#define SCALE(owner)                                                                               \
    {                                                                                              \
        .name = "scale", .type = SCHEMA_VECTOR, .derived = "1, or the unit of the file",           \
        .least_count = 3, .most_count = 3, .minimum = -1e6, .maximum = 1e6,                        \
        .flags = SCHEMA_UNIFORM | SCHEMA_NOT_ZERO, FIELD(owner, scale),                            \
        .meaning =                                                                                 \
            "factor along x, y, z, or one for all; applied first. A negative factor mirrors: "     \
            "fronts stay fronts, and outer sides stay outer sides"                                 \
    }
#define ROTATE(owner)                                                                              \
    {                                                                                              \
        .name = "rotate", .type = SCHEMA_ROTATION, .unit = UNIT_ANGLE, .fallback = "[0, 0, 0]",    \
        FIELD(owner, rotate),                                                                      \
        .meaning =                                                                                 \
            "turn about the origin: angles about fixed x, then y, then z, or {axis, angle}; "      \
            "applied second"                                                                       \
    }
#define PLACE(owner)                                                                               \
    {                                                                                              \
        .name = "place", .type = SCHEMA_MAP, .map = &place_map, .flags = SCHEMA_OPTIONAL,          \
        FIELD(owner, place), .derived = "where its coordinates say",                               \
        .meaning = "turns it upright, gives it a size and sets it down"                            \
    }
#define TRANSLATE(owner)                                                                           \
    {                                                                                              \
        .name = "translate", POINT, .fallback = "[0, 0, 0]", FIELD(owner, translate),              \
        .meaning = "displacement; applied last"                                                    \
    }

#endif
