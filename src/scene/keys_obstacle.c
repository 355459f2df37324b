/* scene/keys_obstacle.c - the table of keys: mesh sequences, motion, copies and obstacles. */
#include "scene/keys_table.h"

/* In the order of sequence_loop. */
static const char *const loop_names[] = {"once", "repeat", "pingpong", NULL};
static const schema_key sequence_table[] = {
    KEY(sequence_keys, files, .type = SCHEMA_PATH, .flags = SCHEMA_ALTERNATIVE,
        .meaning = "numbered mesh files with the same triangles, as body_%02d.obj"),
    KEY(sequence_keys, cache, .type = SCHEMA_PATH, .flags = SCHEMA_ALTERNATIVE,
        .meaning = "PC2 or MDD point cache, whose triangles the obstacle's mesh gives; or an "
                   "animation (.glb, .gltf, .usda, .npz, .abc), which has them itself"),
    KEY(sequence_keys, first, INTEGER(0, 1000000000), .derived = "0", .flags = SCHEMA_OPTIONAL,
        .meaning = "number of the first frame"),
    KEY(sequence_keys, last, INTEGER(0, 1000000000), .derived = "end of the cache",
        .flags = SCHEMA_OPTIONAL, .meaning = "number of the last frame; needed with files"),
    KEY(sequence_keys, interval, QUANTITY(UNIT_TIME, 0, 1e6),
        .flags = SCHEMA_ABOVE_MINIMUM | SCHEMA_SECOND_ALTERNATIVE,
        .meaning = "time from one frame to the next; overrules the times of the file"),
    KEY(sequence_keys, fps, NUMBER(0, 1e6),
        .flags = SCHEMA_ABOVE_MINIMUM | SCHEMA_SECOND_ALTERNATIVE,
        .meaning = "frames in a second, where the file has no times: numbered files; PC2, which "
                   "counts its start and its step in these frames; NPZ without times. All other "
                   "files have their own times, which are used"),
    KEY(sequence_keys, speed, NUMBER(0, 1000), .fallback = "1", .flags = SCHEMA_ABOVE_MINIMUM,
        .meaning = "factor on the speed: 2 plays in half of the time"),
    KEY(sequence_keys, loop, CHOICE(loop_names, "once"),
        .meaning =
            "what follows the last frame. once: it stands still; pingpong: backwards to the first "
            "frame, forwards again, and so on; repeat: the first frame, and so on. The ends must "
            "then meet: from the last frame to the first no vertex may move more than twice as far "
            "as between other frames. If the last frame repeats the first, it counts once"),
    KEY(sequence_keys, start, ANY_TIME,
        .derived = "as the file has it; 0 with first or interval, and where it has none",
        .meaning = "time of the first frame"),
};
const schema_map sequence_map = MAP_OF(
    sequence_table, sequence_keys, .title = "Mesh sequence", .needs_alternative = true,
    .meaning =
        "Frames of a deforming mesh; vertices move linearly in between. The obstacle's scale, "
        "rotate and translate apply to every frame. Frames come at the times of the file where it "
        "has any; [When frames come](formats.md#when-frames-come) says what overrules what.");

static const schema_key motion_table[] = {
    KEY(motion_keys, keyframes, LIST(keyframe_map, 1, 100000), .flags = SCHEMA_ALTERNATIVE,
        .meaning = "rigid motion"),
    KEY(motion_keys, sequence, MAP(sequence_map), .flags = SCHEMA_ALTERNATIVE | SCHEMA_OPTIONAL,
        .meaning = "deforming mesh from files"),
    KEY(motion_keys, eased, .type = SCHEMA_BOOL, .fallback = "false", .beside = "keyframes",
        .meaning = "starts and stops gently at each keyframe"),
    KEY(motion_keys, pivot, POINT, .flags = SCHEMA_OPTIONAL, .derived = "origin of the obstacle",
        .beside = "keyframes",
        .meaning = "point that keyframes turn about, in scene coordinates; if there are copies, in "
                   "coordinates of the copy"),
};
const schema_map motion_map = MAP_OF(
    motion_table, motion_keys, .title = "Motion", .needs_alternative = true,
    .meaning = "How an obstacle moves. Displacements and turns are along the axes of the scene. If "
               "copies stand on a ring or a spiral, they are along the axes of each copy.");

#define MASS_OF_KIND(field_name, its_unit, otherwise, text)                                        \
    KEY(dynamic_keys, field_name, QUANTITY(its_unit, 0, 1e12),                                     \
        .flags = SCHEMA_ABOVE_MINIMUM | SCHEMA_ALTERNATIVE | SCHEMA_OPTIONAL,                      \
        .derived = otherwise, .meaning = text)
#define DAMPING(field_name, text)                                                                  \
    KEY(dynamic_keys, field_name, QUANTITY(UNIT_RATE, 0, 1e6), .fallback = "0", .meaning = text)
