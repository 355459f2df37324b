/* app/cli/mesh_file.h - reads the mesh files that the program takes: OBJ, PLY, STL, and VTP. */
#ifndef TULLE_APP_CLI_MESH_FILE_H
#define TULLE_APP_CLI_MESH_FILE_H

#include "tulle_io/mesh_files.h"

/* Reads a mesh by its name: .vtp as tulle_vtp_read, all others as tulle_mesh_read_source. `source`
 * may be null; release it with tulle_mesh_source_destroy. */
tulle_status mesh_file_read(const char *path, tulle_mesh *mesh, tulle_mesh_source *source,
                            tulle_error *error);

/* What a command says of the files that it reads. */
typedef struct mesh_file_notes {
    const char *command;
    size_t count; /* of readings that passed something over; 0 before the first file */
} mesh_file_notes;

/* The same for a command that has no use for the source. Says on standard error what was passed
 * over, where it may say something about the shape; only of the first three such files. */
tulle_status mesh_file_read_noted(const char *path, mesh_file_notes *notes, tulle_mesh *mesh,
                                  tulle_error *error);
/* After the last file: says how many more there were. */
void mesh_file_finish_notes(const mesh_file_notes *notes);

#endif
