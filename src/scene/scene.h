/* scene/scene.h - scene files: YAML text in, a checked scene and a world out.
 *
 * scene_load reads the file, applies overrides, checks every key against the table that also prints
 * docs/guide/scene.md, reads or generates all meshes, places copies and resolves pins. Nothing is
 * written to disk. scene_build_world then adds everything to a new world through the public
 * headers. */
#ifndef TULLE_SCENE_SCENE_H
#define TULLE_SCENE_SCENE_H

#include "tulle/world.h"

#include <stdbool.h>
#include <stdio.h>

typedef struct scene scene;

/* Most problems that one load keeps; further ones are only counted. */
#define SCENE_PROBLEM_LIMIT 20

/* Everything found wrong with a scene, in the order of the file's text where a place is known.
 * `file` of a problem is the scene file, a mesh file, or "--set PATH=VALUE" for an override. About
 * 50 KiB: not for deep stacks. */
typedef struct scene_problems {
    size_t count;       /* problems kept in `list` */
    size_t total_count; /* problems found; more than `count` when the list is full */
    tulle_error list[SCENE_PROBLEM_LIMIT];
} scene_problems;

/* Loads a scene. `overrides` are texts of the form "path=value", as in
 * "cloth[0].mesh.resolution=[40, 40]" or "time.frames=10": the value is YAML, an empty value
 * removes the key, an index equal to the length of a list appends; they are applied in order.
 * `problems` is zeroed first and holds at least one entry on failure, with its status returned.
 * Release with scene_destroy. */
tulle_status scene_load(const char *path, const char *const *overrides, size_t override_count,
                        scene **result, scene_problems *problems);
/* Null is fine. Worlds built from the scene must be destroyed before (they read its frames). */
void scene_destroy(scene *loaded);

/* What a user should know of a scene that was loaded, one sentence each: statements of a mesh file
 * that were passed over, triangles of an obstacle that were dropped. Owned by the scene. */
size_t scene_get_note_count(const scene *loaded);
const char *scene_get_note(const scene *loaded, size_t index);

/* Writes one line a problem: "file:line:column: message". */
void scene_print_problems(const scene_problems *problems, FILE *stream);

/* Time. */
double scene_get_time_step(const scene *loaded);         /* [s] */
uint32_t scene_get_frame_count(const scene *loaded);     /* written frames after the start */
uint32_t scene_get_steps_per_frame(const scene *loaded); /* >= 1; a frame lasts this many steps */
const char *scene_get_path(const scene *loaded);         /* as given to scene_load */
uint64_t scene_get_seed(const scene *loaded);            /* seeds wind and irregular meshes */
tulle_start_intersections scene_get_start_intersections(const scene *loaded);

/* Objects, in the order of the file; copies of an obstacle follow each other as NAME.000, NAME.001
 * ... Names are unique and usable as file names (letters, digits, '-', '_' and '.'). Meshes are at
 * their start position, borrowed from the scene. */
size_t scene_get_cloth_count(const scene *loaded);
const char *scene_get_cloth_name(const scene *loaded, size_t index);
tulle_mesh_view scene_get_cloth_mesh(const scene *loaded, size_t index);
size_t scene_get_obstacle_count(const scene *loaded);
const char *scene_get_obstacle_name(const scene *loaded, size_t index);
tulle_mesh_view scene_get_obstacle_mesh(const scene *loaded, size_t index);
/* Whether it has keyframes or a mesh sequence; others never change their positions. */
bool scene_is_obstacle_moving(const scene *loaded, size_t index);
/* Whether it is a rigid body. */
bool scene_is_obstacle_dynamic(const scene *loaded, size_t index);

/* The whole scene with every default filled in, in SI units, as YAML text that loads again to the
 * same scene when it lies beside the scene file; for run.json. */
const char *scene_get_canonical_text(const scene *loaded);
/* Hash of the canonical text, all meshes and the contents of all mesh sequences. The number of
 * frames is left out, so a run may be made longer. */
uint64_t scene_get_hash(const scene *loaded);

/* A world with all objects of a scene. Ids are in the order of the scene's objects. */
typedef struct scene_world {
    tulle_world *world;
    tulle_cloth_id *cloths;
    size_t cloth_count;
    tulle_obstacle_id *obstacles;
    size_t obstacle_count;
} scene_world;
/* Makes the world; does not start it. threads: 0 one per processor. allocator: null for malloc.
 * Errors carry the place of the object in the scene file. One world at a time reads the frames of a
 * scene's mesh sequences. */
tulle_status scene_build_world(scene *loaded, int threads, const tulle_allocator *allocator,
                               scene_world *result, tulle_error *error);
/* Destroys the world and releases the id arrays; zeroes the struct. */
void scene_destroy_world(scene_world *built);

/* Prints docs/guide/scene.md from the table of keys. */
void scene_print_documentation(FILE *stream);

#endif
