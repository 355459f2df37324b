/* tulle_io/scene.h - scene files: YAML text in, a checked scene and a world out.
 * docs/guide/scene.md describes every key.
 *
 * tulle_scene_load reads the file, applies overrides, checks every key, reads or generates all
 * meshes, places copies and resolves pins. Nothing is written to disk. tulle_scene_build_world then
 * adds everything to a new world. */
#ifndef TULLE_IO_SCENE_H
#define TULLE_IO_SCENE_H

#include "tulle/base.h"
#include "tulle/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A loaded scene. Made by tulle_scene_load, released by tulle_scene_destroy. */
typedef struct tulle_scene tulle_scene;

/* Most problems that one load keeps; further problems are only counted. */
#define TULLE_SCENE_PROBLEMS_MAX 20

/* All that is wrong with a scene, in the order of the file's text where a place is known. The
 * struct has about 50 KiB: not for deep stacks. */
typedef struct tulle_scene_problems {
    size_t count;       /* problems kept in `list` */
    size_t total_count; /* problems found; more than `count` when the list is full */
    /* The problems. `file` is the scene file, a mesh file, or "--set PATH=VALUE" for an override.
     */
    tulle_error list[TULLE_SCENE_PROBLEMS_MAX];
} tulle_scene_problems;

/* Loads the scene file `path`, a regular file, and makes `*result`, which is null after an error;
 * release it with tulle_scene_destroy. The `override_count` texts of `overrides` change the file's
 * keys, one after the other. A text has the form "path=value", as in "cloth[0].mesh.resolution=[40,
 * 40]" or "time.frames=10". The value is YAML. An empty value removes the key; an index equal to
 * the length of a list appends. `problems` is zeroed first. After an error it holds one problem at
 * least, and the call returns the status of the first. Errors: TULLE_ERROR_IO, TULLE_ERROR_PARSE,
 * TULLE_ERROR_INVALID_ARGUMENT (null, also an override; a value of the file),
 * TULLE_ERROR_INVALID_MESH, TULLE_ERROR_LIMIT, TULLE_ERROR_OUT_OF_MEMORY. */
TULLE_API tulle_status tulle_scene_load(const char *path, const char *const *overrides,
                                        size_t override_count, tulle_scene **result,
                                        tulle_scene_problems *problems);
/* Releases a scene; null is fine. Destroy the worlds built from it first: they read its frames. */
TULLE_API void tulle_scene_destroy(tulle_scene *loaded);

/* How many notes there are about a loaded scene. A note is a sentence that the user should know,
 * for example on parts of a mesh file that were ignored, or triangles of an obstacle that were
 * dropped. 0 for null. */
TULLE_API size_t tulle_scene_get_note_count(const tulle_scene *loaded);
/* Note number `index`; null past the last note and for a null scene. Owned by the scene. */
TULLE_API const char *tulle_scene_get_note(const tulle_scene *loaded, size_t index);

/* The time step [s]; 0 for null. */
TULLE_API double tulle_scene_get_time_step(const tulle_scene *loaded);
/* How many frames a run writes after the start; 0 for null. */
TULLE_API uint32_t tulle_scene_get_frame_count(const tulle_scene *loaded);
/* How many steps a frame lasts, >= 1; 0 for null. */
TULLE_API uint32_t tulle_scene_get_steps_per_frame(const tulle_scene *loaded);

/* The path given to tulle_scene_load. Null for null. */
TULLE_API const char *tulle_scene_get_path(const tulle_scene *loaded);
/* The seed of wind and irregular meshes; 0 for null. */
TULLE_API uint64_t tulle_scene_get_seed(const tulle_scene *loaded);
/* What the world does about intersections at the start; TULLE_START_REFUSE for null. */
TULLE_API tulle_start_intersections tulle_scene_get_start_intersections(const tulle_scene *loaded);

/* Number of cloths; they are in the order of the file. 0 for null. */
TULLE_API size_t tulle_scene_get_cloth_count(const tulle_scene *loaded);
/* Name of cloth `index`, below the count. Names of objects are unique. They have at most 64 bytes
 * of UTF-8: letters and digits of any script, '-', '_', '.', and blanks that are neither first nor
 * last. Null out of range and for a null scene. */
TULLE_API const char *tulle_scene_get_cloth_name(const tulle_scene *loaded, size_t index);
/* Mesh of cloth `index` at the start, borrowed from the scene; empty out of range and for null. */
TULLE_API tulle_mesh_view tulle_scene_get_cloth_mesh(const tulle_scene *loaded, size_t index);
/* Number of obstacles; they are in the order of the file. Copies of an obstacle follow each other.
 * 0 for null. */
TULLE_API size_t tulle_scene_get_obstacle_count(const tulle_scene *loaded);
/* Name of obstacle `index`; of copies NAME.000, NAME.001 ... Null out of range and for a null
 * scene.
 */
TULLE_API const char *tulle_scene_get_obstacle_name(const tulle_scene *loaded, size_t index);
/* Mesh of obstacle `index` at the start, borrowed from the scene; empty out of range and for null.
 */
TULLE_API tulle_mesh_view tulle_scene_get_obstacle_mesh(const tulle_scene *loaded, size_t index);
/* 1: obstacle `index` has keyframes or a mesh sequence, or is a rigid body; others never change
 * their positions. 0 out of range and for null. */
TULLE_API int tulle_scene_is_obstacle_moving(const tulle_scene *loaded, size_t index);
/* 1: obstacle `index` is a rigid body. 0 out of range and for null. */
TULLE_API int tulle_scene_is_obstacle_dynamic(const tulle_scene *loaded, size_t index);

/* The whole scene as YAML text in SI units, with every default filled in. Numbers have the fewest
 * digits that read back to the same double, in every locale. The text loads to the same scene again
 * if it lies in the same directory as the scene file. Null for null. */
TULLE_API const char *tulle_scene_get_canonical_text(const tulle_scene *loaded);
/* Hash of the canonical text, all meshes and the contents of all mesh sequences. It leaves out the
 * number of frames, so a run may be made longer. 0 for null. */
TULLE_API uint64_t tulle_scene_get_hash(const tulle_scene *loaded);

/* A world with all objects of a scene. Made by tulle_scene_build_world, released by
 * tulle_scene_destroy_world. */
typedef struct tulle_scene_world {
    tulle_world *world;           /* not started yet */
    tulle_cloth_id *cloths;       /* cloth_count ids, in the order of the scene */
    size_t cloth_count;           /* number of cloths */
    tulle_obstacle_id *obstacles; /* obstacle_count ids, in the order of the scene */
    size_t obstacle_count;        /* number of obstacles, with all copies */
} tulle_scene_world;
/* Makes a world of a scene into `*result`; does not start it. It runs on `threads` threads, 0: one
 * for each processor, and takes memory from `allocator`, null: malloc. The worlds of a scene may
 * step in different threads. Errors name the place of the object in the scene file. They have the
 * statuses of tulle_world_create, tulle_world_add_cloth and tulle_world_add_obstacle; null scenes
 * and results are refused with TULLE_ERROR_INVALID_ARGUMENT. */
TULLE_API tulle_status tulle_scene_build_world(tulle_scene *loaded, int threads,
                                               const tulle_allocator *allocator,
                                               tulle_scene_world *result, tulle_error *error);
/* Destroys the world and releases the id arrays; zeroes the struct. Null is fine. */
TULLE_API void tulle_scene_destroy_world(tulle_scene_world *built);

#ifdef __cplusplus
}
#endif
#endif
