/* scene/keys_table.h - shorthand for the entries of the table of keys. */
#ifndef TULLE_SCENE_KEYS_TABLE_H
#define TULLE_SCENE_KEYS_TABLE_H

#include "scene/keys.h"

#include <math.h>

#define FIELD(type, field) .offset = offsetof(type, field)
/* An entry: the struct, its member (after which the key is called), then type, range and texts. */
#define KEY_NAMED(key, owner, field, ...)                                                          \
    { .name = key, FIELD(owner, field), __VA_ARGS__ }
#define KEY(owner, field, ...) KEY_NAMED(#field, owner, field, __VA_ARGS__)
#define RANGE(least, most) .minimum = least, .maximum = most
#define NUMBER(least, most) .type = SCHEMA_NUMBER, RANGE(least, most)
#define INTEGER(least, most) .type = SCHEMA_INTEGER, RANGE(least, most)
#define QUANTITY(dimension, least, most) NUMBER(least, most), .unit = dimension
#define MAP(of) .type = SCHEMA_MAP, .map = &of
#define LIST(of, least, most) .type = SCHEMA_LIST, .map = &of, RANGE(least, most)
#define CHOICE(names, default) .type = SCHEMA_CHOICE, .choices = names, .fallback = default
/* By default a word in place of a number. */
#define OR_WORD(text, value) .fallback = text, .word = text, .word_value = value
#define MAP_OF(table, type, ...)                                                                   \
    {                                                                                              \
        .keys = table, .key_count = sizeof table / sizeof table[0], .size = sizeof(type),          \
        __VA_ARGS__                                                                                \
    }
/* [m] Far beyond, doubles are too coarse for cloth. */
#define ANY_SIZE RANGE(-1e6, 1e6)
#define POINT                                                                                      \
    .type = SCHEMA_VECTOR, .unit = UNIT_LENGTH, .least_count = 3, .most_count = 3, ANY_SIZE
#define POSITIVE_LENGTH(more_flags)                                                                \
    QUANTITY(UNIT_LENGTH, 0, 1e6), .flags = SCHEMA_ABOVE_MINIMUM | (more_flags)
#define ANY_TIME QUANTITY(UNIT_TIME, -1e6, 1e6)
#define COUNT_OF_COPIES INTEGER(1, 4096), .flags = SCHEMA_REQUIRED
/* Up to 2^53: exact as a double, too. */
#define ANY_SEED INTEGER(0, 9007199254740992.0)
#define AUTO_SEED ANY_SEED, OR_WORD("auto", (double)SEED_AUTO)

/* Coulomb coefficients, and the coefficient of restitution. */
#define FRICTION_VALUE NUMBER(0, 10)
#define SAME_FRICTION FRICTION_VALUE, .word = "same", .word_value = -1
#define DYNAMIC_FRICTION(owner, text)                                                              \
    KEY(owner, dynamic_friction, SAME_FRICTION, .fallback = "same", .meaning = text)
#define RESTITUTION_VALUE NUMBER(0, 1)
#define RESTITUTION(owner, text)                                                                   \
    KEY(owner, restitution, RESTITUTION_VALUE, .fallback = "0", .meaning = text)

/* The keys of which one chooses vertices of a cloth; the texts are ends of sentences: what lies
 * somewhere, what belongs to some part, what has numbers. */
#define CHOICE_MAP(owner, key, of, text)                                                           \
    KEY_NAMED(#key, owner, where.key, MAP(of), .flags = SCHEMA_ALTERNATIVE | SCHEMA_OPTIONAL,      \
              .meaning = text)
#define CHOICE_PART(owner, key, kind, text)                                                        \
    KEY_NAMED(#key, owner, where.key, .type = kind, .flags = SCHEMA_ALTERNATIVE, .meaning = text)
#define VERTEX_CHOICE(owner, lying, belonging, numbered)                                           \
    CHOICE_MAP(owner, box, box_map, lying "in a box"),                                             \
        CHOICE_MAP(owner, line, line_map, lying "along a segment"),                                \
        CHOICE_MAP(owner, sphere, sphere_map, lying "in a sphere"),                                \
        CHOICE_MAP(owner, near, near_map, lying "near an obstacle"),                               \
        CHOICE_PART(owner, group, SCHEMA_TEXT,                                                     \
                    belonging "of a group or an object (g, o) of the OBJ file"),                   \
        CHOICE_PART(owner, material, SCHEMA_TEXT,                                                  \
                    belonging "of a material (usemtl) of the OBJ file"),                           \
        CHOICE_PART(owner, vertices, SCHEMA_INDICES, numbered ", as in [0, 12, 40-49]")

/* sRGB, as color pickers give it. */
#define COLOR                                                                                      \
    .type = SCHEMA_VECTOR, .least_count = 3, .most_count = 3, RANGE(0, 1),                         \
    .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE

#define SCALE(owner)                                                                               \
    KEY(owner, scale, .type = SCHEMA_VECTOR, .derived = "1, or the unit of the file",              \
        .least_count = 3, .most_count = 3, ANY_SIZE, .flags = SCHEMA_UNIFORM | SCHEMA_NOT_ZERO,    \
        .meaning = "factor along x, y, z, or one for all; applied first. A negative factor "       \
                   "mirrors: fronts stay fronts, and outer sides stay outer sides")
#define ROTATE(owner)                                                                              \
    KEY(owner, rotate, .type = SCHEMA_ROTATION, .unit = UNIT_ANGLE, .fallback = "[0, 0, 0]",       \
        .meaning = "turn about the origin: angles about fixed x, then y, then z, or {axis, "       \
                   "angle}; applied second")
#define PLACE(owner)                                                                               \
    KEY(owner, place, MAP(place_map), .flags = SCHEMA_OPTIONAL,                                    \
        .derived = "where its coordinates say",                                                    \
        .meaning = "turns it upright, gives it a size and sets it down")
#define TRANSLATE(owner)                                                                           \
    KEY(owner, translate, POINT, .fallback = "[0, 0, 0]", .meaning = "displacement; applied last")

#endif
