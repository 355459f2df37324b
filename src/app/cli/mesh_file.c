/* app/cli/mesh_file.c - see mesh_file.h. */
#include "app/cli/mesh_file.h"

#include "app/convert/names.h"

#include "tulle_io/mesh_files.h"

tulle_status mesh_file_read(const char *path, tulle_mesh *mesh, tulle_vtp_passed_over *passed_over,
                            tulle_error *error) {
    return convert_get_format(path) == CONVERT_VTP ? tulle_vtp_read(path, mesh, passed_over, error)
                                                   : tulle_mesh_read(path, mesh, error);
}
