/* io/vtk/vtp_document.h - the structure of a VTK XML PolyData file: which arrays its pieces have
 * and where the values of each stand. The values themselves are decoded by io/vtk/vtp_values.h. */
#ifndef TULLE_IO_VTK_VTP_DOCUMENT_H
#define TULLE_IO_VTK_VTP_DOCUMENT_H

#include "base/memory.h"

#include <stdbool.h>

typedef enum vtp_type {
    VTP_INT8,
    VTP_UINT8,
    VTP_INT16,
    VTP_UINT16,
    VTP_INT32,
    VTP_UINT32,
    VTP_INT64,
    VTP_UINT64,
    VTP_FLOAT32,
    VTP_FLOAT64,
    VTP_TYPE_COUNT
} vtp_type;

typedef enum vtp_format { VTP_ASCII, VTP_BINARY, VTP_APPENDED } vtp_format;

typedef ARRAY(char) vtp_text;

typedef struct vtp_array {
    bool is_there;
    vtp_type type;
    vtp_format format;
    uint64_t component_count;
    uint64_t offset; /* appended: [bytes] behind the underscore */
    vtp_text text;   /* ascii and binary: what stands in the element */
    int line;
} vtp_array;

typedef struct vtp_piece {
    uint64_t point_count, polygon_count;
    uint64_t vertex_cell_count, line_count, strip_count;
    vtp_array points, connectivity, offsets; /* of Points and of Polys */
    int line;
} vtp_piece;

typedef struct vtp_document {
    memory heap;
    const char *path; /* for messages; borrowed */
    const char *bytes;
    size_t byte_count;
    ARRAY(vtp_piece) pieces;
    bool is_big_endian, is_compressed;
    size_t header_size; /* [bytes] of a number in the headers of binary data, 4 or 8 */
    bool has_appended, is_appended_raw;
    size_t appended_begin, appended_end; /* [bytes] behind the underscore, in the file */
} vtp_document;

/* Reads the structure of the file `path`, whose contents are given and stay borrowed. Release with
 * vtp_document_destroy, also after a failure. Errors: TULLE_ERROR_PARSE, TULLE_ERROR_UNSUPPORTED,
 * TULLE_ERROR_OUT_OF_MEMORY. */
tulle_status vtp_document_read(const char *path, const char *bytes, size_t byte_count,
                               vtp_document *document, tulle_error *error);
void vtp_document_destroy(vtp_document *document);

#endif
