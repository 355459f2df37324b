/* app/render/options.h - what the command line of `tulle render` asks for. */
#ifndef TULLE_APP_RENDER_OPTIONS_H
#define TULLE_APP_RENDER_OPTIONS_H

#include "app/cli/options.h"
#include "scene/picture.h"

typedef enum picture_color {
    PICTURE_MATERIAL,
    PICTURE_PATCHES,
    PICTURE_CONTACTS,
    PICTURE_GAP,
    PICTURE_VELOCITY,
    PICTURE_STRAIN
} picture_color;

typedef enum picture_kind {
    PICTURE_STILL,  /* one PNG file */
    PICTURE_SERIES, /* a PNG file a frame, the name a pattern with %d */
    PICTURE_FILM
} picture_kind;

enum { PICTURE_PATH_SIZE = 1024 /* [bytes] of a path */ };

typedef struct picture_options {
    const char *directory;      /* of the run */
    const char *frame, *frames; /* as given, or null */
    const char *output;         /* as given, or null */
    const char *color_name;     /* of --color */
    const char *progress;       /* auto, json or none */
    uint32_t width, height;     /* [pixels] */
    uint32_t samples;           /* of a pixel */
    double frame_rate;          /* [1/s] of a film; 0: in real time */
    int threads;                /* 0: one per processor */
    int subdivision_levels;     /* 0: none */
    bool has_wire;
    option_list hidden; /* names of bodies to leave out */
    picture_color color;
    scene_camera camera; /* goes before the scene's */
} picture_options;

/* Reads the words after `render`. On OPTIONS_REFUSED the reason is printed. */
options_outcome picture_options_read(int argc, char **argv, picture_options *options);

/* "640x360". Errors: TULLE_ERROR_INVALID_ARGUMENT, TULLE_ERROR_LIMIT with what would be right. */
tulle_status picture_read_size(const char *text, uint32_t *width, uint32_t *height,
                               tulle_error *error);

/* "position=1,2,3,target=0,0,50cm,fov=40deg" or "orbit=30deg,20deg,2,turn=360deg". What is not
 * named stays as it is. Errors: TULLE_ERROR_INVALID_ARGUMENT. */
tulle_status picture_read_camera(const char *text, scene_camera *camera, tulle_error *error);

/* The kind that a file's name asks for. Errors: TULLE_ERROR_INVALID_ARGUMENT (an extension that is
 * not known). */
tulle_status picture_find_kind(const char *path, picture_kind *kind, tulle_error *error);

#endif
