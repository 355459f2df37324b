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

/* sRGB, as color pickers give it. */
#define COLOR                                                                                      \
    .type = SCHEMA_VECTOR, .least_count = 3, .most_count = 3, .minimum = 0, .maximum = 1,          \
    .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE

#define SCALE(owner)                                                                               \
    {                                                                                              \
        .name = "scale", .type = SCHEMA_VECTOR, .fallback = "1", .least_count = 3,                 \
        .most_count = 3, .minimum = 0, .maximum = 1e6,                                             \
        .flags = SCHEMA_UNIFORM | SCHEMA_ABOVE_MINIMUM, FIELD(owner, scale),                       \
        .meaning = "factor along x, y, z, or one for all; applied first"                           \
    }
#define ROTATE(owner)                                                                              \
    {                                                                                              \
        .name = "rotate", .type = SCHEMA_ROTATION, .unit = UNIT_ANGLE, .fallback = "[0, 0, 0]",    \
        FIELD(owner, rotate),                                                                      \
        .meaning =                                                                                 \
            "turn about the origin: angles about fixed x, then y, then z, or {axis, angle}; "      \
            "applied second"                                                                       \
    }
#define TRANSLATE(owner)                                                                           \
    {                                                                                              \
        .name = "translate", POINT, .fallback = "[0, 0, 0]", FIELD(owner, translate),              \
        .meaning = "displacement; applied last"                                                    \
    }

#endif
