/* step/step_model.h - what is constant while a step runs: objects, numbering, laws, the cloth's
 * model.
 *
 * All vertices share one numbering: cloths first, in the order they were added, then two slots for
 * each rigid body (bodies.h), then obstacles.
 * Surfaces are numbered the same way: surface i is cloth i, surface cloth_count + j is obstacle j.
 */
#ifndef TULLE_STEP_STEP_MODEL_H
#define TULLE_STEP_STEP_MODEL_H

#include "contact/response.h"
#include "detect/trees/broad_phase.h"
#include "dynamics/cloth_model.h"
#include "dynamics/rigid_body.h"
#include "geom/topology.h"
#include "step/motion.h"
#include "tulle/bodies.h"
#include "tulle/live.h"

enum { WORLD_NAME_BYTES = 80, WORLD_MESSAGE_BYTES = 1024 };

typedef struct world_pin {
    uint32_t *vertices; /* in the cloth's own numbering */
    size_t vertex_count;
    world_motion motion;
    double release_time; /* [s] */
    double *targets;     /* [m] 3 * vertex_count, for the next step; null: it has keyframes */
    bool has_targets;    /* they were given */
} world_pin;

/* What the host gave a driven obstacle for the next step. */
typedef enum given_move { GIVEN_NOTHING, GIVEN_MOVE, GIVEN_JUMP } given_move;

/* Owned positions and triangles, in the object's own numbering. Once the world has started there
 * are no positions of cloth that is not pinned. */
typedef struct world_mesh {
    double *positions; /* [m] */
    uint32_t *triangles;
    size_t vertex_count, triangle_count;
    double extent; /* [m] the largest coordinate, as given */
} world_mesh;

/* What a host says of an object apart from its def. */
typedef struct world_label {
    uint64_t def_hash; /* of the def with all its arrays */
    uint32_t category, mask;
    void *user_data;
} world_label;

typedef struct world_cloth {
    char name[WORLD_NAME_BYTES];
    world_label label;
    uint32_t slot;        /* of its id */
    world_mesh mesh;      /* start positions */
    double *rest;         /* [m] 3 * vertex_count; null once the world has started */
    double *velocities;   /* [m/s] at the start; null once the world has started */
    double *rest_corners; /* [m] 9 * triangle_count; null: the corners follow from `rest` */
    double *warps;        /* 3 * triangle_count; null: along the grain */
    double *factors;      /* triangle_count, on the stiffness; null: 1 */
    bool has_flat_rest;
    tulle_crease *creases; /* crease_count */
    size_t crease_count;
    tulle_material material;
    double grain[3];
    uint32_t contact_material; /* among the world's, or TULLE_NONE */
    double thickness;          /* [m] 0: not given */
    world_pin *pins;
    size_t pin_count;
    bool is_drawn;   /* targets were given for the next step: */
    double *targets; /* null, or [m] targets, targets with departures, marks of led vertices */
    uint32_t vertex_begin; /* in the world's numbering, set by the start */
} world_cloth;

/* Two frames of a mesh sequence. */
typedef struct frame_cache {
    double *positions[2]; /* [m] 3 * vertex_count */
    uint32_t numbers[2];  /* TULLE_NONE: none yet */
} frame_cache;

typedef struct world_obstacle {
    char name[WORLD_NAME_BYTES];
    world_label label;
    uint32_t slot;                                                             /* of its id */
    world_mesh mesh;                                                           /* at motion zero */
    double friction, dynamic_friction, restitution, friction_across, grain[3]; /* of the def */
    uint32_t contact_material;                                                 /* as of a cloth */
    world_motion motion; /* TULLE_DRIVE_RIGID: the motion of the step */
    tulle_drive drive;
    bool is_static; /* no script, no frames, no drive, not a rigid body */
    given_move given;
    motion_pose given_pose;       /* TULLE_DRIVE_RIGID: the pose that was given */
    double *given_positions;      /* null, or [m] at the end of the step; in a jump, at its start */
    bool has_jumped, was_present; /* in the present step; before it */
    tulle_frame_reader read_frame;
    void *frame_context;
    uint32_t frame_count;
    double frame_start_time, frame_interval; /* [s] */
    double appear_time, disappear_time;      /* [s] */
    frame_cache *frames;                     /* of the sequence; filled when a frame is read */
    tulle_body body;                /* as the def said; the members below are for rigid bodies */
    rigid_body rigid;               /* mass and moments */
    vec3 centre;                    /* [m] of mass, at motion zero */
    quaternion axes;                /* from the body's coordinates to the mesh's at motion zero */
    double *points;                 /* [m] vertices in the body's coordinates */
    double radius;                  /* [m] of the farthest vertex from the centre */
    vec3 given_force, given_torque; /* [N], [N m] for the next step */
    uint32_t vertex_begin;
} world_obstacle;

