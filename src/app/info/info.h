/* app/info/info.h - what `tulle info` prints of each kind of file. Each prints to standard output
 * and returns the library's status, with `error` filled on failure. */
#ifndef TULLE_APP_INFO_INFO_H
#define TULLE_APP_INFO_INFO_H

#include "app/cli/options.h"

#include "tulle/mesh.h"
#include "tulle_io/mesh_files.h"

#include <stdbool.h>

/* A mesh file: sizes, topology, quality, what it can be used for. */
tulle_status info_print_mesh(const char *path, tulle_error *error);
/* A PC2 point cache: vertices, frames, bounds of the first and last frame. */
tulle_status info_print_cache(const char *path, tulle_error *error);
/* An animation with its triangles, or numbered meshes: sizes, frames, axes and unit, bounds of the
 * first and last frame in metres with z up, what it can be used for. */
tulle_status info_print_animation(const char *path, tulle_error *error);
/* Whether a mesh can be cloth or an obstacle; else why not. Of cloth also how near the origin. */
void info_print_use(tulle_mesh_view mesh, tulle_mesh_role role, const tulle_mesh_source *source,
                    const char *label);
/* Whether a mesh can be an obstacle, or one that `deforms`, and what of it is left out there; it is
 * then dropped from the mesh. */
tulle_status info_print_use_as_obstacle(tulle_mesh *mesh, const tulle_mesh_source *source,
                                        bool deforms, tulle_error *error);
/* The lines of the box about points, in metres. */
void info_print_bounds(const double *positions, size_t vertex_count);
/* A run directory: scene, frames, bodies, how it ended. */
tulle_status info_print_run(const char *path, tulle_error *error);
/* A scene file with other values for some of its keys: frames, sizes, contact distance. Prints what
 * is wrong with it; the exit code of the program. */
int info_print_scene(const char *path, const option_list *overrides, bool is_json);

#endif
