/* scene/keys_cloth.c - the table of keys: keyframes, pins and cloth. */
#include "scene/keys_table.h"

static const schema_key keyframe_table[] = {
    KEY(keyframe_keys, time, ANY_TIME, .flags = SCHEMA_REQUIRED,
        .meaning = "time of the keyframe, later than the keyframe before"),
    KEY(keyframe_keys, translate, POINT, .fallback = "[0, 0, 0]",
        .meaning = "displacement from the start position"),
    KEY(keyframe_keys, rotate, .type = SCHEMA_ROTATION, .unit = UNIT_ANGLE, .fallback = "[0, 0, 0]",
        .meaning = "turn from the start position, about the pivot, by any angle: 720 deg is two "
                   "turns. Between keyframes about one axis the angle goes as given, else the turn "
                   "goes the shorter way"),
};
const schema_map keyframe_map =
    MAP_OF(keyframe_table, keyframe_keys, .title = "Keyframe",
           .meaning = "A displacement and a turn at a time. Nothing moves before the first "
                      "keyframe or after the last one.");

static const schema_key pin_table[] = {
    VERTEX_CHOICE(pin_keys, "pins the vertices ", "pins the vertices of the triangles ",
                  "pins these vertices"),
    KEY_NAMED("nearest", pin_keys, where.nearest, POINT, .flags = SCHEMA_ALTERNATIVE,
              .meaning = "pins the vertex nearest to a point"),
    KEY(pin_keys, keyframes, LIST(keyframe_map, 0, 100000), .fallback = "[]",
        .meaning = "moves the pinned vertices; without keyframes they are held"),
    KEY(pin_keys, eased, .type = SCHEMA_BOOL, .fallback = "false", .beside = "keyframes",
        .meaning = "starts and stops gently at each keyframe"),
    KEY(pin_keys, pivot, POINT, .flags = SCHEMA_OPTIONAL,
        .derived = "centre of the pinned vertices", .beside = "keyframes",
        .meaning = "point that keyframes turn about"),
    KEY(pin_keys, release, ANY_TIME, OR_WORD("never", INFINITY),
        .meaning = "time at which the vertices are let go"),
};
const schema_map pin_map = MAP_OF(pin_table, pin_keys, .title = "Pin", .needs_alternative = true,
                                  .meaning = "Vertices of a cloth that do not move freely. Points "
                                             "are in scene coordinates, where the cloth starts.");

static const schema_key attach_table[] = {
    VERTEX_CHOICE(attach_keys, "attaches the vertices ", "attaches the vertices of the triangles ",
                  "attaches these vertices"),
    KEY_NAMED("nearest", attach_keys, where.nearest, POINT, .flags = SCHEMA_ALTERNATIVE,
              .meaning = "attaches the vertex nearest to a point"),
    KEY(attach_keys, to, .type = SCHEMA_NAME, .flags = SCHEMA_REQUIRED,
        .meaning = "name of the obstacle, rigid body or cloth that holds them; it must be there "
                   "from the start on. A single copy has a number: post.002"),
    KEY(attach_keys, within, POSITIVE_LENGTH(0), OR_WORD("anywhere", INFINITY),
        .meaning = "vertices that start farther from it stay free"),
    KEY(attach_keys, stiffness, QUANTITY(UNIT_SPRING, 0, 1e12), OR_WORD("rigid", INFINITY),
        .flags = SCHEMA_ABOVE_MINIMUM, .meaning = "of the spring that holds each vertex"),
    KEY(attach_keys, breaks_at, QUANTITY(UNIT_FORCE, 0, 1e12), OR_WORD("never", INFINITY),
        .flags = SCHEMA_ABOVE_MINIMUM, .meaning = "a vertex that needs more force breaks off"),
    KEY(attach_keys, release, ANY_TIME, OR_WORD("never", INFINITY),
        .meaning = "time at which the vertices are let go"),
};
const schema_map attach_map =
    MAP_OF(attach_table, attach_keys, .title = "Attachment", .needs_alternative = true,
           .meaning = "Vertices of a cloth that are attached to the nearest triangle of an object. "
                      "They follow the triangle wherever it moves and however it deforms. Points "
                      "are in scene coordinates, where the cloth starts.");

