/* world/fields/field_rows.c - the values of all defs of a world. Made by tools/make_fields.py
 * of the comments of the public headers; not to be edited. */
/* clang-format off */
#include "world/fields/fields.h"

#include "tulle/tulle.h"

#include <float.h>
#include <math.h>

#define AT(type, member) .name = #member, .offset = offsetof(type, member)
#define ITEMS(type, member, words) .is_array = true, .length = offsetof(type, member), .item = (words)
#define IN(low, high) .least = (low), .most = (high), .range = #low " to " #high
#define ZERO_OR(low, high) .takes_zero = true, .least = (low), .most = (high), .range = "0 or " #low " to " #high
#define ABOVE_ZERO(high) .least = DBL_TRUE_MIN, .most = (high), .range = "above 0 to " #high
#define UP_TO(high) .least = -(double)INFINITY, .most = (high), .range = "at most " #high
#define FINITE .least = -DBL_MAX, .most = DBL_MAX, .range = "finite"
#define ANY .least = -(double)INFINITY, .most = (double)INFINITY, .range = "a number"
#define CHOICE(first, last) .least = (first), .most = (last), .range = #first " to " #last

static const field_table mesh_view_fields = {"tulle_mesh_view", 4, sizeof(tulle_mesh_view), 0, (const field[]){
    {AT(tulle_mesh_view, positions), .kind = FIELD_DOUBLE, .count = 3, ITEMS(tulle_mesh_view, vertex_count, "vertex"), IN(-1e100, 1e100), .unit = "m"},
    {AT(tulle_mesh_view, vertex_count), .kind = FIELD_LENGTH, .count = 1, IN(1, 2147483647)},
    {AT(tulle_mesh_view, triangles), .kind = FIELD_U32, .count = 3, ITEMS(tulle_mesh_view, triangle_count, "triangle")},
    {AT(tulle_mesh_view, triangle_count), .kind = FIELD_LENGTH, .count = 1, IN(0, 2147483647)},
}};
const field_table wind_fields = {"tulle_wind", 6, sizeof(tulle_wind), 0, (const field[]){
    {AT(tulle_wind, velocity), .kind = FIELD_DOUBLE, .count = 3, IN(-1e6, 1e6), .unit = "m/s"},
    {AT(tulle_wind, gust_strength), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e6), .unit = "m/s"},
    {AT(tulle_wind, gust_length), .kind = FIELD_DOUBLE, .count = 1, IN(1e-6, 1e6), .unit = "m", .fallback = {0.5}},
    {AT(tulle_wind, gust_time), .kind = FIELD_DOUBLE, .count = 1, IN(1e-6, 1e6), .unit = "s", .fallback = {0.5}},
    {AT(tulle_wind, seed), .kind = FIELD_U64, .count = 1, .fallback = {1}},
    {AT(tulle_wind, drag_coefficient), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e6), .unit = "kg/m^3", .fallback = {0.7}},
}};
static const field_table world_detection_fields = {"tulle_world_detection", 5, sizeof(tulle_world_detection), 0, (const field[]){
    {AT(tulle_world_detection, method), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_DETECT_PATCHES, TULLE_DETECT_PAPER)},
    {AT(tulle_world_detection, cone), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_CONE_BERNSTEIN, TULLE_CONE_PAPER)},
    {AT(tulle_world_detection, max_angle), .kind = FIELD_DOUBLE, .count = 1, ABOVE_ZERO(1.570795), .unit = "rad", .fallback = {0.7853981633974483}},
    {AT(tulle_world_detection, has_certificate), .kind = FIELD_INT, .count = 1, .fallback = {1}},
    {AT(tulle_world_detection, grows_patches_anew), .kind = FIELD_INT, .count = 1},
}};
const field_table paper_options_fields = {"tulle_paper_options", 8, sizeof(tulle_paper_options), 0xdee89eda, (const field[]){
    {AT(tulle_paper_options, detection), .kind = FIELD_STRUCT, .count = 1, .inner = &world_detection_fields},
    {AT(tulle_paper_options, response), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_RESPONSE_COUPLED, TULLE_RESPONSE_PAPER)},
    {AT(tulle_paper_options, motion_space), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_MOTION_SPACE_CONE, TULLE_MOTION_SPACE_POLYHEDRAL), .fallback = {1}},
    {AT(tulle_paper_options, cg_tolerance), .kind = FIELD_DOUBLE, .count = 1, IN(1e-12, 0.1), .fallback = {0.0001}},
    {AT(tulle_paper_options, cg_max_iterations), .kind = FIELD_INT, .count = 1, IN(1, 1e6), .fallback = {5000}},
    {AT(tulle_paper_options, solve_rounds), .kind = FIELD_INT, .count = 1, IN(1, 20), .fallback = {1}},
    {AT(tulle_paper_options, impulse_sweeps), .kind = FIELD_INT, .count = 1, IN(1, 1000), .fallback = {10}},
    {AT(tulle_paper_options, impact_rounds), .kind = FIELD_INT, .count = 1, IN(0, 100), .fallback = {5}},
}};
const field_table world_def_fields = {"tulle_world_def", 19, sizeof(tulle_world_def), 0xd5a70a56, (const field[]){
    {AT(tulle_world_def, gravity), .kind = FIELD_DOUBLE, .count = 3, IN(-1e6, 1e6), .unit = "m/s^2", .fallback = {0, 0, -9.81}},
    {AT(tulle_world_def, wind), .kind = FIELD_STRUCT, .count = 1, .inner = &wind_fields},
    {AT(tulle_world_def, contact_distance), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1), .unit = "m"},
    {AT(tulle_world_def, separation_distance), .kind = FIELD_DOUBLE, .count = 1, IN(0, 2), .unit = "m"},
    {AT(tulle_world_def, minimum_gap), .kind = FIELD_DOUBLE, .count = 1, IN(0, 0.5), .unit = "m"},
    {AT(tulle_world_def, integrator), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_INTEGRATOR_IMPLICIT_EULER, TULLE_INTEGRATOR_BDF2)},
    {AT(tulle_world_def, membrane), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_MEMBRANE_WOVEN, TULLE_MEMBRANE_SPRINGS)},
    {AT(tulle_world_def, on_overstretch), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_ON_OVERSTRETCH_WARN, TULLE_ON_OVERSTRETCH_STOP)},
    {AT(tulle_world_def, quality), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_QUALITY_DRAFT, TULLE_QUALITY_EXACT), .fallback = {1}},
    {AT(tulle_world_def, friction_cloth_cloth), .kind = FIELD_DOUBLE, .count = 1, IN(0, 10), .fallback = {0.3}},
    {AT(tulle_world_def, dynamic_friction_cloth_cloth), .kind = FIELD_DOUBLE, .count = 1, UP_TO(10), .fallback = {-1}},
    {AT(tulle_world_def, sleep_speed), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1000), .unit = "m/s"},
    {AT(tulle_world_def, sleep_time), .kind = FIELD_DOUBLE, .count = 1, IN(1e-12, 1e6), .unit = "s", .fallback = {0.5}},
    {AT(tulle_world_def, start_intersections), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_START_REFUSE, TULLE_START_UNTANGLE)},
    {AT(tulle_world_def, untangle_limit), .kind = FIELD_INT, .count = 1, IN(1, 1e6), .fallback = {2000}},
    {AT(tulle_world_def, on_pinch), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_ON_PINCH_STOP, TULLE_ON_PINCH_LAG), .fallback = {2}},
    {AT(tulle_world_def, paper), .kind = FIELD_STRUCT, .count = 1, .is_pointer = true, .inner = &paper_options_fields},
    {AT(tulle_world_def, threads), .kind = FIELD_INT, .count = 1, IN(0, 256), .group = "the host's"},
    {AT(tulle_world_def, allocator), .kind = FIELD_HOST},
}};
static const field_table curve_fields = {"tulle_curve", 3, sizeof(tulle_curve), 0, (const field[]){
    {AT(tulle_curve, stiffness), .kind = FIELD_DOUBLE, .count = 1, IN(1e-12, 1e12), .unit = "N/m"},
    {AT(tulle_curve, knee), .kind = FIELD_DOUBLE, .count = 1, ZERO_OR(1e-3, 1e6)},
    {AT(tulle_curve, limit), .kind = FIELD_DOUBLE, .count = 1, IN(1e-3, 1e6)},
}};
static const field_table springs_fields = {"tulle_springs", 3, sizeof(tulle_springs), 0, (const field[]){
    {AT(tulle_springs, stretch_stiffness), .kind = FIELD_DOUBLE, .count = 1, IN(1e-12, 1e12), .unit = "N/m"},
    {AT(tulle_springs, bend_stiffness), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e9), .unit = "N m"},
    {AT(tulle_springs, stiffening_strain), .kind = FIELD_DOUBLE, .count = 1, ZERO_OR(1e-3, 1e6)},
}};
const field_table material_fields = {"tulle_material", 19, sizeof(tulle_material), 0, (const field[]){
    {AT(tulle_material, area_density), .kind = FIELD_DOUBLE, .count = 1, IN(1e-12, 1e6), .unit = "kg/m^2"},
    {AT(tulle_material, warp), .kind = FIELD_STRUCT, .count = 1, .inner = &curve_fields, .group = "woven cloth"},
    {AT(tulle_material, weft), .kind = FIELD_STRUCT, .count = 1, .inner = &curve_fields, .group = "woven cloth"},
    {AT(tulle_material, shear), .kind = FIELD_STRUCT, .count = 1, .inner = &curve_fields, .group = "woven cloth"},
    {AT(tulle_material, poisson), .kind = FIELD_DOUBLE, .count = 1, IN(-0.9, 0.9), .group = "woven cloth"},
    {AT(tulle_material, bend_warp), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e9), .unit = "N m", .group = "woven cloth"},
    {AT(tulle_material, bend_weft), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e9), .unit = "N m", .group = "woven cloth"},
    {AT(tulle_material, bend_twist), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e9), .unit = "N m", .group = "woven cloth"},
    {AT(tulle_material, bend_hysteresis_warp), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e15), .unit = "N", .group = "woven cloth"},
    {AT(tulle_material, bend_hysteresis_weft), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e15), .unit = "N", .group = "woven cloth"},
    {AT(tulle_material, shear_hysteresis), .kind = FIELD_DOUBLE, .count = 1, IN(0, 2e12), .unit = "N/m", .group = "woven cloth"},
    {AT(tulle_material, springs), .kind = FIELD_STRUCT, .count = 1, .inner = &springs_fields, .group = "cloth of springs"},
    {AT(tulle_material, stretch_damping), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e6), .unit = "s", .group = "damping"},
    {AT(tulle_material, bend_damping), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e6), .unit = "s", .group = "damping"},
    {AT(tulle_material, air_damping), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e6), .unit = "1/s", .group = "damping"},
    {AT(tulle_material, friction), .kind = FIELD_DOUBLE, .count = 1, IN(0, 10), .group = "damping"},
    {AT(tulle_material, dynamic_friction), .kind = FIELD_DOUBLE, .count = 1, UP_TO(10), .group = "damping"},
    {AT(tulle_material, restitution), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1), .group = "damping"},
    {AT(tulle_material, friction_across), .kind = FIELD_DOUBLE, .count = 1, IN(0, 10), .group = "damping"},
}};
static const field_table keyframe_fields = {"tulle_keyframe", 3, sizeof(tulle_keyframe), 0, (const field[]){
    {AT(tulle_keyframe, time), .kind = FIELD_DOUBLE, .count = 1, FINITE, .unit = "s"},
    {AT(tulle_keyframe, translation), .kind = FIELD_DOUBLE, .count = 3, FINITE, .unit = "m"},
    {AT(tulle_keyframe, rotation_vector), .kind = FIELD_DOUBLE, .count = 3, FINITE, .unit = "rad"},
}};
static const field_table motion_fields = {"tulle_motion", 4, sizeof(tulle_motion), 0, (const field[]){
    {AT(tulle_motion, keys), .kind = FIELD_STRUCT, .count = 1, ITEMS(tulle_motion, key_count, "key"), .inner = &keyframe_fields},
    {AT(tulle_motion, key_count), .kind = FIELD_LENGTH, .count = 1},
    {AT(tulle_motion, pivot), .kind = FIELD_DOUBLE, .count = 3, FINITE, .unit = "m"},
    {AT(tulle_motion, is_eased), .kind = FIELD_INT, .count = 1},
}};
const field_table pin_fields = {"tulle_pin", 4, sizeof(tulle_pin), 0x1dc27f3c, (const field[]){
    {AT(tulle_pin, vertices), .kind = FIELD_U32, .count = 1, ITEMS(tulle_pin, vertex_count, "vertex")},
    {AT(tulle_pin, vertex_count), .kind = FIELD_LENGTH, .count = 1},
    {AT(tulle_pin, motion), .kind = FIELD_STRUCT, .count = 1, .inner = &motion_fields},
    {AT(tulle_pin, release_time), .kind = FIELD_DOUBLE, .count = 1, ANY, .unit = "s", .fallback = {INFINITY}},
}};
static const field_table crease_fields = {"tulle_crease", 2, sizeof(tulle_crease), 0, (const field[]){
    {AT(tulle_crease, vertices), .kind = FIELD_U32, .count = 2},
    {AT(tulle_crease, angle), .kind = FIELD_DOUBLE, .count = 1, IN(-3, 3), .unit = "rad"},
}};
const field_table cloth_def_fields = {"tulle_cloth_def", 17, sizeof(tulle_cloth_def), 0x356f9b8e, (const field[]){
    {AT(tulle_cloth_def, name), .kind = FIELD_TEXT},
    {AT(tulle_cloth_def, mesh), .kind = FIELD_STRUCT, .count = 1, .inner = &mesh_view_fields},
    {AT(tulle_cloth_def, rest_positions), .kind = FIELD_DOUBLE, .count = 3, ITEMS(tulle_cloth_def, mesh.vertex_count, "vertex"), IN(-1e6, 1e6), .unit = "m"},
    {AT(tulle_cloth_def, rest_corners), .kind = FIELD_DOUBLE, .count = 9, ITEMS(tulle_cloth_def, mesh.triangle_count, "triangle"), IN(-1e6, 1e6), .unit = "m"},
    {AT(tulle_cloth_def, has_flat_rest), .kind = FIELD_INT, .count = 1},
    {AT(tulle_cloth_def, creases), .kind = FIELD_STRUCT, .count = 1, ITEMS(tulle_cloth_def, crease_count, "crease"), .inner = &crease_fields},
    {AT(tulle_cloth_def, crease_count), .kind = FIELD_LENGTH, .count = 1},
    {AT(tulle_cloth_def, material), .kind = FIELD_STRUCT, .count = 1, .inner = &material_fields},
    {AT(tulle_cloth_def, grain), .kind = FIELD_DOUBLE, .count = 3, IN(-1e6, 1e6), .fallback = {1, 0, 0}},
    {AT(tulle_cloth_def, warps), .kind = FIELD_DOUBLE, .count = 3, ITEMS(tulle_cloth_def, mesh.triangle_count, "triangle"), IN(-1e6, 1e6)},
    {AT(tulle_cloth_def, stiffness_factors), .kind = FIELD_DOUBLE, .count = 1, ITEMS(tulle_cloth_def, mesh.triangle_count, "triangle"), IN(0.01, 100)},
    {AT(tulle_cloth_def, contact_material), .kind = FIELD_TEXT},
    {AT(tulle_cloth_def, thickness), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1), .unit = "m"},
    {AT(tulle_cloth_def, pins), .kind = FIELD_STRUCT, .count = 1, ITEMS(tulle_cloth_def, pin_count, "pin"), .inner = &pin_fields},
    {AT(tulle_cloth_def, pin_count), .kind = FIELD_LENGTH, .count = 1},
    {AT(tulle_cloth_def, velocity), .kind = FIELD_DOUBLE, .count = 3, IN(-1e6, 1e6), .unit = "m/s"},
    {AT(tulle_cloth_def, velocities), .kind = FIELD_DOUBLE, .count = 3, ITEMS(tulle_cloth_def, mesh.vertex_count, "vertex"), FINITE, .unit = "m/s"},
}};
static const field_table body_fields = {"tulle_body", 11, sizeof(tulle_body), 0, (const field[]){
    {AT(tulle_body, is_dynamic), .kind = FIELD_INT, .count = 1},
    {AT(tulle_body, mass), .kind = FIELD_DOUBLE, .count = 1, ZERO_OR(1e-12, 1e12), .unit = "kg"},
    {AT(tulle_body, density), .kind = FIELD_DOUBLE, .count = 1, ZERO_OR(1e-12, 1e12), .unit = "kg/m^3"},
    {AT(tulle_body, area_density), .kind = FIELD_DOUBLE, .count = 1, ZERO_OR(1e-12, 1e12), .unit = "kg/m^2"},
    {AT(tulle_body, velocity), .kind = FIELD_DOUBLE, .count = 3, IN(-1e6, 1e6), .unit = "m/s"},
    {AT(tulle_body, angular_velocity), .kind = FIELD_DOUBLE, .count = 3, IN(-1e6, 1e6), .unit = "rad/s"},
    {AT(tulle_body, linear_damping), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e6), .unit = "1/s"},
    {AT(tulle_body, angular_damping), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e6), .unit = "1/s"},
    {AT(tulle_body, start_time), .kind = FIELD_DOUBLE, .count = 1, ANY, .unit = "s"},
    {AT(tulle_body, sleep_speed), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e6), .unit = "m/s"},
    {AT(tulle_body, sleep_time), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e6), .unit = "s"},
}};
const field_table obstacle_def_fields = {"tulle_obstacle_def", 18, sizeof(tulle_obstacle_def), 0xe89ddc6e, (const field[]){
    {AT(tulle_obstacle_def, name), .kind = FIELD_TEXT},
    {AT(tulle_obstacle_def, mesh), .kind = FIELD_STRUCT, .count = 1, .inner = &mesh_view_fields},
    {AT(tulle_obstacle_def, friction), .kind = FIELD_DOUBLE, .count = 1, IN(0, 10), .fallback = {0.3}},
    {AT(tulle_obstacle_def, dynamic_friction), .kind = FIELD_DOUBLE, .count = 1, UP_TO(10), .fallback = {-1}},
    {AT(tulle_obstacle_def, restitution), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1)},
    {AT(tulle_obstacle_def, friction_across), .kind = FIELD_DOUBLE, .count = 1, IN(0, 10), .fallback = {1}},
    {AT(tulle_obstacle_def, grain), .kind = FIELD_DOUBLE, .count = 3, IN(-1e6, 1e6), .fallback = {1, 0, 0}},
    {AT(tulle_obstacle_def, contact_material), .kind = FIELD_TEXT},
    {AT(tulle_obstacle_def, motion), .kind = FIELD_STRUCT, .count = 1, .inner = &motion_fields},
    {AT(tulle_obstacle_def, drive), .kind = FIELD_ENUM, .count = 1, CHOICE(TULLE_DRIVE_NONE, TULLE_DRIVE_DEFORMING)},
    {AT(tulle_obstacle_def, read_frame), .kind = FIELD_CALL},
    {AT(tulle_obstacle_def, frame_context), .kind = FIELD_HOST},
    {AT(tulle_obstacle_def, frame_count), .kind = FIELD_U32, .count = 1, IN(0, 1e9)},
    {AT(tulle_obstacle_def, frame_start_time), .kind = FIELD_DOUBLE, .count = 1, IN(-1e6, 1e6), .unit = "s"},
    {AT(tulle_obstacle_def, frame_interval), .kind = FIELD_DOUBLE, .count = 1, IN(1e-9, 1e6), .unit = "s", .fallback = {0.041666666666666664}},
    {AT(tulle_obstacle_def, appear_time), .kind = FIELD_DOUBLE, .count = 1, ANY, .unit = "s", .fallback = {-INFINITY}},
    {AT(tulle_obstacle_def, disappear_time), .kind = FIELD_DOUBLE, .count = 1, ANY, .unit = "s", .fallback = {INFINITY}},
    {AT(tulle_obstacle_def, body), .kind = FIELD_STRUCT, .count = 1, .inner = &body_fields},
}};
const field_table contact_law_fields = {"tulle_contact_law", 3, sizeof(tulle_contact_law), 0, (const field[]){
    {AT(tulle_contact_law, static_friction), .kind = FIELD_DOUBLE, .count = 1, IN(0, 10)},
    {AT(tulle_contact_law, dynamic_friction), .kind = FIELD_DOUBLE, .count = 1, UP_TO(10)},
    {AT(tulle_contact_law, restitution), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1)},
}};
const field_table attachment_def_fields = {"tulle_attachment_def", 12, sizeof(tulle_attachment_def), 0xa33164fe, (const field[]){
    {AT(tulle_attachment_def, cloth), .kind = FIELD_U32, .count = 2},
    {AT(tulle_attachment_def, vertices), .kind = FIELD_U32, .count = 1, ITEMS(tulle_attachment_def, vertex_count, "vertex")},
    {AT(tulle_attachment_def, vertex_count), .kind = FIELD_LENGTH, .count = 1},
    {AT(tulle_attachment_def, obstacle), .kind = FIELD_U32, .count = 2},
    {AT(tulle_attachment_def, other_cloth), .kind = FIELD_U32, .count = 2},
    {AT(tulle_attachment_def, points), .kind = FIELD_DOUBLE, .count = 3, ITEMS(tulle_attachment_def, vertex_count, "vertex"), IN(-1e100, 1e100), .unit = "m"},
    {AT(tulle_attachment_def, triangles), .kind = FIELD_U32, .count = 1, ITEMS(tulle_attachment_def, vertex_count, "vertex")},
    {AT(tulle_attachment_def, weights), .kind = FIELD_DOUBLE, .count = 3, ITEMS(tulle_attachment_def, vertex_count, "vertex"), IN(-1e6, 1e6)},
    {AT(tulle_attachment_def, max_distance), .kind = FIELD_DOUBLE, .count = 1, ABOVE_ZERO(INFINITY), .unit = "m", .fallback = {INFINITY}},
    {AT(tulle_attachment_def, stiffness), .kind = FIELD_DOUBLE, .count = 1, ABOVE_ZERO(INFINITY), .unit = "N/m", .fallback = {INFINITY}},
    {AT(tulle_attachment_def, break_force), .kind = FIELD_DOUBLE, .count = 1, ABOVE_ZERO(INFINITY), .unit = "N", .fallback = {INFINITY}},
    {AT(tulle_attachment_def, release_time), .kind = FIELD_DOUBLE, .count = 1, ANY, .unit = "s", .fallback = {INFINITY}},
}};
const field_table body_drive_fields = {"tulle_body_drive", 10, sizeof(tulle_body_drive), 0, (const field[]){
    {AT(tulle_body_drive, position), .kind = FIELD_DOUBLE, .count = 3, IN(-1e100, 1e100), .unit = "m"},
    {AT(tulle_body_drive, rotation), .kind = FIELD_DOUBLE, .count = 4, IN(-2, 2), .fallback = {1, 0, 0, 0}},
    {AT(tulle_body_drive, velocity), .kind = FIELD_DOUBLE, .count = 3, IN(-1e6, 1e6), .unit = "m/s"},
    {AT(tulle_body_drive, angular_velocity), .kind = FIELD_DOUBLE, .count = 3, IN(-1e6, 1e6), .unit = "rad/s"},
    {AT(tulle_body_drive, stiffness), .kind = FIELD_DOUBLE, .count = 3, IN(0, 1e12), .unit = "N/m"},
    {AT(tulle_body_drive, damping), .kind = FIELD_DOUBLE, .count = 3, IN(0, 1e12), .unit = "N s/m"},
    {AT(tulle_body_drive, force_limit), .kind = FIELD_DOUBLE, .count = 3, IN(0, INFINITY), .unit = "N", .fallback = {INFINITY, INFINITY, INFINITY}},
    {AT(tulle_body_drive, angular_stiffness), .kind = FIELD_DOUBLE, .count = 3, IN(0, 1e12), .unit = "N m/rad"},
    {AT(tulle_body_drive, angular_damping), .kind = FIELD_DOUBLE, .count = 3, IN(0, 1e12), .unit = "N m s/rad"},
    {AT(tulle_body_drive, torque_limit), .kind = FIELD_DOUBLE, .count = 3, IN(0, INFINITY), .unit = "N m", .fallback = {INFINITY, INFINITY, INFINITY}},
}};
const field_table event_watch_fields = {"tulle_event_watch", 3, sizeof(tulle_event_watch), 0, (const field[]){
    {AT(tulle_event_watch, kinds), .kind = FIELD_U32, .count = 1, IN(1, 4095), .fallback = {4095}},
    {AT(tulle_event_watch, contact_force), .kind = FIELD_DOUBLE, .count = 1, IN(0, 1e300), .unit = "N"},
    {AT(tulle_event_watch, capacity), .kind = FIELD_SIZE, .count = 1, IN(1, 16777216), .fallback = {1024}},
}};

