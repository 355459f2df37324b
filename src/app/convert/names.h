/* app/convert/names.h - the formats of `tulle convert`, by the ends of files' names. */
#ifndef TULLE_APP_CONVERT_NAMES_H
#define TULLE_APP_CONVERT_NAMES_H

#include <stdbool.h>

typedef enum convert_format {
    CONVERT_NONE, /* not known */
    CONVERT_OBJ,
    CONVERT_PLY,
    CONVERT_STL,
    CONVERT_VTP,
    CONVERT_PC2,
    CONVERT_MDD,
    CONVERT_GLB,
    CONVERT_GLTF,
    CONVERT_USDA,
    CONVERT_NPZ,
    CONVERT_ABC
} convert_format;

/* The format that the path's extension names, in capitals or not. */
convert_format convert_get_format(const char *path);

/* Whether the format is a point cache: all frames of one surface's vertices. */
bool convert_is_cache(convert_format format);
/* Whether tulle_animation_write writes it. */
bool convert_is_animation(convert_format format);
/* Whether a file holds several surfaces. */
bool convert_is_scene(convert_format format);

#endif
