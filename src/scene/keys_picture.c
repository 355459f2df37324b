/* scene/keys_picture.c - the table of keys: what only pictures depend on. */
#include "scene/keys_table.h"

static const schema_key camera_table[] = {
    KEY(camera_keys, position, POINT, .flags = SCHEMA_ALTERNATIVE | SCHEMA_PICTURE,
        .meaning = "where the camera stands"),
    KEY(camera_keys, orbit, .type = SCHEMA_VECTOR, .unit = UNIT_ANGLE, .least_count = 2,
        .most_count = 2, .minimum = -1000, .maximum = 1000,
        .flags = SCHEMA_ALTERNATIVE | SCHEMA_PICTURE,
        .meaning = "direction from the target to the camera: azimuth from x towards y, and "
                   "elevation above the ground, -89 to 89 degrees"),
    KEY(camera_keys, target, POINT, .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE,
        .derived = "middle of the cloths and what they touch", .meaning = "what it looks at"),
    KEY(camera_keys, distance, POSITIVE_LENGTH(SCHEMA_OPTIONAL | SCHEMA_PICTURE),
        .derived = "all in view", .meaning = "distance of an orbit from the target"),
    KEY(camera_keys, field_of_view, QUANTITY(UNIT_ANGLE, 0.01, 3),
        .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE, .derived = "by the program",
        .meaning = "angle that the picture's height spans"),
    KEY(camera_keys, turn, QUANTITY(UNIT_ANGLE, -1000, 1000),
        .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE, .derived = "0",
        .meaning = "angle by which the camera goes around the target in the course of a film"),
};
const schema_map camera_map = MAP_OF(
    camera_table, camera_keys, .title = "Camera",
    .meaning =
        "Where `tulle render` looks from. Its option --camera takes precedence over these keys.");

/* In the order of scene_floor. */
static const char *const floor_names[] = {"auto", "on", "off", NULL};
static const schema_key picture_table[] = {
    KEY(picture_keys, camera, MAP(camera_map), .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE,
        .derived = "all in view", .meaning = "where the picture is taken from"),
    KEY(picture_keys, floor, CHOICE(floor_names, "auto"), .flags = SCHEMA_PICTURE,
        .meaning =
            "an endless floor. auto: extends a flat ground of the scene, or lays a floor below "
            "everything if there is none; on: lays a floor below everything; off: none"),
    KEY(picture_keys, exposure, NUMBER(0.01, 100), .fallback = "1", .flags = SCHEMA_PICTURE,
        .meaning = "factor on the brightness"),
};
const schema_map picture_map =
    MAP_OF(picture_table, picture_keys, .title = "Picture",
           .meaning = "What `tulle render` shows, and how. A run does not depend on these keys: "
                      "they may change before it is resumed.");
