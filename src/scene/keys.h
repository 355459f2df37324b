/* scene/keys.h - the structs that the table of keys fills, one for each map of a scene file. Field
 * meanings, units and ranges are in the table (keys.c) and docs/guide/scene.md. */
#ifndef TULLE_SCENE_KEYS_H
#define TULLE_SCENE_KEYS_H

#include "scene/schema.h"

typedef struct time_keys {
    schema_head head;
    double step, duration;
    uint64_t frames, steps_per_frame;
} time_keys;

typedef struct wind_keys {
    schema_head head;
    schema_vector velocity;
    double gust_strength, gust_length, gust_time, drag;
    uint64_t seed;
} wind_keys;

typedef struct mesh_keys {
    schema_head head;
    const char *file;
    int shape;
    schema_vector size;
    double radius, inner_radius, height, tip_height, head_radius, head_height, angle, strand,
        wavelength;
    schema_integers resolution, cells;
    uint64_t strand_resolution, seed;
    bool irregular;
} mesh_keys;

typedef struct curve_keys {
    schema_head head;
    double stiffness, knee, limit;
} curve_keys;

typedef struct material_keys {
    schema_head head;
    const char *file, *preset, *name, *source;
    double area_density;
    curve_keys warp, weft, shear;
    double poisson, bend_warp, bend_weft, bend_twist;
    double bend_hysteresis_warp, bend_hysteresis_weft, shear_hysteresis;
    double stretch, bend, stiffening_strain;
    double stretch_damping, bend_damping, air_damping;
    double friction, dynamic_friction, restitution, friction_across;
} material_keys;

/* Values of rest_keys.folds. */
enum { REST_FOLDS_KEEP, REST_FOLDS_FLAT };

typedef struct rest_keys {
    schema_head head;
    const char *file;
    double uv, shrink;
    int folds;
    schema_list creases;
} rest_keys;

typedef struct keyframe_keys {
    schema_head head;
    double time;
    schema_vector translate;
    schema_rotation rotate;
} keyframe_keys;

typedef struct box_keys {
    schema_head head;
    schema_vector min, max;
} box_keys;

typedef struct line_keys {
    schema_head head;
    schema_vector from, to;
    double radius;
} line_keys;

typedef struct sphere_keys {
    schema_head head;
    schema_vector center;
    double radius;
} sphere_keys;

typedef struct near_keys {
    schema_head head;
    const char *to;
    double within;
} near_keys;

/* Which vertices an entry means: one of them is given. */
typedef struct choice_keys {
    box_keys box;
    line_keys line;
    sphere_keys sphere;
    near_keys near;
    const char *group, *material;
    schema_indices vertices;
    schema_vector nearest;
} choice_keys;

typedef struct pin_keys {
    schema_head head;
    choice_keys where;
    schema_list keyframes;
    bool eased;
    schema_vector pivot;
    double release;
} pin_keys;

typedef struct attach_keys {
    schema_head head;
    choice_keys where;
    const char *to;
    double within, stiffness, breaks_at, release;
} attach_keys;

typedef struct crease_keys {
    schema_head head;
    choice_keys where;
    double angle;
} crease_keys;

typedef struct region_keys {
    schema_head head;
    choice_keys where;
    double shrink, stiffness;
    schema_vector grain;
} region_keys;

typedef enum place_up { UP_Z, UP_Y, UP_X } place_up;

typedef struct place_keys {
    schema_head head;
    int up; /* place_up */
    double size, height;
    bool center;
    double on;
    const char *on_top_of, *as;
} place_keys;

typedef struct cloth_keys {
    schema_head head;
    const char *name;
    mesh_keys mesh;
    schema_vector scale, translate, velocity;
    schema_rotation rotate;
    place_keys place;
    material_keys material;
    rest_keys rest;
    schema_vector grain, grain_uv;
    const char *stiffness_file;
    double thickness;
    schema_list regions, pins, attach;
    schema_vector color, back_color;
    int pattern;
    double pattern_size;
} cloth_keys;

typedef enum sequence_loop { LOOP_ONCE, LOOP_REPEAT, LOOP_PINGPONG } sequence_loop;

