/* scene/keys_choice.c - the table of keys: the shapes that choose vertices of a cloth. */
#include "scene/keys_table.h"

static const schema_key box_table[] = {
    {.name = "min",
     POINT,
     .flags = SCHEMA_REQUIRED,
     FIELD(box_keys, min),
     .meaning = "lowest corner"},
    {.name = "max",
     POINT,
     .flags = SCHEMA_REQUIRED,
     FIELD(box_keys, max),
     .meaning = "highest corner"},
};
const schema_map box_map = {.title = "Box",
                            .meaning = "All vertices in a box, its faces included.",
                            MAP_OF(box_table, box_keys)};

static const schema_key line_table[] = {
    {.name = "from", POINT, .flags = SCHEMA_REQUIRED, FIELD(line_keys, from), .meaning = "one end"},
    {.name = "to", POINT, .flags = SCHEMA_REQUIRED, FIELD(line_keys, to), .meaning = "other end"},
    {.name = "radius",
     POSITIVE_LENGTH(0),
     .fallback = "1 mm",
     FIELD(line_keys, radius),
     .meaning = "distance from the segment within which vertices are meant"},
};
const schema_map line_map = {
    .title = "Line", .meaning = "All vertices near a segment.", MAP_OF(line_table, line_keys)};

static const schema_key sphere_table[] = {
    {.name = "center",
     POINT,
     .flags = SCHEMA_REQUIRED,
     FIELD(sphere_keys, center),
     .meaning = "its middle"},
    {.name = "radius",
     POSITIVE_LENGTH(SCHEMA_REQUIRED),
     FIELD(sphere_keys, radius),
     .meaning = "its radius"},
};
const schema_map sphere_map = {.title = "Sphere",
                               .meaning = "All vertices in a sphere, its surface included.",
                               MAP_OF(sphere_table, sphere_keys)};

static const schema_key near_table[] = {
    {.name = "to",
     .type = SCHEMA_NAME,
     .flags = SCHEMA_REQUIRED,
     FIELD(near_keys, to),
     .meaning = "name of an obstacle or rigid body, which stands for all its copies. A single copy "
                "has a number: post.002"},
    {.name = "within",
     POSITIVE_LENGTH(SCHEMA_REQUIRED),
     FIELD(near_keys, within),
     .meaning = "distance from its triangles within which vertices are meant"},
};
const schema_map near_map = {
    .title = "Near",
    .meaning = "All vertices near the surface of an obstacle, as both start. An obstacle that "
               "appears later counts as it is then placed.",
    MAP_OF(near_table, near_keys)};
