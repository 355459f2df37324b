/* io/unflushed.h - writers of whole files that are not flushed to disk one by one. A killed process
 * leaves each file whole or not at all. A power failure may lose it until the file system is
 * flushed. For runs, which write many small files and flush them together before a checkpoint.
 * A target that is a link is replaced, as by output_open_inside. */
#ifndef TULLE_IO_UNFLUSHED_H
#define TULLE_IO_UNFLUSHED_H

#include "io/output_file.h"

/* As tulle_mesh_write, tulle_vtp_write and tulle_pvd_write; sum (not null) as in
 * output_commit_summed. */
tulle_status mesh_write_unflushed(const char *path, tulle_mesh_view mesh, file_sum *sum,
                                  tulle_error *error);
tulle_status vtp_write_unflushed(const char *path, tulle_mesh_view mesh, const double *velocities,
                                 file_sum *sum, tulle_error *error);
tulle_status pvd_write_unflushed(const char *path, const char *const *files, const double *times,
                                 size_t count, file_sum *sum, tulle_error *error);

#endif