static const schema_key crease_table[] = {
    VERTEX_CHOICE(crease_keys, "the edges whose ends lie ",
                  "the edges whose ends both belong to triangles ",
                  "the edges whose ends are among these vertices"),
    KEY(crease_keys, angle, QUANTITY(UNIT_ANGLE, -3, 3), .flags = SCHEMA_REQUIRED,
        .meaning = "by how much both sides are turned from flat at rest; positive: a ridge as seen "
                   "from the front, where triangles go round to the left"),
};
const schema_map crease_map =
    MAP_OF(crease_table, crease_keys, .title = "Crease", .needs_alternative = true,
           .meaning = "Edges that are folded at rest, whatever `folds` says. Points are in scene "
                      "coordinates, where the cloth starts.");

/* In the order of REST_FOLDS_KEEP and so on. */
static const char *const folds_words[] = {"keep", "flat", NULL};
static const schema_key rest_table[] = {
    KEY(rest_keys, file, .type = SCHEMA_PATH, .flags = SCHEMA_ALTERNATIVE,
        .meaning =
            "a mesh file with the same triangles in the same order, placed as the cloth; with "
            "vertices of its own it is a pattern, whose triangles need not fit together"),
    KEY(rest_keys, uv, POSITIVE_LENGTH(SCHEMA_ALTERNATIVE),
        .meaning = "the texture coordinates of the mesh file are a flat pattern; this is the "
                   "length of one unit of them"),
    KEY(rest_keys, shrink, NUMBER(0.5, 2), .fallback = "1",
        .meaning =
            "factor on all lengths at rest: 0.9 for cloth that draws together, as an elastic band"),
    KEY(rest_keys, folds, .type = SCHEMA_CHOICE, .choices = folds_words, .flags = SCHEMA_OPTIONAL,
        .derived = "`flat` with uv, else `keep`",
        .meaning = "keep: folds of the rest file, or of the start, are there at rest; flat: cloth "
                   "wants to lie flat"),
    KEY(rest_keys, creases, LIST(crease_map, 0, 10000), .fallback = "[]",
        .meaning = "edges that are folded at rest; of two of one edge the last counts"),
};
const schema_map rest_map = MAP_OF(rest_table, rest_keys, .title = "Rest",
                                   .meaning = "The shape in which no part of the cloth pulls.");

static const schema_key region_table[] = {
    VERTEX_CHOICE(region_keys, "the triangles whose corners all lie ", "the triangles ",
                  "the triangles whose corners are all among these vertices"),
    KEY(region_keys, shrink, NUMBER(0.5, 2), .fallback = "1",
        .meaning = "factor on the lengths at rest of these triangles, times the factor of the "
                   "whole cloth"),
    KEY(region_keys, stiffness, NUMBER(0.01, 100), .fallback = "1",
        .meaning = "factor on all stiffness of the material in these triangles, in stretch, shear "
                   "and bending, times the factor of the stiffness_file: 20 for a stiff collar"),
    KEY(region_keys, grain, .type = SCHEMA_VECTOR, .flags = SCHEMA_OPTIONAL, .least_count = 3,
        .most_count = 3, .minimum = -1e6, .maximum = 1e6, .derived = "as of the cloth",
        .meaning =
            "direction of the warp in these triangles, in the mesh as it starts, of any length"),
};
const schema_map region_map =
    MAP_OF(region_table, region_keys, .title = "Region", .needs_alternative = true,
           .meaning = "Triangles of a cloth that differ from the rest. Points are in scene "
                      "coordinates, where the cloth starts.");

