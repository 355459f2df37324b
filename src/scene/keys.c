/* scene/keys.c - the table of keys: what a scene file may say. Parsing, range checks, defaults,
 * canonical text and docs/guide/scene.md all come from it. This part: the file's own keys, time,
 * wind, contact and solver; the other parts are the other files keys_*.c. */
#include "base/words.h"
#include "scene/keys_table.h"

#include "tulle/paper.h"

static const schema_key time_table[] = {
    KEY(time_keys, step, QUANTITY(UNIT_TIME, 0, 1), .fallback = "1/90 s",
        .flags = SCHEMA_ABOVE_MINIMUM, .meaning = "time that one step of the simulation covers"),
    KEY(time_keys, frames, INTEGER(1, 10000000), .flags = SCHEMA_ALTERNATIVE,
        .meaning = "frames written after the start"),
    KEY(time_keys, duration, QUANTITY(UNIT_TIME, 0, 1e6),
        .flags = SCHEMA_ALTERNATIVE | SCHEMA_ABOVE_MINIMUM,
        .meaning = "simulated time, rounded up to whole frames"),
    KEY(time_keys, steps_per_frame, INTEGER(1, 100000), .fallback = "1",
        .meaning = "steps between two written frames"),
};
const schema_map time_map =
    MAP_OF(time_table, time_keys, .title = "Time", .needs_alternative = true,
           .meaning = "How long the scene is simulated, and in which steps.");

static const schema_key wind_table[] = {
    KEY(wind_keys, velocity, .type = SCHEMA_VECTOR, .unit = UNIT_VELOCITY, .fallback = "[0, 0, 0]",
        .least_count = 3, .most_count = 3, .minimum = -1000, .maximum = 1000,
        .meaning = "mean velocity of the air"),
    KEY(wind_keys, gust_strength, QUANTITY(UNIT_VELOCITY, 0, 1000), .fallback = "0",
        .meaning = "standard deviation of each component of the gusts"),
    KEY(wind_keys, gust_length, POSITIVE_LENGTH(0), .fallback = "0.5 m", .beside = "gust_strength",
        .meaning = "distance over which gusts are alike"),
    KEY(wind_keys, gust_time, QUANTITY(UNIT_TIME, 0, 1e6), .fallback = "0.5 s",
        .flags = SCHEMA_ABOVE_MINIMUM, .beside = "gust_strength",
        .meaning = "time over which gusts are alike"),
    KEY(wind_keys, drag, QUANTITY(UNIT_DRAG, 0, 1e4), .fallback = "0.7",
        .meaning = "force per area and squared speed of the air against the cloth; 0: a vacuum"),
    KEY(wind_keys, seed, AUTO_SEED, .beside = "gust_strength",
        .meaning = "seed of the gusts; auto: from the scene's seed"),
};
const schema_map wind_map = MAP_OF(wind_table, wind_keys, .title = "Wind",
                                   .meaning = "Air that pushes cloth: a mean velocity and seeded "
                                              "gusts that are the same on every machine.");

#define DISTANCE                                                                                   \
    .type = SCHEMA_NUMBER, .unit = UNIT_LENGTH, .fallback = "auto", .word = "auto", .minimum = 0,  \
    .maximum = 1, .flags = SCHEMA_ABOVE_MINIMUM
static const schema_key pair_table[] = {
    KEY(pair_keys, between, .type = SCHEMA_NAMES, .least_count = 2, .most_count = 2,
        .flags = SCHEMA_REQUIRED,
        .meaning = "names of two objects: a cloth and another object, or two obstacles of which "
                   "one is a rigid body. An obstacle's name stands for all its copies; the same "
                   "name twice means its copies among themselves"),
    KEY(pair_keys, friction, FRICTION_VALUE, .flags = SCHEMA_REQUIRED,
        .meaning = "Coulomb coefficient of contacts that do not slide"),
    DYNAMIC_FRICTION(pair_keys, "the coefficient of contacts that slide; at most friction"),
    RESTITUTION(pair_keys, "share of an impact's speed at which the two part"),
};
const schema_map pair_map =
    MAP_OF(pair_table, pair_keys, .title = "Pair",
           .meaning = "Friction and restitution of two objects, in place of what their materials "
                      "say. Where one has a grain, this is the friction along it.");

static const schema_key material_pair_table[] = {
    KEY(pair_keys, between, .type = SCHEMA_NAMES, .least_count = 2, .most_count = 2,
        .flags = SCHEMA_REQUIRED,
        .meaning =
            "names of two materials: presets, a cloth's material.name, or an obstacle's material. "
            "The same name twice means that material on itself, folds of one cloth included"),
    KEY(pair_keys, friction, FRICTION_VALUE, .flags = SCHEMA_REQUIRED,
        .meaning = "Coulomb coefficient of contacts that do not slide"),
    DYNAMIC_FRICTION(pair_keys, "the coefficient of contacts that slide; at most friction"),
    RESTITUTION(pair_keys, "share of an impact's speed at which the two part"),
};
const schema_map material_pair_map =
    MAP_OF(material_pair_table, pair_keys, .title = "Pair of materials",
           .meaning = "Friction and restitution of all surfaces of these two materials, in place "
                      "of what the objects say on their own. A law for two named objects takes "
                      "precedence. Where a surface has a grain, this is the friction along it.");

