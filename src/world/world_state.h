/* world/world_state.h - the insides of tulle_world, for the files of world/ alone.
 *
 * All vertices share one numbering: cloths first, in the order they were added, then two slots for
 * each rigid body (bodies.h), then obstacles.
 * Surfaces are numbered the same way: surface i is cloth i, surface cloth_count + j is obstacle j.
 */
#ifndef TULLE_WORLD_WORLD_STATE_H
#define TULLE_WORLD_WORLD_STATE_H

#include "base/arena.h"
#include "contact/response.h"
#include "contact/rows/contact_store.h"
#include "detect/patches/kept_patches.h"
#include "detect/queries/query_trees.h"
#include "detect/trees/broad_phase.h"
#include "dynamics/compute_forces.h"
#include "dynamics/rigid_body.h"
#include "geom/topology.h"
#include "math/nested_aggregates.h"
#include "tulle/attach.h"
#include "tulle/bodies.h"
#include "tulle/events.h"
#include "tulle/live.h"
#include "tulle/query.h"
#include "world/motion.h"

enum { WORLD_NAME_BYTES = 80, WORLD_MESSAGE_BYTES = 1024 };

/* Set by the def defaults; another value means that a def was not made by them. */
#define WORLD_DEF_COOKIE UINT32_C(0x7411e001)
#define CLOTH_DEF_COOKIE UINT32_C(0x7411e002)
#define OBSTACLE_DEF_COOKIE UINT32_C(0x7411e003)
#define ATTACHMENT_DEF_COOKIE UINT32_C(0x7411e004)
#define PIN_COOKIE UINT32_C(0x7411e005)

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

/* What a host says of an object beside its def. */
typedef struct world_label {
    uint32_t category, mask;
    void *user_data;
} world_label;

typedef struct world_cloth {
    char name[WORLD_NAME_BYTES];
    world_label label;
    uint32_t slot;        /* of its id */
    world_mesh mesh;      /* start positions */
    double *rest;         /* [m] 3 * vertex_count; null once the world has started */
    double *velocities;   /* [m/s] at the start; the same */
    double *rest_corners; /* [m] 9 * triangle_count; null: those of `rest` */
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
    uint32_t vertex_begin; /* in the world's numbering, set by the start */
} world_cloth;

typedef struct world_obstacle {
    char name[WORLD_NAME_BYTES];
    world_label label;
    uint32_t slot;                                  /* of its id */
    world_mesh mesh;                                /* at motion zero */
    double friction, dynamic_friction, restitution; /* as the def said */
    double friction_across, grain[3];
    uint32_t contact_material; /* as of a cloth */
    world_motion motion; /* TULLE_DRIVE_RIGID: from the pose at the start of the step to that at its
                            end */
    tulle_drive drive;
    bool is_static; /* no script, no frames, no drive, not a rigid body */
    given_move given;
    motion_pose given_pose;  /* TULLE_DRIVE_RIGID: the pose that was given */
    double *given_positions; /* [m] 3 * vertex_count: where they are to be, or jump to; while a step
                                with a jump runs, where they were. Null: not driven */
    bool has_jumped, was_present; /* in the step that runs; before that */
    tulle_frame_reader read_frame;
    void *frame_context;
    uint32_t frame_count;
    double frame_start_time, frame_interval; /* [s] */
    double appear_time, disappear_time;      /* [s] */
    double *frames[2];                       /* two frames of the sequence, cached */
    uint32_t frame_numbers[2];               /* which; TULLE_NONE: none yet */
    tulle_body body;                         /* as the def said; the rest is for dynamic ones */
    rigid_body rigid;                        /* mass and moments */
    vec3 centre;                             /* [m] of mass, at motion zero */
    quaternion axes;                /* from the body's coordinates to the mesh's at motion zero */
    double *points;                 /* [m] vertices in the body's coordinates */
    double radius;                  /* [m] of the farthest vertex from the centre */
    vec3 given_force, given_torque; /* [N], [N m] for the next step */
    uint32_t vertex_begin;
} world_obstacle;

/* How an obstacle with a body moves. */
typedef enum body_state { BODY_SCRIPTED, BODY_FREE, BODY_SLEEPS } body_state;

/* What a step knows of a body beside its slots (bodies.h). Plain data without padding: saved and
 * hashed as bytes. */
