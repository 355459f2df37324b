/* app/cli/mesh_file.h - reads the mesh files that the program takes: those of the library, and VTP.
 */
#ifndef TULLE_APP_CLI_MESH_FILE_H
#define TULLE_APP_CLI_MESH_FILE_H

#include "tulle_io/mesh_files.h"

/* Reads a mesh by its name: .vtp as tulle_vtp_read, all others as tulle_mesh_read. passed_over may
 * be null; of the others nothing is counted. */
tulle_status mesh_file_read(const char *path, tulle_mesh *mesh, tulle_vtp_passed_over *passed_over,
                            tulle_error *error);

#endif
