/* scene/keys_obstacle.c - the table of keys: mesh sequences, motion, copies and obstacles. */
#include "scene/keys_table.h"

/* In the order of sequence_loop. */
static const char *const loop_names[] = {"once", "repeat", "pingpong", NULL};
static const schema_key sequence_table[] = {
    {.name = "files",
     .type = SCHEMA_PATH,
     .flags = SCHEMA_ALTERNATIVE,
     FIELD(sequence_keys, files),
     .meaning = "numbered mesh files with the same triangles, as body_%02d.obj"},
    {.name = "cache",
     .type = SCHEMA_PATH,
     .flags = SCHEMA_ALTERNATIVE,
     FIELD(sequence_keys, cache),
     .meaning = "PC2 or MDD point cache, whose triangles the obstacle's mesh gives; or an "
                "animation (.glb, .gltf, "
                ".usda, .npz, .abc), which has them itself"},
    {.name = "first",
     .type = SCHEMA_INTEGER,
     .minimum = 0,
     .maximum = 1000000000,
     .derived = "0",
     .flags = SCHEMA_OPTIONAL,
     FIELD(sequence_keys, first),
     .meaning = "number of the first frame"},
    {.name = "last",
     .type = SCHEMA_INTEGER,
     .minimum = 0,
     .maximum = 1000000000,
     .derived = "end of the cache",
     .flags = SCHEMA_OPTIONAL,
     FIELD(sequence_keys, last),
     .meaning = "number of the last frame; needed with files"},
    {.name = "interval",
     .type = SCHEMA_NUMBER,
     .unit = UNIT_TIME,
     .minimum = 0,
     .maximum = 1e6,
     .flags = SCHEMA_ABOVE_MINIMUM | SCHEMA_SECOND_ALTERNATIVE,
     FIELD(sequence_keys, interval),
     .meaning = "time from one frame to the next; overrules the times of the file"},
    {.name = "fps",
     .type = SCHEMA_NUMBER,
     .minimum = 0,
     .maximum = 1e6,
     .flags = SCHEMA_ABOVE_MINIMUM | SCHEMA_SECOND_ALTERNATIVE,
     FIELD(sequence_keys, fps),
     .meaning =
         "frames in a second, where the file has no times: numbered files; PC2, which counts "
         "its start and its step in these frames; NPZ without times. All other files have their "
         "own times, which are used"},
    {.name = "speed",
     .type = SCHEMA_NUMBER,
     .fallback = "1",
     .minimum = 0,
     .maximum = 1000,
     .flags = SCHEMA_ABOVE_MINIMUM,
     FIELD(sequence_keys, speed),
     .meaning = "factor on the speed: 2 plays in half of the time"},
    {.name = "loop",
     .type = SCHEMA_CHOICE,
     .choices = loop_names,
     .fallback = "once",
     FIELD(sequence_keys, loop),
     .meaning =
         "what follows the last frame. once: it stands still; pingpong: backwards to the "
         "first frame, forwards again, and so on; repeat: the first frame, and so on. The ends "
         "must then meet: from the last frame to the first no vertex may move more than twice as "
         "far as between other frames. If the last frame repeats the first, it counts once"},
    {.name = "start",
     ANY_TIME,
     .derived = "as the file has it; 0 with first or interval, and where it has none",
     FIELD(sequence_keys, start),
     .meaning = "time of the first frame"},
};
const schema_map sequence_map = {
    .title = "Mesh sequence",
    .meaning = "Frames of a deforming mesh; vertices move linearly in between. The obstacle's "
               "scale, rotate and translate apply to every frame. Frames come at the times of the "
               "file where it has any; [When frames come](formats.md#when-frames-come) says what "
               "overrules what.",
    MAP_OF(sequence_table, sequence_keys),
    .needs_alternative = true};

static const schema_key motion_table[] = {
    {.name = "keyframes",
     .type = SCHEMA_LIST,
     .map = &keyframe_map,
     .minimum = 1,
     .maximum = 100000,
     .flags = SCHEMA_ALTERNATIVE,
     FIELD(motion_keys, keyframes),
     .meaning = "rigid motion"},
    {.name = "sequence",
     .type = SCHEMA_MAP,
     .map = &sequence_map,
     .flags = SCHEMA_ALTERNATIVE | SCHEMA_OPTIONAL,
     FIELD(motion_keys, sequence),
     .meaning = "deforming mesh from files"},
    {.name = "eased",
     .type = SCHEMA_BOOL,
     .fallback = "false",
     FIELD(motion_keys, eased),
     .beside = "keyframes",
     .meaning = "starts and stops gently at each keyframe"},
    {.name = "pivot",
     POINT,
     .flags = SCHEMA_OPTIONAL,
     .derived = "origin of the obstacle",
     FIELD(motion_keys, pivot),
     .beside = "keyframes",
     .meaning = "point that keyframes turn about, in scene coordinates; if there are copies, in "
                "coordinates of the copy"},
};
const schema_map motion_map = {
    .title = "Motion",
    .meaning = "How an obstacle moves. Displacements and turns are along the axes of the scene. "
               "If copies stand on a ring or a spiral, they are along the axes of each copy.",
    MAP_OF(motion_table, motion_keys),
    .needs_alternative = true};

