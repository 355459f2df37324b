/* app/convert/names.h - the formats of `tulle convert`, by the ends of files' names. */
#ifndef TULLE_APP_CONVERT_NAMES_H
#define TULLE_APP_CONVERT_NAMES_H

typedef enum convert_format {
    CONVERT_NONE, /* not known */
    CONVERT_OBJ,
    CONVERT_PLY,
    CONVERT_STL,
    CONVERT_VTP,
    CONVERT_PC2
} convert_format;

/* The format that the path's extension names, in capitals or not. */
convert_format convert_get_format(const char *path);

#endif
