/* scene/problems.h - collecting what is wrong with a scene. */
#ifndef TULLE_SCENE_PROBLEMS_H
#define TULLE_SCENE_PROBLEMS_H

#include "scene/scene.h"

/* A place in a scene file or in an override. */
typedef struct scene_place {
    const char *file; /* or "--set PATH=VALUE" */
    int line, column; /* 1-based, 0 if it does not apply */
} scene_place;

/* Adds one problem; when the list is full only counts it. Returns status. */
tulle_status problem_add(tulle_scene_problems *problems, tulle_status status, scene_place place,
                         const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Adds a failure of a library call on behalf of an object of the scene. If the message names a mesh
 * file, it keeps that place, and the object's place is added to its text. Else the object's place
 * leads. */
tulle_status problem_add_error(tulle_scene_problems *problems, scene_place place, const char *path,
                               const tulle_error *error);

/* Out of memory, as a problem. */
tulle_status problem_add_memory(tulle_scene_problems *problems, const char *file);

/* Room for a piece of user text in a message. */
typedef struct shown_text {
    char text[72];
} shown_text;
/* A copy of `text` fit for a message: at most 60 bytes, control characters as '?'. */
shown_text show_text(const char *text);

#endif