typedef struct body_rest {
    uint32_t state;    /* body_state */
    uint32_t group;    /* lowest of the bodies with which it fell asleep */
    double quiet_time; /* [s] it has been slow, or slept since */
    double force[3];   /* [N] of cloth on it when it fell asleep */
    double torque[3];  /* [N m] of that force about the body's centre */
    double impulse[3]; /* [N s] of all its contacts in the last substep before it fell asleep */
    double moment[3];  /* [N m s] of these impulses about the body's centre */
} body_rest;

/* What a step knows of the sleep of a cloth (cloth_sleep.h). Plain data without padding: saved and
 * hashed as bytes. */
typedef struct cloth_rest {
    uint64_t is_asleep; /* 0 or 1 */
    double quiet_time;  /* [s] it has been slow, or slept since */
    double slept_from;  /* [s] start of the step in which it fell asleep; 0 while awake */
} cloth_rest;

/* What the host has a body do until it is told otherwise (tulle/bodies.h). Plain data without
 * padding: saved and hashed as bytes. Zeroed is nothing. */
typedef struct body_control {
    tulle_body_drive drive;
    uint32_t locks;     /* bit k: axis k of body_drive */
    uint32_t is_driven; /* 0 or 1 */
} body_control;

/* What on_pinch: slow holds back (holds.h). Plain data without padding: saved and hashed as bytes.
 */
typedef struct world_hold {
    uint32_t kind;          /* hold_kind */
    uint32_t cloth;         /* surface that was pinched */
    uint32_t obstacles[2];  /* the second may be TULLE_NONE: what is fixed */
    uint32_t points[2][4];  /* vertices of each obstacle; their weighted mean is the point at which
                               it is held apart from the other */
    double weights[2][4];   /* of these vertices in the mean */
    double normal[3];       /* unit, from the first obstacle to the second */
    double gap, wanted_gap; /* [m] of the points along the normal that they keep: now, at last */
    double share;           /* of what the script asks too much, that the first holds back */
    double lag;             /* [m] farthest vertex from where the script has it, as it catches up */
    uint32_t wait, waiting; /* steps until it is tried again: all, and those left */
} world_hold;
enum { HOLDS_MAX = 16 };

/* A vertex of cloth that an attachment holds (ties.h). Plain data without padding: saved and hashed
 * as bytes. Of what holds a vertex it has two descriptions: a place over the triangle of `corners`,
 * or, where these are TULLE_NONE, `point`. */
typedef struct world_tie {
    uint32_t number;             /* of the attachment, from 1 */
    uint32_t order, order_count; /* of the vertex in its def, of how many */
    uint32_t vertex;             /* in the world's numbering, as corners are */
    uint32_t corners[3];         /* of a triangle of another surface or of the same cloth */
    uint32_t reserved;           /* 0 */
    double weights[3];           /* barycentric coordinates of the vertex' foot */
    double height;               /* [m] over the triangle */
    double point[3];             /* [m] */
    double stiffness;            /* [N/m] INFINITY: rigid */
    double break_force;          /* [N] */
    double release_time;         /* [s] */
    double force[3];             /* [N] on the vertex in the last substep */
} world_tie;

/* Elastic energies of the cloths, measured once for the same positions. */
typedef struct known_elastic {
    elastic_energies energies;
    bool is_known;
} known_elastic;

/* What a step replaces; there are two, swapped when a step succeeds. */
typedef struct world_motion_state {
    double *positions;  /* [m] all vertices */
    double *velocities; /* [m/s] all vertices */
    /* [m/s] all vertices; null without BDF2, which alone reads them */
    double *previous_mean;       /* mean velocity u of the last step */
    double *previous_velocities; /* at the start of the last step */
    double previous_time_step;   /* [s] of that step; 0: none, or it was shortened */
    double lost_energy;          /* [J] in the last substep; 0 without bodies */
    known_elastic elastic;       /* of the cloths at `positions`; not saved */
    double *plastic;             /* of sliders (hysteresis.h): world->plastic_count */
    double time;                 /* [s] */
    uint8_t *is_present;         /* per obstacle */
    uint8_t *particles;          /* particle_state of particle_count vertices */
    body_rest *rests;            /* per body */
    cloth_rest *cloth_rests;     /* cloth_rest_count */
    double *drive_forces;        /* [N], [N m] 6 per body: of the last substep; not saved */
    motion_pose *poses;          /* of pose_count obstacles: those driven as a whole */
    world_hold holds[HOLDS_MAX];
    size_t hold_count;
    double *lags;              /* [m] of lag_vertex_count vertices, see felt.h */
    double *largest_lags;      /* [m] per obstacle; 0: its lags are zero. Not saved */
    ARRAY(world_tie) ties;     /* by number of attachment, then order */
    uint32_t attachment_count; /* that the world ever had */
    contact_store contacts;
} world_motion_state;

