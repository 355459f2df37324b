/* scene/keys_picture.c - the table of keys: what only pictures depend on. */
#include "scene/keys_table.h"

static const schema_key camera_table[] = {
    {.name = "position",
     POINT,
     .flags = SCHEMA_ALTERNATIVE | SCHEMA_PICTURE,
     FIELD(camera_keys, position),
     .meaning = "where the camera stands"},
    {.name = "orbit",
     .type = SCHEMA_VECTOR,
     .unit = UNIT_ANGLE,
     .least_count = 2,
     .most_count = 2,
     .minimum = -1000,
     .maximum = 1000,
     .flags = SCHEMA_ALTERNATIVE | SCHEMA_PICTURE,
     FIELD(camera_keys, orbit),
     .meaning = "direction from the target to the camera: azimuth from x towards y, and elevation "
                "above the ground, -89 to 89 degrees"},
    {.name = "target",
     POINT,
     .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE,
     FIELD(camera_keys, target),
     .derived = "middle of the cloths and what they touch",
     .meaning = "what it looks at"},
    {.name = "distance",
     POSITIVE_LENGTH(SCHEMA_OPTIONAL | SCHEMA_PICTURE),
     FIELD(camera_keys, distance),
     .derived = "all in view",
     .meaning = "distance of an orbit from the target"},
    {.name = "field_of_view",
     .type = SCHEMA_NUMBER,
     .unit = UNIT_ANGLE,
     .minimum = 0.01,
     .maximum = 3,
     .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE,
     FIELD(camera_keys, field_of_view),
     .derived = "by the program",
     .meaning = "angle that the picture's height spans"},
    {.name = "turn",
     .type = SCHEMA_NUMBER,
     .unit = UNIT_ANGLE,
     .minimum = -1000,
     .maximum = 1000,
     .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE,
     FIELD(camera_keys, turn),
     .derived = "0",
     .meaning = "angle by which the camera goes around the target in the course of a film"},
};
const schema_map camera_map = {
    .title = "Camera",
    .meaning =
        "Where `tulle render` looks from. Its option --camera takes precedence over these keys.",
    MAP_OF(camera_table, camera_keys)};

/* In the order of scene_floor. */
static const char *const floor_names[] = {"auto", "on", "off", NULL};
static const schema_key picture_table[] = {
    {.name = "camera",
     .type = SCHEMA_MAP,
     .map = &camera_map,
     .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE,
     FIELD(picture_keys, camera),
     .derived = "all in view",
     .meaning = "where the picture is taken from"},
    {.name = "floor",
     .type = SCHEMA_CHOICE,
     .choices = floor_names,
     .fallback = "auto",
     .flags = SCHEMA_PICTURE,
     FIELD(picture_keys, floor),
     .meaning = "an endless floor. auto: extends a flat ground of the scene, or lays a floor below "
                "everything if there is none; on: lays a floor below everything; off: none"},
    {.name = "exposure",
     .type = SCHEMA_NUMBER,
     .fallback = "1",
     .minimum = 0.01,
     .maximum = 100,
     .flags = SCHEMA_PICTURE,
     FIELD(picture_keys, exposure),
     .meaning = "factor on the brightness"},
};
const schema_map picture_map = {.title = "Picture",
                                .meaning =
                                    "What `tulle render` shows, and how. A run does not depend on "
                                    "these keys: they may change before it is resumed.",
                                MAP_OF(picture_table, picture_keys)};
