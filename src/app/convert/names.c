/* app/convert/names.c - see names.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/convert/names.h"

#include <stddef.h>
#include <string.h>
#include <strings.h>

convert_format convert_get_format(const char *path) {
    static const char *const extensions[] = {".obj", ".ply", ".stl",  ".vtp",  ".pc2",
                                             ".mdd", ".glb", ".gltf", ".usda", ".npz",
                                             ".abc", ".usd", ".usdc"};
    size_t const length = strlen(path);
    for (size_t i = 0; i < sizeof extensions / sizeof extensions[0]; i++) {
        size_t const tail = strlen(extensions[i]);
        if (length >= tail && strcasecmp(path + length - tail, extensions[i]) == 0)
            return i < CONVERT_ABC ? (convert_format)(i + 1) : CONVERT_USDA; /* they are read */
    }
    return CONVERT_NONE;
}

bool convert_is_cache(convert_format format) {
    return format == CONVERT_PC2 || format == CONVERT_MDD;
}

bool convert_is_animation(convert_format format) { return format >= CONVERT_MDD; }

bool convert_is_scene(convert_format format) { return format >= CONVERT_GLB; }