enum { STATE_VECTORS_MAX = 4 };
/* The vectors over all vertices that a state has, and how many they are. */
static inline size_t world_list_vectors(const world_motion_state *state,
                                        double *vectors[STATE_VECTORS_MAX]) {
    vectors[0] = state->positions;
    vectors[1] = state->velocities;
    vectors[2] = state->previous_mean;
    vectors[3] = state->previous_velocities;
    return state->previous_mean ? 4 : 2;
}

/* The law of two objects that does not follow from their materials. */
typedef struct world_pair_law {
    size_t first, second; /* indices among cloths or obstacles, cloths first, the lower first */
    int obstacle_count;   /* 0: both are cloths, 1: the second is an obstacle, 2: both are */
    tulle_contact_law law;
} world_pair_law;

typedef ARRAY(world_cloth) cloth_list;
typedef ARRAY(world_obstacle) obstacle_list;
typedef ARRAY(world_pair_law) pair_law_list;

/* A name that cloths and obstacles give what their surface is made of. */
typedef struct world_contact_material {
    char name[WORLD_NAME_BYTES];
} world_contact_material;

/* The law of two contact materials. */
typedef struct world_material_law {
    uint32_t first, second; /* the lower first */
    tulle_contact_law law;
} world_material_law;

/* What a host may change while the world runs. Plain data without padding: saved and hashed as
 * bytes. */
typedef struct world_settings {
    double gravity[3]; /* [m/s^2] */
    tulle_wind wind;
    uint64_t parts; /* of a state: what of these stands before it, of setting_part; else 0 */
} world_settings;

/* What cloths are made of and when their pins let go, where that is not as it is. */
typedef struct cloth_settings {
    const tulle_material *materials; /* by cloth; null: those of the cloths */
    const double *releases;          /* [s] by pin of all cloths in turn; null: those of the pins */
} cloth_settings;

/* What follows from the cloths' rest shapes, materials and pins. */
typedef struct cloth_machinery {
    cloth_model *model;
    linear_system system;
    nested_aggregates *aggregates; /* preconditioner of the solve; null for small cloth */
} cloth_machinery;

typedef ARRAY(tulle_intersection) intersection_list;

/* A point of a surface that is no cloth: weighted mean of vertices in the world's numbering. */
typedef struct room_side {
    uint32_t vertices[3];
    double weights[3];
    bool may_lag;
} room_side;

/* Two sides that face each other with cloth between: normal . (second - first) is to be at least
 * `room`. */
typedef struct room_place {
    room_side sides[2]; /* the first may lag */
    vec3 normal;        /* unit, from the first to the second */
    double room;        /* [m] */
    double share;       /* of what is missing, that the first side gives */
} room_place;
typedef ARRAY(room_place) room_list;

/* A place for a cloth or an obstacle in ids: index and generation of an id name it. */
typedef struct object_slot {
    uint32_t generation; /* of the object that is there, or was there last; from 1 */
    size_t index;        /* among the cloths or the obstacles; SIZE_MAX: nothing is there */
} object_slot;
typedef ARRAY(object_slot) slot_list;

/* What is watched for the host; see events.c. */
typedef struct world_events world_events;
/* How objects come and go in a world that runs; see change/change.h. */
typedef struct world_change world_change;
/* What records the calls of the host; see record/record.c. */
typedef struct world_recording world_recording;

struct tulle_world {
    memory heap;
    tulle_world_def def;
    const contact_response *response; /* that def.response names; set by the start */
    cloth_list cloths;
    obstacle_list obstacles;
    slot_list cloth_slots, obstacle_slots;
    pair_law_list pair_laws;
    ARRAY(world_contact_material) contact_materials;
    ARRAY(world_material_law) material_laws;
    ARRAY(tulle_attachment_def) attachments; /* made before the start, with arrays of their own */
    tulle_pair_filter pair_filter;           /* of the host; null: none */
    void *pair_context;
    bool is_started;
    int threads;
    tulle_tasks host_tasks;       /* as given by tulle_world_set_tasks */
    const tulle_tasks *tasks;     /* those, or null: threads of the library */
    bool is_in_batch;             /* while tulle_worlds_step looks whether a world is there twice */
    stop_poll stop;               /* of the caller */
    tulle_step_progress progress; /* of the step that is under way */

