/* io/vtk/vtp_read.h - reads the polygons of VTK XML PolyData files (.vtp), as ParaView and VTK
 * write them. */
#ifndef TULLE_IO_VTK_VTP_READ_H
#define TULLE_IO_VTK_VTP_READ_H

#include "tulle_io/mesh_files.h"

/* As tulle_vtp_read, of bytes in memory. `path` is for messages. */
tulle_status vtp_read_memory(const char *path, const char *bytes, size_t byte_count,
                             tulle_mesh *mesh, tulle_vtp_passed_over *passed_over,
                             tulle_error *error);

#endif
