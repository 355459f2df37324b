/* scene/keys_choice.c - the table of keys: the shapes that choose vertices of a cloth. */
#include "scene/keys_table.h"

static const schema_key box_table[] = {
    KEY(box_keys, min, POINT, .flags = SCHEMA_REQUIRED, .meaning = "lowest corner"),
    KEY(box_keys, max, POINT, .flags = SCHEMA_REQUIRED, .meaning = "highest corner"),
};
const schema_map box_map = MAP_OF(box_table, box_keys, .title = "Box",
                                  .meaning = "All vertices in a box, its faces included.");

static const schema_key line_table[] = {
    KEY(line_keys, from, POINT, .flags = SCHEMA_REQUIRED, .meaning = "one end"),
    KEY(line_keys, to, POINT, .flags = SCHEMA_REQUIRED, .meaning = "other end"),
    KEY(line_keys, radius, POSITIVE_LENGTH(0), .fallback = "1 mm",
        .meaning = "distance from the segment within which vertices are meant"),
};
const schema_map line_map =
    MAP_OF(line_table, line_keys, .title = "Line", .meaning = "All vertices near a segment.");

static const schema_key sphere_table[] = {
    KEY(sphere_keys, center, POINT, .flags = SCHEMA_REQUIRED, .meaning = "its middle"),
    KEY(sphere_keys, radius, POSITIVE_LENGTH(SCHEMA_REQUIRED), .meaning = "its radius"),
};
const schema_map sphere_map = MAP_OF(sphere_table, sphere_keys, .title = "Sphere",
                                     .meaning = "All vertices in a sphere, its surface included.");

static const schema_key near_table[] = {
    KEY(near_keys, to, .type = SCHEMA_NAME, .flags = SCHEMA_REQUIRED,
        .meaning = "name of an obstacle or rigid body, which stands for all its copies. A single "
                   "copy has a number: post.002"),
    KEY(near_keys, within, POSITIVE_LENGTH(SCHEMA_REQUIRED),
        .meaning = "distance from its triangles within which vertices are meant"),
};
const schema_map near_map =
    MAP_OF(near_table, near_keys, .title = "Near",
           .meaning = "All vertices near the surface of an obstacle, as both start. An obstacle "
                      "that appears later counts as it is then placed.");