#define MASS_OF_KIND(field_name, its_unit, otherwise, text)                                        \
    {                                                                                              \
        .name = #field_name, .type = SCHEMA_NUMBER, .unit = its_unit, .minimum = 0,                \
        .maximum = 1e12, .flags = SCHEMA_ABOVE_MINIMUM | SCHEMA_ALTERNATIVE | SCHEMA_OPTIONAL,     \
        .derived = otherwise, FIELD(dynamic_keys, field_name), .meaning = text                     \
    }
#define DAMPING(field_name, text)                                                                  \
    {                                                                                              \
        .name = #field_name, .type = SCHEMA_NUMBER, .unit = UNIT_RATE, .fallback = "0",            \
        .minimum = 0, .maximum = 1e6, FIELD(dynamic_keys, field_name), .meaning = text             \
    }
static const schema_key dynamic_table[] = {
    MASS_OF_KIND(mass, UNIT_MASS, "by density", "mass of each copy, spread evenly over its volume"),
    MASS_OF_KIND(density, UNIT_DENSITY, "1000, as water, where none of the three is given",
                 "density of the volume"),
    MASS_OF_KIND(area_density, UNIT_AREA_DENSITY, "none",
                 "density of the surface, for shells; the mesh need not be closed"),
    {.name = "velocity",
     .type = SCHEMA_VECTOR,
     .unit = UNIT_VELOCITY,
     .fallback = "[0, 0, 0]",
     .least_count = 3,
     .most_count = 3,
     .minimum = -1000,
     .maximum = 1000,
     FIELD(dynamic_keys, velocity),
     .meaning = "velocity of the centre of mass at the start"},
    {.name = "spin",
     .type = SCHEMA_VECTOR,
     .unit = UNIT_SPIN,
     .fallback = "[0, 0, 0]",
     .least_count = 3,
     .most_count = 3,
     .minimum = -10000,
     .maximum = 10000,
     FIELD(dynamic_keys, spin),
     .meaning = "angular velocity at the start"},
    DAMPING(linear_damping, "rate at which the velocity of the centre decays"),
    DAMPING(angular_damping, "rate at which the spin decays"),
    {.name = "start",
     ANY_TIME,
     .fallback = "0",
     FIELD(dynamic_keys, start),
     .meaning = "until then the body follows its motion, which must begin earlier; after that it "
                "moves freely, with the velocity that it has"},
    {.name = "sleep_speed",
     .type = SCHEMA_NUMBER,
     .unit = UNIT_VELOCITY,
     .fallback = "0",
     .minimum = 0,
     .maximum = 1000,
     FIELD(dynamic_keys, sleep_speed),
     .meaning = "the body falls asleep once it and all that it touches have been slower than this "
                "for sleep_time. A sleeping body stands still and costs little; it wakes when "
                "something presses on it. 0: never; 1 cm/s is usual"},
    {.name = "sleep_time",
     .type = SCHEMA_NUMBER,
     .unit = UNIT_TIME,
     .fallback = "0.5 s",
     .minimum = 0,
     .maximum = 1e6,
     .flags = SCHEMA_ABOVE_MINIMUM,
     FIELD(dynamic_keys, sleep_time),
     .beside = "sleep_speed",
     .meaning = "how long the body must be slow before it falls asleep"},
};
const schema_map dynamic_map = {
    .title = "Rigid body",
    .meaning = "An obstacle that answers contact with cloth, with obstacles and with other bodies. "
               "Its mesh must face outwards, and be closed unless area_density is given. At the "
               "start it must not intersect anything. `dynamic: true` makes a body with all "
               "defaults, `false` makes no body.",
    MAP_OF(dynamic_table, dynamic_keys),
    .takes_flag = true};

static const schema_key row_table[] = {
    {.name = "count", COUNT_OF_COPIES, FIELD(row_keys, count), .meaning = "copies"},
    {.name = "offset",
     POINT,
     .flags = SCHEMA_REQUIRED,
     FIELD(row_keys, offset),
     .meaning = "from one copy to the next; the first stays in place"},
};
const schema_map row_map = {.title = "Copies in a row",
                            .meaning = "Copies stand at equal distances and have the same axes.",
                            MAP_OF(row_table, row_keys)};

