/* app/check/animation.h - judging every frame of animations: point caches with their meshes, scenes
 * of glTF, USD, NPZ and Alembic, numbered mesh files. */
#ifndef TULLE_APP_CHECK_ANIMATION_H
#define TULLE_APP_CHECK_ANIMATION_H

#include "app/check/frame.h"

#include <stdbool.h>

/* A file, and the mesh that it moves; null: none is given. */
typedef struct check_file {
    const char *path, *mesh_path;
} check_file;

typedef struct check_animation_choice {
    const check_file *files; /* cloths, then obstacles */
    size_t cloth_count, file_count;
    const char *frames; /* as frame_range_read takes --frames; null: all */
    int threads;
    bool welds; /* vertices in the same place in all frames that are judged are one */
} check_animation_choice;

/* Whether a path names more than a mesh. */
bool check_is_animation(const char *path);

/* Judges the frames of the files together, prints each and adds them to the totals; a bar on
 * standard error if it is a terminal. A file of one frame stands still; all others have as many
 * frames. Files are judged in the axes and unit of the first, so its numbers are
 * those of the file; places are told in metres with z up. Stops at the first frame that cannot
 * be read or judged, with the error filled in. */
tulle_status check_animations(const check_animation_choice *choice, const check_report *report,
                              check_totals *totals, tulle_error *error);

#endif