    /* fixed by the start */
    size_t vertex_count, cloth_vertex_count;
    size_t particle_count; /* cloth vertices whose particle_state the response keeps: all or none */
    uint32_t cloth_edge_count; /* edges of all cloths come first */
    size_t plastic_count;      /* of sliders; 0 where no cloth has hysteresis */
    size_t pose_count;         /* all obstacles where one is driven as a whole, else 0 */
    size_t lag_vertex_count;   /* of obstacles that may lag (felt.h) */
    size_t body_count;         /* each has two slots after the cloth vertices, see bodies.h */
    uint32_t *surface_bodies;  /* number of each surface's body, or TULLE_NONE; null: no bodies */
    uint32_t *body_obstacles;  /* obstacle of each body */
    body_control *controls;    /* per body */
    topology topo;
    surface_range *surfaces;
    surface_set set;
    unsigned char *collides; /* surface_count^2, as in `set`; null: all */
    bool has_sleep;          /* a body or cloth may sleep */
    size_t cloth_rest_count; /* all cloths where they may sleep, else 0 */
    /* of cloth vertices and triangles of sleepers in this substep; null where none may sleep */
    uint8_t *idle_vertices, *idle_triangles;
    size_t idle_vertex_count, idle_triangle_count;
    double *rest;              /* [m] all vertices */
    double *inverse_masses;    /* [1/kg] 0 for obstacles */
    uint32_t *vertex_surface;  /* surface of each vertex */
    contact_law *laws;         /* surface_count^2 */
    surface_grain *grains;     /* surface_count; null: none */
    double *rooms, *automatic; /* as of contact_scene; null: there is room everywhere */
    double contact_distance, separation_distance, minimum_gap; /* [m] */
    double edge_length;                                        /* [m] mean over all cloth */
    double
        height_share; /* of the lowest triangle in what is not low; 1: none is low (start_laws.c) */
    cloth_model *model;
    linear_system system;
    nested_aggregates *aggregates; /* preconditioner of the solve; null for small cloth */
    broad_phase *broad;
    kept_patches *patches;   /* null for methods without */
    patch_rules patch_rules; /* set by the start, but for keeps_all */
    double hold_reach;       /* [m] with which patches hold for the paths of stages 8 and 9 */
    uint64_t def_hash;       /* of all defs; guards loaded states */
    world_settings first_settings;
    contact_law *first_laws;         /* surface_count^2; null: no law has changed since the start */
    tulle_material *first_materials; /* by cloth; null: none has changed */
    double *first_releases;          /* [s] by pin; null: none has changed */
    size_t pin_count;                /* of all cloths */
    cloth_machinery spare;           /* of a state that is about to be loaded */

    /* changed by steps */
    world_motion_state now, next;
    uint64_t step_count;
    double step_end;               /* [s] time at the end of the step that runs */
    uint8_t *is_fixed;             /* cloth vertices: pinned in this step */
    double *active_inverse_masses; /* [1/kg] 0 where pinned */
    double *targets;               /* [m] where scripted vertices go in this step */
    pair_list pairs;
    ARRAY(unsigned char) kept_patch_bytes; /* the patches at the start of the step */
    row_list rows;                         /* of the substep that runs, or ran last */
    row_list accepted_rows;                /* of the last substep of the last accepted step */
    intersection_list intersections;       /* of the start, or of what last appeared */
    ARRAY(tulle_overlap)
    overlaps;                        /* of the intersections, once a start or a step was refused for
                                        them; else none */
    intersection_list ignored;       /* those that have not come apart */
    intersection_list ignored_start; /* the ignored ones at the start of the step */
    ARRAY(uint64_t) ignored_keys;    /* the same as ignored_pair_key, ascending */
    ARRAY(tulle_contact) contacts;   /* accepted_rows as the user sees them, when has_contacts */
    bool has_contacts;
    query_trees queries; /* of the last state that was asked, when has_queries */
    bool has_queries;
    room_list places;                      /* of the step that runs, or ran last */
    const world_change *change;            /* while objects come and go; else null */
    world_events *events;                  /* null: the host watches nothing */
    world_recording *recording;            /* null: calls are not recorded */
    tulle_untangle_report untangle_report; /* of the start */
    arena scratch;
    char message[WORLD_MESSAGE_BYTES];
};

static inline const char *world_surface_name(const tulle_world *world, size_t surface) {
    size_t const cloth_count = world->cloths.count;
    return surface < cloth_count ? world->cloths.data[surface].name
                                 : world->obstacles.data[surface - cloth_count].name;
}