static const schema_key contact_table[] = {
    KEY(contact_keys, delta_c, DISTANCE,
        .meaning = "contact distance; auto: from thickness or the meshes"),
    KEY(contact_keys, delta_s, DISTANCE,
        .meaning = "distance beyond which a contact ends, at least delta_c and every thickness; "
                   "auto: 1.5 delta_c"),
    KEY(contact_keys, xi, DISTANCE,
        .meaning = "smallest gap that a state may have, at most half of delta_c; auto: from "
                   "delta_c and the scene's extent"),
    KEY(contact_keys, friction, FRICTION_VALUE, .fallback = "0.3",
        .meaning = "Coulomb coefficient between cloths that do not slide on one another, unless "
                   "pairs or materials say otherwise"),
    DYNAMIC_FRICTION(contact_keys,
                     "the coefficient of cloths that slide on one another; at most friction"),
    KEY(contact_keys, response, CHOICE(response_words, "coupled"),
        .meaning = "how contact acts. coupled: impulses are part of the solve; paper: forces and "
                   "velocities are projected vertex by vertex, for comparison"),
    KEY(contact_keys, motion_space, CHOICE(motion_space_words, "polyhedral"), .beside = "response",
        .beside_choices = 1U << TULLE_RESPONSE_PAPER,
        .meaning = "for response paper, which velocities a vertex in contact may have. cone: the "
                   "widest circular cone inside the half-spaces of its contacts, as in the paper; "
                   "polyhedral: all of their intersection"),
    KEY(contact_keys, method, CHOICE(method_words, "patches"),
        .meaning =
            "how pairs are found. patches: refitted trees that skip pairs within one certified "
            "patch; refit: the same without patches; bvox: voxel trees built again in each search; "
            "paper: a voxel tree for each patch. They differ in time, not in the result"),
    KEY(contact_keys, cone, CHOICE(cone_words, "bernstein"),
        .meaning = "for methods patches and paper, as the three keys below: bound on the normals "
                   "of a moving triangle. bernstein, or the paper's, which is wider"),
    KEY(contact_keys, alpha_max, QUANTITY(UNIT_ANGLE, 1e-12, 1.57), .fallback = "45 deg",
        .meaning = "half the opening of the widest cone that the normals of a patch may fill"),
    KEY(contact_keys, certificate, CHOICE(switch_words, "on"),
        .meaning = "on: the search skips only patches that are proven not to touch themselves; "
                   "off: it skips all patches, as in the paper, and cloth may pass through itself "
                   "within a patch, an exception to the promise"),
    KEY(contact_keys, patches, CHOICE(patches_words, "keep"),
        .meaning = "keep: patches live from step to step and are checked again; grow: every search "
                   "grows them again, as method paper always does"),
    KEY(contact_keys, impact_rounds, INTEGER(0, 100), .fallback = "5",
        .meaning = "rounds of impact resolution before the rescue"),
    KEY(contact_keys, start_intersections, CHOICE(start_words, "refuse"),
        .meaning = "what to do with cloth that intersects at the start. refuse: end the run; "
                   "ignore: ignore these pairs until they have come apart, an exception to the "
                   "promise; untangle: move the cloth until nothing intersects"),
    KEY(contact_keys, untangle_limit, INTEGER(1, 1000000), .fallback = "2000",
        .beside = "start_intersections", .beside_choices = 1U << TULLE_START_UNTANGLE,
        .meaning = "rounds of untangling after which a start that still intersects is refused"),
    KEY(contact_keys, on_pinch, CHOICE(pinch_words, "lag"),
        .meaning =
            "what to do when obstacles close on cloth. lag: a mesh sequence stays behind its "
            "frames where there is no room, and a pinch of rigid obstacles ends the run; stop: end "
            "the run; slow: as lag, but rigid obstacles wait until there is room"),
    KEY(contact_keys, pairs, LIST(pair_map, 0, 4096), .fallback = "[]",
        .meaning = "friction and restitution of certain pairs of objects"),
    KEY(contact_keys, materials, LIST(material_pair_map, 0, 4096), .derived = "`[]`",
        .meaning = "friction and restitution of certain pairs of materials"),
};
const schema_map contact_map = MAP_OF(
    contact_table, contact_keys, .title = "Contact",
    .meaning =
        "Contact distances, friction between cloths, and how contacts are found and answered.");