const uint32_t fields_version = 0x9f027d92;

#define SIZE(type) {#type, sizeof(type)}
const struct_size struct_sizes[] = {
    SIZE(tulle_allocator), SIZE(tulle_attachment_def), SIZE(tulle_attachment_report), SIZE(tulle_body),
    SIZE(tulle_body_drive), SIZE(tulle_check_body), SIZE(tulle_check_pair), SIZE(tulle_check_result),
    SIZE(tulle_cloth_def), SIZE(tulle_cloth_id), SIZE(tulle_cloth_targets), SIZE(tulle_contact),
    SIZE(tulle_contact_law), SIZE(tulle_counts), SIZE(tulle_crease), SIZE(tulle_curve),
    SIZE(tulle_detect_def), SIZE(tulle_detect_event), SIZE(tulle_detect_receiver), SIZE(tulle_detect_result),
    SIZE(tulle_detect_statistics), SIZE(tulle_detect_surface), SIZE(tulle_error), SIZE(tulle_event),
    SIZE(tulle_event_watch), SIZE(tulle_fineness), SIZE(tulle_found), SIZE(tulle_found_triangle),
    SIZE(tulle_hit), SIZE(tulle_intersection), SIZE(tulle_keyframe), SIZE(tulle_material),
    SIZE(tulle_mesh), SIZE(tulle_mesh_duplicates), SIZE(tulle_mesh_info), SIZE(tulle_mesh_lines),
    SIZE(tulle_mesh_repairs), SIZE(tulle_mesh_view), SIZE(tulle_moment), SIZE(tulle_motion),
    SIZE(tulle_object_id), SIZE(tulle_object_info), SIZE(tulle_obstacle_def), SIZE(tulle_obstacle_id),
    SIZE(tulle_overlap), SIZE(tulle_paper_options), SIZE(tulle_patch_options), SIZE(tulle_pin),
    SIZE(tulle_ray), SIZE(tulle_record_writer), SIZE(tulle_replay_options), SIZE(tulle_replay_report),
    SIZE(tulle_shape_def), SIZE(tulle_springs), SIZE(tulle_step_progress), SIZE(tulle_step_report),
    SIZE(tulle_stretch), SIZE(tulle_target), SIZE(tulle_tasks), SIZE(tulle_transform),
    SIZE(tulle_untangle_report), SIZE(tulle_wind), SIZE(tulle_world_batch), SIZE(tulle_world_def),
    SIZE(tulle_world_detection),
};
const size_t struct_size_count = sizeof struct_sizes / sizeof struct_sizes[0];
