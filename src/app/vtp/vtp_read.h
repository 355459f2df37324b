/* app/vtp/vtp_read.h - reads the polygons of VTK XML PolyData files (.vtp), as ParaView and VTK
 * write them. */
#ifndef TULLE_APP_VTP_VTP_READ_H
#define TULLE_APP_VTP_VTP_READ_H

#include "tulle/mesh.h"

/* What the file holds beside the mesh. */
typedef struct vtp_passed_over {
    uint64_t vertex_cells, lines;
} vtp_passed_over;

/* Reads the file: points and polygons of all pieces, polygons as fans around their first corner.
 * Vertices and lines are passed over, as are point, cell and field data; triangle strips are
 * refused. `passed_over` may be null. Errors name the line, as those of vtp_document.h and
 * vtp_values.h; also TULLE_ERROR_IO, and TULLE_ERROR_LIMIT for more than 2^31 - 1 points or
 * triangles. */
tulle_status vtp_read(const char *path, tulle_mesh *mesh, vtp_passed_over *passed_over,
                      tulle_error *error);

/* The same of bytes in memory. `path` is for messages. */
tulle_status vtp_read_memory(const char *path, const char *bytes, size_t byte_count,
                             tulle_mesh *mesh, vtp_passed_over *passed_over, tulle_error *error);

#endif