static inline const world_mesh *world_surface_mesh(const tulle_world *world, size_t surface) {
    size_t const cloth_count = world->cloths.count;
    return surface < cloth_count ? &world->cloths.data[surface].mesh
                                 : &world->obstacles.data[surface - cloth_count].mesh;
}

/* Whether features of two surfaces are held apart at all, by what the host chose. */
static inline bool world_pair_collides(const tulle_world *world, size_t a, size_t b) {
    return !world->collides || world->collides[a * world->set.surface_count + b];
}

static inline world_label *world_get_label(const tulle_world *world, size_t surface) {
    size_t const cloth_count = world->cloths.count;
    return surface < cloth_count ? &world->cloths.data[surface].label
                                 : &world->obstacles.data[surface - cloth_count].label;
}

/* slots.c: what an id names, as an index among the cloths or the obstacles; SIZE_MAX: nothing, the
 * world is null or the id is stale. */
size_t world_find_cloth(const tulle_world *world, tulle_cloth_id id);
size_t world_find_obstacle(const tulle_world *world, tulle_obstacle_id id);
/* slots.c: the ids of what is there. */
tulle_cloth_id world_get_cloth_id(const tulle_world *world, size_t cloth);
tulle_obstacle_id world_get_obstacle_id(const tulle_world *world, size_t obstacle);
/* slots.c: the slot that the next object gets. Puts an object there, with the next generation;
 * there is room for one. Undoes that. */
uint32_t world_find_free_slot(const slot_list *slots);
void world_take_slot(slot_list *slots, uint32_t slot, size_t index);
void world_return_slot(slot_list *slots, uint32_t slot);
/* slots.c: the id of the next obstacle that is added. */
tulle_obstacle_id world_find_next_obstacle(const tulle_world *world);
/* slots.c: lets the slots name objects by their places in the arrays, which have changed. */
void world_renumber_slots(tulle_world *world);

/* objects.c: the number among all surfaces, or SIZE_MAX with an error where there is none. */
size_t world_find_object(const tulle_world *world, tulle_object_id id, tulle_error *error);
/* objects.c: which pairs collide, by the filters of the host; false when memory is short. */
bool world_choose_pairs(tulle_world *world);

/* pair_laws.c: the law set for two surfaces, else that of their contact materials, or null. */
const tulle_contact_law *world_find_pair_law(const tulle_world *world, size_t a, size_t b);
/* pair_laws.c: number of a contact material of that name, new or not; TULLE_NONE for null. There is
 * room for one. */
uint32_t world_add_contact_material(tulle_world *world, const char *name);

/* bodies.c: mass, inertia and centre of a dynamic obstacle, from its def. */
tulle_status world_make_body(tulle_world *world, world_obstacle *obstacle, tulle_error *error);

/* world.c: releases what an object owns. */
void world_destroy_cloth(memory *heap, world_cloth *cloth);
void world_destroy_obstacle(memory *heap, world_obstacle *obstacle);

/* start.c: tulle_world_start; without judgement when a saved state is about to take the place of
 * the first one. */
tulle_status world_start(tulle_world *world, bool is_judged, const tulle_moment *moment,
                         tulle_error *error);
/* start_arrays.c: releases what the start made; fine before it. */
void world_release_start(tulle_world *world);
/* start_arrays.c: releases what cloths were at first, of which the start made its own. */
void world_release_first_cloth(tulle_world *world);

/* start/build_model.c: the machinery for materials and pins as they are, or as `settings` has them;
 * an error leaves nothing. Releases it. Puts it in the place of the world's own, which is released.
 */
tulle_status world_build_machinery(tulle_world *world, cloth_settings settings,
                                   cloth_machinery *made, tulle_error *error);
void world_release_machinery(tulle_world *world, cloth_machinery *made);
void world_set_machinery(tulle_world *world, cloth_machinery *made);

/* settings.c: what a host has changed, as a state has it where it is not as at the start. How many
 * bytes that is; the bytes; their hash. */
size_t world_get_settings_size(const tulle_world *world);
void world_put_settings(const tulle_world *world, void *bytes);
uint64_t world_hash_settings(const tulle_world *world, uint64_t hash);
/* settings.c: checks such bytes and makes room; then puts them in force, or what was at the start
 * where there are none, which cannot fail. */
tulle_status world_check_settings(tulle_world *world, const void *bytes, size_t size,
                                  tulle_error *error);
