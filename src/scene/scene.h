/* scene/scene.h - facts of scene files that the program prints, in addition to tulle_io/scene.h. */
#ifndef TULLE_SCENE_SCENE_H
#define TULLE_SCENE_SCENE_H

#include "tulle/record.h"
#include "tulle_io/scene.h"

#include <stdint.h>
#include <stdio.h>

/* Writes one line a problem: "file:line:column: message". */
void scene_print_problems(const tulle_scene_problems *problems, FILE *stream);

/* Reads the material file `path` with all values that it leaves to its preset. `problems` is zeroed
 * first; statuses as of tulle_scene_load. */
tulle_status scene_load_material(const char *path, tulle_material *material,
                                 tulle_scene_problems *problems);

/* Prints the table of keys as a JSON array: an object for each key of each kind of map, with its
 * path as "cloth[].mesh.shape", kind, unit, choices, default and meaning. */
void scene_print_schema(FILE *stream);

/* ---- a scene that is simulated by hand ---- */

/* As tulle_scene_load without overrides, of `length` bytes of `text` that stand for the contents of
 * `path`: paths within it are relative to that, and problems name it. No file `path` is read. */
tulle_status scene_load_text(const char *path, const char *text, size_t length,
                             tulle_scene **result, tulle_scene_problems *problems);

/* As tulle_scene_build_world; all calls for the world are recorded from its creation on. */
tulle_status scene_build_recorded_world(tulle_scene *loaded, int threads,
                                        const tulle_record_writer *writer,
                                        tulle_scene_world *result, tulle_error *error);

/* Puts an obstacle that stands still, number `index` of the scene, in place of the one that
 * `built` has: the same, but driven as a whole (TULLE_DRIVE_RIGID). The scene's attachments to it
 * that still hold are made again. Errors: TULLE_ERROR_UNSUPPORTED (it moves by itself), those of
 * adding and removing; an obstacle that could not be added again is gone. */
tulle_status scene_drive_obstacle(const tulle_scene *loaded, tulle_scene_world *built, size_t index,
                                  tulle_error *error);

/* Facts of an object in the scene, without its mesh; cloths count first, then obstacles. */
typedef struct scene_object_facts {
    const char *material; /* preset or file of a cloth, contact material of an obstacle; or null */
    const tulle_material *cloth_material; /* null for obstacles */
    double thickness, friction, restitution;
    size_t pin_count;
} scene_object_facts;
scene_object_facts scene_get_object_facts(const tulle_scene *loaded, size_t object);
/* The number of the last pin that holds this vertex of a cloth, below `limit`; SIZE_MAX: none. */
size_t scene_find_pin(const tulle_scene *loaded, size_t cloth, uint32_t vertex, size_t limit);
/* Vertices of a pin: `*count` of them, owned by the scene. */
const uint32_t *scene_get_pin_vertices(const tulle_scene *loaded, size_t cloth, size_t pin,
                                       size_t *count);
/* Gravity and wind as the scene has them at its start. */
void scene_get_weather(const tulle_scene *loaded, double gravity[3], tulle_wind *wind);

#endif
