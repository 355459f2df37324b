/* scene/scene.h - what the program prints about scene files, beside tulle_io/scene.h. */
#ifndef TULLE_SCENE_SCENE_H
#define TULLE_SCENE_SCENE_H

#include "tulle_io/scene.h"

#include <stdio.h>

/* Writes one line a problem: "file:line:column: message". */
void scene_print_problems(const tulle_scene_problems *problems, FILE *stream);

/* Prints docs/guide/scene.md from the table of keys. */
void scene_print_documentation(FILE *stream);

#endif
