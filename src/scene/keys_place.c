/* scene/keys_place.c - the table of keys: how cloth and obstacles are set down. */
#include "scene/keys_table.h"

/* In the order of place_up. */
static const char *const up_names[] = {"z", "y", "x", NULL};
static const schema_key place_table[] = {
    KEY(place_keys, up, .type = SCHEMA_CHOICE, .choices = up_names,
        .derived = "z, or as the file says",
        .meaning = "axis of the mesh that points up; it is turned to z, y about x and x about y. "
                   "glTF, Alembic and USD say it; see [Axes and units](formats.md#axes-and-units)"),
    KEY(place_keys, size, POSITIVE_LENGTH(SCHEMA_ALTERNATIVE),
        .meaning = "its largest extent along x, y and z"),
    KEY(place_keys, height, POSITIVE_LENGTH(SCHEMA_ALTERNATIVE), .meaning = "its extent along z"),
    KEY(place_keys, center, .type = SCHEMA_BOOL, .fallback = "false",
        .meaning = "brings the middle of its box to x = y = 0"),
    KEY(place_keys, on, .type = SCHEMA_NUMBER, ANY_SIZE, .unit = UNIT_LENGTH, .word = "ground",
        .flags = SCHEMA_SECOND_ALTERNATIVE,
        .meaning = "brings its lowest point to this height; ground: to z = 0"),
    KEY(place_keys, on_top_of, .type = SCHEMA_NAME, .flags = SCHEMA_SECOND_ALTERNATIVE,
        .meaning = "brings its lowest point to the height of the highest point of an obstacle, "
                   "with all its copies, at the start. An obstacle can only stand on an obstacle "
                   "that comes before it in the file"),
    KEY(place_keys, as, .type = SCHEMA_NAME, .flags = SCHEMA_OPTIONAL, .derived = "by its own box",
        .meaning =
            "moves to the place of an obstacle, without scale, rotate and the other keys of place: "
            "cloth that was modelled on a body stays on it. A copy has a number: post.002"),
};
const schema_map place_map = MAP_OF(
    place_table, place_keys, .title = "Place",
    .meaning = "Sets a mesh down by its box, so that nobody has to know its coordinates. The keys "
               "act in this order: scale, up, rotate, size or height, center, on or on_top_of, "
               "translate. The box is the box of the mesh at the start, after scale, up and "
               "rotate. translate moves the mesh after it was set down, as `[0, 0, 5 mm]` for a "
               "gap. Size and height scale evenly. Copies are set down by their layout after that; "
               "every frame of a mesh sequence is placed as the first one, and a rest file as its "
               "cloth. Points of pins and regions are in scene coordinates, after all this.");
