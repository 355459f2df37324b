/* app/cli/mesh_file.h - reads the mesh files that the program takes: OBJ, PLY, STL, and VTP. */
#ifndef TULLE_APP_CLI_MESH_FILE_H
#define TULLE_APP_CLI_MESH_FILE_H

#include "tulle_io/mesh_files.h"

/* Reads a mesh by its name: .vtp as tulle_vtp_read, all others as tulle_mesh_read_source. `source`
 * may be null; release it with tulle_mesh_source_destroy. */
tulle_status mesh_file_read(const char *path, tulle_mesh *mesh, tulle_mesh_source *source,
                            tulle_error *error);

/* The same for a command that has no use for the source. Says on standard error what was passed
 * over, where it may say something about the shape. */
tulle_status mesh_file_read_noted(const char *path, const char *command, tulle_mesh *mesh,
                                  tulle_error *error);

#endif
