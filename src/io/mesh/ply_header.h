/* io/mesh/ply_header.h - the header of a PLY file: format, elements and their properties, and which
 * of them carry the positions, the texture coordinates and the polygons. */
#ifndef TULLE_IO_MESH_PLY_HEADER_H
#define TULLE_IO_MESH_PLY_HEADER_H

#include "io/text/text_cursor.h"

typedef enum ply_format { PLY_TEXT, PLY_LITTLE_ENDIAN, PLY_BIG_ENDIAN } ply_format;

typedef enum ply_type {
    PLY_INT8,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_INT64,
    PLY_UINT64,
    PLY_FLOAT,
    PLY_DOUBLE,
    PLY_TYPE_COUNT
} ply_type;

/* [bytes] of a value of the type in a binary file. */
size_t ply_type_size(ply_type type);

enum {
    PLY_ELEMENT_MAX = 32,  /* kinds of element in a file */
    PLY_PROPERTY_MAX = 256 /* properties of all elements together */
};

typedef enum ply_role { PLY_PASSED_OVER, PLY_X, PLY_Y, PLY_Z, PLY_S, PLY_T, PLY_CORNERS } ply_role;

typedef struct ply_property {
    char name[TEXT_SHOWN_SIZE];
    ply_type type; /* of the value, or of the values of a list */
    bool is_list;
    ply_type count_type; /* of a list */
    ply_role role;
} ply_property;

typedef struct ply_element {
    char name[TEXT_SHOWN_SIZE];
    uint64_t count;
    size_t first_property, property_count;
    bool is_vertex, is_face;
} ply_element;

typedef struct ply_header {
    ply_format format;
    ply_element elements[PLY_ELEMENT_MAX];
    size_t element_count;
    ply_property properties[PLY_PROPERTY_MAX];
    size_t property_count;
} ply_header;

/* Reads the header and leaves the cursor behind it. Checks that vertices have x, y and z and that
 * faces have a list of integers for their corners. */
tulle_status ply_read_header(text_cursor *text, ply_header *header, tulle_error *error);

#endif
