/* app/convert/names.c - see names.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/convert/names.h"

#include <stddef.h>
#include <string.h>
#include <strings.h>

convert_format convert_get_format(const char *path) {
    static const char *const extensions[] = {".obj", ".ply", ".stl", ".vtp", ".pc2"};
    size_t const length = strlen(path);
    for (size_t i = 0; i < 5; i++)
        if (length >= 4 && strcasecmp(path + length - 4, extensions[i]) == 0)
            return (convert_format)(i + 1);
    return CONVERT_NONE;
}