/* In the order of tulle_quality. */
static const char *const quality_words[] = {"draft", "normal", "exact", NULL};
static const schema_key solver_table[] = {
    KEY(solver_keys, integrator, CHOICE(integrator_words, "implicit-euler"),
        .meaning = "time integration"),
    KEY(solver_keys, quality, CHOICE(quality_words, "normal"),
        .meaning = "how exactly costly solves are solved, see [Performance](performance.md); the "
                   "promise does not depend on it"),
    KEY(solver_keys, cg_tolerance, NUMBER(1e-12, 0.1), .fallback = "1e-4",
        .meaning = "relative residual at which conjugate gradients stop; 1e-3 makes sliding "
                   "inaccurate. A solve that takes long may end sooner: `quality`"),
    KEY(solver_keys, cg_iterations, INTEGER(1, 1000000), .fallback = "5000",
        .meaning = "most iterations of a solve"),
    KEY(solver_keys, rounds, INTEGER(1, 20), .fallback = "1",
        .meaning = "least number of solves of motion and impulses in a step; more follow until the "
                   "impulses settle"),
    KEY(solver_keys, sweeps, INTEGER(1, 1000), .fallback = "10",
        .meaning = "sweeps over the contacts in a round"),
    KEY(solver_keys, sleep_speed, QUANTITY(UNIT_VELOCITY, 0, 1000), .fallback = "0",
        .meaning =
            "cloth falls asleep once it and all cloth that touches it have been slower than this "
            "for sleep_time, and their centres ten times slower. Sleeping cloth stands still and "
            "costs little; it wakes when something comes near. 0: never; 1 mm/s is usual"),
    KEY(solver_keys, sleep_time, QUANTITY(UNIT_TIME, 0, 1e6), .fallback = "0.5 s",
        .flags = SCHEMA_ABOVE_MINIMUM, .beside = "sleep_speed",
        .meaning = "how long cloth must be slow before it falls asleep"),
};
const schema_map solver_map = MAP_OF(solver_table, solver_keys, .title = "Solver",
                                     .meaning = "Time integration and its linear systems.");

/* In the order of tulle_membrane. */
static const char *const membrane_words[] = {"woven", "springs", NULL};
/* In the order of tulle_on_overstretch. */
static const char *const overstretch_words[] = {"warn", "stop", NULL};
static const schema_key scene_table[] = {
    KEY(scene_keys, title, .type = SCHEMA_TEXT, .fallback = "''",
        .meaning = "title for people; nothing depends on it"),
    KEY(scene_keys, seed, ANY_SEED, .fallback = "1",
        .meaning = "every seed that is `auto` follows from it"),
    KEY(scene_keys, time, MAP(time_map), .flags = SCHEMA_REQUIRED,
        .meaning = "how long the scene is simulated, and in which steps"),
    KEY(scene_keys, gravity, .type = SCHEMA_VECTOR, .unit = UNIT_ACCELERATION,
        .fallback = "[0, 0, -9.81]", .least_count = 3, .most_count = 3, .minimum = -1e4,
        .maximum = 1e4, .meaning = "acceleration of all cloth"),
    KEY(scene_keys, wind, MAP(wind_map), .meaning = "moving air"),
    KEY(scene_keys, cloth, LIST(cloth_map, 0, 1000), .fallback = "[]",
        .meaning = "what is simulated; may be left out if an obstacle is a rigid body"),
    KEY(scene_keys, obstacles, LIST(obstacle_map, 0, 4096), .fallback = "[]",
        .meaning = "what cloth meets: fixed things, moving things, rigid bodies"),
    KEY(scene_keys, membrane, CHOICE(membrane_words, "woven"),
        .meaning = "what cloth is made of. woven: yarns of warp and weft, and shear, the same on "
                   "every mesh; springs: along the edges of the mesh, as in the paper"),
    KEY(scene_keys, on_overstretch, CHOICE(overstretch_words, "warn"), .beside = "membrane",
        .beside_choices = 1U << TULLE_MEMBRANE_WOVEN,
        .meaning = "what to do when a yarn of woven cloth is stretched beyond its material's "
                   "limit. warn: the run continues and reports it at its end; stop: the run fails"),
    KEY(scene_keys, contact, MAP(contact_map),
        .meaning = "contact distances, friction between cloths, detection and response"),
    KEY(scene_keys, solver, MAP(solver_map), .meaning = "time integration and its linear systems"),
    KEY_NAMED("render", scene_keys, picture, MAP(picture_map),
              .flags = SCHEMA_OPTIONAL | SCHEMA_PICTURE, .derived = "its defaults",
              .meaning = "how pictures look"),
};
const schema_map scene_map =
    MAP_OF(scene_table, scene_keys, .title = "Scene", .meaning = "The keys of the file itself.");