void world_take_settings(tulle_world *world, const void *bytes, size_t size);
/* settings.c: releases what was kept of the start. */
void world_release_first_settings(tulle_world *world);
/* settings.c: the law of two surfaces from the next step on. */
tulle_status world_change_law(tulle_world *world, size_t a, size_t b, const tulle_contact_law *law,
                              tulle_error *error);

/* ties/kept_attachments.c: keeps a def until the start; releases all that were kept. */
tulle_status world_keep_attachment(tulle_world *world, const tulle_attachment_def *def,
                                   tulle_error *error);
void world_release_attachments(tulle_world *world);
/* ties/attach.c: makes those that were kept, at the end of a start. */
tulle_status world_begin_attachments(tulle_world *world, tulle_error *error);

/* body_control.c: the locks and drives of bodies as a state has them where there are any: how many
 * bytes that is; their hash. */
size_t world_get_controls_size(const tulle_world *world);
uint64_t world_hash_controls(const tulle_world *world, uint64_t hash);
/* body_control.c: checks such bytes; then puts them in force, or nothing where there are none. */
tulle_status world_check_controls(const tulle_world *world, const void *bytes, size_t size,
                                  tulle_error *error);
void world_take_controls(tulle_world *world, const void *bytes, size_t size);

/* events.c: looks for the objects that press on each other in a state that is about to become the
 * world's; then, when it has, tells what has changed since the last look, or begins anew with an
 * empty queue. Lets go of all. */
tulle_status world_find_touching(tulle_world *world, const world_motion_state *state,
                                 tulle_error *error);
void world_tell_events(tulle_world *world);
void world_restart_events(tulle_world *world);
void world_release_events(tulle_world *world);

/* given.c: before a step, obstacles that jump do so in world->now, where they count as absent, so
 * that they are judged as what appears. At its end, or when a state is loaded, what was given is
 * used up; after a step that failed nothing has jumped. */
void world_begin_given(tulle_world *world);
void world_end_given(tulle_world *world, bool has_failed);

/* state.c: vertices that may move: all but those of static obstacles, which a saved state leaves
 * out. Runs of them ascend and may be empty. */
typedef struct moving_run {
    size_t begin, end; /* vertices */
    size_t surface;    /* the static one behind it, or surface_count */
} moving_run;
moving_run world_first_moving(const tulle_world *world);
/* False after the last run. */
bool world_next_moving(const tulle_world *world, moving_run *run);

/* state_check.c: whether a state that was read may be one of this world, which has started; an
 * error says why not. */
tulle_status world_check_state(const tulle_world *world, const world_motion_state *state,
                               tulle_error *error);

/* kinematics.c: where obstacles and pins are to be at `end_time` (targets), and which vertices are
 * pinned at `time`. */
tulle_status world_script_targets(tulle_world *world, double time, double end_time,
                                  tulle_error *error);
/* kinematics.c: where an obstacle that is added is at the time of the world. */
tulle_status world_place_obstacle(tulle_world *world, size_t index, double *positions,
                                  tulle_error *error);
/* kinematics.c: which obstacles are there at `time`, into state->is_present and the surfaces. An
 * obstacle that appears into cloth is an error or is ignored, as the def says. */
tulle_status world_update_presence(tulle_world *world, world_motion_state *state,
                                   tulle_error *error);

/* judge.c: exact intersections among present surfaces; replaces `list`. */
tulle_status world_find_intersections(tulle_world *world, const double *positions,
                                      intersection_list *list, tulle_error *error);
/* judge.c: how many of world->intersections are without cloth. */
size_t world_count_intersecting_bodies(const tulle_world *world);
/* refuse.c: sorts world->intersections by depth, deepest first, and fills the error with the first
 * pairs: how deep, where, their vertices. */
tulle_status world_refuse_intersections(tulle_world *world, const double *positions,
                                        const char *when, tulle_error *error);
/* refuse.c: the same before anything is untangled, where pairs are without cloth; `what` names
 * them. */
tulle_status world_refuse_bodies(tulle_world *world, const char *what, tulle_error *error);
/* judge.c: from now on ignores the pairs in world->intersections; an error leaves them as before.
 */
tulle_status world_ignore_intersections(tulle_world *world, tulle_error *error);
/* judge.c: keeps the ignored pairs as they are now, for world_restore_ignored. */
tulle_status world_keep_ignored(tulle_world *world, tulle_error *error);
void world_restore_ignored(tulle_world *world);
/* judge.c: drops ignored pairs that have come apart. */
void world_update_ignored(tulle_world *world, const double *positions);

#endif
