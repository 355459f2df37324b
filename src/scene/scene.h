/* scene/scene.h - what the program prints about scene files, beside tulle_io/scene.h. */
#ifndef TULLE_SCENE_SCENE_H
#define TULLE_SCENE_SCENE_H

#include "tulle_io/scene.h"

#include <stdio.h>

/* Writes one line a problem: "file:line:column: message". */
void scene_print_problems(const tulle_scene_problems *problems, FILE *stream);

/* Reads the material file `path` with all values that it leaves to its preset. `problems` is zeroed
 * first; statuses as of tulle_scene_load. */
tulle_status scene_load_material(const char *path, tulle_material *material,
                                 tulle_scene_problems *problems);

/* Prints docs/guide/scene.md from the table of keys. */
void scene_print_documentation(FILE *stream);

#endif