static const schema_key dynamic_table[] = {
    MASS_OF_KIND(mass, UNIT_MASS, "by density", "mass of each copy, spread evenly over its volume"),
    MASS_OF_KIND(density, UNIT_DENSITY, "1000, as water, where none of the three is given",
                 "density of the volume"),
    MASS_OF_KIND(area_density, UNIT_AREA_DENSITY, "none",
                 "density of the surface, for shells; the mesh need not be closed"),
    KEY(dynamic_keys, velocity, .type = SCHEMA_VECTOR, .unit = UNIT_VELOCITY,
        .fallback = "[0, 0, 0]", .least_count = 3, .most_count = 3, .minimum = -1000,
        .maximum = 1000, .meaning = "velocity of the centre of mass at the start"),
    KEY(dynamic_keys, spin, .type = SCHEMA_VECTOR, .unit = UNIT_SPIN, .fallback = "[0, 0, 0]",
        .least_count = 3, .most_count = 3, .minimum = -10000, .maximum = 10000,
        .meaning = "angular velocity at the start"),
    DAMPING(linear_damping, "rate at which the velocity of the centre decays"),
    DAMPING(angular_damping, "rate at which the spin decays"),
    KEY(dynamic_keys, start, ANY_TIME, .fallback = "0",
        .meaning = "until then the body follows its motion, which must begin earlier; after that "
                   "it moves freely, with the velocity that it has"),
    KEY(dynamic_keys, sleep_speed, QUANTITY(UNIT_VELOCITY, 0, 1000), .fallback = "0",
        .meaning = "the body falls asleep once it and all that it touches have been slower than "
                   "this for sleep_time. A sleeping body stands still and costs little; it wakes "
                   "when something presses on it. 0: never; 1 cm/s is usual"),
    KEY(dynamic_keys, sleep_time, QUANTITY(UNIT_TIME, 0, 1e6), .fallback = "0.5 s",
        .flags = SCHEMA_ABOVE_MINIMUM, .beside = "sleep_speed",
        .meaning = "how long the body must be slow before it falls asleep"),
};
const schema_map dynamic_map =
    MAP_OF(dynamic_table, dynamic_keys, .title = "Rigid body", .takes_flag = true,
           .meaning = "An obstacle that answers contact with cloth, with obstacles and with other "
                      "bodies. Its mesh must face outwards, and be closed unless area_density is "
                      "given. At the start it must not intersect anything. `dynamic: true` makes a "
                      "body with all defaults, `false` makes no body.");

static const schema_key row_table[] = {
    KEY(row_keys, count, COUNT_OF_COPIES, .meaning = "copies"),
    KEY(row_keys, offset, POINT, .flags = SCHEMA_REQUIRED,
        .meaning = "from one copy to the next; the first stays in place"),
};
const schema_map row_map =
    MAP_OF(row_table, row_keys, .title = "Copies in a row",
           .meaning = "Copies stand at equal distances and have the same axes.");

static const schema_key grid_table[] = {
    KEY(grid_keys, count, .type = SCHEMA_INTEGERS, .least_count = 2, .most_count = 3, .minimum = 1,
        .maximum = 4096, .flags = SCHEMA_REQUIRED, .meaning = "copies along x, y and perhaps z"),
    KEY(grid_keys, spacing, .type = SCHEMA_VECTOR, ANY_SIZE, .unit = UNIT_LENGTH, .least_count = 2,
        .most_count = 3, .flags = SCHEMA_REQUIRED,
        .meaning = "distance along x, y and perhaps z; the grid is centred"),
};
const schema_map grid_map =
    MAP_OF(grid_table, grid_keys, .title = "Copies in a grid",
           .meaning = "Copies fill rows along x first and have the same axes.");

static const schema_key ring_table[] = {
    KEY(ring_keys, count, COUNT_OF_COPIES, .meaning = "copies"),
    KEY(ring_keys, radius, POSITIVE_LENGTH(SCHEMA_REQUIRED), .meaning = "radius of the ring"),
    KEY(ring_keys, from, QUANTITY(UNIT_ANGLE, -1000, 1000), .fallback = "0",
        .meaning = "angle of the first copy"),
};
const schema_map ring_map =
    MAP_OF(ring_table, ring_keys, .title = "Copies on a ring",
           .meaning = "Copies stand evenly around z. The x axis of each points outwards.");

static const schema_key spiral_table[] = {
    KEY(spiral_keys, count, COUNT_OF_COPIES, .meaning = "copies"),
    KEY(spiral_keys, radius, POSITIVE_LENGTH(SCHEMA_REQUIRED), .meaning = "radius of the sphere"),
    KEY(spiral_keys, from, QUANTITY(UNIT_ANGLE, 0, 3.141592653589793), .fallback = "0 deg",
        .meaning = "angle from the pole where the spiral begins"),
    KEY(spiral_keys, to, QUANTITY(UNIT_ANGLE, 0, 3.141592653589793), .fallback = "90 deg",
        .meaning = "angle from the pole where it ends"),
    KEY(spiral_keys, turns, NUMBER(-1000, 1000), .fallback = "4",
        .meaning = "turns about z; negative: clockwise seen from above"),
};
const schema_map spiral_map = MAP_OF(
    spiral_table, spiral_keys, .title = "Copies on a spiral",
    .meaning =
        "Copies stand at even distances along a spiral on a sphere about the origin, which begins "
        "near the pole on the z axis. The z axis of each copy points away from the sphere.");

