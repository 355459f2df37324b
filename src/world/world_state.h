/* world/world_state.h - the insides of tulle_world, for the files of world/ alone. */
#ifndef TULLE_WORLD_WORLD_STATE_H
#define TULLE_WORLD_WORLD_STATE_H

#include "detect/queries/query_trees.h"
#include "step/motion_state.h"
#include "step/step_model.h"
#include "step/step_work.h"
#include "tulle/attach.h"
#include "tulle/events.h"
#include "tulle/query.h"

/* The law of two objects that does not follow from their materials. */
typedef struct world_pair_law {
    size_t first, second; /* indices among cloths or obstacles, cloths first, the lower first */
    int obstacle_count;   /* 0: both are cloths, 1: the second is an obstacle, 2: both are */
    tulle_contact_law law;
} world_pair_law;

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

/* What is where in ids. */
typedef struct world_slots {
    slot_list cloths, obstacles;
} world_slots;

/* What the host says of pairs of objects. */
typedef struct world_rules {
    pair_law_list pair_laws;
    ARRAY(world_contact_material) contact_materials;
    ARRAY(world_material_law) material_laws;
    tulle_pair_filter pair_filter; /* null: none */
    void *pair_context;
} world_rules;

/* What the start had of what the host has changed since; null: nothing of that kind. */
typedef struct first_settings {
    uint64_t def_hash; /* of the world's def alone */
    world_settings settings;
    contact_law *laws;         /* surface_count^2 */
    tulle_material *materials; /* by cloth */
    double *releases;          /* [s] by pin */
} first_settings;

struct tulle_world {
    memory heap;
    step_model model;
    motion_state now, next; /* swapped when a step succeeds */
    step_work work;

    world_slots slots;
    world_rules rules;
    ARRAY(tulle_attachment_def) attachments; /* made before the start, with arrays of their own */
    bool is_started;
    tulle_tasks host_tasks; /* as given by tulle_world_set_tasks */
    bool is_in_batch;       /* while tulle_worlds_step looks whether a world is there twice */
    uint64_t def_hash;      /* of all defs; guards loaded states */
    first_settings first;
    cloth_machinery spare;           /* of a state that is about to be loaded */
    row_list accepted_rows;          /* of the last substep of the last accepted step */
    intersection_list intersections; /* of the start, or of what last appeared */
    ARRAY(tulle_overlap)
    overlaps;                        /* of the intersections, once a start or a step was refused for
                                        them; else none */
    intersection_list ignored;       /* those that have not come apart */
    intersection_list ignored_start; /* the ignored ones at the start of the step */
    ARRAY(tulle_contact) contacts;   /* accepted_rows as the user sees them, when has_contacts */
    bool has_contacts;
    const world_change *change;            /* while objects come and go; else null */
    world_events *events;                  /* null: the host watches nothing */
    world_recording *recording;            /* null: calls are not recorded */
    tulle_untangle_report untangle_report; /* of the start */
    char message[WORLD_MESSAGE_BYTES];
};

/* objects.c: what an id names, as an index among the cloths or the obstacles; SIZE_MAX: nothing,
 * the world is null or the id is stale. */
size_t world_find_cloth(const tulle_world *world, tulle_cloth_id id);
size_t world_find_obstacle(const tulle_world *world, tulle_obstacle_id id);
/* settings.c: the cloth, or null with an error: none, or a world that has not started. */
world_cloth *world_find_started_cloth(tulle_world *world, tulle_cloth_id id, tulle_error *error);
/* objects.c: the ids of what is there. */
tulle_cloth_id world_get_cloth_id(const tulle_world *world, size_t cloth);
tulle_obstacle_id world_get_obstacle_id(const tulle_world *world, size_t obstacle);
/* objects.c: the slot that the next object gets. Puts an object there, with the next generation;
 * there is room for one. Undoes that. */
uint32_t world_find_free_slot(const slot_list *slots);
void world_take_slot(slot_list *slots, uint32_t slot, size_t index);
void world_return_slot(slot_list *slots, uint32_t slot);
/* objects.c: the id of the next obstacle that is added. */
tulle_obstacle_id world_find_next_obstacle(const tulle_world *world);
/* objects.c: lets the slots name objects by their places in the arrays, which have changed. */
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

/* start_arrays.c: mass, inertia and centre of a dynamic obstacle, from its def. */
tulle_status world_make_body(tulle_world *world, world_obstacle *obstacle, tulle_error *error);

/* world.c: lets the work of steps point to the insides of this world, which may have been copied
 * here. */
void world_point_work(tulle_world *world);
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
/* settings.c: checks such bytes and makes room; then, without failing, puts them in force, or the
 * settings of the start without bytes. */
tulle_status world_check_settings(tulle_world *world, const void *bytes, size_t size,
                                  tulle_error *error);
void world_take_settings(tulle_world *world, const void *bytes, size_t size);
/* settings.c: releases the kept settings of the start. */
void world_release_first_settings(tulle_world *world);
/* settings.c: the law of two surfaces from the next step on. */
tulle_status world_change_law(tulle_world *world, size_t a, size_t b, const tulle_contact_law *law,
                              tulle_error *error);

/* ties/attach.c: makes the attachments that were made before the start, at its end; releases them.
 */
tulle_status world_begin_attachments(tulle_world *world, tulle_error *error);
void world_release_attachments(tulle_world *world);
/* ties/attach.c: whether ties that were read may be of this world. */
bool world_ties_are_valid(const tulle_world *world, const motion_state *state);

/* body_access.c: number of a body, or TULLE_NONE with an error. */
uint32_t world_find_body(const tulle_world *world, tulle_obstacle_id id, tulle_error *error);
/* body_control.c: gives a body of the state other velocities, three of its centre and three of its
 * turn, zero along what is locked. */
void world_set_body_velocity(tulle_world *world, size_t body, const double *velocities);

/* body_control.c: the locks and drives of bodies as a state has them where there are any: how many
 * bytes that is; their hash. */
size_t world_get_controls_size(const tulle_world *world);
uint64_t world_hash_controls(const tulle_world *world, uint64_t hash);
/* body_control.c: checks such bytes; then puts them in force, or nothing where there are none. */
tulle_status world_check_controls(const tulle_world *world, const void *bytes, size_t size,
                                  tulle_error *error);
void world_take_controls(tulle_world *world, const void *bytes, size_t size);

/* events.c: finds the objects that press on each other in a state that will become the state of the
 * world; afterwards queues the changes since the last look, or restarts with an empty queue;
 * releases all. */
tulle_status world_find_touching(tulle_world *world, const motion_state *state, tulle_error *error);
void world_tell_events(tulle_world *world);
void world_restart_events(tulle_world *world);
void world_release_events(tulle_world *world);

/* given.c: before a step, obstacles that jump do so in world->now, where they count as absent, so
 * that they are judged like objects that appear; targets become shapes in the scratch arena. At its
 * end, or when a state is loaded, the poses are used up; after a failure nothing has jumped. */
tulle_status world_begin_given(tulle_world *world, tulle_error *error);
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
tulle_status world_check_state(const tulle_world *world, const motion_state *state,
                               tulle_error *error);

/* words.c: adds what a step that succeeded has found to the world's message. Says why a step
 * failed; returns the status. */
void world_tell_findings(tulle_world *world);
tulle_status world_tell_failure(tulle_world *world, tulle_status status, tulle_error *error);

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