static const schema_key grid_table[] = {
    {.name = "count",
     .type = SCHEMA_INTEGERS,
     .least_count = 2,
     .most_count = 3,
     .minimum = 1,
     .maximum = 4096,
     .flags = SCHEMA_REQUIRED,
     FIELD(grid_keys, count),
     .meaning = "copies along x, y and perhaps z"},
    {.name = "spacing",
     .type = SCHEMA_VECTOR,
     .unit = UNIT_LENGTH,
     ANY_SIZE,
     .least_count = 2,
     .most_count = 3,
     .flags = SCHEMA_REQUIRED,
     FIELD(grid_keys, spacing),
     .meaning = "distance along x, y and perhaps z; the grid is centred"},
};
const schema_map grid_map = {.title = "Copies in a grid",
                             .meaning = "Copies fill rows along x first and have the same axes.",
                             MAP_OF(grid_table, grid_keys)};

static const schema_key ring_table[] = {
    {.name = "count", COUNT_OF_COPIES, FIELD(ring_keys, count), .meaning = "copies"},
    {.name = "radius",
     POSITIVE_LENGTH(SCHEMA_REQUIRED),
     FIELD(ring_keys, radius),
     .meaning = "radius of the ring"},
    {.name = "from",
     .type = SCHEMA_NUMBER,
     .unit = UNIT_ANGLE,
     .fallback = "0",
     .minimum = -1000,
     .maximum = 1000,
     FIELD(ring_keys, from),
     .meaning = "angle of the first copy"},
};
const schema_map ring_map = {
    .title = "Copies on a ring",
    .meaning = "Copies stand evenly around z. The x axis of each points outwards.",
    MAP_OF(ring_table, ring_keys)};

static const schema_key spiral_table[] = {
    {.name = "count", COUNT_OF_COPIES, FIELD(spiral_keys, count), .meaning = "copies"},
    {.name = "radius",
     POSITIVE_LENGTH(SCHEMA_REQUIRED),
     FIELD(spiral_keys, radius),
     .meaning = "radius of the sphere"},
    {.name = "from",
     .type = SCHEMA_NUMBER,
     .unit = UNIT_ANGLE,
     .fallback = "0 deg",
     .minimum = 0,
     .maximum = 3.141592653589793,
     FIELD(spiral_keys, from),
     .meaning = "angle from the pole where the spiral begins"},
    {.name = "to",
     .type = SCHEMA_NUMBER,
     .unit = UNIT_ANGLE,
     .fallback = "90 deg",
     .minimum = 0,
     .maximum = 3.141592653589793,
     FIELD(spiral_keys, to),
     .meaning = "angle from the pole where it ends"},
    {.name = "turns",
     .type = SCHEMA_NUMBER,
     .fallback = "4",
     .minimum = -1000,
     .maximum = 1000,
     FIELD(spiral_keys, turns),
     .meaning = "turns about z; negative: clockwise seen from above"},
};
const schema_map spiral_map = {
    .title = "Copies on a spiral",
    .meaning =
        "Copies stand at even distances along a spiral on a sphere about the origin, which begins "
        "near the pole on the z axis. The z axis of each copy points away from the sphere.",
    MAP_OF(spiral_table, spiral_keys)};

static const char *const order_names[] = {"first-to-last", "last-to-first", NULL};
#define LAYOUT(field_name, map_name, text)                                                         \
    {                                                                                              \
        .name = #field_name, .type = SCHEMA_MAP, .map = &map_name,                                 \
        .flags = SCHEMA_ALTERNATIVE | SCHEMA_OPTIONAL, FIELD(copies_keys, field_name),             \
        .meaning = text                                                                            \
    }
static const schema_key copies_table[] = {
    LAYOUT(row, row_map, "copies in a row"),
    LAYOUT(grid, grid_map, "copies in a grid"),
    LAYOUT(ring, ring_map, "copies on a ring"),
    LAYOUT(spiral, spiral_map, "copies on a spiral over a sphere"),
    {.name = "stagger",
     .type = SCHEMA_NUMBER,
     .unit = UNIT_TIME,
     .fallback = "0",
     .minimum = 0,
     .maximum = 1e6,
     FIELD(copies_keys, stagger),
     .meaning = "delays keyframes, appears and disappears from one copy to the next"},
    {.name = "order",
     .type = SCHEMA_CHOICE,
     .choices = order_names,
     .fallback = "first-to-last",
     FIELD(copies_keys, order),
     .beside = "stagger",
     .meaning = "which copy moves first"},
};
const schema_map copies_map = {
    .title = "Copies",
    .meaning =
        "Places an obstacle many times. Each copy is scaled and turned by the obstacle's "
        "scale and rotate, set down by the layout, and moved by translate. Copies count from 000: "
        "three copies of post are post.000, post.001 and post.002.",
    MAP_OF(copies_table, copies_keys),
    .needs_alternative = true};