static const char *const order_names[] = {"first-to-last", "last-to-first", NULL};
#define LAYOUT(field_name, map_name, text)                                                         \
    KEY(copies_keys, field_name, MAP(map_name), .flags = SCHEMA_ALTERNATIVE | SCHEMA_OPTIONAL,     \
        .meaning = text)
static const schema_key copies_table[] = {
    LAYOUT(row, row_map, "copies in a row"),
    LAYOUT(grid, grid_map, "copies in a grid"),
    LAYOUT(ring, ring_map, "copies on a ring"),
    LAYOUT(spiral, spiral_map, "copies on a spiral over a sphere"),
    KEY(copies_keys, stagger, QUANTITY(UNIT_TIME, 0, 1e6), .fallback = "0",
        .meaning = "delays keyframes, appears and disappears from one copy to the next"),
    KEY(copies_keys, order, CHOICE(order_names, "first-to-last"), .beside = "stagger",
        .meaning = "which copy moves first"),
};
const schema_map copies_map = MAP_OF(
    copies_table, copies_keys, .title = "Copies", .needs_alternative = true,
    .meaning = "Places an obstacle many times. Each copy is scaled and turned by the obstacle's "
               "scale and rotate, set down by the layout, and moved by translate. Copies count "
               "from 000: three copies of post are post.000, post.001 and post.002.");

static const schema_key obstacle_table[] = {
    KEY(obstacle_keys, name, .type = SCHEMA_NAME, .derived = "obstacle0, obstacle1, ...",
        .meaning = "name in messages and of files"),
    KEY(obstacle_keys, mesh, MAP(mesh_map), .flags = SCHEMA_OPTIONAL,
        .derived = "first file of the sequence", .meaning = "any triangles, closed or not"),
    SCALE(obstacle_keys),
    ROTATE(obstacle_keys),
    PLACE(obstacle_keys),
    TRANSLATE(obstacle_keys),
    KEY(obstacle_keys, material, .type = SCHEMA_NAME, .derived = "none",
        .meaning = "name of its surface in contact.materials: any name, for example wood"),
    KEY(obstacle_keys, friction, FRICTION_VALUE, .fallback = "0.3",
        .meaning = "Coulomb coefficient of a contact that does not slide; the geometric mean with "
                   "the cloth's counts"),
    DYNAMIC_FRICTION(obstacle_keys, "the coefficient of a contact that slides; at most friction"),
    RESTITUTION(obstacle_keys, "share of an impact's speed at which cloth rebounds; the geometric "
                               "mean with the cloth's counts"),
    KEY(obstacle_keys, friction_across, FRICTION_VALUE, .derived = "`1`",
        .meaning = "factor on friction at right angles to the grain, whichever law the friction "
                   "comes from; 1: the same all around; response paper ignores it"),
    KEY(obstacle_keys, grain, .type = SCHEMA_VECTOR, .derived = "`[1, 0, 0]`", .least_count = 3,
        .most_count = 3, .minimum = -1e6, .maximum = 1e6, .beside = "friction_across",
        .meaning = "direction in the mesh before its motion, of any length; friction_across acts "
                   "at right angles to it. It is given along the axes of the scene, for a copy on "
                   "a ring or a spiral along the axes of that copy, and goes with the motion"),
    KEY(obstacle_keys, motion, MAP(motion_map), .flags = SCHEMA_OPTIONAL, .derived = "static",
        .meaning = "how it moves"),
    KEY(obstacle_keys, dynamic, MAP(dynamic_map), .flags = SCHEMA_OPTIONAL, .derived = "none",
        .meaning = "makes it a rigid body, which moves by contact"),
    KEY(obstacle_keys, appears, ANY_TIME, OR_WORD("start", -INFINITY),
        .meaning = "time at which it comes into the scene"),
    KEY(obstacle_keys, disappears, ANY_TIME, OR_WORD("never", INFINITY),
        .meaning = "time at which it leaves the scene"),
    KEY(obstacle_keys, copies, MAP(copies_map), .flags = SCHEMA_OPTIONAL, .derived = "one",
        .meaning = "places it many times"),
    KEY(obstacle_keys, color, COLOR, .derived = "grey",
        .meaning = "color in pictures: red, green, blue of sRGB"),
    KEY(obstacle_keys, hidden, .type = SCHEMA_BOOL, .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE,
        .derived = "`false`",
        .meaning = "leaves it out of pictures, so that its inside can be seen"),
};
const schema_map obstacle_map =
    MAP_OF(obstacle_table, obstacle_keys, .title = "Obstacle",
           .meaning = "Something that cloth cannot pass. Obstacles may intersect themselves and "
                      "one another; rigid bodies may not.");