/* Drives and locks of a body; they hold until the host changes them (tulle/bodies.h). Plain data
 * without padding: saved and hashed as bytes. Zeroed: no drive and no lock. */
typedef struct body_control {
    tulle_body_drive drive;
    uint32_t locks;     /* bit k: axis k of body_drive */
    uint32_t is_driven; /* 0 or 1 */
} body_control;

typedef ARRAY(world_cloth) cloth_list;
typedef ARRAY(world_obstacle) obstacle_list;

/* The start makes it from the objects' defs. Between two steps the host may
 * change settings in it (gravity, wind, materials, laws, drives). */
typedef struct step_model {
    tulle_world_def def;
    tulle_paper_options paper; /* def.paper points here */
    cloth_list cloths;
    obstacle_list obstacles;
    size_t pin_count; /* of all cloths */

    size_t vertex_count, cloth_vertex_count;
    size_t particle_count; /* cloth vertices whose particle_state the response keeps: all or none */
    uint32_t cloth_edge_count; /* edges of all cloths come first */
    size_t plastic_count;      /* of sliders; 0 where no cloth has hysteresis */
    size_t pose_count;         /* all obstacles where one is driven as a whole, else 0 */
    size_t lag_vertex_count;   /* of all obstacles where one may lag (lag.h), else 0 */
    topology topo;
    size_t surface_count;
    uint32_t *vertex_surface; /* surface of each vertex */
    double *rest;             /* [m] all vertices */
    double *inverse_masses;   /* [1/kg] 0 for obstacles */
    cloth_model *cloth_model;

    size_t body_count;        /* each has two slots after the cloth vertices, see bodies.h */
    uint32_t *surface_bodies; /* number of each surface's body, or TULLE_NONE; null: no bodies */
    uint32_t *body_obstacles; /* obstacle of each body */
    body_control *controls;   /* per body */
    bool has_sleep;           /* a body or cloth may sleep */
    size_t cloth_rest_count;  /* all cloths where they may sleep, else 0 */

    unsigned char *collides;   /* surface_count^2, as in `set`; null: all */
    contact_law *laws;         /* surface_count^2 */
    surface_grain *grains;     /* surface_count; null: none */
    double *rooms, *automatic; /* as of contact_scene; null: there is room everywhere */
    double contact_distance, separation_distance, minimum_gap; /* [m] */
    double edge_length;                                        /* [m] mean over all cloth */
    double height_share; /* lowest height over the height that counts as low; 1: none is low */
} step_model;

static inline const char *world_surface_name(const step_model *model, size_t surface) {
    size_t const cloth_count = model->cloths.count;
    return surface < cloth_count ? model->cloths.data[surface].name
                                 : model->obstacles.data[surface - cloth_count].name;
}

static inline const world_mesh *world_surface_mesh(const step_model *model, size_t surface) {
    size_t const cloth_count = model->cloths.count;
    return surface < cloth_count ? &model->cloths.data[surface].mesh
                                 : &model->obstacles.data[surface - cloth_count].mesh;
}

/* Whether features of two surfaces are held apart at all: the host may have excluded the pair. */
static inline bool world_pair_collides(const step_model *model, size_t a, size_t b) {
    return !model->collides || model->collides[a * model->surface_count + b];
}

static inline world_label *world_get_label(const step_model *model, size_t surface) {
    size_t const cloth_count = model->cloths.count;
    return surface < cloth_count ? &model->cloths.data[surface].label
                                 : &model->obstacles.data[surface - cloth_count].label;
}

/* The most candidates that a search lists. If there are more, paths are too long for a substep, or
 * meshes too fine. */
#define MOST_CANDIDATES(model) (256 * (uint64_t)(model)->vertex_count + (1 << 20))

#endif