static const schema_key obstacle_table[] = {
    {.name = "name",
     .type = SCHEMA_NAME,
     FIELD(obstacle_keys, name),
     .derived = "obstacle0, obstacle1, ...",
     .meaning = "name in messages and of files"},
    {.name = "mesh",
     .type = SCHEMA_MAP,
     .map = &mesh_map,
     .flags = SCHEMA_OPTIONAL,
     FIELD(obstacle_keys, mesh),
     .derived = "first file of the sequence",
     .meaning = "any triangles, closed or not"},
    SCALE(obstacle_keys),
    ROTATE(obstacle_keys),
    PLACE(obstacle_keys),
    TRANSLATE(obstacle_keys),
    {.name = "material",
     .type = SCHEMA_NAME,
     .derived = "none",
     FIELD(obstacle_keys, material),
     .meaning = "name of its surface in contact.materials: any name, for example wood"},
    {.name = "friction",
     FRICTION_VALUE,
     .fallback = "0.3",
     FIELD(obstacle_keys, friction),
     .meaning = "Coulomb coefficient of a contact that does not slide; the geometric mean with the "
                "cloth's counts"},
    DYNAMIC_FRICTION(obstacle_keys, "the coefficient of a contact that slides; at most friction"),
    RESTITUTION(obstacle_keys, "share of an impact's speed at which cloth rebounds; the geometric "
                               "mean with the cloth's counts"),
    {.name = "friction_across",
     FRICTION_VALUE,
     .derived = "`1`",
     FIELD(obstacle_keys, friction_across),
     .meaning = "factor on friction at right angles to the grain, whichever law the friction comes "
                "from; 1: the same all around; response paper ignores it"},
    {.name = "grain",
     .type = SCHEMA_VECTOR,
     .derived = "`[1, 0, 0]`",
     .least_count = 3,
     .most_count = 3,
     .minimum = -1e6,
     .maximum = 1e6,
     FIELD(obstacle_keys, grain),
     .beside = "friction_across",
     .meaning = "direction in the mesh before its motion, of any length; friction_across acts at "
                "right angles to it. It is given along the axes of the scene, for a copy on a ring "
                "or a spiral along the axes of that copy, and goes with the motion"},
    {.name = "motion",
     .type = SCHEMA_MAP,
     .map = &motion_map,
     .flags = SCHEMA_OPTIONAL,
     FIELD(obstacle_keys, motion),
     .derived = "static",
     .meaning = "how it moves"},
    {.name = "dynamic",
     .type = SCHEMA_MAP,
     .map = &dynamic_map,
     .flags = SCHEMA_OPTIONAL,
     FIELD(obstacle_keys, dynamic),
     .derived = "none",
     .meaning = "makes it a rigid body, which moves by contact"},
    {.name = "appears",
     ANY_TIME,
     .fallback = "start",
     .word = "start",
     .word_value = -INFINITY,
     FIELD(obstacle_keys, appears),
     .meaning = "time at which it comes into the scene"},
    {.name = "disappears",
     ANY_TIME,
     .fallback = "never",
     .word = "never",
     .word_value = INFINITY,
     FIELD(obstacle_keys, disappears),
     .meaning = "time at which it leaves the scene"},
    {.name = "copies",
     .type = SCHEMA_MAP,
     .map = &copies_map,
     .flags = SCHEMA_OPTIONAL,
     FIELD(obstacle_keys, copies),
     .derived = "one",
     .meaning = "places it many times"},
    {.name = "color",
     COLOR,
     FIELD(obstacle_keys, color),
     .derived = "grey",
     .meaning = "color in pictures: red, green, blue of sRGB"},
    {.name = "hidden",
     .type = SCHEMA_BOOL,
     .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE,
     FIELD(obstacle_keys, hidden),
     .derived = "`false`",
     .meaning = "leaves it out of pictures, so that its inside can be seen"},
};
const schema_map obstacle_map = {.title = "Obstacle",
                                 .meaning =
                                     "Something that cloth cannot pass. Obstacles may intersect "
                                     "themselves and one another; rigid bodies may not.",
                                 MAP_OF(obstacle_table, obstacle_keys)};