typedef struct sequence_keys {
    schema_head head;
    const char *files, *cache;
    uint64_t first, last;
    double interval, fps, speed, start;
    int loop; /* sequence_loop */
} sequence_keys;

typedef struct motion_keys {
    schema_head head;
    schema_list keyframes;
    sequence_keys sequence;
    bool eased;
    schema_vector pivot;
} motion_keys;

typedef struct row_keys {
    schema_head head;
    uint64_t count;
    schema_vector offset;
} row_keys;

typedef struct grid_keys {
    schema_head head;
    schema_integers count;
    schema_vector spacing;
} grid_keys;

typedef struct ring_keys {
    schema_head head;
    uint64_t count;
    double radius, from;
} ring_keys;

typedef struct spiral_keys {
    schema_head head;
    uint64_t count;
    double radius, from, to, turns;
} spiral_keys;

typedef enum stagger_order { STAGGER_FIRST_TO_LAST, STAGGER_LAST_TO_FIRST } stagger_order;

typedef struct copies_keys {
    schema_head head;
    row_keys row;
    grid_keys grid;
    ring_keys ring;
    spiral_keys spiral;
    double stagger;
    int order; /* stagger_order */
} copies_keys;

typedef struct dynamic_keys {
    schema_head head;
    double mass, density, area_density, linear_damping, angular_damping, start;
    double sleep_speed, sleep_time;
    schema_vector velocity, spin;
} dynamic_keys;

typedef struct obstacle_keys {
    schema_head head;
    const char *name;
    mesh_keys mesh;
    schema_vector scale, translate;
    schema_rotation rotate;
    place_keys place;
    const char *material;
    double friction, dynamic_friction, restitution, friction_across, appears, disappears;
    schema_vector grain;
    motion_keys motion;
    dynamic_keys dynamic;
    copies_keys copies;
    schema_vector color;
    bool hidden;
} obstacle_keys;

/* The law of two objects, or of two materials. */
typedef struct pair_keys {
    schema_head head;
    schema_names between;
    double friction, dynamic_friction, restitution;
} pair_keys;

typedef struct contact_keys {
    schema_head head;
    double delta_c, delta_s, xi, friction, dynamic_friction;
    int response, motion_space;
    int method, cone, certificate, patches; /* see build_world.c */
    double alpha_max;
    int start_intersections, on_pinch;
    uint64_t untangle_limit, impact_rounds;
    schema_list pairs, materials;
} contact_keys;

typedef struct solver_keys {
    schema_head head;
    int integrator, quality;
    double cg_tolerance;
    uint64_t cg_iterations, rounds, sweeps;
    double sleep_speed, sleep_time;
} solver_keys;

typedef struct camera_keys {
    schema_head head;
    schema_vector position, orbit, target;
    double distance, field_of_view, turn;
} camera_keys;

typedef struct picture_keys {
    schema_head head;
    camera_keys camera;
    int floor; /* scene_floor */
    double exposure;
} picture_keys;

typedef struct scene_keys {
    schema_head head;
    const char *title;
    uint64_t seed;
    time_keys time;
    schema_vector gravity;
    wind_keys wind;
    schema_list cloth, obstacles;
    int membrane;       /* tulle_membrane */
    int on_overstretch; /* tulle_on_overstretch */
    contact_keys contact;
    solver_keys solver;
    picture_keys picture;
} scene_keys;

extern const schema_map scene_map, time_map, wind_map, mesh_map, curve_map, material_map, rest_map,
    keyframe_map, box_map, line_map, sphere_map, near_map, pin_map, attach_map, region_map,
    crease_map, cloth_map, place_map, sequence_map, motion_map, dynamic_map, row_map, grid_map,
    ring_map, spiral_map, copies_map, obstacle_map, pair_map, material_pair_map, contact_map,
    solver_map, camera_map, picture_map;

/* An integer that stands for "derived from the scene's seed". */
#define SEED_AUTO ((uint64_t)1 << 60)

/* Whether a shape takes two or three numbers as its size; 0: none. */
size_t shape_size_count(int shape);
/* How many resolutions a shape takes: 2, 1, or 0. */
size_t shape_resolution_count(int shape);

#endif
