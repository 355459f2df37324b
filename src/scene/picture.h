/* scene/picture.h - what a scene file says about pictures, read without its meshes. */
#ifndef TULLE_SCENE_PICTURE_H
#define TULLE_SCENE_PICTURE_H

#include "scene/scene.h"

#include <stdbool.h>

/* Where pictures are taken from; values count where has_ says so. */
typedef struct scene_camera {
    bool has_position, has_orbit, has_target, has_distance, has_field_of_view, has_turn;
    double position[3], target[3]; /* [m] */
    double azimuth, elevation;     /* [rad] of the direction from the target to the camera */
    double distance;               /* [m] of an orbit */
    double field_of_view, turn;    /* [rad] */
} scene_camera;

typedef enum scene_floor { SCENE_FLOOR_AUTO, SCENE_FLOOR_ON, SCENE_FLOOR_OFF } scene_floor;
typedef enum scene_pattern {
    SCENE_PATTERN_PLAIN,
    SCENE_PATTERN_WEAVE,
    SCENE_PATTERN_CHECK
} scene_pattern;

/* How a body looks; values count where has_ says so. */
typedef struct scene_look {
    bool has_color, has_back_color, has_pattern, is_hidden;
    double color[3], back_color[3]; /* sRGB, 0 .. 1 */
    scene_pattern pattern;
    double pattern_size; /* [m] 0: not given */
} scene_look;

typedef struct scene_picture {
    scene_camera camera;
    scene_floor floor;
    double exposure;
    scene_look *looks; /* of cloths, then of obstacles with all copies: the order of a run's bodies;
                          null: nothing is known */
    size_t look_count;
} scene_picture;

/* What holds without a scene file. */
scene_picture scene_picture_default(void);
/* Reads and checks the keys of the file; no other file is opened. On failure the problems are as
 * from tulle_scene_load, and *picture is the default. */
tulle_status scene_read_picture(const char *path, scene_picture *picture,
                                tulle_scene_problems *problems);
void scene_picture_destroy(scene_picture *picture);

#endif