/* In the order of scene_pattern. */
static const char *const pattern_names[] = {"plain", "weave", "check", NULL};
static const schema_key cloth_table[] = {
    KEY(cloth_keys, name, .type = SCHEMA_NAME, .derived = "cloth0, cloth1, ...",
        .meaning = "name in messages and of files"),
    KEY(cloth_keys, mesh, MAP(mesh_map), .flags = SCHEMA_REQUIRED,
        .meaning = "triangles; they must form a manifold, with or without boundary"),
    SCALE(cloth_keys),
    ROTATE(cloth_keys),
    PLACE(cloth_keys),
    TRANSLATE(cloth_keys),
    KEY(cloth_keys, material, MAP(material_map), .meaning = "what the cloth is made of"),
    KEY(cloth_keys, rest, MAP(rest_map),
        .meaning = "the shape in which no part of the cloth pulls; by default the start"),
    KEY(cloth_keys, grain, .type = SCHEMA_VECTOR, .fallback = "[1, 0, 0]", .least_count = 3,
        .most_count = 3, .minimum = -1e6, .maximum = 1e6,
        .meaning = "direction of the warp in the mesh as it starts, of any length; the material's "
                   "friction_across acts at right angles to it"),
    KEY(cloth_keys, grain_uv, .type = SCHEMA_VECTOR, .flags = SCHEMA_OPTIONAL, .least_count = 2,
        .most_count = 2, .minimum = -1e6, .maximum = 1e6, .derived = "grain",
        .meaning = "direction of the warp in the plane of the mesh file's texture coordinates, as "
                   "patterns of garments lie there; friction_across still follows grain"),
    KEY(cloth_keys, stiffness_file, .type = SCHEMA_PATH, .flags = SCHEMA_OPTIONAL,
        .derived = "1 everywhere",
        .meaning = "text file with a factor on all stiffness of the material for each vertex, 0.01 "
                   "to 100, in the order of the mesh; a triangle takes the mean of its corners. "
                   "Text after # is ignored"),
    KEY(cloth_keys, thickness, QUANTITY(UNIT_LENGTH, 0, 1), .fallback = "auto",
        .flags = SCHEMA_ABOVE_MINIMUM, .word = "auto",
        .meaning = "thickness of the cloth; auto: the contact distance decides"),
    KEY(cloth_keys, velocity, .type = SCHEMA_VECTOR, .unit = UNIT_VELOCITY, .fallback = "[0, 0, 0]",
        .least_count = 3, .most_count = 3, .minimum = -1000, .maximum = 1000,
        .meaning = "velocity of every vertex at the start"),
    KEY(cloth_keys, regions, LIST(region_map, 0, 10000), .fallback = "[]",
        .meaning = "parts that shrink, are stiffer or softer, or have their warp elsewhere; where "
                   "they overlap the last counts"),
    KEY(cloth_keys, pins, LIST(pin_map, 0, 10000), .fallback = "[]",
        .meaning = "vertices that are held or moved"),
    KEY(cloth_keys, attach, LIST(attach_map, 0, 10000), .fallback = "[]",
        .meaning = "vertices that go with an obstacle, a rigid body or a cloth"),
    KEY(cloth_keys, color, COLOR, .derived = "from a palette",
        .meaning = "color of its front in pictures: red, green, blue of sRGB"),
    KEY(cloth_keys, back_color, COLOR, .derived = "from the front's",
        .meaning = "color of its back in pictures"),
    KEY(cloth_keys, pattern, .type = SCHEMA_CHOICE, .choices = pattern_names,
        .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE, .derived = "`check`",
        .meaning = "pattern in pictures; it follows the cloth's rest shape"),
    KEY(cloth_keys, pattern_size, POSITIVE_LENGTH(SCHEMA_OPTIONAL | SCHEMA_PICTURE),
        .beside = "pattern", .beside_choices = ~UINT64_C(1), .derived = "from its extent",
        .meaning = "length of a square of the check, or of a period of the weave"),
};
const schema_map cloth_map =
    MAP_OF(cloth_table, cloth_keys, .title = "Cloth",
           .meaning = "One piece of cloth, or several that share all values.");
